//! Dense stereo matching in WGSL compute shaders, equal to a plain CPU reference to the bit.
//!
//! Two rectified images go in, the disparity of every left pixel comes out. The stages, in order:
//!
//! 1. `gray`: luma, or with [`Params::color_cost`] red, green and blue, at the depth of the samples; and luma in 8
//!    bits.
//! 2. `prefilter`: the horizontal Sobel derivative, the gradient magnitude, the difference from the mean of a window,
//!    or the gray image itself ([`Prefilter`]).
//! 3. `features`: the bytes of a pixel that the cost compares ([`Cost`]): a value, derivatives, a census string
//!    ([`Census`]) and others.
//! 4. `cost_columns`, `matching_cost`: the sum of the costs of pixels over a block for each disparity, quantised to
//!    0..=89.
//! 5. `penalties`, `sgm_aggregate`: semi-global matching along 3 to 16 directions ([`Paths`]).
//! 6. `winner`: the disparity of the smallest aggregate, the uniqueness test, 1/16 px ([`Subpixel`]), the right view.
//!    With [`Method::Bm`], `block_match` does this on the block sums, in place of `matching_cost`, 5 and 6.
//! 7. `texture`: what a block that holds too little says is dropped.
//! 8. `lr_check`: a left pixel keeps its disparity if the right view agrees ([`RightView`]).
//! 9. `speckle`, `median` ([`Median`]), `fill` ([`Fill`]), `weighted_median`, `wls` ([`Wls`]): filters of the map,
//!    those that are asked for; `confidence`; `depth` ([`Camera`]).
//!
//! docs/ALGORITHMS.md defines every stage in exact integers. [`mod@reference`] is that definition in Rust,
//! [`StereoMatcher`] the schedule that computes it on a device. No result depends on the device, the order of
//! evaluation or a rounding mode.
//!
//! # In another program
//!
//! The matcher works on the caller's device. It needs no optional feature, and WebGPU's default limits suffice; with
//! [`StereoMatcher::required_features`] it is faster, and
//! [`StereoMatcher::required_limits`] raises them so that large pairs are cut into fewer bands.
//!
//! ```no_run
//! use gpu_stereo::{DisparityMap, Error, Image, Inputs, Outputs, Params, Pixels, StereoMatcher, reference, wgpu};
//!
//! fn frame(device: &wgpu::Device, queue: &wgpu::Queue, l: Vec<u8>, r: Vec<u8>) -> Result<DisparityMap, Error> {
//!     let left = Image::new(741, 500, Pixels::Gray8(l))?;
//!     let right = Image::new(741, 500, Pixels::Gray8(r))?;
//!     let params = Params::sgm(64);
//!     let matcher = StereoMatcher::new(device, queue, 741, 500, left.format(), &params)?; // once
//!
//!     // In the caller's own frame: `record` neither submits nor waits.
//!     matcher.upload(&left, &right)?;
//!     let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
//!     matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default())?;
//!     let _map: &wgpu::Buffer = matcher.output(); // i16 in 1/16 px, two pixels a word: for the caller's next pass
//!     queue.submit([encoder.finish()]);
//!
//!     // Is this device right? The blocking convenience beside the definition.
//!     let map = matcher.compute_blocking(&left, &right)?.map;
//!     assert_eq!(map, reference::compute(&left, &right, &params)?);
//!     Ok(map)
//! }
//! ```
//!
//! [`StereoMatcher::check_blocking`] compares after every stage instead and names the first value that differs.
//!
//! `wgpu` is exported again, so that the caller's device and the matcher's are of one version.
//!
//! # Features
//!
//! `cli` (default): the command `gpu-stereo` and its file formats. The library alone: `default-features = false`.
#![cfg_attr(test, allow(clippy::unwrap_used))]

#[cfg(test)]
extern crate self as gpu_stereo; // for tests/support, which the unit tests share

mod buffers;
mod camera;
mod chain;
mod check;
mod error;
mod image;
mod kernels;
mod matcher;
mod options;
mod params;
mod readback;
pub mod reference;
mod schedule;
mod steps;
mod stream;
mod surfaces;

pub use camera::Camera;
pub use check::{Mismatch, StageCheck};
pub use error::Error;
pub use image::{ConfidenceMap, DepthMap, DisparityMap, Image, Matched, PixelFormat, Pixels};
pub use matcher::{Reading, StageTime, StereoMatcher};
pub use options::ParamOption;
pub use params::{Census, Cost, Fill, Median, Method, Params, Paths, Prefilter, Preset, RightView, Subpixel, Wls};
pub use schedule::Schedule;
pub use stream::{StereoStream, StreamFrame};
pub use surfaces::{Inputs, Outputs};
pub use wgpu;
