//! The headings of the help that several command lines have.

/// What is written and printed.
pub const OUTPUT: &str = "Output";
/// Where to compute.
pub const DEVICE: &str = "Device";
/// What a map is scored against.
pub const TRUTH: &str = "Truth";
