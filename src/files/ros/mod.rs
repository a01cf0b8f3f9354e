//! Messages of ROS 2 in CDR: the images and cameras that records hold, and the maps that are written into them.

mod cdr;
mod encodings;
mod read;
mod schemas;
mod write;

pub use read::{CameraInfo, ImageMessage};
pub use schemas::{DEPTH, DISPARITY, POINTS, Schema};
pub use write::{DisparityRange, depth, disparity, points};

use super::error::Result;

/// When and in which frame of coordinates a message was taken.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Seconds and nanoseconds.
    pub stamp: (i32, u32),
    /// The name of the frame.
    pub frame: String,
}

impl Header {
    /// The header that a message begins with.
    ///
    /// # Errors
    /// If the message is cut short or not in CDR.
    pub fn read(message: &[u8]) -> Result<Self> {
        cdr::Reader::new(message)?.header()
    }

    /// Nanoseconds since the epoch of the stamps.
    #[must_use]
    pub fn nanoseconds(&self) -> i64 {
        i64::from(self.stamp.0) * 1_000_000_000 + i64::from(self.stamp.1)
    }
}
