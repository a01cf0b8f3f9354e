//! A map in the bytes of each format.

use super::disparity::{kitti, pixels};
use super::format::{Format, Look, PointFormat, SampleFormat, searched};
use super::pictures::{image_png, picture};
use super::samples::{npy, pfm, png, png8, png16, tiff};
use super::scale_bar::beside;
use super::{depth, points};
use crate::files::error::{Context as _, Result};
use crate::{Camera, ConfidenceMap, DepthMap, DisparityMap, Image, Matched, Params};
use image::RgbImage;

/// What is written.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// The disparities.
    pub map: &'a DisparityMap,
    /// Those of the right view, if they were computed.
    pub right: Option<&'a DisparityMap>,
    /// The confidence of the left view, if it was computed.
    pub confidence: Option<&'a ConfidenceMap>,
    /// The depth of the left view, if it was computed.
    pub depth: Option<&'a DepthMap>,
    /// The images, rectified if the pair was: the left one has the colours of points.
    pub images: [Option<&'a Image>; 2],
    /// The cameras, if they are known, for the scale of a picture.
    pub camera: Option<&'a Camera>,
    /// The picture of its errors, if there is a truth.
    pub errors: Option<&'a RgbImage>,
    /// The settings.
    pub params: &'a Params,
}

impl<'a> Maps<'a> {
    /// A map alone.
    pub fn of(map: &'a DisparityMap, params: &'a Params) -> Self {
        Self {
            map,
            right: None,
            confidence: None,
            depth: None,
            images: [None; 2],
            camera: params.depth.as_ref(),
            errors: None,
            params,
        }
    }

    /// All that was computed.
    pub fn all(matched: &'a Matched, params: &'a Params) -> Self {
        let Matched { map, right, confidence, depth, .. } = matched;
        let (right, confidence, depth) = (right.as_ref(), confidence.as_ref(), depth.as_ref());
        Self { right, confidence, depth, ..Self::of(map, params) }
    }
}

/// The bytes of a file.
#[non_exhaustive]
pub struct Encoded {
    /// All of them.
    pub bytes: Vec<u8>,
    /// Which values of the map the file cannot hold, for a warning.
    pub doubt: Option<String>,
}

/// Disparities in a format.
fn disparities(format: SampleFormat, map: &DisparityMap) -> Result<Vec<u8>> {
    let (width, height) = (map.width, map.height);
    let floats = |invalid: f32| map.data.iter().map(|&value| pixels(value).unwrap_or(invalid)).collect::<Vec<_>>();
    match format {
        SampleFormat::Png => png16(width, height, kitti(map)?),
        SampleFormat::Pfm => pfm(width, height, &floats(f32::INFINITY)),
        SampleFormat::Npy => npy(width, height, &floats(f32::NAN)),
        SampleFormat::Tiff => tiff(width, height, &floats(f32::NAN)),
    }
}

/// Depths in a format.
fn depths(format: SampleFormat, depth: &DepthMap, baseline: f64) -> Result<Encoded> {
    let (width, height, mut doubt) = (depth.width, depth.height, None);
    let bytes = match format {
        SampleFormat::Png => {
            let (samples, lost) = depth::millimetres(depth);
            if lost > 0 {
                doubt = Some(format!(
                    "{lost} pixels are 65.5355 m away or farther at a baseline of {baseline} m, beyond a 16-bit PNG in \
                     millimetres, and are 0 there; if the baseline is right, use .pfm, .npy or .tif"
                ));
            }
            png16(width, height, samples)
        }
        SampleFormat::Pfm => pfm(width, height, &depth::metres(depth, f32::INFINITY)),
        SampleFormat::Npy => npy(width, height, &depth::metres(depth, f32::NAN)),
        SampleFormat::Tiff => tiff(width, height, &depth::metres(depth, f32::NAN)),
    }?;
    Ok(Encoded { bytes, doubt })
}

/// A map in a format.
///
/// # Errors
/// Where the format cannot hold the map, or `maps` lacks what it is of.
pub fn encode(format: Format, maps: &Maps<'_>) -> Result<Encoded> {
    let Maps { map, params, .. } = maps;
    let depth = || maps.depth.zip(params.depth.as_ref()).context("no depth was computed");
    let image = |side: usize| maps.images[side].context("the image is not there");
    let bytes = match format {
        Format::Disparity(format) => disparities(format, map),
        Format::Right(format) => {
            disparities(format, maps.right.context("no map of the right view was computed")?).context("the right view")
        }
        Format::Color(Look { colors, scale_bar }) => {
            let drawn = picture(map, searched(params), colors);
            match scale_bar {
                true => png(&beside(&drawn, searched(params), colors, maps.camera)),
                false => png(&drawn),
            }
        }
        Format::Mask => {
            let samples: Vec<u8> =
                map.data.iter().map(|&value| if pixels(value).is_some() { 255 } else { 0 }).collect();
            png8(map.width, map.height, &samples)
        }
        Format::Confidence => png8(map.width, map.height, &maps.confidence.context("no confidence was computed")?.data),
        Format::Depth(format) => {
            let (found, camera) = depth()?;
            return depths(format, found, camera.baseline);
        }
        Format::Points(format) => {
            let ((found, camera), left) = (depth()?, image(0)?);
            match format {
                PointFormat::Ply => points::ply(found, camera, left),
                PointFormat::Pcd => points::pcd(found, camera, left),
            }
        }
        Format::RectifiedLeft => image_png(image(0)?),
        Format::RectifiedRight => image_png(image(1)?),
        Format::ErrorMap => png(maps.errors.context("no truth was read")?),
    }?;
    Ok(Encoded { bytes, doubt: None })
}
