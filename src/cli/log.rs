//! Logs: what came of the pairs of a batch, a JSON object a line. Several processes may write one at once.

use crate::list::absolute;
use crate::pipeline::Pair;
use crate::record::read_shared;
use crate::terminal;
use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// A line: a pair, with its failure if it failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The name of its map.
    pub name: String,
    /// The left image's absolute path.
    pub left: String,
    /// The right image's absolute path.
    pub right: String,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl Line {
    /// A pair that did not fail.
    pub fn new(name: &str, pair: &Pair) -> Self {
        let text = |path: &Path| absolute(path).to_string_lossy().into_owned();
        Self { name: name.into(), left: text(&pair.left), right: text(&pair.right), error: None }
    }
}

/// A file of lines.
#[derive(Debug)]
pub struct Log {
    /// Where it is.
    pub path: PathBuf,
}

impl Log {
    /// Adds a whole line.
    pub fn append(&self, line: &Line) -> Result<()> {
        let add = || -> Result<()> {
            let mut text = terminal::json(line)? + "\n";
            let file = OpenOptions::new().read(true).append(true).create(true).open(&self.path)?;
            let mut lock = fd_lock::RwLock::new(file);
            let mut file = lock.write()?;
            // A process that ended in the middle of a line spoils that one alone.
            let mut last = [b'\n'];
            if file.seek(SeekFrom::End(-1)).is_ok() {
                file.read_exact(&mut last)?;
            }
            if last != [b'\n'] {
                text.insert(0, '\n');
            }
            file.write_all(text.as_bytes())?;
            Ok(())
        };
        add().with_context(|| format!("{:?} cannot be written; check the space and its permissions", self.path))
    }

    /// The lines that are whole; none if there is no such file.
    pub fn read(&self) -> Result<Vec<Line>> {
        match read_shared(&self.path) {
            Ok(bytes) => {
                Ok(bytes.split(|&byte| byte == b'\n').filter_map(|l| serde_json::from_slice(l).ok()).collect())
            }
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(error).with_context(|| format!("{:?} cannot be read; check its permissions", self.path)),
        }
    }

    /// Begins anew.
    pub fn remove(&self) -> std::io::Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torn_line_spoils_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let log = Log { path: folder.path().join("log") };
        let line = |name: &str| Line { name: name.into(), left: "l".into(), right: "r\n".into(), error: None };
        assert_eq!(log.read().unwrap(), []);
        log.append(&line("a")).unwrap();
        let mut bytes = fs::read(&log.path).unwrap();
        bytes.extend(&bytes.clone()[..7]);
        fs::write(&log.path, bytes).unwrap();
        log.append(&line("b")).unwrap();
        log.append(&line("c")).unwrap();
        assert_eq!(log.read().unwrap(), ["a", "b", "c"].map(line));
        log.remove().unwrap();
        log.remove().unwrap();
        assert_eq!(log.read().unwrap(), []);
    }

    #[test]
    fn lines_of_many_threads_are_whole() {
        let folder = tempfile::tempdir().unwrap();
        let log = Log { path: folder.path().join("log") };
        let line = |i: usize| Line { name: "n".repeat(i), left: "l".into(), right: "r".into(), error: None };
        std::thread::scope(|scope| {
            for first in 0..8 {
                let log = &log;
                scope.spawn(move || (first..400).step_by(8).for_each(|i| log.append(&line(i)).unwrap()));
            }
        });
        let mut lengths: Vec<_> = log.read().unwrap().iter().map(|line| line.name.len()).collect();
        lengths.sort_unstable();
        assert!(lengths.into_iter().eq(0..400));
    }
}
