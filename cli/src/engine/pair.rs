//! The image files of a pair.

use std::path::{Path, PathBuf};

/// A pair to match. A file that holds both views is both the left and the right image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// The left image.
    pub left: PathBuf,
    /// The right image.
    pub right: PathBuf,
}

impl Pair {
    /// The pair in one file.
    pub fn in_one(path: &Path) -> Self {
        Self { left: path.into(), right: path.into() }
    }
}
