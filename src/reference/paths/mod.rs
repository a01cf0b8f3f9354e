//! Semi-global matching.

pub(crate) mod penalties;
pub(crate) mod second_cost;
pub(crate) mod sgm_aggregate;
