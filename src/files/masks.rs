//! Masks: which pixels of the given images have content, from image files.

use super::contents::read_file;
use super::error::{Result, ensure};
use super::images::{decode, decoder};
use crate::{Image, Masks};
use std::path::{Path, PathBuf};

/// A mask: a byte a pixel, row by row from the top, 0 where all colours of the image are 0.
struct Mask {
    /// Columns.
    width: u32,
    /// Rows.
    height: u32,
    /// The bytes.
    data: Vec<u8>,
}

/// Reads a mask.
fn read_mask(path: &Path) -> Result<Mask> {
    let file = read_file(path, "a mask")?;
    let image = decode(path, decoder(path, &file)?)?;
    let (width, height) = (image.width(), image.height());
    // At the depth of any image: no value but 0 becomes 0.
    let samples = image.into_rgb16().into_raw();
    let data = samples.chunks_exact(3).map(|rgb| if rgb.iter().all(|&v| v == 0) { 0 } else { 255 }).collect();
    Ok(Mask { width, height, data })
}

/// The files of `--mask-in`: of the left image and of the right one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaskFiles([Option<PathBuf>; 2]);

/// Masks as they were read.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ReadMasks {
    /// The masks; nothing if no file was named.
    pub masks: Option<Masks>,
    /// Why the masks may be wrong, for warnings.
    pub doubts: Vec<String>,
}

impl MaskFiles {
    /// The files of a value LEFT, LEFT,RIGHT or ,RIGHT. A comma belongs to a name if a file of that name exists.
    ///
    /// # Errors
    /// If the value names no file, or can be split in more than one way.
    pub fn resolve(given: Option<&Path>) -> Result<Self> {
        let Some(given) = given else { return Ok(Self::default()) };
        // A name that is not Unicode is not split.
        let text = given.to_str().unwrap_or_default();
        if given.exists() || !text.contains(',') {
            return Ok(Self([Some(given.into()), None]));
        }
        let part = |name: &str| (!name.is_empty()).then(|| PathBuf::from(name));
        let splits: Vec<_> =
            text.match_indices(',').map(|(at, _)| [part(&text[..at]), part(&text[at + 1..])]).collect();
        let is_there = |sides: &&[Option<PathBuf>; 2]| sides.iter().flatten().all(|path| path.exists());
        let there: Vec<_> = splits.iter().filter(|sides| sides.iter().any(Option::is_some)).filter(is_there).collect();
        ensure!(
            there.len() < 2,
            "--mask-in is {given:?}, but its commas can separate more than one pair of existing files; rename one"
        );
        let sides = there.first().copied().or(splits.first()).cloned().unwrap_or_default();
        ensure!(
            sides.iter().any(Option::is_some),
            "--mask-in is {given:?}, but names no file; give LEFT, LEFT,RIGHT or ,RIGHT"
        );
        Ok(Self(sides))
    }

    /// The files.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.iter().flatten().map(PathBuf::as_path)
    }

    /// The masks for images of their size, `None` if no file was named.
    ///
    /// # Errors
    /// If a mask cannot be read, or the two differ in size.
    pub fn read(&self) -> Result<ReadMasks> {
        self.read_if(|_, _| Ok(()))
    }

    /// The masks for pairs of the size of `image`.
    ///
    /// # Errors
    /// If a mask cannot be read, or is of another size.
    pub fn read_for(&self, image: &Image) -> Result<ReadMasks> {
        let (width, height) = (image.width(), image.height());
        self.read_if(|path, mask| {
            ensure!(
                (mask.width, mask.height) == (width, height),
                "{path:?} is {}x{}, but the images are {width}x{height}; give a mask of the size of the given images",
                mask.width,
                mask.height
            );
            Ok(())
        })
    }

    fn read_if(&self, fits: impl Fn(&Path, &Mask) -> Result<()>) -> Result<ReadMasks> {
        let (mut sides, mut doubts) = ([None, None], Vec::new());
        let mut first: Option<(&Path, u32, u32)> = None;
        for (side, path) in sides.iter_mut().zip(&self.0) {
            let Some(path) = path else { continue };
            let mask = read_mask(path)?;
            fits(path, &mask)?;
            let (other, width, height) = *first.get_or_insert((path, mask.width, mask.height));
            ensure!(
                (mask.width, mask.height) == (width, height),
                "{other:?} is {width}x{height} but {path:?} is {}x{}; both masks have the size of the given images",
                mask.width,
                mask.height
            );
            if mask.data.iter().all(|&value| value == 0) {
                doubts.push(format!("{path:?} is 0 (no content) everywhere, so no pixel has a disparity"));
            }
            *side = Some(mask.data);
        }
        let Some((_, width, height)) = first else { return Ok(ReadMasks::default()) };
        Ok(ReadMasks { masks: Some(Masks::new(width, height, sides)?), doubts })
    }
}
