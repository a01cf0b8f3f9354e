//! Frames: streams of pictures without a file each, as `ffmpeg` and cameras write them into a pipe, and the pixels of messages.

mod lines;
mod packing;
mod pam;
mod raw;
mod reader;
mod y4m;

pub use packing::Packing;
pub use raw::RawFrames;
pub use reader::FrameReader;
