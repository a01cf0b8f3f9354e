//! What runs pairs: an adapter, the native schedule or the reference, one pair or many at a time, and the folder of their maps.

pub mod adapter;
pub mod compute;
pub mod diagnosis;
pub mod disk;
mod environment;
pub mod ffmpeg;
pub mod images;
pub mod known;
pub mod log;
pub mod output_files;
pub mod pair;
pub mod pairs;
pub mod pipeline;
pub mod places;
pub mod signals;
pub mod store;
pub mod stream;
pub mod trial;
