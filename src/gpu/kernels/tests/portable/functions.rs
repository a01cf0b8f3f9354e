//! A text as naga understands it, and its functions and statements.

use wgpu::naga::{self, Function, Handle, Module, Statement};

use crate::gpu::kernels::tests::specialisations::CAPABILITIES;

/// The functions of a module, the entry points last.
pub(super) fn functions(module: &Module) -> Vec<(Option<Handle<Function>>, &Function)> {
    let named = module.functions.iter().map(|(handle, function)| (Some(handle), function));
    named.chain(module.entry_points.iter().map(|entry| (None, &entry.function))).collect()
}

/// Visits all statements of a block.
pub(super) fn visit<'a>(block: &'a naga::Block, see: &mut dyn FnMut(&'a Statement)) {
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

pub(super) fn name(function: &Function) -> &str {
    function.name.as_deref().unwrap_or("an entry point")
}

/// A text as naga understands it; what naga itself says if it does not.
pub(super) fn understood(text: &str) -> Result<(Module, naga::valid::ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), CAPABILITIES);
    validator.subgroup_stages(naga::valid::ShaderStages::COMPUTE);
    validator.subgroup_operations(naga::valid::SubgroupOperationSet::all());
    let info = validator.validate(&module).map_err(|error| error.emit_to_string(text))?;
    Ok((module, info))
}
