//! The journal: the pairs that a process has begun, so that after its death a later process knows which of them may have caused it.
//!
//! Each process has its own journal in the output folder, and beside it a file that it keeps locked as long as it lives. A journal
//! whose lock is free was left by a process that died, and the pairs that it began and did not end are suspects. They are computed
//! one by one in a separate process, which may die without harm to the others.

use crate::engine::pair::Pair;
use crate::engine::{disk, log};
use anyhow::{Context as _, Result};
use fd_lock::RwLock;
use gpu_stereo::files::JsonPath;
use gpu_stereo::files::lists::absolute;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const PREFIX: &str = ".gpu-stereo-begun-";

/// A pair that was begun.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Begun {
    /// The name of its map.
    pub name: JsonPath,
    /// The left image's absolute path.
    pub left: JsonPath,
    /// The right image's absolute path.
    pub right: JsonPath,
    /// How many processes computed it alone and died, or have just begun to compute it alone.
    pub alone: u32,
}

impl Begun {
    /// A pair.
    pub fn new(name: &Path, pair: &Pair, alone: u32) -> Self {
        Self { name: name.into(), left: absolute(&pair.left).into(), right: absolute(&pair.right).into(), alone }
    }
}

/// A line of the journal.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Line {
    /// It is to be computed alone.
    Suspect(Begun),
    /// It is being computed.
    Begun(Begun),
    /// It came to an end.
    Ended { name: JsonPath, error: Option<String> },
}

/// The state of a pair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Not begun by this process.
    Suspect,
    /// Begun and not ended.
    Running,
    /// Ended, with an error if it failed.
    Ended(Option<String>),
}

/// What a journal says of each pair.
pub type States = BTreeMap<JsonPath, (Begun, State)>;

/// The journal of this process, or that of the process that started this one.
pub struct Journal {
    /// Where it is.
    pub path: PathBuf,
    lines: Mutex<File>,
    /// Locked until it is dropped.
    _lock: RwLock<File>,
}

impl Journal {
    /// Creates a journal.
    pub fn create(folder: &Path) -> Result<Self> {
        let create = || -> std::io::Result<Self> {
            // The lock file gets its name only once it is locked, or others would take it for that of a dead process.
            let file = disk::temporary(folder, "")?;
            let random = file.path().file_name().map(|name| name.to_string_lossy().replace(".gpu-stereo-", ""));
            let lock = held(file.as_file().try_clone()?)?;
            let path = folder.join(format!("{PREFIX}{}.jsonl", random.unwrap_or_default()));
            file.persist_noclobber(lock_of(&path)).map_err(|error| error.error)?;
            let lines = OpenOptions::new().append(true).create_new(true).open(&path)?;
            Ok(Self { path, lines: Mutex::new(lines), _lock: lock })
        };
        create().map_err(|error| disk::unwritten(error, format_args!("output folder {folder:?}")))
    }

    /// Opens the journal of the process that started this one.
    pub fn join(path: &Path) -> Result<Self> {
        let join = || -> std::io::Result<Self> {
            let lines = OpenOptions::new().append(true).open(path)?;
            let lock = held(OpenOptions::new().read(true).write(true).open(lock_of(path))?)?;
            Ok(Self { path: path.into(), lines: Mutex::new(lines), _lock: lock })
        };
        join().with_context(|| format!("{path:?} cannot be opened"))
    }

    fn add(&self, lines: &[Line]) -> Result<()> {
        let text = log::text(lines)?;
        let mut file = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        // Not synced: what is written outlives the process, if not the system.
        file.write_all(text.as_bytes()).map_err(|error| disk::unwritten(error, format_args!("{:?}", self.path)))
    }

    /// These will be computed alone.
    pub fn suspect(&self, all: impl IntoIterator<Item = Begun>) -> Result<()> {
        self.add(&all.into_iter().map(Line::Suspect).collect::<Vec<_>>())
    }

    /// A pair is about to be read.
    pub fn begin(&self, begun: Begun) -> Result<()> {
        self.add(&[Line::Begun(begun)])
    }

    /// A pair is written, or failed.
    pub fn end(&self, name: &Path, error: Option<&str>) -> Result<()> {
        self.add(&[Line::Ended { name: name.into(), error: error.map(Into::into) }])
    }

    /// What it says.
    pub fn states(&self) -> Result<States> {
        states(&self.path)
    }

    /// Closes the journal at the end of a run: what this process began is no suspect; earlier suspects stay in the file.
    pub fn close(&self) -> Result<()> {
        let states = self.states()?;
        let stay = |(begun, state): &(Begun, State)| match state {
            State::Suspect => true,
            State::Running => begun.alone > 0,
            State::Ended(_) => false,
        };
        if !states.values().any(stay) {
            return remove(&self.path);
        }
        let ended = states.values().filter(|of| of.1 == State::Running && of.0.alone == 0);
        let ended = ended.map(|(begun, _)| Line::Ended { name: begun.name.clone(), error: None });
        self.add(&ended.collect::<Vec<_>>())
    }
}

/// A file with a shared lock that lasts until it is dropped.
fn held(file: File) -> std::io::Result<RwLock<File>> {
    let lock = RwLock::new(file);
    mem::forget(lock.try_read()?);
    Ok(lock)
}

/// The file that is locked while a journal is in use.
fn lock_of(journal: &Path) -> PathBuf {
    journal.with_extension("lock")
}

