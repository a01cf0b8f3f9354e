//! Dense stereo matching in WGSL compute shaders, equal to a plain CPU reference to the bit.
//!
//! Two rectified images go in, the disparity of every left pixel comes out. The stages, in order:
//!
//! 0. `rectify`, optional: rectifies pairs that are not yet rectified ([`Rectification`]).
//! 1. `gray`: luma, or with [`Params::color_cost`] red, green and blue, at the depth of the samples; and luma in 8
//!    bits.
//! 2. `prefilter`: the horizontal Sobel derivative, the gradient magnitude, the difference from the mean of a window,
//!    or the gray image itself ([`Prefilter`]).
//! 3. `descriptors`: the bytes of a pixel that the cost compares ([`Cost`]): a value, derivatives, a census string
//!    ([`Census`]) and others.
//! 4. `cost_columns`, `matching_cost`: the sum of the costs of pixels over a block for each disparity, quantised to
//!    0..=89.
//! 5. `penalties`, `sgm_aggregate`: semi-global matching along 3 to 16 directions ([`Paths`]).
//! 6. `winner`: the disparity of the smallest aggregate, the uniqueness test, 1/16 px ([`Subpixel`]), the right view.
//!    With [`Method::Bp`], `coarse_cost` and `messages` are in place of 5: belief propagation ([`Smoothness`]).
//!    With [`Method::Bm`], `block_match` does this on the block sums, in place of `matching_cost`, 5 and 6.
//!    `validity`: what is outside the image that was rectified, or masked ([`Masks`]), has no disparity; here, and again
//!    after each filter that gives one.
//! 7. `texture`: drops disparities of blocks with too little texture.
//! 8. `lr_check`: a left pixel keeps its disparity if the right view agrees ([`RightView`]).
//! 9. `speckle`, `median` ([`Median`]), `fill` ([`Fill`]), `weighted_median`, `wls` ([`Wls`]): filters of the map,
//!    those that are switched on; `confidence`; `depth` ([`Camera`]).
//!
//! docs/ALGORITHMS.md defines every stage in exact integers. [`mod@reference`] is that definition in Rust,
//! [`StereoMatcher`] computes it on a device by a schedule of its own. No result depends on the device, the order of
//! evaluation or a rounding mode.
//!
//! # In another program
//!
//! The matcher works on the caller's device, from the caller's textures or buffers into such, in the caller's encoder.
//! It needs no optional feature, and WebGPU's default limits suffice; with [`StereoMatcher::required_features`] it is
//! faster, and [`StereoMatcher::required_limits`] raises them so that large pairs are cut into fewer bands.
//!
//! ```no_run
//! use gpu_stereo::{Error, Inputs, Outputs, Params, PixelFormat, StereoMatcher, wgpu};
//!
//! /// Textures of 1280x720: `left` and `right` in Rgba8Unorm with the usage TEXTURE_BINDING, `disparity` in R32Float
//! /// with RENDER_ATTACHMENT.
//! fn program(
//!     device: &wgpu::Device,
//!     queue: &wgpu::Queue,
//!     [left, right, disparity]: [&wgpu::Texture; 3],
//! ) -> Result<(), Error> {
//!     let matcher = StereoMatcher::new(device, queue, 1280, 720, PixelFormat::Rgba8, &Params::default_for(64))?; // once
//!
//!     loop {
//!         let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
//!         // ... passes that draw `left` and `right` ...
//!         let outputs = Outputs::default().disparity(disparity);
//!         matcher.record(&mut encoder, &Inputs::textures(left, right), &outputs)?; // neither submits nor waits
//!         // ... passes that read `disparity`: pixels, -2048 where there is none ...
//!         queue.submit([encoder.finish()]);
//!     }
//! }
//! ```
//!
//! [`Inputs`] and [`Outputs`] list the formats. After the first frame [`StereoMatcher::record`] allocates nothing on the
//! device. examples/embed.rs is a whole program.
//!
//! From the program's own memory instead: [`Image`] holds samples, [`ImageView`] borrows them, with any stride and in the order of
//! OpenCV, too. [`StereoMatcher::compute`] waits for the maps of one pair, a [`StereoStream`] has several in flight, and
//! `cpu::CpuMatcher` needs no device. All give the same bits; [`StereoMatcher::check`] compares every stage with the reference and
//! names the first value that differs.
//!
//! Settings are [`Params`]: [`Params::default_for`] a number of disparities, a [`Preset`], or by the names of the command's options
//! ([`Params::from_options`]). Every mistake is an [`Error`], whose variants say what a program can do then. A size is
//! `width, height` where a function takes one, `[width, height]` where a value holds both. [`evaluation`] scores a map against a truth.
//!
//! # Features
//!
//! | feature | what it brings |
//! |---|---|
//! | `gpu` | the matcher on a device, by wgpu: [`StereoMatcher`], [`StereoStream`]; `wgpu`, so that both sides have one version |
//! | `cpu` | the module `gpu_stereo::cpu`: the matcher without a device |
//! | `gpu` and `cpu` | the module `gpu_stereo::backend`, which takes the best adapter of the machine or the CPU |
//! | `files` | the module `gpu_stereo::files`: reads and writes images, maps, calibrations, lists and truths |
//! | `tracing` | spans of the crate `tracing`, target `gpu_stereo`, around what a matcher does on the host: `new`, `rebuild` (other sizes and settings), `build` (its steps), `upload`, `record`, `compute`, `submit`, `wait`; at the level TRACE `pass`, each compute pass with its first stage |
//! | `serde` | settings, cameras and rectifications by serde |
//! | `vulkan`, `metal`, `dx12`, `gles`, `vulkan-portability` | the backends of wgpu of that name; in a browser there is WebGPU's |
//!
//! Default are `gpu`, `vulkan`, `metal` and `dx12`. A program that brings a device has chosen its backends: `default-features = false,
//! features = ["gpu"]`. Without a device: `["cpu"]`. The command is a package of its own, gpu-stereo-cli.
//!
//! # Browsers
//!
//! The library builds for `wasm32-unknown-unknown`, with wgpu's backend WebGPU. Nothing can block there: what has
//! `blocking` in its name does not exist. The errors of a device are known only when the browser reports them: in place of
//! `new`, `resize` and `set_params`, which do not exist there, are [`StereoMatcher::new_async`],
//! [`StereoMatcher::resize_async`] and [`StereoMatcher::set_params_async`], and [`StereoMatcher::compute`],
//! [`StereoMatcher::read`], [`StereoMatcher::check`] and the results of a [`StereoStream`] come with it.
//! [`mod@reference`] works, on one thread.
#![cfg_attr(test, allow(clippy::unwrap_used))]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(target_arch = "wasm32", allow(dead_code, unused_imports))] // what only blocking functions use
#![cfg_attr(not(all(feature = "gpu", feature = "cpu")), allow(dead_code, unused_imports))] // what only one schedule uses

