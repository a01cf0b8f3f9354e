//! A guard of speed that no noise can break. Mesa keeps a local array in registers only where every index of it is a
//! constant once the loops are unrolled; one other index, and the array lies in memory, 2 to 5 times slower on lavapipe
//! (docs/PERFORMANCE.md). So the text of every specialised kernel is searched for such an index.

use wgpu::naga::{self, Expression, Function, Handle, Module, Statement, TypeInner};

use std::collections::{BTreeMap, BTreeSet};

use super::specialisations::{parse, texts};
use crate::gpu::kernels::KERNELS;
use crate::gpu::plan::MOST_TRIPS;

/// The local variables that count a loop from below to a constant.
fn counters(module: &Module, function: &Function, block: &naga::Block, found: &mut Vec<Handle<naga::LocalVariable>>) {
    for statement in block {
        match statement {
            Statement::Block(inner) => counters(module, function, inner, found),
            Statement::If { accept, reject, .. } => {
                counters(module, function, accept, found);
                counters(module, function, reject, found);
            }
            Statement::Switch { cases, .. } => {
                cases.iter().for_each(|case| counters(module, function, &case.body, found));
            }
            Statement::Loop { body, .. } => {
                // `for (..; counter < bound; ..)` is a loop that begins with `if counter < bound {} else { break }`.
                let condition = body.iter().find_map(|statement| match statement {
                    Statement::If { condition, reject, .. } if matches!(reject.last(), Some(Statement::Break)) => {
                        Some(&function.expressions[*condition])
                    }
                    _ => None,
                });
                if let Some(Expression::Binary { op: naga::BinaryOperator::Less, left, right }) = condition
                    && let Expression::Load { pointer } = function.expressions[*left]
                    && let Expression::LocalVariable(counter) = function.expressions[pointer]
                    && number(module, function, *right).is_some_and(|bound| bound <= MOST_TRIPS)
                {
                    found.push(counter);
                }
                counters(module, function, body, found);
            }
            _ => (),
        }
    }
}

fn number(module: &Module, function: &Function, expression: Handle<Expression>) -> Option<u32> {
    let expression = match &function.expressions[expression] {
        Expression::Constant(constant) => &module.global_expressions[module.constants[*constant].init],
        expression => expression,
    };
    match expression {
        Expression::Literal(naga::Literal::U32(value)) => Some(*value),
        Expression::Literal(naga::Literal::I32(value)) => u32::try_from(*value).ok(),
        _ => None,
    }
}

/// Whether an expression is a constant once the loops are unrolled. Arguments of which that is asked are added to
/// `asked`: it is the callers who know.
fn fixed(
    function: &Function,
    counters: &[Handle<naga::LocalVariable>],
    expression: Handle<Expression>,
    asked: &mut BTreeSet<u32>,
) -> bool {
    let mut all = |parts: &[Handle<Expression>]| parts.iter().all(|part| fixed(function, counters, *part, asked));
    match &function.expressions[expression] {
        Expression::Literal(_) | Expression::Constant(_) | Expression::ZeroValue(_) => true,
        Expression::Load { pointer } => {
            matches!(function.expressions[*pointer], Expression::LocalVariable(local) if counters.contains(&local))
        }
        Expression::FunctionArgument(index) => {
            asked.insert(*index);
            true
        }
        Expression::Binary { left, right, .. } => all(&[*left, *right]),
        Expression::Math { arg, arg1, arg2, .. } => {
            let parts: Vec<_> = [Some(*arg), *arg1, *arg2].into_iter().flatten().collect();
            all(&parts)
        }
        Expression::Unary { expr, .. } | Expression::As { expr, .. } => all(&[*expr]),
        Expression::Select { condition, accept, reject } => all(&[*condition, *accept, *reject]),
        _ => false,
    }
}

/// Whether the base of an access is a local array, in a variable, behind a pointer or as a value.
fn is_local_array(module: &Module, resolved: &naga::proc::TypeResolution) -> bool {
    match *resolved.inner_with(&module.types) {
        TypeInner::Pointer { base, space: naga::AddressSpace::Function } => {
            matches!(module.types[base].inner, TypeInner::Array { .. })
        }
        TypeInner::Array { .. } => true,
        _ => false,
    }
}

