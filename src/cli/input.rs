//! Two image files become two [`Image`]s of one size and one sample format.

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use gpu_stereo::{Image, Pixels};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::fs;
use std::io::Cursor;
use std::path::Path;

/// The largest file, and the largest decoded image, that is taken: a header can declare any size, and a decoder would
/// allocate it. 1 GiB is 130 megapixels of 16-bit colour.
pub const MAX_BYTES: u64 = 1 << 30;

/// Reads a pair.
pub fn read_pair(left: &Path, right: &Path) -> Result<(Image, Image)> {
    let (left_file, right_file) = (read_file(left, "an image")?, read_file(right, "an image")?);
    let left_decoder = decoder(left, &left_file)?;
    let right_decoder = decoder(right, &right_file)?;
    let (left_size, right_size) = (left_decoder.dimensions(), right_decoder.dimensions());
    ensure!(
        left_size == right_size,
        "{left:?} is {}x{} but {right:?} is {}x{}; both must have one size: crop or rectify them again",
        left_size.0,
        left_size.1,
        right_size.0,
        right_size.1
    );
    let left_image = decode(left, left_decoder)?;
    let right_image = decode(right, right_decoder)?;

    // The matcher takes one format for both; the poorer image is brought to the richer one's, which changes no gray value.
    let colour = left_image.color().has_color() || right_image.color().has_color();
    let deep = is_deep(&left_image) || is_deep(&right_image);
    Ok((to_image(left_image, colour, deep)?, to_image(right_image, colour, deep)?))
}

/// What is wrong with a path that leads nowhere, if its form tells; for the end of a sentence.
pub fn hint(path: &Path) -> &'static str {
    let text = path.to_string_lossy();
    match () {
        () if text.contains("://") => ", not an address: download it first, or leave out file://",
        () if text.starts_with('~') => "; the shell takes ~ for the home folder only where it is not in quotes",
        () if cfg!(not(windows)) && text.contains('\\') => ", in which / and not \\ parts the folders",
        () => "",
    }
}

/// A mask: a byte a pixel, row by row from the top, 0 where all colours of the image are 0.
pub struct Mask {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The bytes.
    pub data: Vec<u8>,
}

/// Reads a mask.
pub fn read_mask(path: &Path) -> Result<Mask> {
    let file = read_file(path, "a mask")?;
    let image = decode(path, decoder(path, &file)?)?;
    let (width, height) = (image.width(), image.height());
    // At the depth of any image: no value but 0 becomes 0.
    let samples = image.into_rgb16().into_raw();
    let data = samples.chunks_exact(3).map(|rgb| if rgb.iter().all(|&v| v == 0) { 0 } else { 255 }).collect();
    Ok(Mask { width, height, data })
}

/// The bytes of a regular file of a sane size, which holds `what`.
pub fn read_file(path: &Path, what: &str) -> Result<Vec<u8>> {
    let kind = match fs::metadata(path) {
        Ok(kind) => kind,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            bail!("{path:?} does not exist; give the path of {what}{}", hint(path))
        }
        Err(error) => {
            return Err(error).with_context(|| format!("{path:?} cannot be read; give the path of {what}"));
        }
    };
    ensure!(!kind.is_dir(), "{path:?} is a folder; give the path of {what}");
    ensure!(kind.is_file(), "{path:?} is not a regular file; save {what} to a file first");
    ensure!(
        kind.len() <= MAX_BYTES,
        "{path:?} has {} bytes, but at most {MAX_BYTES} are read; crop or scale it",
        kind.len()
    );
    let bytes = fs::read(path).with_context(|| format!("{path:?} cannot be read; check its permissions"))?;
    ensure!(!bytes.is_empty(), "{path:?} is empty; save it again");
    Ok(bytes)
}

