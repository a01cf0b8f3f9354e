//! Semi-global matching.

pub(crate) mod penalties;
pub(crate) mod sgm_aggregate;
