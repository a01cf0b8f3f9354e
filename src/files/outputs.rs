//! Files that are written whole or not at all.

use super::disk::{self, temporary};
use super::encoders::{Format, Maps, SheetFormat, encode, jpeg, png};
use super::error::{Context as _, Error, Result, bail};
use super::facts::Facts;
use image::RgbImage;
use rayon::prelude::*;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file to write.
#[derive(Debug)]
pub struct Output<F = Format> {
    /// The path as it was given.
    pub path: PathBuf,
    /// What to write.
    pub format: F,
    /// The file itself, symbolic links followed.
    place: PathBuf,
}

impl<F> Output<F> {
    /// A file of a folder that is known to be writable, by its own name.
    pub fn at(path: PathBuf, format: F) -> Self {
        Self { place: path.clone(), path, format }
    }

    /// A file that is written at `place`, which is where the links of `path` lead.
    pub fn placed(path: PathBuf, place: PathBuf, format: F) -> Self {
        Self { path, format, place }
    }
}

/// What was written.
#[non_exhaustive]
pub struct Written {
    /// The facts of each file, which show later whether it has changed.
    pub facts: Vec<Facts>,
    /// Which values of the maps the files cannot hold, for warnings.
    pub doubts: Vec<String>,
}

/// Checks that every file can hold a map of this size: a TIFF has at most 4 GiB.
///
/// # Errors
/// If a TIFF would be larger.
pub fn ensure_size(outputs: &[Output], width: u32, height: u32) -> Result<()> {
    let too_large = 4 * u64::from(width) * u64::from(height) >= (1 << 32) - (1 << 20);
    match outputs.iter().find(|output| output.format.is_tiff()).filter(|_| too_large) {
        Some(Output { path, .. }) => {
            bail!("output {path:?} is a TIFF, which cannot hold {width}x{height} floats; use .pfm or .npy")
        }
        None => Ok(()),
    }
}

/// Writes maps to every file, or, if one cannot be written, to none.
///
/// # Errors
/// Where a format cannot hold its map, or a file cannot be written.
pub fn write(outputs: &[Output], maps: &Maps<'_>) -> Result<Written> {
    let mut doubts = Vec::new();
    let mut encoded = outputs.par_iter().map(|output| encode(output.format, maps)).collect::<Vec<_>>().into_iter();
    let facts = put(outputs, |format| {
        let encoded = encoded.next().unwrap_or_else(|| encode(format, maps))?;
        doubts.extend(encoded.doubt);
        Ok(encoded.bytes)
    })?;
    Ok(Written { facts, doubts })
}

/// Writes a picture to every file, or, if one cannot be written, to none.
///
/// # Errors
/// Where a file cannot be written.
pub fn write_sheet(outputs: &[Output<SheetFormat>], sheet: &RgbImage) -> Result<()> {
    put(outputs, |format| match format {
        SheetFormat::Png => png(sheet),
        SheetFormat::Jpeg => jpeg(sheet),
    })
    .map(drop)
}

/// Writes a file of these bytes, whole or not at all.
///
/// # Errors
/// Where it cannot be written.
pub fn write_bytes(output: &Output<()>, bytes: &[u8]) -> Result<()> {
    put(std::slice::from_ref(output), |()| Ok(bytes.to_vec())).map(drop)
}

/// Writes every file, or, if one cannot be, none: names appear only when all contents are on disk.
fn put<F: Copy>(outputs: &[Output<F>], mut contents: impl FnMut(F) -> Result<Vec<u8>>) -> Result<Vec<Facts>> {
    let mut written = Vec::new();
    for output in outputs {
        let bytes = contents(output.format).with_context(|| format!("output {:?} cannot be written", output.path))?;
        if let Some(what) = fs::symlink_metadata(&output.place).ok().and_then(|kind| in_the_way(kind.file_type())) {
            bail!(
                "output {:?} cannot be written: {what} is in its place; remove it, or give another name",
                output.path
            );
        }
        let file = stage(folder_of(&output.place), &bytes).map_err(|error| cannot_write(&output.path, error))?;
        written.push((file, bytes));
    }
    let mut files = Vec::new();
    for ((file, bytes), output) in written.into_iter().zip(outputs) {
        let file = file.persist(&output.place).map_err(|error| {
            let error = cannot_write(&output.path, error.error);
            if files.is_empty() { error } else { error.context(kept(&outputs[..files.len()])) }
        })?;
        files.push((file, bytes));
    }
    for (i, output) in outputs.iter().enumerate() {
        let folder = folder_of(&output.place);
        if outputs[..i].iter().all(|other| folder_of(&other.place) != folder) {
            disk::sync_folder(folder).map_err(|error| cannot_write(&output.path, error))?;
        }
    }
    Ok(files.iter().map(|(file, bytes)| facts(file, bytes)).collect())
}

