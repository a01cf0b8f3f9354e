//! The formats that maps are written in, and what each can hold.

use crate::files::error::{Result, bail, ensure};
use crate::{Colors, Params};
use std::ops::RangeInclusive;
use std::path::Path;

/// The formats of a file with a number a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleFormat {
    /// 16-bit gray PNG. Disparities as in the KITTI benchmark: 256 a pixel, 0 invalid, a valid 0 is written as 1. Depths in
    /// millimetres: 0 without a depth and beyond what 16 bits hold.
    Png,
    /// Portable float map, little endian, rows from the bottom, +inf invalid.
    Pfm,
    /// NumPy array of 32-bit floats, rows x columns, NaN invalid.
    Npy,
    /// TIFF of 32-bit floats, NaN invalid.
    Tiff,
}

/// The formats of a file with coloured points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointFormat {
    /// Binary PLY.
    Ply,
    /// Binary PCD.
    Pcd,
}

/// How a map is drawn as a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// The colours of disparities.
    pub colors: Colors,
    /// Whether a bar beside the map tells what the colours stand for: metres where the cameras are known, else px.
    pub scale_bar: bool,
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// The disparities of the left view, in pixels.
    Disparity(SampleFormat),
    /// Those of the right view.
    Right(SampleFormat),
    /// The depth, in millimetres (PNG) or metres.
    Depth(SampleFormat),
    /// The points that have a depth.
    Points(PointFormat),
    /// A picture: the colours of a map over the searched range, invalid black.
    Color(Look),
    /// An 8-bit gray PNG: 255 where there is a disparity, 0 where not.
    Mask,
    /// An 8-bit gray PNG: the confidence.
    Confidence,
    /// A picture: the errors.
    ErrorMap,
    /// The left image as it was matched (PNG): rectified, if the pair was.
    RectifiedLeft,
    /// The right one.
    RectifiedRight,
}

impl Format {
    /// What follows the name of a frame.
    pub fn suffix(self) -> &'static str {
        use SampleFormat::{Npy, Pfm, Png, Tiff};
        match self {
            Self::Disparity(Png) => ".png",
            Self::Disparity(Pfm) => ".pfm",
            Self::Disparity(Npy) => ".npy",
            Self::Disparity(Tiff) => ".tif",
            Self::Right(Png) => "_right.png",
            Self::Right(Pfm) => "_right.pfm",
            Self::Right(Npy) => "_right.npy",
            Self::Right(Tiff) => "_right.tif",
            Self::Depth(Png) => "_depth.png",
            Self::Depth(Pfm) => "_depth.pfm",
            Self::Depth(Npy) => "_depth.npy",
            Self::Depth(Tiff) => "_depth.tif",
            Self::Points(PointFormat::Ply) => "_points.ply",
            Self::Points(PointFormat::Pcd) => "_points.pcd",
            Self::Color(_) => "_color.png",
            Self::Mask => "_mask.png",
            Self::Confidence => "_confidence.png",
            Self::ErrorMap => "_errors.png",
            Self::RectifiedLeft => "_rectified_left.png",
            Self::RectifiedRight => "_rectified_right.png",
        }
    }

    /// Whether it is made from the depth, so that the cameras must be known.
    pub fn needs_depth(self) -> bool {
        matches!(self, Self::Depth(_) | Self::Points(_))
    }

    /// Whether it shows the image of a side, 0 the left one: its colours or the image itself.
    pub fn shows_image(self, side: usize) -> bool {
        match self {
            Self::Points(_) | Self::RectifiedLeft => side == 0,
            Self::RectifiedRight => side == 1,
            _ => false,
        }
    }

    /// The whole disparities that it can hold; none if it holds all, or holds none.
    pub fn holds(self) -> Option<RangeInclusive<i32>> {
        matches!(self, Self::Disparity(SampleFormat::Png) | Self::Right(SampleFormat::Png)).then_some(0..=255)
    }

    /// Whether it is a TIFF, which has at most 4 GiB.
    pub fn is_tiff(self) -> bool {
        matches!(
            self,
            Self::Disparity(SampleFormat::Tiff) | Self::Right(SampleFormat::Tiff) | Self::Depth(SampleFormat::Tiff)
        )
    }
}

/// What a file with a sheet holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SheetFormat {
    /// Without loss.
    Png,
    /// Small.
    Jpeg,
}

/// Checks before any work that a 16-bit PNG can hold the searched range.
///
/// # Errors
/// If it cannot.
pub fn ensure_range(format: Format, path: &Path, params: &Params) -> Result<()> {
    let (first, last) = searched(params);
    ensure!(
        format.holds().is_none_or(|held| held.contains(&first) && held.contains(&last)),
        "output {path:?} is a 16-bit PNG, which holds 0 to 255.9375 px, but disparities from {first} to {last} px are \
         searched; use .pfm, .npy or .tif, or search another range"
    );
    Ok(())
}

/// The format of a map whose name has no ending: 16-bit PNG if it can hold the searched range, else TIFF.
pub fn default_format(params: &Params) -> SampleFormat {
    let (first, last) = searched(params);
    let held = Format::Disparity(SampleFormat::Png).holds();
    let is_held = held.is_none_or(|held| held.contains(&first) && held.contains(&last));
    if is_held { SampleFormat::Png } else { SampleFormat::Tiff }
}

/// The smallest and the largest disparity searched.
pub fn searched(params: &Params) -> (i32, i32) {
    params.searched().into_inner()
}

/// The file extension in lower case; empty if there is none.
pub fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The format that the ending of a name selects.
///
/// # Errors
/// If there is no ending, or it is unknown.
pub fn sample_format(path: &Path) -> Result<SampleFormat> {
    Ok(match ending(path).as_str() {
        "png" => SampleFormat::Png,
        "pfm" => SampleFormat::Pfm,
        "npy" => SampleFormat::Npy,
        "tif" | "tiff" => SampleFormat::Tiff,
        "" => bail!("output {path:?} has no ending, which selects the format; add .png, .pfm, .npy, .tif or .tiff"),
        other => {
            bail!("output {path:?} ends in .{other}, but .png, .pfm, .npy, .tif and .tiff are known; use one of them")
        }
    })
}
