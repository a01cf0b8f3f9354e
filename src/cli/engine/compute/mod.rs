//! What computes the maps of pairs: an adapter, the native schedule or the reference; and the cameras that settings are fitted to.

mod beforehand;
mod cameras;
mod engine;
mod names;
mod on_cpu;
mod range;

pub use beforehand::{Beforehand, Shape, upright};
pub use cameras::{Cameras, ParamsBySize};
pub use engine::{Computed, Engine, FrameMs, OnAdapter};
pub use names::EngineNames;
pub use on_cpu::OnCpu;
pub use range::find as find_range;
