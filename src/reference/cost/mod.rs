//! The matching cost.

pub(crate) mod cost_columns;
pub(crate) mod descriptors;
pub(crate) mod matching_cost;
pub(crate) mod mi_histogram;
pub(crate) mod mi_table;
