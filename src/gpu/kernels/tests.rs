//! Every row of the table: valid WGSL, the folder's files, the Rust twins' layouts, WebGPU's limits; and the proof that
//! a wrong shader is found.

mod bindings;
mod folders;
mod grammar;
mod limits;
mod mutants;
mod pipelines;
mod portable;
pub(crate) mod rounds;
mod settings;
mod specialisations;
#[path = "../../../tests/support/mod.rs"]
pub(crate) mod support;
mod unrolling;

pub(crate) use settings::Setup;
