//! Samples as the bytes of a file.

use crate::files::error::{Error, Result};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _, RgbImage};
use npyz::WriterBuilder as _;
use std::io::{Cursor, Write as _};

/// A picture as PNG.
///
/// # Errors
/// If the encoder fails.
pub fn png(picture: &RgbImage) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_with_encoder(PngEncoder::new(&mut bytes)).map_err(|error| Error::of(&error))?;
    Ok(bytes.into_inner())
}

/// A picture as JPEG of quality 80.
///
/// # Errors
/// If the encoder fails.
pub fn jpeg(picture: &RgbImage) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let encoded = JpegEncoder::new_with_quality(&mut bytes, 80).encode_image(picture);
    encoded.map_err(|error| Error::of(&error))?;
    Ok(bytes.into_inner())
}

/// 8-bit gray PNG.
///
/// # Errors
/// If the encoder fails.
pub fn png8(width: u32, height: u32, samples: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(samples, width, height, ExtendedColorType::L8)
        .map_err(|error| Error::of(&error))?;
    Ok(bytes)
}

/// 16-bit gray PNG.
///
/// # Errors
/// If the encoder fails.
pub fn png16(width: u32, height: u32, samples: Vec<u16>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let samples: Vec<u8> = samples.into_iter().flat_map(u16::to_ne_bytes).collect();
    PngEncoder::new(&mut bytes)
        .write_image(&samples, width, height, ExtendedColorType::L16)
        .map_err(|error| Error::of(&error))?;
    Ok(bytes)
}

/// Portable float map, little endian, rows from the bottom.
///
/// # Errors
/// If the encoder fails.
pub fn pfm(width: u32, height: u32, samples: &[f32]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write!(bytes, "Pf\n{width} {height}\n-1.0\n")?;
    for row in samples.chunks(width.max(1) as usize).rev() {
        for sample in row {
            bytes.write_all(&sample.to_le_bytes())?;
        }
    }
    Ok(bytes)
}

/// NumPy array, rows x columns.
///
/// # Errors
/// If the encoder fails.
pub fn npy(width: u32, height: u32, samples: &[f32]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::<f32>::new().default_dtype();
    let mut npy = options.shape(&[height.into(), width.into()]).writer(&mut bytes).begin_nd()?;
    npy.extend(samples.iter().copied())?;
    npy.finish()?;
    Ok(bytes)
}

/// TIFF of 32-bit floats.
///
/// # Errors
/// If the encoder fails.
pub fn tiff(width: u32, height: u32, samples: &[f32]) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    tiff::encoder::TiffEncoder::new(&mut bytes)
        .and_then(|mut file| file.write_image::<tiff::encoder::colortype::Gray32Float>(width, height, samples))
        .map_err(|error| Error::of(&error))?;
    Ok(bytes.into_inner())
}
