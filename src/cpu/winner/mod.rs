//! The winner of each pixel, of both views: stage `winner` and the second half of `block_match`.

mod finish;
mod keys;
mod rows;
#[cfg(test)]
mod tests;

pub(crate) use finish::{Found, RowOfMaps};
pub(crate) use keys::RightKeys;
pub(crate) use rows::{Costs, WinnerRow};
