//! The matcher: images in, maps out, on the caller's device.

mod another;
mod build;
mod compute;
mod rebuild;
mod record;
mod shaders;
mod shared_kernels;
mod stereo_matcher;
mod timed;
mod timer;
mod upload;

pub use stereo_matcher::StereoMatcher;
