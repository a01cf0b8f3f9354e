//! The list of steps that a frame is computed by.

mod builder;
mod level;
mod output;
mod pool;
mod step;

pub(crate) use builder::{Bound, Builder};
pub(crate) use level::{Level, levels, rooms};
pub(crate) use output::Output;
pub(crate) use pool::Pool;
pub(crate) use step::{Step, record_steps};
