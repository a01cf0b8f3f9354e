//! Images in, maps out, and what is made of maps.

use crate::objects::object;
use crate::settings::camera;
use crate::throw::{of_kind, thrown};
use gpu_stereo::{Colors, DisparityMap, Image, Matched, PixelFormat, Pixels, reference};
use js_sys::{Int16Array, Uint8Array, Uint16Array, Uint32Array};
use wasm_bindgen::prelude::*;

/// The formats of pixels by name.
const FORMATS: [(&str, PixelFormat); 4] = [
    ("gray8", PixelFormat::Gray8),
    ("gray16", PixelFormat::Gray16),
    ("rgba8", PixelFormat::Rgba8),
    ("rgba16", PixelFormat::Rgba16),
];

/// The format of this name.
///
/// # Errors
/// For an unknown name.
pub fn format(name: &str) -> Result<PixelFormat, JsValue> {
    let known = FORMATS.iter().find(|(known, _)| *known == name).map(|(_, format)| *format);
    known.ok_or_else(|| {
        let text = format!("format is {name:?}, but must be gray8, gray16, rgba8 or rgba16; give one of these");
        of_kind("parameter", &text)
    })
}

/// An image from its bytes; 16-bit samples with the lower byte first.
///
/// # Errors
/// As [`Image::new`], and for half a sample.
pub fn image([width, height]: [u32; 2], format: PixelFormat, bytes: Vec<u8>) -> Result<Image, JsValue> {
    let deep = |bytes: &[u8]| {
        let text = || format!("an image of 16-bit samples has {} bytes; give two a sample", bytes.len());
        let whole = bytes.len().is_multiple_of(2);
        let sample = |pair: &[u8]| u16::from_le_bytes([pair[0], pair[1]]);
        if whole { Ok(bytes.chunks_exact(2).map(sample).collect()) } else { Err(of_kind("image", &text())) }
    };
    let pixels = match format {
        PixelFormat::Gray8 => Pixels::Gray8(bytes),
        PixelFormat::Rgba8 => Pixels::Rgba8(bytes),
        PixelFormat::Gray16 => Pixels::Gray16(deep(&bytes)?),
        PixelFormat::Rgba16 => Pixels::Rgba16(deep(&bytes)?),
        other => return Err(of_kind("image", &format!("images in {other:?} are not taken here"))),
    };
    Image::new(width, height, pixels).map_err(thrown)
}

/// Both images of a pair.
///
/// # Errors
/// As [`image`].
pub fn pair(size: [u32; 2], format: PixelFormat, [left, right]: [Vec<u8>; 2]) -> Result<[Image; 2], JsValue> {
    Ok([image(size, format, left)?, image(size, format, right)?])
}

/// The maps of a pair: an object with `width`, `height`, `disparities` (`Int16Array`), and those of `right` (`Int16Array`), `confidence`
/// (`Uint8Array`), `labels` (`Uint16Array`) and `depth` (`Uint32Array`) that the settings ask for, else null.
pub fn maps(matched: &Matched) -> JsValue {
    let map = &matched.map;
    let or_null = |value: Option<JsValue>| value.unwrap_or(JsValue::NULL);
    object([
        ("width", map.width.into()),
        ("height", map.height.into()),
        ("disparities", Int16Array::from(map.data.as_slice()).into()),
        ("right", or_null(matched.right.as_ref().map(|map| Int16Array::from(map.data.as_slice()).into()))),
        ("confidence", or_null(matched.confidence.as_ref().map(|map| Uint8Array::from(map.data.as_slice()).into()))),
        ("labels", or_null(matched.labels.as_ref().map(|map| Uint16Array::from(map.data.as_slice()).into()))),
        ("depth", or_null(matched.depth.as_ref().map(|map| Uint32Array::from(map.data.as_slice()).into()))),
    ])
}

/// A map from its values.
fn map(width: u32, height: u32, data: Vec<i16>) -> Result<DisparityMap, JsValue> {
    if data.len() as u64 == u64::from(width) * u64::from(height) {
        return Ok(DisparityMap { width, height, data });
    }
    let text = format!("a map of {width}x{height} pixels has {} values; give one a pixel", data.len());
    Err(of_kind("image", &text))
}

/// The names of the colour maps.
#[wasm_bindgen]
pub fn colors() -> Vec<String> {
    Colors::ALL.iter().map(|(name, _)| (*name).into()).collect()
}

/// The picture of a map: red, green, blue and 255 for each pixel, by its place among the disparities `first` to `last` in pixels, in the
/// colours of this name ([`Colors::ALL`]); black where there is no disparity.
///
/// # Errors
/// For a count of values that is not that of the pixels, and for an unknown name.
#[wasm_bindgen]
pub fn color(width: u32, height: u32, data: Vec<i16>, first: i32, last: i32, colors: &str) -> Result<Vec<u8>, JsValue> {
    let colors: Colors = colors.parse().map_err(thrown)?;
    Ok(map(width, height, data)?.color_by(&(first..=last), colors))
}

/// The depth of each pixel in micrometres, 0 where there is none, seen by a camera of five numbers: focal length in pixels, baseline in
/// metres, difference of the principal points, column and row of the left one.
///
/// # Errors
/// As [`camera`], and for a count of values that is not that of the pixels.
#[wasm_bindgen]
pub fn depth(width: u32, height: u32, data: Vec<i16>, numbers: &[f64]) -> Result<Vec<u32>, JsValue> {
    Ok(reference::depth(&map(width, height, data)?, &camera(numbers)?).data)
}

/// The places that the pixels of the left image show, of those with a depth: three numbers each, metres to the right, down and forward of
/// the left camera; in order of the pixels.
///
/// # Errors
/// As [`depth`].
#[wasm_bindgen]
pub fn points(width: u32, height: u32, data: Vec<i16>, numbers: &[f64]) -> Result<Vec<f64>, JsValue> {
    let camera = camera(numbers)?;
    let depth = reference::depth(&map(width, height, data)?, &camera);
    let places = depth.data.iter().zip(0u32..).filter(|(depth, _)| **depth != 0);
    Ok(places.flat_map(|(&depth, i)| camera.point(i % width, i / width, depth)).collect())
}
