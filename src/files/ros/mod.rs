//! Messages of ROS 2 in CDR: the images and cameras that records hold, and the maps that are written into them.

mod cdr;
mod encodings;
mod header;
mod read;
mod schemas;
mod write;

pub use header::Header;
pub use read::{CameraInfo, ImageMessage};
pub use schemas::{DEPTH, DISPARITY, POINTS, Schema};
pub use write::{DisparityRange, depth, disparity, points};
