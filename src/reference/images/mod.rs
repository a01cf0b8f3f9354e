//! From the images to what the cost compares.

pub(crate) mod gray;
pub(crate) mod halve;
pub(crate) mod prefilter;
pub(crate) mod rectify;
pub(crate) mod window_sums;
