//! Maps, depths and pictures as the bytes of files.

mod depth;
mod disparity;
mod font;
mod format;
mod map;
mod pictures;
mod points;
mod samples;
mod scale_bar;

pub use depth::{metres, millimetres};
pub use font::Font;
pub use format::{
    Format, Look, PointFormat, SampleFormat, SheetFormat, default_format, ending, ensure_range, sample_format, searched,
};
pub use map::{Encoded, Maps, encode};
pub use pictures::{picture, rgba8, truth_picture};
pub(super) use points::{Point, coloured};
pub use points::{pcd, ply};
pub use samples::{jpeg, npy, pfm, png, png8, png16, tiff};
