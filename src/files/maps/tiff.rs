//! TIFF and BigTIFF.

use super::samples::{Samples, ensure_pixels};
use crate::files::contents::MAX_BYTES;
use crate::files::error::{Result, bail, ensure, error};
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// The first image of a TIFF file, in floats or whole numbers, one sample a pixel.
pub fn tiff(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
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
    let whole = Samples::whole;
    let samples = match decoder.read_image().map_err(damaged)? {
        DecodingResult::F16(values) => Samples::Float(values.into_iter().map(f64::from).collect()),
        DecodingResult::F32(values) => Samples::Float(values.into_iter().map(f64::from).collect()),
        DecodingResult::F64(values) => Samples::Float(values),
        DecodingResult::U8(values) if kind == tiff::ColorType::Gray(8) => {
            whole(values.into_iter().map(i64::from).collect())
        }
        DecodingResult::U16(values) => whole(values.into_iter().map(i64::from).collect()),
        DecodingResult::U32(values) => whole(values.into_iter().map(i64::from).collect()),
        DecodingResult::I8(values) => whole(values.into_iter().map(i64::from).collect()),
        DecodingResult::I16(values) => Samples::signed16(values.into_iter().map(i64::from).collect()),
        DecodingResult::I32(values) => whole(values.into_iter().map(i64::from).collect()),
        _ => bail!("it has {kind:?} pixels, but floats of 16, 32 or 64 bits or whole numbers are needed; convert it"),
    };
    Ok((width, height, samples))
}
