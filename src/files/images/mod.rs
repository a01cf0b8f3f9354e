//! Images: two files become the pair that the matcher takes.

mod bits;
mod decoder;
mod kinds;
mod pair;

pub use bits::Bits;
pub(super) use decoder::{decode, decoder};
pub use pair::{ImagePair, read_pair};
