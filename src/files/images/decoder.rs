//! Files become images; the sizes that they declare are checked before anything is decoded.

use super::kinds;
use crate::files::contents::MAX_BYTES;
use crate::files::error::{Error, Result, bail, ensure, error};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// The most pixels of an image: as many as a map can have.
pub const MAX_PIXELS: u64 = 1 << 27;
/// Bytes that a decoder may allocate besides the image: profiles, texts and the like are compressed, too.
const MAX_EXTRA: u64 = 32 << 20;

/// How the image is to be turned; not at all if that cannot be read.
pub fn orientation(decoder: &mut impl ImageDecoder) -> Orientation {
    decoder.orientation().unwrap_or(Orientation::NoTransforms)
}

/// Whether a file's name ends as that of an image in a format that is read: to find the images of a folder. Whether it is one,
/// its content says.
#[must_use]
pub fn has_image_ending(path: &Path) -> bool {
    ImageFormat::from_path(path).is_ok_and(|format| format.reading_enabled())
}

/// A decoder that has read the header; the size that it declares is known to be allowed.
pub fn decoder<'a>(path: &Path, bytes: &'a [u8]) -> Result<impl ImageDecoder + use<'a>> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    // The content tells the format, whatever the name says. Only TGA has no signature.
    let is_tga = || path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("tga"));
    let known = reader.format().filter(ImageFormat::reading_enabled);
    if let (None, Some(foreign)) = (known, kinds::foreign(path, bytes)) {
        bail!("{path:?} is {foreign}");
    }
    let Some(format) = known.or_else(|| is_tga().then_some(ImageFormat::Tga)) else {
        bail!("{path:?} is not an image in a known format; save it as PNG, JPEG, PNM, TIFF, BMP or WebP");
    };
    ensure!(
        format != ImageFormat::Tiff || !kinds::begins_with_preview(bytes),
        "{path:?} is a camera's raw file or begins with a preview, but the developed image is needed; convert it to 16-bit \
         TIFF or PNG, for example with dcraw -T -6"
    );
    ensure!(is_whole(format, bytes), "{path:?} is cut short: the end of its {format:?} data is missing; save it again");
    let mut reader = ImageReader::with_format(reader.into_inner(), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_EXTRA);
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder().map_err(|error| damaged(path, &error))?;
    let (width, height) = decoder.dimensions();
    ensure!(width > 0 && height > 0, "{path:?} is {width}x{height}; both sides must be at least 1: save it again");
    let (pixels, all) = (u64::from(width) * u64::from(height), decoder.total_bytes());
    ensure!(
        pixels <= MAX_PIXELS && all <= MAX_BYTES,
        "{path:?} declares {width}x{height} pixels, {all} bytes, but at most {MAX_PIXELS} pixels and {MAX_BYTES} bytes are \
         decoded; crop or scale it"
    );
    ensure!(
        can_hold(format, bytes.len() as u64, pixels, all),
        "{path:?} declares {width}x{height} pixels, but its {} bytes cannot hold so many; it is damaged: save it again",
        bytes.len()
    );
    limits.max_alloc = Some(all + all / 4 + MAX_EXTRA + bytes.len() as u64);
    if format != ImageFormat::Png {
        decoder.set_limits(limits).map_err(|error| damaged(path, &error))?; // PNG has its own for all but the image
    }
    Ok(decoder)
}

/// Whether a file of `length` bytes can hold so much by its format: a header can declare anything.
fn can_hold(format: ImageFormat, length: u64, pixels: u64, bytes: u64) -> bool {
    match format {
        // Each block of 8x8 pixels has a bit at least.
        ImageFormat::Jpeg => pixels <= 512 * length,
        // An area of one colour takes next to nothing.
        ImageFormat::WebP => true,
        // Deflate makes at most 1032 bytes of one, LZW somewhat more.
        _ => bytes <= 4096 * length,
    }
}

/// The image of a decoder, turned as its file says.
pub fn decode(path: &Path, mut decoder: impl ImageDecoder) -> Result<DynamicImage> {
    let turned = orientation(&mut decoder);
    let mut image = DynamicImage::from_decoder(decoder).map_err(|error| damaged(path, &error))?;
    ensure!(
        !matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)),
        "{path:?} has floating-point samples, but 8-bit or 16-bit ones are needed; convert it to a 16-bit PNG"
    );
    image.apply_orientation(turned);
    Ok(image)
}

fn damaged(path: &Path, error: &image::ImageError) -> Error {
    error!("{path:?} cannot be decoded ({error}); it is damaged, cut short or of a rare kind: save it again as PNG")
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
