//! What no kernel may do though lavapipe lets it, because other drivers compute something else or refuse it: barriers that not
//! all invocations of a workgroup reach, signed remainders, shifts by the bits of a word or more, and arrays and structs of
//! one kind where another one of the same shape is declared.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use naga::{
    AddressSpace, BinaryOperator, Expression, Function, Handle, Literal, MathFunction, Module, Statement, TypeInner,
};

use super::*;

/// The functions of a module, the entry points last.
fn functions(module: &Module) -> Vec<(Option<Handle<Function>>, &Function)> {
    let named = module.functions.iter().map(|(handle, function)| (Some(handle), function));
    named.chain(module.entry_points.iter().map(|entry| (None, &entry.function))).collect()
}

/// Visits all statements of a block.
fn visit<'a>(block: &'a naga::Block, see: &mut dyn FnMut(&'a Statement)) {
    for statement in block {
        see(statement);
        match statement {
            Statement::Block(inner) => visit(inner, see),
            Statement::If { accept, reject, .. } => {
                visit(accept, see);
                visit(reject, see);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| visit(&case.body, see)),
            Statement::Loop { body, continuing, .. } => {
                visit(body, see);
                visit(continuing, see);
            }
            _ => (),
        }
    }
}

fn name(function: &Function) -> &str {
    function.name.as_deref().unwrap_or("an entry point")
}

/// What may differ between the invocations of a workgroup. `None` is the entry point.
#[derive(Default)]
struct Varying {
    locals: BTreeSet<(Option<Handle<Function>>, Handle<naga::LocalVariable>)>,
    globals: BTreeSet<Handle<naga::GlobalVariable>>,
    arguments: BTreeSet<(Handle<Function>, u32)>,
    results: BTreeSet<Handle<Function>>,
    /// Functions that some invocations may call and others not.
    called: BTreeSet<Handle<Function>>,
}

impl Varying {
    fn len(&self) -> usize {
        self.locals.len() + self.globals.len() + self.arguments.len() + self.results.len() + self.called.len()
    }
}

/// A walk through one function.
struct Walk<'a> {
    module: &'a Module,
    handle: Option<Handle<Function>>,
    function: &'a Function,
    varying: &'a mut Varying,
    /// Some invocations may have returned.
    gone: bool,
    wrong: Vec<String>,
}

