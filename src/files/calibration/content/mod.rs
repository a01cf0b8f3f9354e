//! What the files of calibrations hold: YAML, JSON, XML and NumPy's archives become the values under each path of names.

mod names;
mod node;
mod npz;
mod numpy;
mod parse;
pub mod tree;
mod xml;
mod yaml;

pub use names::canonical;
pub use npz::{is_archive, npz};
pub use parse::{json, yaml};
pub use xml::xml;