/// A decoder that has read the header; what it declares is known to be of a sane size.
pub fn decoder<'a>(path: &Path, bytes: &'a [u8]) -> Result<impl ImageDecoder + use<'a>> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    // The content tells the format, whatever the name says. Only TGA has no signature.
    let is_tga = || path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("tga"));
    let format = reader.format().or_else(|| is_tga().then_some(ImageFormat::Tga));
    let Some(format) = format else {
        bail!("{path:?} is not an image in a known format; save it as PNG, JPEG, PNM, TIFF, BMP or WebP");
    };
    let mut reader = ImageReader::with_format(reader.into_inner(), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(2 * MAX_BYTES); // the decoded image, which is checked below, and a decoder's own buffers
    reader.limits(limits);
    ensure!(is_whole(format, bytes), "{path:?} is cut short: the end of its {format:?} data is missing; save it again");
    let decoder = reader.into_decoder().map_err(|error| damaged(path, &error))?;
    let (width, height) = decoder.dimensions();
    ensure!(width > 0 && height > 0, "{path:?} is {width}x{height}; both sides must be at least 1: save it again");
    ensure!(
        decoder.total_bytes() <= MAX_BYTES,
        "{path:?} declares {width}x{height} pixels, {} bytes, but at most {MAX_BYTES} are decoded; crop or scale it",
        decoder.total_bytes()
    );
    Ok(decoder)
}

/// The image of a decoder.
pub fn decode(path: &Path, decoder: impl ImageDecoder) -> Result<DynamicImage> {
    let image = DynamicImage::from_decoder(decoder).map_err(|error| damaged(path, &error))?;
    ensure!(
        !matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)),
        "{path:?} has floating-point samples, but 8-bit or 16-bit ones are needed; convert it to a 16-bit PNG"
    );
    Ok(image)
}

fn damaged(path: &Path, error: &image::ImageError) -> anyhow::Error {
    anyhow!("{path:?} cannot be decoded ({error}); it is damaged, cut short or of a rare kind: save it again as PNG")
}

/// Whether the end of the image data is there, for the formats whose decoders are content with less.
fn is_whole(format: ImageFormat, bytes: &[u8]) -> bool {
    match format {
        ImageFormat::Png => {
            // Chunks: length of the data, type, data, checksum.
            let mut rest = bytes.get(8..).unwrap_or_default();
            while let Some((length, after)) = rest.split_first_chunk::<4>() {
                let end = u32::from_be_bytes(*length) as usize + 8;
                if after.len() < end {
                    return false;
                }
                if after.starts_with(b"IEND") {
                    return true;
                }
                rest = &after[end..];
            }
            false
        }
        ImageFormat::Jpeg => {
            // Segments (0xff, marker, length of the rest) up to the first scan; from there on 0xff 0xd9 is the end.
            let mut rest = bytes.get(2..).unwrap_or_default();
            while let [0xff, marker, after @ ..] = rest {
                rest = match (marker, after) {
                    (0xda, _) => return after.windows(2).any(|pair| pair == [0xff, 0xd9]),
                    (0xff, _) => &rest[1..], // padding
                    (_, [high, low, ..]) => {
                        after.get(usize::from(u16::from_be_bytes([*high, *low]))..).unwrap_or_default()
                    }
                    _ => return false,
                };
            }
            false
        }
        _ => true,
    }
}

fn is_deep(image: &DynamicImage) -> bool {
    let color = image.color();
    color.bytes_per_pixel() > color.channel_count()
}

fn to_image(image: DynamicImage, colour: bool, deep: bool) -> Result<Image, gpu_stereo::Error> {
    let (width, height) = (image.width(), image.height());
    let pixels = match (colour, deep) {
        (false, false) => Pixels::Gray8(image.into_luma8().into_raw()),
        (false, true) => Pixels::Gray16(image.into_luma16().into_raw()),
        (true, false) => Pixels::Rgba8(image.into_rgba8().into_raw()),
        (true, true) => Pixels::Rgba16(image.into_rgba16().into_raw()),
    };
    Image::new(width, height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gpu_stereo::reference::{Channel, gray};
    use image::{GrayImage, Luma};

    #[test]
    fn promotion_changes_no_gray_value() {
        let image = GrayImage::from_fn(256, 1, |x, _| Luma([x as u8]));
        let plain = gray(&to_image(image.clone().into(), false, false).unwrap(), Channel::Luma);
        for (colour, deep) in [(false, true), (true, false), (true, true)] {
            let promoted = to_image(image.clone().into(), colour, deep).unwrap();
            assert_eq!(gray(&promoted, Channel::Luma), plain, "{colour} {deep}");
        }
    }
}
