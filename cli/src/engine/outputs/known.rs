//! Files with the facts of their contents, for the lines of logs.

use gpu_stereo::files::lists::absolute;
use gpu_stereo::files::{Facts, JsonPath};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A file and its contents.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KnownFile {
    /// Where it is.
    pub path: JsonPath,
    /// What its contents are.
    #[serde(flatten)]
    pub facts: Facts,
}

impl KnownFile {
    /// A file whose contents are known, by its absolute path.
    pub fn new(path: &Path, facts: Facts) -> Self {
        Self { path: absolute(path).into(), facts }
    }

    /// A file as it is now, if it can be read.
    pub fn read(path: &Path) -> Option<Self> {
        Some(Self::new(path, Facts::of_file(path).ok()?))
    }
}