/// Which of several outputs were written when another one fails.
fn kept<F>(outputs: &[Output<F>]) -> String {
    let names: Vec<_> = outputs.iter().map(|output| format!("{:?}", output.path)).collect();
    format!(
        "{} written, the rest not",
        if let [one] = &names[..] { format!("{one} was") } else { names.join(", ") + " were" }
    )
}

/// The facts of a written file. One that was not flushed may be lost in a power cut, so its times are not kept.
fn facts(file: &File, bytes: &[u8]) -> Facts {
    let kind = disk::syncs().then(|| file.metadata().ok()).flatten();
    Facts::of_written(bytes, kind.as_ref())
}

/// The kind of what a file cannot replace. It can replace a link.
fn in_the_way(kind: fs::FileType) -> Option<&'static str> {
    if kind.is_symlink() { None } else { disk::other_than_file(kind) }
}

fn folder_of(place: &Path) -> &Path {
    match place.parent() {
        Some(folder) if folder != Path::new("") => folder,
        Some(_) => Path::new("."),
        None => Path::new("/"),
    }
}

/// A temporary file with its contents on the disk.
fn stage(folder: &Path, bytes: &[u8]) -> std::io::Result<NamedTempFile> {
    let mut file = temporary(folder, "")?;
    file.write_all(bytes)?;
    file.flush()?;
    disk::sync(file.as_file())?;
    Ok(file)
}

/// Writes a file of many, whole or not at all; a missing folder is created. Returns the facts of the file.
///
/// # Errors
/// Where the file cannot be written.
pub fn write_in_folder(path: &Path, bytes: &[u8]) -> Result<Facts> {
    let folder = folder_of(path);
    let write = || -> std::io::Result<Facts> {
        fs::create_dir_all(folder)?;
        let file = stage(folder, bytes)?.persist(path).map_err(|error| error.error)?;
        disk::sync_folder(folder)?;
        Ok(facts(&file, bytes))
    };
    write().map_err(|error| cannot_write(path, error))
}

/// The error that a file cannot be written, and what to do about it.
fn cannot_write(path: &Path, error: std::io::Error) -> Error {
    let told = format!("output {path:?} cannot be written; {}", disk::remedy(&error));
    Error::from(error).context(told)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::encoders::SampleFormat;
    use crate::{DisparityMap, Params};

    fn map(data: &[i16]) -> DisparityMap {
        DisparityMap { width: data.len() as u32, height: 1, data: data.into() }
    }

    #[test]
    fn an_output_that_fails_last_says_which_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.npy", "b.npy", "c.npy"].map(|name| folder.path().join(name));
        let outputs = paths.each_ref().map(|path| Output::at(path.clone(), Format::Disparity(SampleFormat::Npy)));
        let calls = std::cell::Cell::new(0);
        let contents = |_| {
            calls.set(calls.get() + 1);
            if calls.get() == 3 {
                fs::create_dir(&paths[1]).unwrap(); // after it was looked at
            }
            Ok(vec![calls.get()])
        };
        let error = format!("{:#}", put(&outputs, contents).unwrap_err());
        assert!(error.contains("a.npy\" was written, the rest not: output ") && error.contains("b.npy"), "{error}");
        assert_eq!((fs::read(&paths[0]).unwrap(), paths[2].exists()), (vec![1], false));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "temporary files are gone");
    }

    #[test]
    fn a_disparity_that_does_not_fit_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let paths = [folder.path().join("a.npy"), folder.path().join("b.png")];
        let [a, b] = paths;
        let outputs =
            [Output::at(a, Format::Disparity(SampleFormat::Npy)), Output::at(b, Format::Disparity(SampleFormat::Png))];
        assert!(write(&outputs, &Maps::of(&map(&[-16]), &Params::sgm(8))).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
