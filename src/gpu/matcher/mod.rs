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
mod timestamps;
mod upload;

pub use stereo_matcher::StereoMatcher;
pub(crate) use timestamps::Stamps;
pub use timestamps::{TimedSpan, Timestamps};