fn remove(journal: &Path) -> Result<()> {
    let gone = |path: &Path| match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    };
    let removed = gone(journal).and_then(|()| gone(&lock_of(journal)));
    removed.with_context(|| format!("{journal:?} cannot be removed"))
}

/// What a journal says.
pub fn states(path: &Path) -> Result<States> {
    let mut states = States::new();
    let lines = (log::Log { path: path.into() }).read::<Line>()?;
    for line in lines {
        match line {
            Line::Suspect(begun) => drop(states.insert(begun.name.clone(), (begun, State::Suspect))),
            Line::Begun(begun) => drop(states.insert(begun.name.clone(), (begun, State::Running))),
            Line::Ended { name, error } => {
                if let Some((_, state)) = states.get_mut(&name) {
                    *state = State::Ended(error);
                }
            }
        }
    }
    Ok(states)
}

/// The journal of a process that died. Nobody else can open it meanwhile.
pub struct Dead {
    path: PathBuf,
    /// The pairs that it began and did not end.
    pub suspects: BTreeMap<JsonPath, Begun>,
    _lock: RwLock<File>,
}

impl Dead {
    /// All dead journals of a folder.
    pub fn find(folder: &Path) -> Vec<Self> {
        let dead = |path: PathBuf| {
            let lock = exclusive(&path)?;
            let open = |(name, (begun, state))| (!matches!(state, State::Ended(_))).then_some((name, begun));
            let suspects = states(&path).ok()?.into_iter().filter_map(open).collect();
            Some(Self { path, suspects, _lock: lock })
        };
        journals(folder).filter_map(dead).collect()
    }

    /// Takes over these suspects, and removes the file if no other is left.
    pub fn take(mut self, names: impl Iterator<Item = JsonPath>) -> Result<()> {
        let taken: Vec<_> = names.filter(|name| self.suspects.remove(name).is_some()).collect();
        if self.suspects.is_empty() {
            return remove(&self.path);
        }
        let lines: Vec<_> = taken.into_iter().map(|name| Line::Ended { name, error: None }).collect();
        log::Log { path: self.path }.append(&lines, false)
    }
}

/// An exclusive lock on a journal; `None` if it is in use.
fn exclusive(journal: &Path) -> Option<RwLock<File>> {
    let mut lock = RwLock::new(OpenOptions::new().read(true).write(true).open(lock_of(journal)).ok()?);
    let guard = lock.try_write().ok()?;
    mem::forget(guard);
    Some(lock)
}

/// The journals of a folder that have a lock file, which is created first and removed last.
fn journals(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let is_lock = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_file = || fs::symlink_metadata(path).is_ok_and(|kind| kind.is_file());
        name.starts_with(PREFIX) && name.ends_with(".lock") && is_file()
    };
    let paths = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    paths.filter(is_lock).map(|lock| lock.with_extension("jsonl"))
}

/// Whether a process other than that of this journal writes into a folder.
pub fn is_in_use(folder: &Path, own: Option<&Journal>) -> bool {
    journals(folder)
        .any(|path| own.is_none_or(|own| own.path != path) && exclusive(&path).is_none() && lock_of(&path).exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun(name: &str, alone: u32) -> Begun {
        Begun { name: name.into(), left: "/l".into(), right: "/r".into(), alone }
    }

    #[test]
    fn what_a_dead_process_began_is_suspect() {
        let folder = tempfile::tempdir().unwrap();
        let journal = Journal::create(folder.path()).unwrap();
        journal.suspect([begun("s", 1)]).unwrap();
        for name in ["a", "b", "c"] {
            journal.begin(begun(name, 0)).unwrap();
        }
        journal.end(Path::new("b"), None).unwrap();
        journal.end(Path::new("c"), Some("no image")).unwrap();
        assert!(Dead::find(folder.path()).is_empty(), "it lives");
        assert!(is_in_use(folder.path(), None) && !is_in_use(folder.path(), Some(&journal)));
        drop(journal);
        assert!(!is_in_use(folder.path(), None));
        let mut dead = Dead::find(folder.path());
        let first = dead.pop().unwrap();
        assert!(dead.is_empty() && Dead::find(folder.path()).is_empty(), "one process takes it");
        assert!(first.suspects.values().eq([&begun("a", 0), &begun("s", 1)]));
        first.take([JsonPath::from("a")].into_iter()).unwrap();
        let rest = Dead::find(folder.path()).pop().unwrap();
        assert!(rest.suspects.values().eq([&begun("s", 1)]));
        rest.take([JsonPath::from("s")].into_iter()).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_process_that_ends_in_order_leaves_only_what_was_suspect_before() {
        let folder = tempfile::tempdir().unwrap();
        let journal = Journal::create(folder.path()).unwrap();
        journal.begin(begun("a", 0)).unwrap();
        journal.close().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let journal = Journal::create(folder.path()).unwrap();
        journal.begin(begun("a", 0)).unwrap();
        journal.suspect([begun("s", 0)]).unwrap();
        let other = Journal::join(&journal.path).unwrap();
        other.begin(begun("s", 1)).unwrap();
        journal.close().unwrap();
        drop(journal);
        assert!(Dead::find(folder.path()).is_empty(), "the other one lives");
        drop(other);
        let dead = Dead::find(folder.path()).pop().unwrap();
        assert!(dead.suspects.values().eq([&begun("s", 1)]));
    }
}
