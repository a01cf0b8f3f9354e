//! Files become disparity maps in px and masks. The content tells the format, whatever the name says.

use super::contents::{self, MAX_BYTES};
use super::error::{Context as _, Result, bail, ensure, error};
use super::images::{decode, decoder};
use crate::evaluation::FloatMap;
use image::codecs::pnm::PnmDecoder;
use image::{DynamicImage, ExtendedColorType, ImageDecoder as _, ImageFormat};
use std::io::Cursor;
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// The longest text before the samples of a PFM or NumPy file.
const MAX_HEADER: usize = 1 << 16;
/// The most pixels: a small file can declare many, and reading keeps a few numbers for each.
const MAX_PIXELS: u64 = 1 << 27;
/// Digits in the header of a NumPy file: two sides and the size of a sample have fewer.
const MAX_DIGITS: usize = 18;

/// What the values of a file mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding {
    /// The value that stands for 1 px, or with `depth` for 1 m.
    pub scale: Option<f64>,
    /// The values are depths; focal length times baseline, in px m, makes them disparities.
    pub depth: Option<f64>,
}

/// Values as they stand in a file.
enum Samples {
    /// 0 is no disparity.
    Whole { values: Vec<u32>, usual_scale: Option<f64> },
    /// What is not finite is no disparity.
    Float(Vec<f64>),
}

/// Reads a disparity map. `option`: what sets the scale on the command line, for the error where it is missing.
///
/// # Errors
/// If the file cannot be read, is not a map, or needs a scale.
pub fn read(path: &Path, encoding: Encoding, option: &str) -> Result<FloatMap> {
    parse(path, &contents::read_file(path, "a disparity map")?, encoding, option)
}

/// As [`read`], from a file's bytes.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8], encoding: Encoding, option: &str) -> Result<FloatMap> {
    let (width, height, samples) = match bytes {
        [b'P', b'f', ..] => pfm(bytes).with_context(|| in_file(path))?,
        [b'P', b'F', ..] => bail!("{path:?} is a PFM of three channels, but a gray one (Pf) is needed; save it as one"),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy(bytes).with_context(|| in_file(path))?,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tiff(bytes).with_context(|| in_file(path))?,
        _ => picture(path, bytes, encoding.depth.is_some())?,
    };
    let values = match samples {
        Samples::Float(values) => values.iter().map(|&v| disparity(v, encoding, 1.0)).collect(),
        Samples::Whole { values, usual_scale } => {
            let usual = match encoding.depth {
                Some(_) => Some(100.0), // centimetres
                None => usual_scale,
            };
            let Some(usual) = usual.or(encoding.scale) else {
                bail!(
                    "{path:?} has whole numbers, and only 16-bit PNG has a usual scale; give {option} S, the value of 1 px \
                     (Middlebury 2001: 8, Tsukuba 16; 2003: 4; 2005 and 2006 in full size: 1)"
                );
            };
            let known = |v: u32| v != 0 && !(encoding.depth.is_some() && v == u32::from(u16::MAX));
            values.iter().map(|&v| if known(v) { disparity(v.into(), encoding, usual) } else { f32::NAN }).collect()
        }
    };
    Ok(FloatMap::new(width, height, values)?)
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
        bail!("{path:?} is {what}, but a disparity map is PNG, PGM, PFM, NumPy or TIFF; save it as one of these");
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
        DynamicImage::ImageLuma16(image) => (image.into_raw().into_iter().map(u32::from).collect(), true),
        other => (other.into_luma8().into_raw().into_iter().map(u32::from).collect(), false),
    };
    ensure!(deep || !depth, "{path:?} has 8 bits, but depth has 16; give Virtual KITTI's depth image");
    let usual_scale = (deep && format == ImageFormat::Png).then_some(256.0); // KITTI
    Ok((width, height, Samples::Whole { values, usual_scale }))
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

fn ensure_pixels(width: u32, height: u32) -> Result<()> {
    ensure!(
        u64::from(width) * u64::from(height) <= MAX_PIXELS,
        "it declares {width}x{height} pixels, but at most {MAX_PIXELS} are read; crop or scale it"
    );
    Ok(())
}

