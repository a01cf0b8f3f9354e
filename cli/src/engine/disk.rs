//! The folder of a run's maps: what may be written there, and by one process at a time.

use crate::terminal::message;
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::files;
pub use gpu_stereo::files::disk::{leave_to_the_system, other_than_file, remedy, sync, sync_folder, temporary};
use std::fmt::Display;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Component, Path};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempPath;

/// A lock that is waited for longer is reported.
const PATIENCE: Duration = Duration::from_secs(1);

/// Whether what cannot be written now cannot be written a moment later either, and nothing else can be.
pub fn is_lasting(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| match cause.downcast_ref::<files::Error>() {
        Some(error) => error.is_lasting(),
        None => cause.downcast_ref::<io::Error>().is_some_and(|error| files::Error::of_io(error).is_lasting()),
    })
}

/// The error of writing `what`, which says so, and how to go on.
pub fn unwritten(error: impl Into<anyhow::Error>, what: impl Display) -> anyhow::Error {
    let error = error.into();
    let cause = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    let remedy = cause.map(|cause| format!("; {}", remedy(cause))).unwrap_or_default();
    error.context(format!("{what} cannot be written{remedy}"))
}

/// Gives a file that was written under another name its own, once its contents are on the disk.
pub fn publish(contents: &File, written: TempPath, place: &Path) -> io::Result<()> {
    sync(contents)?;
    written.persist(place).map_err(|error| error.error)?;
    sync_folder(place.parent().unwrap_or(Path::new("/")))
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
            message(&format!("note: waiting for {path:?}, which another process has locked"));
        }
        thread::sleep(Duration::from_millis(if reported { 50 } else { 2 }));
    }
}
