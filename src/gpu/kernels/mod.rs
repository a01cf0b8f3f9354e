//! The table of kernels: everything that turns a WGSL file into a pipeline.

mod compile;
mod constants;
mod limits;
mod source;
mod table;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use compile::{Compiled, CompiledKey, compile};
pub(crate) use limits::check_limits;
pub(crate) use source::source;
pub(crate) use table::{Access, KERNELS};