/// The sides, if the file has as many samples as it declares.
fn ensure_length(width: u64, height: u64, bytes_each: u64, got: usize) -> Result<(u32, u32)> {
    let needed = width.checked_mul(height).and_then(|count| count.checked_mul(bytes_each));
    let sides = u32::try_from(width).ok().zip(u32::try_from(height).ok());
    match (sides, needed) {
        (Some((width @ 1.., height @ 1..)), Some(needed)) if needed == got as u64 => {
            ensure_pixels(width, height).map(|()| (width, height))
        }
        _ => bail!(
            "it declares {width}x{height} pixels of {bytes_each} bytes, but {got} bytes follow; it is cut short or damaged: save it \
             again"
        ),
    }
}

/// `Pf`, width, height and scale as text, then 32-bit floats from the lowest row up, little endian if the scale is
/// negative (netpbm's pfm.html). Middlebury says that the scale's amount is ignored.
fn pfm(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    let mut at = 2;
    let mut words = Vec::new();
    while words.len() < 3 {
        let rest = bytes.get(at..).unwrap_or_default();
        let blank = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let rest = &rest[blank..];
        let is_comment = rest.starts_with(b"#");
        let ends = |b: &u8| if is_comment { *b == b'\n' } else { b.is_ascii_whitespace() };
        let length = rest.iter().position(ends).context("its header has no end; save it again")?;
        ensure!(blank > 0 && at < MAX_HEADER, "its header is not \"Pf\", width, height and scale; save it again");
        if !is_comment {
            words.push(String::from_utf8_lossy(&rest[..length]).into_owned());
        }
        at += blank + length;
    }
    // One white space ends the header, on Windows perhaps two.
    at += if bytes[at..].starts_with(b"\r\n") { 2 } else { 1 };
    let side = |what: &str, word: &str| {
        word.parse::<u32>().ok().filter(|side| *side > 0).with_context(|| {
            format!("its {what} is {word:?}, but must be a whole number from 1 to {}; save it again", u32::MAX)
        })
    };
    let (width, height) = (side("width", &words[0])?, side("height", &words[1])?);
    let scale = words[2].parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0).with_context(|| {
        format!(
            "its scale is {:?}, but must be a number other than 0, negative for little endian; save it again",
            words[2]
        )
    })?;
    let samples = bytes.get(at..).unwrap_or_default();
    ensure_length(width.into(), height.into(), 4, samples.len())?;
    let value = |b: &[u8; 4]| f64::from(if scale < 0.0 { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) });
    let (values, _) = samples.as_chunks::<4>();
    let rows = values.chunks_exact(width as usize).rev();
    Ok((width, height, Samples::Float(rows.flatten().map(value).collect())))
}

