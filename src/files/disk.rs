//! The disk: flushing files and folders, so that they survive a power cut, and why a file cannot be written.

use std::fs::{File, FileType};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::NamedTempFile;

static SYNC: AtomicBool = AtomicBool::new(true);

/// `--no-sync`: files are not flushed; the system writes them to the disk in its own time.
pub fn leave_to_the_system() {
    SYNC.store(false, Ordering::Relaxed);
}

/// Whether a file is flushed to the disk before it gets its name.
pub fn syncs() -> bool {
    SYNC.load(Ordering::Relaxed)
}

/// Waits until the contents of a file are on the disk.
///
/// # Errors
/// If they cannot be written.
pub fn sync(file: &File) -> io::Result<()> {
    if syncs() { supported(file.sync_all()) } else { Ok(()) }
}

/// Waits until the names in a folder are on the disk.
///
/// # Errors
/// If they cannot be written.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // Other systems cannot open a folder as a file.
    if !syncs() || !cfg!(unix) {
        return Ok(());
    }
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    match File::open(folder) {
        Ok(folder) => supported(folder.sync_all()),
        Err(error) if error.kind() == ErrorKind::PermissionDenied => Ok(()), // a folder that can be written, but not read
        Err(error) => Err(error),
    }
}

/// Ignores the error of file systems that do not support flushing.
fn supported(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput) => Ok(()),
        other => other,
    }
}

/// What to do about a file that cannot be written.
pub fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space, or give another folder",
        ErrorKind::FileTooLarge => "raise the limit of file sizes (ulimit -f), or give another folder",
        ErrorKind::ReadOnlyFilesystem => "give a folder that can be written",
        _ => "check the space and the permissions of its folder",
    }
}

/// The kind of what exists at a path; `None` for a regular file.
pub fn other_than_file(kind: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        if kind.is_fifo() {
            return Some("a FIFO");
        }
        if kind.is_socket() || kind.is_block_device() || kind.is_char_device() {
            return Some("a socket or a device");
        }
    }
    match kind {
        _ if kind.is_dir() => Some("a folder"),
        _ if kind.is_symlink() => Some("a link"),
        _ if kind.is_file() => None,
        _ => Some("something other than a file"),
    }
}

/// A file that is deleted unless it is renamed, with the permissions of an ordinary new file.
///
/// # Errors
/// If it cannot be created.
pub fn temporary(folder: &Path, suffix: &str) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gpu-stereo-").suffix(suffix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // less the umask
    }
    builder.tempfile_in(folder)
}
