//! Barriers that some invocations of a workgroup may not reach.

use std::collections::BTreeSet;

use wgpu::naga::{self, AddressSpace, Expression, Function, Handle, Module, Statement};

use super::functions::{functions, name};

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
pub(super) fn lonely_barriers(module: &Module) -> Vec<String> {
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