impl Walk<'_> {
    fn varies(&self, expression: Handle<Expression>) -> bool {
        let any = |parts: &[Option<Handle<Expression>>]| parts.iter().flatten().any(|part| self.varies(*part));
        match &self.function.expressions[expression] {
            Expression::Literal(_) | Expression::Constant(_) | Expression::Override(_) | Expression::ZeroValue(_) => {
                false
            }
            Expression::Compose { components, .. } => components.iter().any(|part| self.varies(*part)),
            Expression::Access { base, index } => any(&[Some(*base), Some(*index)]),
            Expression::AccessIndex { base, .. } => self.varies(*base),
            Expression::Splat { value, .. } => self.varies(*value),
            Expression::Swizzle { vector, .. } => self.varies(*vector),
            Expression::FunctionArgument(i) => match self.handle {
                None => true,
                Some(handle) => self.varying.arguments.contains(&(handle, *i)),
            },
            Expression::GlobalVariable(variable) => match self.module.global_variables[*variable].space {
                AddressSpace::Uniform | AddressSpace::Handle => false,
                AddressSpace::Storage { access } => access != naga::StorageAccess::LOAD,
                AddressSpace::Private => self.varying.globals.contains(variable),
                _ => true,
            },
            Expression::LocalVariable(variable) => self.varying.locals.contains(&(self.handle, *variable)),
            Expression::Load { pointer } => self.varies(*pointer),
            Expression::ImageLoad { coordinate, array_index, sample, level, .. } => {
                any(&[Some(*coordinate), *array_index, *sample, *level])
            }
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => self.varies(*expr),
            Expression::Binary { left, right, .. } => any(&[Some(*left), Some(*right)]),
            Expression::Select { condition, accept, reject } => any(&[Some(*condition), Some(*accept), Some(*reject)]),
            Expression::Relational { argument, .. } => self.varies(*argument),
            Expression::Math { arg, arg1, arg2, arg3, .. } => any(&[Some(*arg), *arg1, *arg2, *arg3]),
            Expression::CallResult(callee) => self.varying.results.contains(callee),
            Expression::ArrayLength(_)
            | Expression::ImageQuery { .. }
            | Expression::WorkGroupUniformLoadResult { .. } => false,
            _ => true,
        }
    }

    /// What a pointer leads to varies from now on.
    fn taint(&mut self, pointer: Handle<Expression>) {
        match self.function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.taint(base),
            Expression::LocalVariable(variable) => drop(self.varying.locals.insert((self.handle, variable))),
            Expression::GlobalVariable(variable) => drop(self.varying.globals.insert(variable)),
            Expression::FunctionArgument(i) => {
                if let Some(handle) = self.handle {
                    self.varying.arguments.insert((handle, i));
                }
            }
            _ => (),
        }
    }

    fn index_varies(&self, pointer: Handle<Expression>) -> bool {
        match self.function.expressions[pointer] {
            Expression::Access { base, index } => self.varies(index) || self.index_varies(base),
            Expression::AccessIndex { base, .. } => self.index_varies(base),
            _ => false,
        }
    }

    /// Walks a block, which only some invocations reach if `some`. Returns whether only some leave it by `break` or `continue`.
    fn block(&mut self, block: &naga::Block, some: bool) -> bool {
        let mut left = false;
        for statement in block {
            let some = some || left || self.gone;
            match statement {
                Statement::Block(inner) => left |= self.block(inner, some),
                Statement::If { condition, accept, reject } => {
                    let some = some || self.varies(*condition);
                    left |= self.block(accept, some);
                    left |= self.block(reject, some);
                }
                Statement::Switch { selector, cases } => {
                    // A `break` in it leaves the switch alone; that it may be a `continue` makes this stricter, not laxer.
                    let some = some || self.varies(*selector);
                    for case in cases {
                        left |=
                            self.block(&case.body, some) && case.body.iter().any(|s| !matches!(s, Statement::Break));
                    }
                }
                Statement::Loop { body, continuing, break_if } => {
                    // What a round leaves is what the next one finds.
                    let mut some = some;
                    for _ in 0..2 {
                        some |= self.block(body, some);
                        some |= self.block(continuing, some);
                        some |= break_if.is_some_and(|condition| self.varies(condition)) || self.gone;
                    }
                }
                Statement::Break | Statement::Continue => left |= some,
                Statement::Return { value } => {
                    if let (Some(value), Some(handle)) = (value, self.handle)
                        && (some || self.varies(*value))
                    {
                        self.varying.results.insert(handle);
                    }
                    self.gone |= some;
                }
                Statement::Store { pointer, value } if some || self.varies(*value) || self.index_varies(*pointer) => {
                    self.taint(*pointer);
                }
                Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. } if some => {
                    self.wrong.push(format!("{}: a barrier", name(self.function)));
                }
                Statement::Call { function, arguments, .. } => self.call(*function, arguments, some),
                _ => (),
            }
        }
        left
    }

    fn call(&mut self, callee: Handle<Function>, arguments: &[Handle<Expression>], some: bool) {
        if some {
            self.varying.called.insert(callee);
        }
        for (i, argument) in (0..).zip(arguments) {
            let place = (callee, i);
            if self.varies(*argument) {
                self.varying.arguments.insert(place);
            }
            // What the callee leaves behind a pointer.
            if self.varying.arguments.contains(&place) {
                self.taint(*argument);
            }
        }
    }
}

/// The barriers of a module that some invocations of a workgroup may not reach.
fn lonely_barriers(module: &Module) -> Vec<String> {
    let mut varying = Varying::default();
    loop {
        let before = varying.len();
        let mut wrong = Vec::new();
        // Callers before those that they call.
        for (handle, function) in functions(module).into_iter().rev() {
            let some = handle.is_some_and(|handle| varying.called.contains(&handle));
            let mut walk = Walk { module, handle, function, varying: &mut varying, gone: false, wrong: Vec::new() };
            walk.block(&function.body, some);
            wrong.extend(walk.wrong);
        }
        if varying.len() == before {
            wrong.dedup();
            return wrong;
        }
    }
}

/// Members of the uniform blocks that shift, and the most that src/gpu/layout and src/gpu/chain put there.
const SHIFTING: [(&str, u64); 2] = [("halvings", 15), ("narrowing", 31)];

