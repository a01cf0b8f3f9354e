//! Logs: files of JSON lines, to which several processes may append at once.

use crate::engine::disk;
use crate::terminal;
use anyhow::{Context as _, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::PathBuf;

/// A file of lines.
#[derive(Debug)]
pub struct Log {
    /// Where it is.
    pub path: PathBuf,
}

impl Log {
    /// Appends whole lines in one write. `sync`: waits until they are on the disk.
    pub fn append(&self, lines: &[impl Serialize], sync: bool) -> Result<()> {
        let mut text = text(lines)?;
        let file = disk::open_own(&self.path, OpenOptions::new().read(true).append(true).create(true))?;
        disk::locked(&self.path, file, |file| {
            let mut add = || -> std::io::Result<()> {
                // A process that ended in the middle of a line spoils only that one.
                let mut last = [b'\n'];
                if file.seek(SeekFrom::End(-1)).is_ok() {
                    file.read_exact(&mut last)?;
                }
                if last != [b'\n'] {
                    text.insert(0, '\n');
                }
                let before = file.seek(SeekFrom::End(0))?;
                let written =
                    file.write_all(text.as_bytes()).and_then(|()| if sync { disk::sync(file) } else { Ok(()) });
                if written.is_err() {
                    let _ = file.set_len(before); // the error is what matters
                }
                written
            };
            add().map_err(|error| disk::unwritten(error, format_args!("{:?}", self.path)))
        })
    }

    /// Refuses anything but a regular file, or none.
    pub fn ensure_own(&self) -> Result<()> {
        disk::ensure_own(&self.path)
    }

    /// Waits until it is on the disk, if it is there.
    pub fn sync(&self) -> Result<()> {
        let synced = match OpenOptions::new().append(true).open(&self.path) {
            Ok(file) => disk::sync(&file),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            Err(error) => Err(error),
        };
        synced.map_err(|error| disk::unwritten(error, format_args!("{:?}", self.path)))
    }

    /// The complete lines; none if there is no such file.
    pub fn read<L: DeserializeOwned>(&self) -> Result<Vec<L>> {
        let read = || -> Result<Vec<u8>> {
            let mut bytes = Vec::new();
            disk::open_own(&self.path, OpenOptions::new().read(true))?.read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let bytes = match read() {
            Err(error) if is_missing(&error) => return Ok(Vec::new()),
            other => other.with_context(|| format!("{:?} cannot be read", self.path))?,
        };
        Ok(bytes.split(|&byte| byte == b'\n').filter_map(|line| serde_json::from_slice(line).ok()).collect())
    }
}

/// Lines as they are written, with control characters escaped.
pub fn text(lines: &[impl Serialize]) -> Result<String> {
    lines.iter().map(|line| Ok(terminal::json(line)? + "\n")).collect()
}

/// Whether there is no such file.
pub fn is_missing(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|error| error.kind() == ErrorKind::NotFound)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_torn_line_spoils_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let log = Log { path: folder.path().join("log") };
        let read = || log.read::<String>().unwrap();
        assert!(read().is_empty());
        log.append(&["a\n"], false).unwrap();
        let mut bytes = fs::read(&log.path).unwrap();
        bytes.extend(&bytes.clone()[..3]);
        fs::write(&log.path, bytes).unwrap();
        log.append(&["b"], true).unwrap();
        log.append(&["c", "d"], false).unwrap();
        assert_eq!(read(), ["a\n", "b", "c", "d"]);
    }

    #[test]
    fn lines_of_many_threads_are_whole() {
        let folder = tempfile::tempdir().unwrap();
        let log = Log { path: folder.path().join("log") };
        std::thread::scope(|scope| {
            for first in 0..8 {
                let log = &log;
                let add = move || (first..400).step_by(8).for_each(|i| log.append(&["n".repeat(i)], false).unwrap());
                scope.spawn(add);
            }
        });
        let mut lengths: Vec<_> = log.read::<String>().unwrap().iter().map(String::len).collect();
        lengths.sort_unstable();
        assert!(lengths.into_iter().eq(0..400));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_its_place_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let log = Log { path: folder.path().join("log") };
        std::os::unix::fs::symlink(folder.path().join("other"), &log.path).unwrap();
        assert!(log.append(&["a"], false).unwrap_err().to_string().contains("is a link"));
        assert!(log.read::<String>().is_err() && !folder.path().join("other").exists());
    }
}
