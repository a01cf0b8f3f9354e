//! Files that belong to a result.

use crate::engine::known::KnownFile;
use anyhow::Result;
use gpu_stereo::files::outputs;
use std::path::Path;

/// Writes a file that belongs to a result.
pub fn put(path: &Path, bytes: &[u8]) -> Result<KnownFile> {
    Ok(KnownFile::new(path, outputs::write_in_folder(path, bytes)?))
}
