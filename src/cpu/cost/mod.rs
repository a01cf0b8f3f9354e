//! The matching cost, row by row.

mod angles;
mod block_match;
mod compare;
mod correlation;
mod kernels;
mod pixels;
mod quantise;
mod rows;
mod sums;
#[cfg(test)]
pub(crate) mod tests;

pub use block_match::block_match;
pub use rows::CostRows;
