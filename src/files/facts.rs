//! Facts: length, hash and times of a file, which show later whether it has changed.

use super::error::{Context as _, Result};
use serde::{Deserialize, Serialize};
use std::fs::{self, File, Metadata};
use std::hash::Hasher as _;
use std::io::Read as _;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};
use twox_hash::XxHash3_64;

/// A file that changed less than this many nanoseconds ago may change again and keep its times: file systems round them.
const RECENT: i64 = 2_000_000_000;

/// When the contents were last changed (mtime) and, where that is known, when anything of the file was (ctime), in
/// nanoseconds since 1970. Setting the first one back changes the second.
type Stamp = [i64; 2];

/// The length and the hash of a file, and the times that spare hashing it again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Facts {
    /// Its length.
    pub bytes: u64,
    /// XXH3 of its contents, 64 bits.
    pub hash: String,
    /// While the file has these times, its hash is still right. `None`: the contents must be read to compare them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stamp: Option<Stamp>,
}

/// XXH3 of bytes.
pub fn hash(bytes: &[u8]) -> String {
    format!("{:016x}", XxHash3_64::oneshot(bytes))
}

impl Facts {
    /// The facts of a file whose contents were read, with its metadata from before and after.
    pub fn of_read(bytes: &[u8], [before, after]: [&Metadata; 2]) -> Self {
        let stamp = stamp(before).filter(|at| stamp(after) == Some(*at) && is_settled(at));
        Self { bytes: bytes.len() as u64, hash: hash(bytes), stamp }
    }

    /// The facts of a file that this process wrote. `kind`: its metadata, now that it is on the disk.
    pub fn of_written(bytes: &[u8], kind: Option<&Metadata>) -> Self {
        Self { bytes: bytes.len() as u64, hash: hash(bytes), stamp: kind.and_then(stamp) }
    }

    /// The facts of a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn of_file(path: &Path) -> Result<Self> {
        let read = || -> std::io::Result<Self> {
            let mut file = File::open(path)?;
            let before = file.metadata()?;
            let (mut hasher, mut bytes, mut part) = (XxHash3_64::default(), 0, vec![0; 1 << 20]);
            loop {
                match file.read(&mut part)? {
                    0 => break,
                    n => {
                        hasher.write(&part[..n]);
                        bytes += n as u64;
                    }
                }
            }
            let after = file.metadata()?;
            let stamp = stamp(&before).filter(|at| stamp(&after) == Some(*at) && is_settled(at));
            Ok(Self { bytes, hash: format!("{:016x}", hasher.finish()), stamp })
        };
        read().with_context(|| format!("{path:?} cannot be read"))
    }

    /// Whether a file that `kind` describes has these contents. They are read only if its times differ.
    fn are_of(&self, path: &Path, kind: &Metadata) -> bool {
        let same_times = || self.stamp.is_some() && self.stamp == stamp(kind);
        let same_contents =
            || Self::of_file(path).is_ok_and(|facts| facts.hash == self.hash && facts.bytes == self.bytes);
        kind.is_file() && kind.len() == self.bytes && (same_times() || same_contents())
    }

    /// Whether an input still has these contents.
    pub fn are_of_input(&self, path: &Path) -> bool {
        fs::metadata(path).is_ok_and(|kind| self.are_of(path, &kind))
    }

    /// Whether an output still has these contents, and is no link.
    pub fn are_of_output(&self, path: &Path) -> bool {
        fs::symlink_metadata(path).is_ok_and(|kind| self.are_of(path, &kind))
    }
}

/// Whether a change after the file was read would give it other times.
fn is_settled(at: &Stamp) -> bool {
    nanoseconds(SystemTime::now()).is_some_and(|now| at.iter().all(|&changed| changed < now - RECENT))
}

fn nanoseconds(time: SystemTime) -> Option<i64> {
    time.duration_since(UNIX_EPOCH).ok().and_then(|since| i64::try_from(since.as_nanos()).ok())
}

fn stamp(kind: &Metadata) -> Option<Stamp> {
    let modified = nanoseconds(kind.modified().ok()?)?;
    #[cfg(unix)]
    let changed = {
        use std::os::unix::fs::MetadataExt as _;
        kind.ctime().checked_mul(1_000_000_000)?.checked_add(kind.ctime_nsec())?
    };
    #[cfg(not(unix))]
    let changed = modified;
    Some([modified, changed])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_are_told_apart_whatever_the_times_say() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "old").unwrap();
        let kind = fs::metadata(&path).unwrap();
        let facts = Facts::of_read(b"old", [&kind, &kind]);
        assert_eq!((facts.bytes, facts.stamp), (3, None), "it may change within the same tick of the clock");
        assert_eq!(facts, Facts::of_file(&path).unwrap());
        assert!(facts.are_of_input(&path) && facts.are_of_output(&path));
        fs::write(&path, "new").unwrap();
        File::options().write(true).open(&path).unwrap().set_modified(kind.modified().unwrap()).unwrap();
        assert!(!facts.are_of_input(&path));
        fs::write(&path, "older").unwrap();
        assert!(!facts.are_of_input(&path));
        // A copy has other times.
        fs::write(&path, "old").unwrap();
        assert!(Facts { stamp: Some([1, 1]), ..facts.clone() }.are_of_input(&path));
        // With its times it is taken for the same unseen.
        let kind = fs::metadata(&path).unwrap();
        let unseen = Facts { stamp: stamp(&kind), hash: "0".into(), ..facts.clone() };
        assert!(unseen.are_of_input(&path));
        fs::remove_file(&path).unwrap();
        assert!(!facts.are_of_input(&path));
        fs::create_dir(&path).unwrap();
        assert!(!facts.are_of_output(&path));
    }
}
