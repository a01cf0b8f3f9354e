//! Files become disparity maps in px and masks. The content tells the format, whatever the name says.

mod exr;
pub(in crate::files) mod npy;
mod pfm;
mod samples;
#[cfg(test)]
mod tests;
mod tiff;

use self::exr::exr;
use self::npy::npy;
use self::pfm::pfm;
use self::samples::{Samples, ensure_pixels};
use self::tiff::tiff;
use super::contents;
use super::error::{Context as _, Result, bail, ensure};
use super::images::{decode, decoder};
use crate::evaluation::FloatMap;
use image::codecs::pnm::PnmDecoder;
use image::{DynamicImage, ExtendedColorType, ImageDecoder as _, ImageFormat};
use std::path::Path;

/// What the values of a file mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding {
    /// The value that stands for 1 px, or with `depth` for 1 m.
    pub scale: Option<f64>,
    /// The values are depths; focal length times baseline, in px m, makes them disparities.
    pub depth: Option<f64>,
    /// A value of the file that means no disparity, besides those that usually do.
    pub invalid: Option<f64>,
}

/// The options of the command that say what a file's values mean, for errors and doubts.
#[derive(Clone, Copy, Debug)]
pub struct EncodingOptions {
    /// What sets the scale.
    pub scale: &'static str,
    /// What names a value without a disparity.
    pub invalid: &'static str,
}

impl EncodingOptions {
    /// Those of a truth.
    pub const TRUTH: Self = Self { scale: "--gt-scale", invalid: "--gt-invalid" };
    /// Those of an estimate.
    pub const ESTIMATE: Self = Self { scale: "--scale", invalid: "--invalid" };
}

/// A map as it was read.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MapFile {
    /// The disparities in px.
    pub map: FloatMap,
    /// Why they may be wrong, for warnings.
    pub doubts: Vec<String>,
}

/// Reads a disparity map.
///
/// # Errors
/// If the file cannot be read, is not a map, or needs a scale.
pub fn read(path: &Path, encoding: Encoding, options: EncodingOptions) -> Result<MapFile> {
    parse(path, &contents::read_file(path, "a disparity map")?, encoding, options)
}

/// As [`read`], from a file's bytes.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8], encoding: Encoding, options: EncodingOptions) -> Result<MapFile> {
    let (width, height, samples) = match bytes {
        [b'P', b'f', ..] => pfm(bytes).with_context(|| in_file(path))?,
        [b'P', b'F', ..] => bail!("{path:?} is a PFM of three channels, but a gray one (Pf) is needed; save it as one"),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy(bytes).with_context(|| in_file(path))?,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tiff(bytes).with_context(|| in_file(path))?,
        [0x76, 0x2f, 0x31, 0x01, ..] => exr(bytes).with_context(|| in_file(path))?,
        _ => picture(path, bytes, encoding.depth.is_some())?,
    };
    let mut doubts = Vec::new();
    let values = match samples {
        Samples::Float(values) => {
            doubts.extend(doubt(path, &values, encoding, options));
            let invalid = encoding.invalid.map(|invalid| invalid as f32);
            let value = |&v: &f64| if Some(v as f32) == invalid { f32::NAN } else { disparity(v, encoding, 1.0) };
            values.iter().map(value).collect()
        }
        Samples::Whole { values, usual_scale, none } => {
            let is_opencv = none < 0;
            let usual = match encoding.depth {
                Some(_) => Some(100.0), // centimetres
                None => usual_scale,
            };
            let Some(scale) = encoding.scale.or(usual) else {
                bail!(
                    "{path:?} has whole numbers, and only 16-bit PNG has a usual scale; give {} S, the value of 1 px \
                     (Middlebury 2001: 8, Tsukuba 16; 2003: 4; 2005 and 2006 in full size: 1; OpenCV's matchers: 16)",
                    options.scale
                );
            };
            let of_opencv = is_opencv && encoding.invalid.is_none() && encoding.scale.is_none();
            if of_opencv {
                doubts.push(format!(
                    "{path:?} is read as a map of OpenCV: 16 a pixel, and {none} is no disparity; {} and {} say otherwise",
                    options.scale, options.invalid
                ));
            }
            // A value that is named replaces the one that OpenCV's matchers give.
            let none = if is_opencv && encoding.invalid.is_some() { None } else { Some(none) };
            let is_none = |v: i64| {
                Some(v) == none
                    || Some(v as f64) == encoding.invalid
                    || (encoding.depth.is_some() && v == i64::from(u16::MAX))
            };
            if let Some(&v) = values.iter().find(|&&v| v < 0 && !is_opencv && !is_none(v)) {
                bail!(
                    "{path:?} holds the whole number {v}, but whole numbers are 0 (no disparity) or more; if {v} means no \
                     disparity, give {} {v}, else save floats, NaN for none",
                    options.invalid
                );
            }
            values.iter().map(|&v| if is_none(v) { f32::NAN } else { disparity(v as f64, encoding, scale) }).collect()
        }
    };
    Ok(MapFile { map: FloatMap::new(width, height, values)?, doubts })
}

/// The share of the pixels that one value may have without a doubt: what is computed or measured rarely has any.
const SUSPECT: f64 = 0.01;

