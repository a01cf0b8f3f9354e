//! The disk: what it takes that a file is still whole after a power cut, and what is in the way of one.

use std::fs::{File, FileType};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::NamedTempFile;

static SYNC: AtomicBool = AtomicBool::new(true);

/// `--no-sync`: files are left to the system, which writes them when it likes.
pub fn leave_to_the_system() {
    SYNC.store(false, Ordering::Relaxed);
}

/// Whether a file is on the disk when it has its name.
pub fn syncs() -> bool {
    SYNC.load(Ordering::Relaxed)
}

/// Waits until the contents of a file are on the disk.
pub fn sync(file: &File) -> io::Result<()> {
    if syncs() { supported(file.sync_all()) } else { Ok(()) }
}

/// Waits until the names in a folder are on the disk.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // Elsewhere a folder is no file.
    if !syncs() || !cfg!(unix) {
        return Ok(());
    }
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    match File::open(folder) {
        Ok(folder) => supported(folder.sync_all()),
        Err(error) if error.kind() == ErrorKind::PermissionDenied => Ok(()), // it may be written, but not be listed
        Err(error) => Err(error),
    }
}

/// Some file systems have no such thing.
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

/// What is there, if it is no regular file.
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
        _ => Some("no regular file"),
    }
}

/// A file that disappears unless it is renamed, with the permissions that an ordinary new file has.
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
