//! The winners of both views.

pub(crate) mod block_match;
pub(crate) mod block_statistics;
pub(crate) mod mirror;
pub(crate) mod winner;
