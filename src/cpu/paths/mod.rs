//! Semi-global matching, from the rows of the cost to the winners of both views: the stages `sgm_aggregate`, `second_cost` and `winner`.
//!
//! A path's cost is L = C + T, so the sum over P paths is P C plus all T, and only T, at most P2 <= 127, is kept: of two paths in
//! a byte. ARCHITECTURE.md shows how the rows are walked.

mod across;
mod aggregation;
mod buffers;
mod down;
mod front;
mod meet;
mod memory;
mod penalties;
mod second_cost;
mod step;
mod team;
#[cfg(test)]
mod tests;

pub(crate) use aggregation::{Aggregation, CostSource, Record};
pub(crate) use buffers::Buffers;
pub(crate) use meet::{aggregate, second_cost};
pub(crate) use penalties::penalties;
