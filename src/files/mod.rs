//! Everything that reads and writes files: images, masks, disparity maps, calibrations, lists of pairs, truths, data sets,
//! weights of networks, and the encoders of maps, depths, points and pictures.
//!
//! Nothing here prints: warnings are returned with the result. An [`Error`] is one sentence; options that it names are those
//! of the command.

pub mod calibration;
mod contents;
#[cfg(test)]
mod damage;
pub mod datasets;
pub mod disk;
pub mod encoders;
mod error;
mod facts;
pub mod frames;
pub mod images;
mod json_path;
pub mod lists;
pub mod maps;
pub mod masks;
pub mod outputs;
pub mod ros;
pub mod truth;
pub mod weights;
mod zip;

pub use contents::{MAX_BYTES, hint};
pub use error::{Error, Result};
pub use facts::{Facts, hash};
pub use json_path::JsonPath;