/// A function, and an expression of it.
type Given<'a> = (&'a Function, Option<Handle<Function>>, Handle<Expression>);

/// What the integers of a module may be.
struct Ranges<'a> {
    module: &'a Module,
    /// Of each argument what it is called with, and where.
    given: BTreeMap<(Handle<Function>, u32), Vec<Given<'a>>>,
}

impl<'a> Ranges<'a> {
    fn new(module: &'a Module) -> Self {
        let mut given: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (handle, function) in functions(module) {
            visit(&function.body, &mut |statement| {
                if let Statement::Call { function: callee, arguments, .. } = statement {
                    for (i, argument) in (0..).zip(arguments) {
                        given.entry((*callee, i)).or_default().push((function, handle, *argument));
                    }
                }
            });
        }
        Self { module, given }
    }

    /// The least and the most that an expression can be, in any of its components; `None` where that is not known.
    fn of(
        &self,
        f: &'a Function,
        handle: Option<Handle<Function>>,
        e: Handle<Expression>,
        depth: u32,
    ) -> Option<(u64, u64)> {
        let depth = depth.checked_sub(1)?;
        let of = |e: Handle<Expression>| self.of(f, handle, e, depth);
        let union = |ranges: Vec<Option<(u64, u64)>>| {
            let ranges = ranges.into_iter().collect::<Option<Vec<_>>>()?;
            Some((ranges.iter().map(|r| r.0).min()?, ranges.iter().map(|r| r.1).max()?))
        };
        match &f.expressions[e] {
            Expression::Literal(literal) => number(*literal).map(|value| (value, value)),
            Expression::Constant(constant) => self.constant(self.module.constants[*constant].init),
            Expression::ZeroValue(_) => Some((0, 0)),
            Expression::Compose { components, .. } => union(components.iter().map(|part| of(*part)).collect()),
            Expression::Splat { value, .. } | Expression::Swizzle { vector: value, .. } => of(*value),
            Expression::AccessIndex { base, index } => match self.shifting(f, *base, *index) {
                Some(most) => Some((0, most)),
                None => of(*base),
            },
            Expression::Access { base, .. } => of(*base),
            Expression::Load { pointer } => match f.expressions[*pointer] {
                Expression::LocalVariable(variable) => self.counter(f, handle, variable, depth),
                Expression::AccessIndex { base, index } => self.shifting(f, base, index).map(|most| (0, most)),
                _ => None,
            },
            Expression::As { expr, .. } => of(*expr),
            Expression::Select { accept, reject, .. } => union(vec![of(*accept), of(*reject)]),
            Expression::Binary { op, left, right } => binary(*op, of(*left), of(*right)),
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let [a, b, c] = [Some(*arg), *arg1, *arg2].map(|arg| arg.and_then(of));
                match fun {
                    MathFunction::Min => Some((0, a.or(b)?.1.min(b.or(a)?.1))),
                    MathFunction::Max => Some((a?.0.max(b?.0), a?.1.max(b?.1))),
                    MathFunction::Clamp => Some((b?.0, c?.1)),
                    MathFunction::ExtractBits => Some((0, (1 << c?.1) - 1)),
                    MathFunction::CountOneBits => Some((0, 32)),
                    // Of words that are not 0.
                    MathFunction::FirstTrailingBit | MathFunction::FirstLeadingBit => Some((0, 31)),
                    _ => None,
                }
            }
            Expression::FunctionArgument(i) => {
                let Some(given) = self.given.get(&(handle?, *i)) else { return Some((0, 0)) }; // never called
                union(given.iter().map(|(f, handle, e)| self.of(f, *handle, *e, depth)).collect())
            }
            _ => None,
        }
    }

    fn constant(&self, e: Handle<Expression>) -> Option<(u64, u64)> {
        match &self.module.global_expressions[e] {
            Expression::Literal(literal) => number(*literal).map(|value| (value, value)),
            Expression::Splat { value, .. } => self.constant(*value),
            Expression::ZeroValue(_) => Some((0, 0)),
            _ => None,
        }
    }

    /// The most of a member of a uniform block that shifts.
    fn shifting(&self, f: &Function, base: Handle<Expression>, index: u32) -> Option<u64> {
        let Expression::GlobalVariable(variable) = f.expressions[base] else { return None };
        let variable = &self.module.global_variables[variable];
        let TypeInner::Struct { members, .. } = &self.module.types[variable.ty].inner else { return None };
        let member = members[index as usize].name.as_deref();
        let known = (variable.space == AddressSpace::Uniform).then_some(SHIFTING)?;
        known.into_iter().find(|(name, _)| member == Some(*name)).map(|(_, most)| most)
    }

    /// What a local variable is in a loop that counts it from below to a bound, or where it is set to what is known.
    fn counter(
        &self,
        f: &'a Function,
        handle: Option<Handle<Function>>,
        variable: Handle<naga::LocalVariable>,
        depth: u32,
    ) -> Option<(u64, u64)> {
        let is_load = |e: Handle<Expression>| match f.expressions[e] {
            Expression::Load { pointer } => {
                matches!(f.expressions[pointer], Expression::LocalVariable(v) if v == variable)
            }
            _ => false,
        };
        let mut bound = None;
        let mut values = f.local_variables[variable].init.into_iter().collect::<Vec<_>>();
        visit(&f.body, &mut |statement| match statement {
            Statement::If { condition, .. } => {
                if let Expression::Binary { op: BinaryOperator::Less, left, right } = f.expressions[*condition]
                    && is_load(left)
                {
                    bound = bound.or(Some(right));
                }
            }
            Statement::Store { pointer, value } => {
                if matches!(f.expressions[*pointer], Expression::LocalVariable(v) if v == variable) {
                    values.push(*value);
                }
            }
            _ => (),
        });
        let rises = |e: &Handle<Expression>| matches!(f.expressions[*e], Expression::Binary { op: BinaryOperator::Add, left, .. } if is_load(left));
        let counts = values.iter().any(rises);
        values.retain(|value| !rises(value));
        let starts = values.iter().map(|value| self.of(f, handle, *value, depth)).collect::<Option<Vec<_>>>()?;
        let least = starts.iter().map(|r| r.0).min()?;
        let most = starts.iter().map(|r| r.1).max()?;
        match counts {
            true => Some((least, most.max(self.of(f, handle, bound?, depth)?.1.checked_sub(1)?))),
            false => Some((least, most)),
        }
    }
}

