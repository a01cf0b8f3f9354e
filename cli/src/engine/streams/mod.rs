//! Streams: pairs of frames that are no files of their own, from videos, stdin and records.

pub mod ffmpeg;
mod messages;
mod partners;
mod record;
mod stream;

pub use record::{Taken, is_record};
pub use stream::Stream;