/// Why the floats of a map may be wrong: many are one value that often means that there is no disparity.
fn doubt(path: &Path, values: &[f64], encoding: Encoding, options: EncodingOptions) -> Option<String> {
    if encoding.depth.is_some() {
        return None; // there they have no disparity
    }
    let least = values.iter().copied().filter(|v| v.is_finite()).fold(f64::INFINITY, f64::min);
    let found = [0.0, least].into_iter().filter(|&v| v <= 0.0 && Some(v) != encoding.invalid).find_map(|suspect| {
        let count = values.iter().filter(|&&v| v == suspect).count();
        (count as f64 > SUSPECT * values.len() as f64).then_some((suspect, count))
    });
    let (value, count) = found.filter(|(_, count)| *count < values.len())?;
    Some(format!(
        "{count} of {} pixels of {path:?} are {value}, which counts as a disparity; if it means that there is none, give \
         {} {value}",
        values.len(),
        options.invalid
    ))
}

/// Reads which pixels a mask has: 255 in Middlebury's masks, where 128 is occluded and 0 unknown.
///
/// # Errors
/// If the file cannot be read, is not a mask, or is of another size.
pub fn read_mask(path: &Path, size: (u32, u32)) -> Result<Vec<bool>> {
    let bytes = contents::read_file(path, "a mask")?;
    let image = gray(path, decode(path, decoder(path, &bytes)?)?)?;
    let DynamicImage::ImageLuma8(mask) = image else {
        bail!("{path:?} has 16 bits, but a mask has 8: 255 where pixels count; convert it");
    };
    ensure!(
        mask.dimensions() == size,
        "{path:?} is {}x{}, but the truth is {}x{}; give the mask of this truth",
        mask.width(),
        mask.height(),
        size.0,
        size.1
    );
    Ok(mask.into_raw().into_iter().map(|value| value == 255).collect())
}

fn in_file(path: &Path) -> String {
    format!("{path:?} cannot be read as a disparity map")
}

/// A value in px; NaN where it means none.
fn disparity(value: f64, encoding: Encoding, usual_scale: f64) -> f32 {
    let value = value / encoding.scale.unwrap_or(usual_scale);
    let disparity = match encoding.depth {
        Some(focal_baseline) if value > 0.0 => focal_baseline / value,
        Some(_) => f64::NAN,
        None => value,
    };
    let disparity = disparity as f32; // what is too large for an f32 becomes infinite
    if disparity.is_finite() { disparity } else { f32::NAN }
}

/// A gray image without loss: PNG or PNM.
fn picture(path: &Path, bytes: &[u8], depth: bool) -> Result<(u32, u32, Samples)> {
    let format = image::guess_format(bytes).ok();
    let Some(format @ (ImageFormat::Png | ImageFormat::Pnm)) = format else {
        let what = format.map_or("in no known format".into(), |format| format!("{format:?}"));
        bail!(
            "{path:?} is {what}, but a disparity map is PNG, PGM, PFM, NumPy (.npy), TIFF or EXR; save it as one of these"
        );
    };
    let decoder = decoder(path, bytes)?;
    let (width, height) = decoder.dimensions();
    ensure_pixels(width, height).with_context(|| in_file(path))?;
    if format == ImageFormat::Pnm {
        // The decoder rescales samples of another maximum.
        let (_, header) = PnmDecoder::new(bytes).with_context(|| in_file(path))?.into_inner();
        let most = header.maximal_sample();
        ensure!(
            most == 255 || most == 65535,
            "{path:?} has a maximum of {most}, but a disparity map has 255 or 65535; rescale it, or save it as PNG"
        );
    }
    ensure!(
        !matches!(decoder.original_color_type(), ExtendedColorType::L1 | ExtendedColorType::L2 | ExtendedColorType::L4),
        "{path:?} has less than 8 bits a pixel, but a disparity map has 8 or 16; convert it"
    );
    let image = gray(path, decode(path, decoder)?)?;
    let (width, height) = (image.width(), image.height()); // turned as the file says
    let (values, deep) = match image {
        DynamicImage::ImageLuma16(image) => (image.into_raw().into_iter().map(i64::from).collect(), true),
        other => (other.into_luma8().into_raw().into_iter().map(i64::from).collect(), false),
    };
    ensure!(deep || !depth, "{path:?} has 8 bits, but depth has 16; give Virtual KITTI's depth image");
    let usual_scale = (deep && format == ImageFormat::Png).then_some(256.0); // KITTI
    Ok((width, height, Samples::Whole { values, usual_scale, none: 0 }))
}

/// The image in gray of 8 or 16 bits; one of colours has to have equal channels.
fn gray(path: &Path, image: DynamicImage) -> Result<DynamicImage> {
    let gray = |is_gray: bool| match is_gray {
        true => Ok(()),
        false => bail!(
            "{path:?} has colours or an alpha channel, but gray values are needed; give the map itself, not a picture of it"
        ),
    };
    match image {
        DynamicImage::ImageLuma8(_) | DynamicImage::ImageLuma16(_) => Ok(image),
        DynamicImage::ImageRgb8(rgb) => {
            gray(rgb.pixels().all(|p| p.0 == [p.0[0]; 3]))?;
            Ok(DynamicImage::ImageRgb8(rgb).into_luma8().into())
        }
        DynamicImage::ImageRgb16(rgb) => {
            gray(rgb.pixels().all(|p| p.0 == [p.0[0]; 3]))?;
            Ok(DynamicImage::ImageRgb16(rgb).into_luma16().into())
        }
        _ => gray(false).map(|()| image),
    }
}
