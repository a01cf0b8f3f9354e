//! Belief propagation.

pub(crate) mod coarse_cost;
pub(crate) mod messages;
