//! The entries of a store's logs.

use super::plan::Item;
use crate::engine::known::KnownFile;
use crate::engine::pair::Pair;
use crate::engine::pipeline::PairKind;
use gpu_stereo::files::JsonPath;
use gpu_stereo::files::lists::absolute;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A line of failures.jsonl, which can be read as a list of pairs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FailedLine {
    /// The name of its map.
    pub name: JsonPath,
    /// The left image's absolute path.
    pub left: JsonPath,
    /// The right image's absolute path.
    pub right: JsonPath,
    /// Why.
    pub error: String,
}

/// A line of done.jsonl: the maps of a pair and the files they were made of. The last line of a name counts.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// The name of the maps.
    pub name: JsonPath,
    /// The fingerprint of the settings. Without it the entry is void.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<String>,
    /// The images.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<KnownFile>,
    /// The maps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outputs: Vec<KnownFile>,
    /// Files that may exist with unknown contents.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<JsonPath>,
    /// Size and samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<PairKind>,
    /// The first and the last disparity searched, if the pair decided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub searched: Option<[i32; 2]>,
    /// Set if the pair ended the processes that computed it: how.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub killed: Option<String>,
}

impl Entry {
    /// A void entry.
    pub fn empty(name: &Path) -> Self {
        Self {
            name: name.into(),
            settings: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            files: Vec::new(),
            kind: None,
            searched: None,
            killed: None,
        }
    }

    /// Whether the entry is about this pair, with the present contents of its images.
    pub fn is_of(&self, settings: &str, pair: &Pair) -> bool {
        let paths = [&pair.left, &pair.right].map(|path| JsonPath(absolute(path)));
        self.settings.as_deref() == Some(settings)
            && self.inputs.iter().map(|input| &input.path).eq(&paths)
            && self.inputs.iter().all(|input| input.facts.are_of_input(&input.path.0))
    }

    /// Whether the maps of an item still exist as they were written.
    pub fn has(&self, out: &Path, item: &Item) -> bool {
        item.outputs.iter().all(|output| {
            let known = self.outputs.iter().find(|known| out.join(&known.path.0) == output.path);
            known.is_some_and(|known| known.facts.are_of_output(&output.path))
        })
    }
}
