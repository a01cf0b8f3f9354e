//! Images: two files become the pair that the matcher takes.

mod bits;
mod decoder;
mod kinds;
mod pair;

pub use bits::Bits;
pub use decoder::has_image_ending;
pub(super) use decoder::{decode, decoder};
pub use pair::{ImagePair, read_pair};
