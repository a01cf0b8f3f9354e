//! From the given cameras to the rectified ones.

mod stereo_rectify;
mod undistort;
mod view;

pub use stereo_rectify::{Rectified, Wanted, stereo_rectify};
