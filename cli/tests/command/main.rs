//! The built program as its users meet it: a file for each of its sides.
#![allow(clippy::unwrap_used)]

mod batch;
mod calibrations;
mod cli;
mod depth;
mod evaluation;
mod input;
mod masks;
#[cfg(target_os = "linux")]
mod memory;
mod outputs;
mod range;
#[cfg(unix)]
mod resume;
mod sources;
mod support;
mod terminal;
mod video;
mod weights;
