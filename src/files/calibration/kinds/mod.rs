//! The kinds of calibrations, each by the structure of its files.

mod basalt;
mod camera_info;
mod euroc;
mod foundation_stereo;
mod kalibr;
mod kitti;
mod middlebury;
mod opencv;
mod plain;
mod source;

pub use source::Source;
mod zed;