#[cfg(test)]
extern crate self as gpu_stereo; // for tests/support, which the unit tests share

#[cfg(all(feature = "cpu", feature = "gpu", not(target_arch = "wasm32")))]
#[cfg_attr(docsrs, doc(cfg(all(feature = "cpu", feature = "gpu"))))]
pub mod backend;
#[cfg(any(feature = "cpu", feature = "gpu"))]
mod check;
mod color;
#[cfg(feature = "cpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "cpu")))]
pub mod cpu;
mod error;
pub mod evaluation;
pub mod features;
#[cfg(feature = "files")]
#[cfg_attr(docsrs, doc(cfg(feature = "files")))]
pub mod files;
#[cfg(feature = "gpu")]
mod gpu;
mod image;
mod image_view;
pub mod memory;
pub mod network;
mod params;
pub mod reference;
mod search;
mod yuv;

#[cfg(any(feature = "cpu", feature = "gpu"))]
#[cfg_attr(docsrs, doc(cfg(any(feature = "cpu", feature = "gpu"))))]
pub use check::{Mismatch, StageCheck};
pub use color::{Colors, turbo};
pub use error::Error;
pub use features::FeatureNetwork;
#[cfg(feature = "gpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "gpu")))]
pub use gpu::interop::{Inputs, Outputs, PixelBuffer, TextureLayer, YuvPicture};
#[cfg(feature = "gpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "gpu")))]
pub use gpu::map_layout::{MapFormat, MapLayout};
#[cfg(feature = "gpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "gpu")))]
pub use gpu::matcher::{StereoMatcher, TimedSpan, Timestamps};
#[cfg(feature = "gpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "gpu")))]
pub use gpu::reading::Reading;
#[cfg(feature = "gpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "gpu")))]
pub use gpu::stream::{StereoStream, StreamFrame};
pub use image::{
    ConfidenceMap, DepthMap, DisparityMap, Energy, Image, Labels, Matched, PixelFormat, Pixels, StageTime, Unrounded,
};
pub use image_view::{ImageView, ViewFormat};
pub use network::{Architecture, Network};
pub use params::{
    Camera, Census, Cost, Distortion, Fill, Lens, Masks, Median, Method, ParamOption, Params, Paths, Prefilter, Preset,
    Rectification, RightView, Schedule, Smoothness, Subpixel, Wls,
};
pub use search::RangeSearch;
#[cfg(feature = "gpu")]
#[cfg_attr(docsrs, doc(cfg(feature = "gpu")))]
pub use wgpu;
pub use yuv::YuvColors;
