//! Disk: what it takes that a file is still whole after a power cut, what is in the way of one, and which failures stay.

use anyhow::{Context as _, Result, bail, ensure};
use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Component, Path};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// A lock that is waited for longer is reported.
const PATIENCE: Duration = Duration::from_secs(1);

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

/// Whether what cannot be written now cannot be written a moment later, either, and nothing else can be.
pub fn is_lasting(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>()).any(|error| {
        // EIO, ENFILE, EMFILE
        let of_unix = cfg!(unix) && matches!(error.raw_os_error(), Some(5 | 23 | 24));
        of_unix
            || matches!(
                error.kind(),
                ErrorKind::StorageFull
                    | ErrorKind::QuotaExceeded
                    | ErrorKind::FileTooLarge
                    | ErrorKind::ReadOnlyFilesystem
                    | ErrorKind::StaleNetworkFileHandle
            )
    })
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

/// A file that is written beside maps is a regular one, if it is there: a link leads elsewhere, and a FIFO would never open.
pub fn ensure_own(path: &Path) -> Result<()> {
    match fs::symlink_metadata(path).ok().and_then(|kind| other_than_file(kind.file_type())) {
        Some(what) => {
            bail!("{path:?} is {what}, but a regular file is needed there; remove it, or give another folder")
        }
        None => Ok(()),
    }
}

/// Opens such a file.
pub fn open_own(path: &Path, options: &OpenOptions) -> Result<File> {
    ensure_own(path)?;
    match options.open(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            let remedy = remedy(&error);
            Err(error).with_context(|| format!("{path:?} cannot be opened; {remedy}"))
        }
        other => Ok(other?),
    }
}

/// Makes the folder of a file below `out`, and is sure that no link leads out of it.
pub fn make_folder_below(out: &Path, folder: &Path) -> Result<()> {
    let Ok(below) = folder.strip_prefix(out) else { return Ok(()) };
    let mut at = out.to_owned();
    for part in below.components().filter(|part| matches!(part, Component::Normal(_))) {
        let parent = at.clone();
        at.push(part);
        if fs::symlink_metadata(&at).is_err() {
            match fs::create_dir(&at) {
                Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                    let remedy = remedy(&error);
                    return Err(error).with_context(|| format!("output folder {at:?} cannot be made; {remedy}"));
                }
                _ => sync_folder(&parent).with_context(|| format!("output folder {at:?} cannot be made"))?,
            }
        }
        ensure_plain_folder(&at)?;
    }
    Ok(())
}

/// What is there, if anything, is no link.
pub fn ensure_no_link(path: &Path) -> Result<()> {
    ensure!(
        !fs::symlink_metadata(path).is_ok_and(|kind| kind.is_symlink()),
        "output folder {path:?} is a link, which may lead out of the output folder; remove it, or give other names"
    );
    Ok(())
}

/// What is there, if anything, is a folder and no link.
pub fn ensure_plain_folder(folder: &Path) -> Result<()> {
    ensure_no_link(folder)?;
    let Ok(kind) = fs::symlink_metadata(folder) else { return Ok(()) };
    ensure!(
        kind.is_dir(),
        "output folder {folder:?} cannot be made; a file is in its place: remove it, or give another name"
    );
    Ok(())
}

/// Works on a file while nobody else does. It says so if it has to wait.
pub fn locked<T>(path: &Path, file: File, work: impl FnOnce(&mut File) -> Result<T>) -> Result<T> {
    let mut lock = fd_lock::RwLock::new(file);
    let start = Instant::now();
    let mut reported = false;
    loop {
        match lock.try_write() {
            Ok(mut file) => return work(&mut file),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => {
                return Err(error).with_context(|| format!("{path:?} cannot be locked; give a folder of another disk"));
            }
        }
        if !reported && start.elapsed() >= PATIENCE {
            reported = true;
            crate::tell(&format!("note: waiting for {path:?}, which another process has locked"));
        }
        thread::sleep(Duration::from_millis(if reported { 50 } else { 2 }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    #[test]
    fn a_full_disk_lasts_and_a_missing_file_does_not() {
        let lasting = |kind: ErrorKind| is_lasting(&anyhow::Error::from(io::Error::from(kind)).context("of a map"));
        assert!(
            lasting(ErrorKind::StorageFull) && lasting(ErrorKind::FileTooLarge) && lasting(ErrorKind::QuotaExceeded)
        );
        assert!(!lasting(ErrorKind::NotFound) && !lasting(ErrorKind::PermissionDenied));
        assert!(!is_lasting(&anyhow!("something else")));
        #[cfg(unix)]
        for number in [5, 28, 27, 30, 122] {
            let lasts = is_lasting(&io::Error::from_raw_os_error(number).into());
            assert!(lasts || (number == 122 && !cfg!(target_os = "linux")), "{number}");
        }
    }
}
