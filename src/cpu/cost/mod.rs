//! The matching cost, row by row.

mod compare;
mod kernels;
mod pixels;
mod quantise;
mod rows;
mod sums;
#[cfg(test)]
pub(crate) mod tests;

pub use rows::CostRows;
