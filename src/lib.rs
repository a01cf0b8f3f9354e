//! Dense stereo matching in WGSL compute shaders.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod error;
mod image;
mod matcher;
mod params;
pub mod reference;

pub use error::Error;
pub use image::{DisparityMap, Image, PixelFormat, Pixels};
pub use params::{Median, Method, Params, Paths, Prefilter};
pub use wgpu;
