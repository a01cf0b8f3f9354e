//! What computes the maps of pairs, as the options ask for it, and the settings that are fitted to the cameras.

mod cameras;
mod engine;
mod names;
mod range;

pub use cameras::{Cameras, OfPair, ParamsBySize};
pub use engine::{Computed, FrameMs, again, check, frames, open};
pub use names::EngineNames;
pub use range::{Coarse, RangeFinder, ends, joined};
