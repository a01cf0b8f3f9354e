//! The formats that maps are written in, and what each can hold.

use crate::Params;
use crate::files::error::{Result, bail, ensure};
use std::path::Path;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 16-bit gray PNG as in the KITTI benchmark: 256 a pixel of disparity, 0 invalid, a valid 0 is written as 1.
    Kitti,
    /// Portable float map, little endian, rows from the bottom, +inf invalid.
    Pfm,
    /// NumPy array of 32-bit floats, rows x columns, NaN invalid.
    Npy,
    /// TIFF of 32-bit floats, NaN invalid.
    Tiff,
    /// A picture: turbo colours over the searched range, invalid black.
    Color,
    /// An 8-bit gray PNG: 255 where there is a disparity, 0 where not.
    Mask,
    /// An 8-bit gray PNG: the confidence.
    Confidence,
    /// A picture: the errors.
    ErrorMap,
    /// The depth.
    Depth(DepthFormat),
}

/// What a file with a depth holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthFormat {
    /// 16-bit gray PNG: millimetres, 0 without a depth and beyond what 16 bits hold.
    Png,
    /// As [`Format::Pfm`], in metres.
    Pfm,
    /// As [`Format::Npy`], in metres.
    Npy,
    /// As [`Format::Tiff`], in metres.
    Tiff,
    /// Coloured points.
    Ply,
    /// Coloured points.
    Pcd,
}

impl Format {
    /// What follows the name of a frame.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Kitti => ".png",
            Self::Pfm => ".pfm",
            Self::Npy => ".npy",
            Self::Tiff => ".tif",
            Self::Color => "_color.png",
            Self::Mask => "_mask.png",
            Self::Confidence => "_confidence.png",
            Self::Depth(DepthFormat::Png) => "_depth.png",
            Self::Depth(DepthFormat::Pfm) => "_depth.pfm",
            Self::Depth(DepthFormat::Npy) => "_depth.npy",
            Self::Depth(DepthFormat::Tiff) => "_depth.tif",
            Self::Depth(DepthFormat::Ply) => ".ply",
            Self::Depth(DepthFormat::Pcd) => ".pcd",
            Self::ErrorMap => "_errors.png",
        }
    }
}

/// What a file with a sheet holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
        format != Format::Kitti || (first >= 0 && last <= 255),
        "output {path:?} is a 16-bit PNG, which holds 0 to 255.9375 px, but disparities from {first} to {last} px are \
         searched; use .pfm, .npy or .tif, or search another range"
    );
    Ok(())
}

/// The format of a map whose name has no ending: 16-bit PNG if it can hold the searched range, else TIFF.
pub fn default_format(params: &Params) -> Format {
    let (first, last) = searched(params);
    if first >= 0 && last <= 255 { Format::Kitti } else { Format::Tiff }
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
pub fn map_format(path: &Path) -> Result<Format> {
    Ok(match ending(path).as_str() {
        "png" => Format::Kitti,
        "pfm" => Format::Pfm,
        "npy" => Format::Npy,
        "tif" | "tiff" => Format::Tiff,
        "" => bail!("output {path:?} has no ending, which selects the format; add .png, .pfm, .npy, .tif or .tiff"),
        other => {
            bail!("output {path:?} ends in .{other}, but .png, .pfm, .npy, .tif and .tiff are known; use one of them")
        }
    })
}