fn calls(block: &naga::Block, found: &mut Vec<(Handle<Function>, Vec<Handle<Expression>>)>) {
    for statement in block {
        match statement {
            Statement::Call { function, arguments, .. } => found.push((*function, arguments.clone())),
            Statement::Block(inner) => calls(inner, found),
            Statement::If { accept, reject, .. } => {
                calls(accept, found);
                calls(reject, found);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| calls(&case.body, found)),
            Statement::Loop { body, continuing, .. } => {
                calls(body, found);
                calls(continuing, found);
            }
            _ => (),
        }
    }
}

/// The functions of a kernel in which a local array has an index that stays unknown.
fn unknown_indices(text: &str, module: &Module) -> Vec<String> {
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all())
        .validate(module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    // Functions come after those that they call, so the questions of a function are known when all its callers have
    // been seen: from the entry point backwards.
    let mut asked: BTreeMap<Handle<Function>, BTreeSet<u32>> = BTreeMap::new();
    let mut wrong = Vec::new();
    for (handle, function) in module.functions.iter() {
        let questions = examine(module, function, &info[handle], &asked, &mut wrong);
        asked.insert(handle, questions);
    }
    let entry = &module.entry_points[0].function;
    let questions = examine(module, entry, info.get_entry_point(0), &asked, &mut wrong);
    assert!(questions.is_empty(), "an entry point has no caller to ask");
    wrong
}

/// Adds the unknown indices of one function to `wrong`; returns the arguments that its callers must fix.
fn examine(
    module: &Module,
    function: &Function,
    info: &naga::valid::FunctionInfo,
    asked: &BTreeMap<Handle<Function>, BTreeSet<u32>>,
    wrong: &mut Vec<String>,
) -> BTreeSet<u32> {
    let name = function.name.as_deref().unwrap_or("main");
    let mut loops = Vec::new();
    counters(module, function, &function.body, &mut loops);
    let mut questions = BTreeSet::new();
    for (_, expression) in function.expressions.iter() {
        if let Expression::Access { base, index } = *expression
            && is_local_array(module, &info[base].ty)
            && !fixed(function, &loops, index, &mut questions)
        {
            wrong.push(format!("{name}: an index of a local array"));
        }
    }
    let mut called = Vec::new();
    calls(&function.body, &mut called);
    for (callee, arguments) in called {
        for &argument in &asked[&callee] {
            if !fixed(function, &loops, arguments[argument as usize], &mut questions) {
                let callee = module.functions[callee].name.as_deref().unwrap_or("a function");
                wrong.push(format!("{name}: argument {argument} of {callee}, which is an index of a local array"));
            }
        }
    }
    questions
}

#[test]
fn local_arrays_stay_in_registers() {
    for kernel in KERNELS {
        for text in texts(kernel) {
            let wrong = unknown_indices(text, &parse(kernel, text));
            assert!(
                wrong.is_empty(),
                "{}.wgsl: unless loops of at most {MOST_TRIPS} trips to a constant unroll, Mesa keeps an array in \
                 memory: {wrong:?}",
                kernel.name
            );
        }
    }
}

/// The test of the test: a loop to a size that only the device knows, an index from memory, both behind a call.
#[test]
fn arrays_in_memory_are_found() {
    let kernel = |index: &str, bound: &str| {
        format!(
            "@group(0) @binding(0) var<storage, read_write> data: array<u32>;
            fn put(a: ptr<function, array<u32, 8>>, i: u32) {{ (*a)[min(i + 1u, 7u)] += 1u; }}
            @compute @workgroup_size(1) fn main() {{
                var a: array<u32, 8>;
                for (var i = 0u; i < {bound}; i++) {{ put(&a, {index}); a[i] += 1u; }}
                data[0] = a[3];
            }}"
        )
    };
    for (index, bound, expected) in
        [("i", "8u", 0), ("i", "33u", 2), ("i", "data[1]", 2), ("data[2]", "8u", 1), ("data[2] & 7u", "8u", 1)]
    {
        let text = kernel(index, bound);
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        let wrong = unknown_indices(&text, &module);
        assert_eq!(wrong.len(), expected, "{index}, {bound}: {wrong:?}");
    }
}
