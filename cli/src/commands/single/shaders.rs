//! `--dump-shaders`: the text of every kernel of the run, a file each.

use crate::engine::places;
use anyhow::{Context as _, Result, ensure};
use std::fs;
use std::path::Path;

/// Before any work: the folder is new or empty, and can be written.
pub fn ensure_empty(folder: &Path, inputs: &[&Path]) -> Result<()> {
    let is_used = fs::read_dir(folder).is_ok_and(|mut files| files.next().is_some());
    ensure!(!is_used, "--dump-shaders is {folder:?}, which is not empty; give a new or an empty folder");
    ensure!(!folder.is_file(), "--dump-shaders is {folder:?}, which is a file; give a new or an empty folder");
    places::ensure_apart([folder.join("name.wgsl").as_path()], inputs.iter().copied())
}

/// Writes the texts into the folder.
pub fn write(folder: &Path, shaders: &[(String, &str)]) -> Result<()> {
    places::ensure_folder(folder)?;
    for (name, text) in shaders {
        let path = folder.join(format!("{name}.wgsl"));
        fs::write(&path, text)
            .with_context(|| format!("{path:?} cannot be written; check the disk, or give another folder"))?;
    }
    Ok(())
}
