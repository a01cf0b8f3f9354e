//! What runs pairs: an adapter, the native schedule or the reference, one pair or many at a time, and the folder of their maps.

pub mod adapter;
pub mod compute;
pub mod diagnosis;
pub mod disk;
pub mod images;
pub mod log;
pub mod outputs;
pub mod pair;
pub mod pairs;
pub mod pipeline;
pub mod signals;
pub mod store;
pub mod streams;
pub mod trial;

pub use outputs::{files as output_files, known, places};
