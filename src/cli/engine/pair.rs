//! The two image files of a pair.

use std::path::PathBuf;

/// A pair to match.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// The left image.
    pub left: PathBuf,
    /// The right image.
    pub right: PathBuf,
}
