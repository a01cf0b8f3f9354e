//! Dense stereo matching in WGSL compute shaders.
#![cfg_attr(test, allow(clippy::unwrap_used))]

#[cfg(test)]
extern crate self as gpu_stereo; // for tests/support, which the unit tests share

mod buffers;
mod check;
mod error;
mod image;
mod kernels;
mod matcher;
mod params;
mod readback;
pub mod reference;

pub use check::{Mismatch, StageCheck};
pub use error::Error;
pub use image::{DisparityMap, Image, PixelFormat, Pixels};
pub use matcher::{StageTime, StereoMatcher};
pub use params::{Median, Method, Params, Paths, Prefilter};
pub use wgpu;
