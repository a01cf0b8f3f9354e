//! What the pairs of a store become, before any of them is computed.

use super::{journal, record};
use crate::engine::pair::Pair;
use crate::engine::{disk, output_files};
use anyhow::{Result, bail, ensure};
use gpu_stereo::files::encoders::Format;
use gpu_stereo::files::outputs::Output;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// The log of the maps.
pub const DONE: &str = "done.jsonl";
/// The log of the failures.
pub const FAILURES: &str = "failures.jsonl";
/// Names of files that are the store's own.
const OWN: [&str; 3] = [record::NAME, DONE, FAILURES];

/// What a pair becomes.
#[derive(Debug)]
pub struct Item {
    /// A path within the output folder, without an ending.
    pub name: PathBuf,
    /// The files.
    pub outputs: Vec<Output>,
}

impl Item {
    /// The files of these formats.
    pub fn new(out: &Path, name: PathBuf, formats: &[Format]) -> Self {
        Self { outputs: output_files::of_name(out, &name, formats), name }
    }
}

/// A pair and what it becomes.
#[derive(Debug)]
pub struct Planned {
    /// The images.
    pub pair: Pair,
    /// The maps.
    pub item: Item,
    /// The line of the list, if it is in one.
    pub line: Option<usize>,
}

impl Planned {
    fn label(&self) -> String {
        let line = self.line.map(|line| format!(" (line {line})")).unwrap_or_default();
        format!("{:?}{line}", self.pair.left)
    }
}

/// The pairs of a journal that did not come to an end, with the names of their maps.
pub fn suspects(journal: &Path) -> Result<Vec<(Pair, PathBuf)>> {
    let open = journal::states(journal)?.into_values();
    let open = open.filter(|(_, state)| !matches!(state, journal::State::Ended(_)));
    Ok(open.map(|(begun, _)| (Pair { left: begun.left.0, right: begun.right.0 }, begun.name.0)).collect())
}

/// No two pairs have a file in common, and no file is in the way of another's folder or of the store's own files.
pub fn ensure_possible(out: &Path, all: &[Planned], caseless: bool, advice: &str) -> Result<()> {
    let key = |path: &Path| if caseless { path.to_string_lossy().to_lowercase().into() } else { path.to_owned() };
    let own: HashSet<PathBuf> = OWN.iter().map(|name| key(&out.join(name))).collect();
    let mut files = HashMap::new();
    for planned in all {
        for Output { path, .. } in &planned.item.outputs {
            if let Some(other) = files.insert(key(path), planned) {
                bail!("{} and {} would both become {path:?}; {advice}", other.label(), planned.label());
            }
        }
    }
    let mut folders = HashSet::new();
    for planned in all {
        for Output { path, .. } in &planned.item.outputs {
            for folder in path.ancestors().skip(1).take_while(|folder| *folder != out) {
                if !folders.insert(folder) {
                    break; // and so were those that it is in
                }
                let is_own = own.contains(&key(folder));
                ensure!(
                    !is_own,
                    "{folder:?} would be the folder of {path:?}, but it is a file of gpu-stereo itself; {advice}"
                );
                if let Some(other) = files.get(&key(folder)) {
                    bail!(
                        "{folder:?} would be the map of {} and the folder of that of {}; {advice}",
                        other.label(),
                        planned.label()
                    );
                }
                disk::ensure_no_link(folder)?;
            }
        }
    }
    Ok(())
}
