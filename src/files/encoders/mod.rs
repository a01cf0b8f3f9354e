//! Maps, depths and pictures as the bytes of files.

mod depth;
mod disparity;
mod format;
mod map;
mod pictures;
mod points;
mod samples;

pub use depth::{metres, millimetres};
pub use format::{
    Format, PointFormat, SampleFormat, SheetFormat, default_format, ending, ensure_range, sample_format, searched,
};
pub use map::{Encoded, Maps, encode};
pub use pictures::{picture, rgba8, truth_picture};
pub use points::{pcd, ply};
pub use samples::{jpeg, npy, pfm, png, png8, png16, tiff};