fn number(literal: Literal) -> Option<u64> {
    match literal {
        Literal::U32(value) => Some(value.into()),
        Literal::I32(value) => u64::try_from(value).ok(),
        Literal::U64(value) => Some(value),
        _ => None,
    }
}

fn binary(op: BinaryOperator, a: Option<(u64, u64)>, b: Option<(u64, u64)>) -> Option<(u64, u64)> {
    let (both, inside) = (a.zip(b), |least: u64, most: u64| (most < 1 << 31).then_some((least, most)));
    match op {
        BinaryOperator::And => Some((0, a.or(b)?.1.min(b.or(a)?.1))),
        BinaryOperator::Modulo => Some((0, b?.1.checked_sub(1)?)),
        BinaryOperator::ShiftRight => Some((0, a?.1)),
        BinaryOperator::Divide => Some((0, a?.1 / b?.0.max(1))),
        BinaryOperator::Add => both.and_then(|(a, b)| inside(a.0 + b.0, a.1 + b.1)),
        BinaryOperator::Multiply => both.and_then(|(a, b)| inside(a.0 * b.0, a.1.checked_mul(b.1)?)),
        BinaryOperator::Subtract => both.and_then(|(a, b)| Some((a.0.checked_sub(b.1)?, a.1 - b.0))),
        BinaryOperator::InclusiveOr | BinaryOperator::ExclusiveOr => {
            both.and_then(|(a, b)| inside(0, (a.1.max(b.1) + 1).next_power_of_two() - 1))
        }
        _ => None,
    }
}

