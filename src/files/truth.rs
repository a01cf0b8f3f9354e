//! The truth of a map: its files, and the scores of an estimate.

use super::error::{Result, ensure};
use super::maps::{self, Encoding, EncodingOptions, MapFile};
use crate::evaluation::{self, FloatMap, Scores};
use image::{Rgb, RgbImage};
use std::path::{Path, PathBuf};

/// Where the truth of a pair is.
#[derive(Clone, Debug)]
pub struct TruthFile {
    /// The map.
    pub path: PathBuf,
    /// Which pixels count.
    pub mask: Option<PathBuf>,
    /// What the map's values mean.
    pub encoding: Encoding,
}

/// The truth, read.
pub struct Truth {
    /// The map.
    pub map: FloatMap,
    /// Which pixels count.
    pub mask: Option<Vec<bool>>,
    /// Why the map may be wrong, for warnings.
    pub doubts: Vec<String>,
}

impl TruthFile {
    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [Some(&self.path), self.mask.as_ref()].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Reads the truth for a map of `size`, the size of the file `of`.
    ///
    /// # Errors
    /// If a file cannot be read, or is of another size.
    pub fn read(&self, size: (u32, u32), of: &Path) -> Result<Truth> {
        let MapFile { map, doubts } = maps::read(&self.path, self.encoding, EncodingOptions::TRUTH)?;
        let truth = (map.width(), map.height());
        ensure!(
            truth == size,
            "{:?} is {}x{}, but {of:?} is {}x{}; give the truth of this size",
            self.path,
            truth.0,
            truth.1,
            size.0,
            size.1
        );
        let mask = self.mask.as_ref().map(|path| maps::read_mask(path, size)).transpose()?;
        Ok(Truth { map, mask, doubts })
    }
}

impl Truth {
    /// The part that begins at column x and row y.
    ///
    /// # Errors
    /// If the part does not lie within the truth.
    pub fn cropped(self, [x, y, width, height]: [u32; 4]) -> Result<Self> {
        fn part<T: Copy>(values: &[T], of: u32, [x, y, width, height]: [u32; 4]) -> Vec<T> {
            let rows = values.chunks_exact(of as usize).skip(y as usize).take(height as usize);
            rows.flat_map(|row| row.iter().skip(x as usize).take(width as usize)).copied().collect()
        }
        let (of, part_of) = (self.map.width(), [x, y, width, height]);
        let map = FloatMap::new(width, height, part(self.map.data(), of, part_of))?;
        Ok(Self { map, mask: self.mask.map(|mask| part(&mask, of, part_of)), doubts: self.doubts })
    }

    /// The scores of an estimate.
    ///
    /// # Errors
    /// If the sizes differ, or no pixel counts.
    pub fn score(&self, estimate: &FloatMap) -> Result<Scores> {
        Ok(evaluation::evaluate(estimate, &self.map, self.mask.as_deref())?)
    }

    /// The errors in KITTI's colours.
    ///
    /// # Errors
    /// If the sizes differ.
    pub fn error_picture(&self, estimate: &FloatMap) -> Result<RgbImage> {
        let mut pixels = evaluation::error_picture(estimate, &self.map, self.mask.as_deref())?.into_iter();
        let (width, height) = (estimate.width(), estimate.height());
        Ok(RgbImage::from_fn(width, height, |_, _| Rgb(pixels.next().unwrap_or_default())))
    }
}
