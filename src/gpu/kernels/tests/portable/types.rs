//! Values of another type than the declared one.

use wgpu::naga::{self, Expression, Handle, Module, Statement, TypeInner};

use super::functions::{functions, visit};

/// Arrays and structs that are given where another type of the same shape is declared: the two are one type for WGSL, but not
/// in what naga makes of them.
pub(super) fn other_types(module: &Module, info: &naga::valid::ModuleInfo) -> Vec<String> {
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
                wrong.push(format!(
                    "{}: {what} wants {}, gets {}",
                    super::functions::name(function),
                    name(wanted),
                    name(got)
                ));
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