/// Divisions and remainders of signed integers, and shifts that a driver may read in its own way.
fn doubtful_integers(module: &Module, info: &naga::valid::ModuleInfo) -> Vec<String> {
    let ranges = Ranges::new(module);
    let mut wrong = Vec::new();
    for (handle, function) in functions(module) {
        let known = handle.map_or_else(|| info.get_entry_point(0), |handle| &info[handle]);
        for (_, expression) in function.expressions.iter() {
            let Expression::Binary { op, left, right } = *expression else { continue };
            let inner = known[left].ty.inner_with(&module.types);
            let scalar = inner.scalar();
            let signed = scalar.is_some_and(|scalar| scalar.kind == naga::ScalarKind::Sint);
            let bits = scalar.map_or(32, |scalar| 8 * u64::from(scalar.width));
            let what = match op {
                BinaryOperator::Divide if signed => "a signed division",
                BinaryOperator::Modulo if signed => "a signed remainder",
                BinaryOperator::ShiftLeft if signed => "a signed number shifted to the left",
                BinaryOperator::ShiftLeft | BinaryOperator::ShiftRight => {
                    match ranges.of(function, handle, right, 40) {
                        Some((_, most)) if most < bits => continue,
                        Some((_, most)) => {
                            wrong.push(format!("{}: a shift by up to {most}", name(function)));
                            continue;
                        }
                        None => "a shift by who knows how much",
                    }
                }
                _ => continue,
            };
            wrong.push(format!("{}: {what}", name(function)));
        }
    }
    wrong
}

/// Arrays and structs that are given where another type of the same shape is declared: the two are one type for WGSL, but not
/// in what naga makes of them.
fn other_types(module: &Module, info: &naga::valid::ModuleInfo) -> Vec<String> {
    let mut wrong = Vec::new();
    for (handle, function) in functions(module) {
        let known = handle.map_or_else(|| info.get_entry_point(0), |handle| &info[handle]);
        let kind = |e: Handle<Expression>| known[e].ty.handle();
        let pointee = |e: Handle<Expression>| match *known[e].ty.inner_with(&module.types) {
            TypeInner::Pointer { base, .. } => Some(base),
            _ => None,
        };
        let base_of = |ty: Handle<naga::Type>| match module.types[ty].inner {
            TypeInner::Pointer { base, .. } => base,
            _ => ty,
        };
        let mut check = |what: &str, wanted: Option<Handle<naga::Type>>, got: Option<Handle<naga::Type>>| {
            if let (Some(wanted), Some(got)) = (wanted, got)
                && matches!(module.types[wanted].inner, TypeInner::Array { .. } | TypeInner::Struct { .. })
                && wanted != got
            {
                let name = |ty: Handle<naga::Type>| module.types[ty].name.clone().unwrap_or_else(|| "no name".into());
                wrong.push(format!("{}: {what} wants {}, gets {}", self::name(function), name(wanted), name(got)));
            }
        };
        visit(&function.body, &mut |statement| match statement {
            Statement::Return { value: Some(value) } => {
                check("the result", function.result.as_ref().map(|result| result.ty), kind(*value));
            }
            Statement::Store { pointer, value } => check("a variable", pointee(*pointer), kind(*value)),
            Statement::Call { function: callee, arguments, .. } => {
                for (declared, given) in module.functions[*callee].arguments.iter().zip(arguments) {
                    check("an argument", Some(base_of(declared.ty)), pointee(*given).or_else(|| kind(*given)));
                }
            }
            _ => (),
        });
        for (_, variable) in function.local_variables.iter() {
            check("a variable", Some(variable.ty), variable.init.and_then(kind));
        }
        for (_, expression) in function.expressions.iter() {
            let Expression::Compose { ty, components } = expression else { continue };
            for (i, component) in components.iter().enumerate() {
                let wanted = match &module.types[*ty].inner {
                    TypeInner::Array { base, .. } => Some(*base),
                    TypeInner::Struct { members, .. } => Some(members[i].ty),
                    _ => None,
                };
                check("an element", wanted, kind(*component));
            }
        }
    }
    wrong
}

/// A text as naga understands it; what naga itself says if it does not.
fn understood(text: &str) -> Result<(Module, naga::valid::ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), CAPABILITIES);
    validator.subgroup_stages(naga::valid::ShaderStages::COMPUTE);
    validator.subgroup_operations(naga::valid::SubgroupOperationSet::all());
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(text))?;
    Ok((module, info))
}

/// What is wrong with the specialised kernels.
#[derive(Default)]
struct Findings {
    barriers: BTreeSet<String>,
    integers: BTreeSet<String>,
    types: BTreeSet<String>,
    /// Texts that have a barrier.
    with_barriers: u32,
}

