//! The caller's textures and buffers.

mod cache;
mod checks;
mod context;
mod frame_ends;
mod pipelines;
mod refusal;
mod regions;
mod resources;
#[cfg(test)]
mod tests;
mod work;
mod yuv_checks;

pub(crate) use cache::PassCache;
pub(crate) use context::Context;
pub(crate) use pipelines::Prepared;
pub(crate) use regions::Regions;
pub use resources::{Inputs, Outputs, PixelBuffer, TextureLayer, YuvPicture};
#[cfg(test)]
pub(crate) use tests::{are_made, texts};
#[cfg(test)]
pub(crate) use work::SHADERS;
pub(crate) use work::VALUES;
