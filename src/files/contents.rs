//! The contents of regular files.

use super::error::{Context as _, Result, bail, ensure};
use super::facts::Facts;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;

/// The largest file, and the largest decoded image, that is read: a header can declare any size, and a decoder would
/// allocate it. 1 GiB is 130 megapixels of 16-bit colour.
pub const MAX_BYTES: u64 = 1 << 30;

/// A guess from its form why a path does not exist, to end a sentence with; empty without one.
pub fn hint(path: &Path) -> String {
    let text = path.to_string_lossy();
    match text.split_once("://") {
        Some(("file", _)) => return ", not an address: drop file://".into(),
        Some(_) => return format!(", not an address: download it first, by curl -LO {}", in_shell(path)),
        None => {}
    }
    let hint = match () {
        () if text.starts_with('~') => "; the shell expands ~ only outside quotes",
        () if cfg!(not(windows)) && text.contains('\\') => "; separate folders by / instead of \\",
        () => "",
    };
    hint.into()
}

/// A path as a word of a shell's command line; `FILE` if it cannot be shown so.
pub(super) fn in_shell(path: &Path) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./:%+,=@".contains(c);
    match path.to_str() {
        Some(text) if text.contains(|c: char| c.is_control() || c == '\'') => "FILE".into(),
        Some(text) if !text.is_empty() && text.chars().all(is_plain) => text.into(),
        Some(text) => format!("'{text}'"),
        None => "FILE".into(),
    }
}

/// Describes a pointer file of Git LFS or git-annex, whose content is yet to be fetched; `None` for any other file.
pub(super) fn pointer(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"version https://git-lfs.github.com/spec/") {
        return Some(
            "a Git LFS pointer, not the file itself; run git lfs pull in its repository (once before: install git-lfs)",
        );
    }
    let is_annexed = bytes.len() < 4096 && bytes.starts_with(b"/annex/objects/");
    is_annexed.then_some("a git-annex pointer, not the file itself; run git annex get")
}

/// The bytes of a regular file of at most [`MAX_BYTES`], which holds `what`.
///
/// # Errors
/// If it is not a regular file, cannot be read, is empty or too large, or is the pointer of a file that was not fetched.
pub fn read_file(path: &Path, what: &str) -> Result<Vec<u8>> {
    read_file_with_facts(path, what).map(|(bytes, _)| bytes)
}

/// As [`read_file`], with the facts that show later whether the file has changed.
///
/// # Errors
/// As [`read_file`].
pub fn read_file_with_facts(path: &Path, what: &str) -> Result<(Vec<u8>, Facts)> {
    let kind = match fs::metadata(path) {
        Ok(kind) => kind,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            bail!("{path:?} does not exist; give the path of {what}{}", hint(path))
        }
        Err(error) => {
            return Err(error).with_context(|| format!("{path:?} cannot be read; give the path of {what}"));
        }
    };
    ensure!(!kind.is_dir(), "{path:?} is a folder; give the path of {what}");
    ensure!(kind.is_file(), "{path:?} is not a regular file; save {what} to a file first");
    ensure!(
        kind.len() <= MAX_BYTES,
        "{path:?} has {} bytes, but at most {MAX_BYTES} are read; crop or scale it",
        kind.len()
    );
    let read = || -> std::io::Result<_> {
        let mut file = File::open(path)?;
        let before = file.metadata()?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let facts = Facts::of_read(&bytes, [&before, &file.metadata()?]);
        Ok((bytes, facts))
    };
    let (bytes, facts) = read().with_context(|| format!("{path:?} cannot be read; check its permissions"))?;
    ensure!(!bytes.is_empty(), "{path:?} is empty; save it again");
    if let Some(pointer) = pointer(&bytes) {
        bail!("{path:?} is {pointer}");
    }
    Ok((bytes, facts))
}