/// NumPy's array of rows and columns: floats, or whole numbers from 0 on.
fn npy(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    // The library allocates as much as the header declares and multiplies the sides, so both are limited before.
    let length = match bytes {
        [_, _, _, _, _, _, 1, _, a, b, ..] => 10 + usize::from(u16::from_le_bytes([*a, *b])),
        [_, _, _, _, _, _, _, _, a, b, c, d, ..] => 12 + u32::from_le_bytes([*a, *b, *c, *d]) as usize,
        _ => bail!("its header is cut short; save it again"),
    };
    let header = bytes.get(..length).filter(|_| length <= MAX_HEADER).with_context(|| {
        format!("its header declares {length} bytes, more than the file or a header of two sides has; save it again")
    })?;
    let digits = header[8..].iter().filter(|b| b.is_ascii_digit()).count();
    ensure!(
        digits <= MAX_DIGITS,
        "its header has {digits} digits, but two sides need fewer; save an array of rows and columns"
    );
    // The library's time doubles with each level of nested brackets.
    let text = &header[if bytes[6] == 1 { 10 } else { 12 }..];
    let brackets = text.iter().filter(|b| b"[({".contains(b)).count();
    ensure!(
        brackets <= 2,
        "its header opens {brackets} brackets, as for an array of records, but at most 2 are allowed; save one field as numbers"
    );
    let file = npyz::NpyFile::new(bytes).context("its header is not NumPy's; save it again")?;
    let [height, width] = file.shape()[..] else {
        bail!("it has {} dimensions, but 2 are needed, rows and columns; save one channel", file.shape().len());
    };
    let npyz::DType::Plain(kind) = file.dtype() else {
        bail!("it is an array of records, but numbers are needed; save one field");
    };
    let kind = kind.to_string();
    let by_columns = file.order() == npyz::Order::Fortran;
    let each = kind.get(2..).and_then(|size| size.parse().ok()).unwrap_or(0);
    let sides = ensure_length(width, height, each, bytes.len() - length)?;
    fn all<T: npyz::Deserialize>(file: npyz::NpyFile<&[u8]>) -> Result<Vec<T>> {
        file.into_vec().context("its samples cannot be read; save it again")
    }
    fn whole<T: npyz::Deserialize + TryInto<u32> + Copy + std::fmt::Display>(
        file: npyz::NpyFile<&[u8]>,
    ) -> Result<Vec<u32>> {
        let number = |v: T| {
            v.try_into().ok().with_context(|| {
                format!("it holds the whole number {v}, but whole numbers are 0 (no disparity) or more; save floats, NaN for none")
            })
        };
        all::<T>(file)?.into_iter().map(number).collect()
    }
    let mut samples = match kind.get(1..).unwrap_or_default() {
        "f4" => Samples::Float(all::<f32>(file)?.into_iter().map(f64::from).collect()),
        "f8" => Samples::Float(all(file)?),
        integer => {
            let values = match integer {
                "u1" => whole::<u8>(file)?,
                "u2" => whole::<u16>(file)?,
                "u4" => whole::<u32>(file)?,
                "i1" => whole::<i8>(file)?,
                "i2" => whole::<i16>(file)?,
                "i4" => whole::<i32>(file)?,
                "u8" => whole::<u64>(file)?,
                "i8" => whole::<i64>(file)?,
                _ => bail!("its type is {kind:?}, but f4, f8 or whole numbers are needed; save it with astype(\"f4\")"),
            };
            Samples::Whole { values, usual_scale: None }
        }
    };
    if by_columns {
        match &mut samples {
            Samples::Float(values) => *values = transposed(values, sides),
            Samples::Whole { values, .. } => *values = transposed(values, sides),
        }
    }
    Ok((sides.0, sides.1, samples))
}

/// Samples that are stored column by column, reordered row by row.
fn transposed<T: Copy>(values: &[T], (width, height): (u32, u32)) -> Vec<T> {
    let (width, height) = (width as usize, height as usize);
    (0..width * height).map(|i| values[i % width * height + i / width]).collect()
}

/// The first image of a TIFF file, in floats or whole numbers, one sample a pixel.
fn tiff(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    // The decoder's message can name every entry of a damaged list.
    let damaged = |error: tiff::TiffError| {
        let told: String = error.to_string().chars().take(200).collect();
        error!("it is damaged, cut short or of a rare kind ({told}): save it again")
    };
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES as usize;
    limits.intermediate_buffer_size = MAX_BYTES as usize;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(damaged)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(damaged)?;
    ensure_pixels(width, height)?;
    let kind = decoder.colortype().map_err(damaged)?;
    ensure!(
        matches!(kind, tiff::ColorType::Gray(_)),
        "it has {kind:?} pixels, but gray ones are needed; save one channel"
    );
    let usual_scale = None;
    let samples = match decoder.read_image().map_err(damaged)? {
        DecodingResult::F32(values) => Samples::Float(values.into_iter().map(f64::from).collect()),
        DecodingResult::F64(values) => Samples::Float(values),
        DecodingResult::U8(values) if kind == tiff::ColorType::Gray(8) => {
            Samples::Whole { values: values.into_iter().map(u32::from).collect(), usual_scale }
        }
        DecodingResult::U16(values) => {
            Samples::Whole { values: values.into_iter().map(u32::from).collect(), usual_scale }
        }
        DecodingResult::U32(values) => Samples::Whole { values, usual_scale },
        _ => bail!(
            "it has {kind:?} pixels, but 32-bit or 64-bit floats or whole numbers from 0 on are needed; convert it"
        ),
    };
    Ok((width, height, samples))
}
#[cfg(test)]
mod tests;
