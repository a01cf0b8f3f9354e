//! The list of steps that a frame is computed by.

mod builder;
mod level;
mod planned;
mod pool;
mod step;
mod weights;
mod written;

pub(crate) use builder::{Bound, Builder};
pub(crate) use level::{Level, levels, rooms};
pub(crate) use pool::Pool;
pub(crate) use step::{Step, record_steps};
pub(crate) use weights::{Held, Weights};
pub(crate) use written::Written;