/// Of all texts, looked at once for all tests.
static FINDINGS: LazyLock<Findings> = LazyLock::new(|| {
    let mut findings = Findings::default();
    for (name, text) in every_text() {
        let (module, info) = understood(text).unwrap_or_else(|error| panic!("{name}.wgsl: {error}"));
        let named = |wrong: Vec<String>| wrong.into_iter().map(move |wrong| format!("{name}.wgsl, {wrong}"));
        findings.barriers.extend(named(lonely_barriers(&module)));
        findings.integers.extend(named(doubtful_integers(&module, &info)));
        findings.types.extend(named(other_types(&module, &info)));
        findings.with_barriers += u32::from(text.contains("workgroupBarrier()"));
    }
    findings
});

#[test]
fn all_invocations_reach_each_barrier() {
    let Findings { barriers, with_barriers, .. } = &*FINDINGS;
    assert!(barriers.is_empty(), "where not all invocations of a workgroup come: {barriers:#?}");
    assert!(*with_barriers > 10, "only {with_barriers} texts have barriers");
}

#[test]
fn integers_mean_the_same_on_every_driver() {
    let wrong = &FINDINGS.integers;
    assert!(wrong.is_empty(), "take unsigned numbers, and shifts below their bits: {wrong:#?}");
}

#[test]
fn values_have_the_types_that_are_declared() {
    let wrong = &FINDINGS.types;
    assert!(wrong.is_empty(), "construct the declared type by its name: {wrong:#?}");
}

/// The tests of the tests.
mod mutants {
    use super::*;

    #[test]
    fn barriers_that_some_do_not_reach_are_found() {
        let kernel = |body: &str| {
            format!(
                "struct Block {{ rows: u32, list: array<vec4<u32>, 4> }}
                @group(0) @binding(0) var<uniform> block: Block;
                @group(0) @binding(1) var<storage, read_write> data: array<u32>;
                var<workgroup> places: array<u32, 64>;
                var<private> member: u32;
                fn wait(v: u32) {{ places[member] = v; workgroupBarrier(); }}
                fn two(v: u32) {{ wait(v); wait(v + 1u); }}
                fn own(v: u32) -> bool {{ return v > 3u; }}
                fn leave(v: ptr<function, u32>) {{ *v = member; }}
                fn maybe(v: u32) {{ if v > 2u {{ return; }} workgroupBarrier(); }}
                @compute @workgroup_size(64)
                fn main(@builtin(local_invocation_index) local: u32, @builtin(global_invocation_id) id: vec3<u32>) {{
                    member = local;
                    let rows = block.rows;
                    {body}
                }}"
            )
        };
        for (body, expected) in [
            ("workgroupBarrier();", false),
            ("for (var i = 0u; i < rows; i++) { wait(i + local); }", false),
            ("if rows > 3u { two(local); }", false),
            ("if local > 3u { data[0] = 1u; } two(1u);", false),
            ("var n = rows; if own(n) { return; } wait(local);", false),
            ("for (var i = 0u; i < rows; i++) { if i == 7u { break; } wait(i); }", false),
            ("switch block.list[1].x { case 1u: { wait(1u); } default: { } }", false),
            (
                "var i = 0u; loop { if local == i { data[1] = i; } wait(i); continuing { i++; break if i == rows; } }",
                false,
            ),
            ("maybe(rows);", false),
            ("if local > 3u { return; } workgroupBarrier();", true),
            ("if local > 3u && false { return; } two(1u);", true),
            ("if id.x > 3u { wait(1u); }", true),
            ("if rows > 3u { if own(local) { two(1u); } }", true),
            ("for (var i = 0u; i < local; i++) { wait(i); }", true),
            ("for (var i = 0u; i < rows; i++) { if i == local { break; } wait(i); }", true),
            ("for (var i = 0u; i < rows; i++) { wait(i); if i == local { continue; } }", true),
            ("for (var i = 0u; i < rows; i++) { wait(i); if i == local { return; } }", true),
            ("var n = rows; if local == 2u { n = 1u; } for (var i = 0u; i < n; i++) { wait(i); }", true),
            ("var n = rows; leave(&n); if n == 2u { wait(1u); }", true),
            ("if data[2] == 0u { wait(1u); }", true),
            ("if places[2] == 0u { wait(1u); }", true),
            ("switch local { case 1u: { wait(1u); } default: { } }", true),
            ("var i = 0u; loop { wait(i); continuing { i++; break if i == local; } }", true),
            ("while true { wait(1u); if own(member) { break; } }", true),
            ("maybe(local);", true),
        ] {
            let found = !lonely_barriers(&understood(&kernel(body)).unwrap().0).is_empty();
            assert_eq!(found, expected, "{body}");
        }
    }

