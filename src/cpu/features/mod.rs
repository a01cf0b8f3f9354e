//! The features of an image. Layers of points add products of pairs of 16-bit numbers; the others compute in 32-bit floats, in which
//! whole numbers below 2^24 are exact, as all sums here are. A piece of the image goes through all layers row by row, so that what lies
//! between two layers stays in the second cache.

mod input;
mod prepared;
mod row;
mod rows;
mod strip;
#[cfg(test)]
pub(crate) mod tests;
mod vectors;

pub use rows::FeatureRows;
