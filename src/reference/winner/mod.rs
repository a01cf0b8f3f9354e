//! The winners of both views.

pub(crate) mod block_match;
pub(crate) mod block_statistics;
pub(crate) mod mirror;
#[allow(clippy::module_inception)] // the stage has the name of its folder
pub(crate) mod winner;