    #[test]
    fn doubtful_integers_are_found() {
        let kernel = |expression: &str| {
            format!(
                "struct Dispatch {{ halvings: u32, other: u32 }}
                @group(0) @binding(0) var<uniform> dispatch: Dispatch;
                @group(0) @binding(1) var<storage, read_write> data: array<u32>;
                fn shifted(v: u32, by: u32) -> u32 {{ return v >> by; }}
                @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
                    let u = id.x; let i = i32(id.y); let v = vec4(id.x, id.y, id.z, 1u);
                    data[0] = u32({expression});
                    for (var n = 0u; n < 8u; n++) {{ data[1] = 1u << (4u * n + 3u); }}
                }}"
            )
        };
        for (expression, expected) in [
            ("u % 3u + u / 5u", 0),
            ("u >> 31u", 0),
            ("i >> 4u", 0),
            ("u << (8u * (u & 3u))", 0),
            ("u << (31u - 8u * (u % 4u))", 0),
            ("(v << vec4(0u, 8u, 16u, 24u)).x", 0),
            ("1u << dispatch.halvings", 0),
            ("1u << min(u, 31u)", 0),
            ("shifted(u, 3u) + shifted(u, u & 31u)", 0),
            ("u >> select(4u, 8u, u > 3u)", 0),
            ("i % 3", 1),
            ("i / 3", 1),
            ("(vec4(i) % vec4(3)).x", 1),
            ("i << 2u", 1),
            ("u << u", 1),
            ("u << (32u - 8u * (u & 3u))", 1),
            ("u >> (8u * (u & 7u))", 1),
            ("1u << dispatch.other", 1),
            ("shifted(u, 3u) + shifted(u, u)", 1),
            ("(v >> vec4(u)).x", 1),
            ("u >> (u - 1u)", 1),
        ] {
            let (module, info) = understood(&kernel(expression)).unwrap();
            let wrong = doubtful_integers(&module, &info);
            assert_eq!(wrong.len(), expected, "{expression}: {wrong:?}");
        }
    }

    #[test]
    fn other_types_are_found() {
        let kernel = |body: &str| {
            format!(
                "alias Sums = array<vec4<u32>, 2>;
                struct Pair {{ a: Sums, b: u32 }}
                @group(0) @binding(0) var<storage, read_write> data: array<vec4<u32>>;
                fn take(s: Sums) -> vec4<u32> {{ return s[0]; }}
                fn change(s: ptr<function, Sums>) {{ (*s)[0] = vec4(1u); }}
                {body}
                @compute @workgroup_size(1) fn main() {{ data[0] = take(f()); }}"
            )
        };
        for (body, expected) in [
            ("fn f() -> Sums { return Sums(vec4(1u), vec4(2u)); }", 0),
            ("fn f() -> Sums { var s = Sums(); s[0] = vec4(1u); change(&s); return s; }", 0),
            ("fn f() -> Sums { let p = Pair(Sums(), 1u); return p.a; }", 0),
            ("fn f() -> Sums { return array(vec4(1u), vec4(2u)); }", 1),
            ("fn f() -> Sums { return array<vec4<u32>, 2>(vec4(1u), vec4(2u)); }", 1),
            (
                "fn g(a: array<vec4<u32>, 2>) -> Sums { return a; } fn f() -> Sums { return g(array<vec4<u32>, 2>()); }",
                1,
            ),
            ("fn f() -> Sums { var s: Sums; s = array(vec4(1u), vec4(2u)); return s; }", 1),
            ("fn f() -> Sums { let a = array(vec4(1u), vec4(2u)); data[1] = take(a); return Sums(); }", 1),
            ("fn f() -> Sums { var a = array(vec4(1u), vec4(2u)); change(&a); return Sums(); }", 1),
            ("fn f() -> Sums { let p = Pair(array(vec4(1u), vec4(2u)), 1u); return p.a; }", 1),
        ] {
            let wrong = match understood(&kernel(body)) {
                Ok((module, info)) => other_types(&module, &info),
                Err(refused) => vec![refused],
            };
            assert_eq!(wrong.len(), expected, "{body}: {wrong:#?}");
        }
    }
}
