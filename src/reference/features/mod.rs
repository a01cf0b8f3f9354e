//! The features that a network makes of an image, for the learned costs: in integers.

pub(crate) mod feature_layer;
pub(crate) mod feature_statistics;
#[allow(clippy::module_inception)] // the stage itself
pub(crate) mod features;
#[cfg(test)]
mod tests;
