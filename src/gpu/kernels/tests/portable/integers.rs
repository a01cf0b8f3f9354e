//! Arithmetic of integers that a driver may read in its own way.

use std::collections::BTreeMap;

use wgpu::naga::{
    self, AddressSpace, BinaryOperator, Expression, Function, Handle, Literal, MathFunction, Module, Statement,
    TypeInner,
};

use super::functions::{functions, name, visit};

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

    /// The type of a uniform block, or of a struct in one.
    fn uniform(&self, f: &Function, base: Handle<Expression>) -> Option<Handle<naga::Type>> {
        match f.expressions[base] {
            Expression::GlobalVariable(variable) => {
                let variable = &self.module.global_variables[variable];
                (variable.space == AddressSpace::Uniform).then_some(variable.ty)
            }
            Expression::AccessIndex { base, index } => {
                let TypeInner::Struct { members, .. } = &self.module.types[self.uniform(f, base)?].inner else {
                    return None;
                };
                Some(members[index as usize].ty)
            }
            _ => None,
        }
    }

    /// The most of a member of a uniform block that shifts.
    fn shifting(&self, f: &Function, base: Handle<Expression>, index: u32) -> Option<u64> {
        let TypeInner::Struct { members, .. } = &self.module.types[self.uniform(f, base)?].inner else { return None };
        let member = members[index as usize].name.as_deref();
        let known = SHIFTING;
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
pub(super) fn doubtful_integers(module: &Module, info: &naga::valid::ModuleInfo) -> Vec<String> {
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
