//! From the images to what the cost compares: planes of bytes.

mod channels;
mod derivatives;
mod descriptors;
mod gray;
mod padded;
mod planes;
mod prefilter;
#[cfg(test)]
mod tests;

pub use channels::Channels;
pub use gray::luma;
pub use padded::Samples;
pub use planes::{Planes, Side};
