//! A map in the bytes of each format.

use super::disparity::{kitti, pixels};
use super::format::{DepthFormat, Format, searched};
use super::pictures::picture;
use super::samples::{npy, pfm, png, png8, png16, tiff};
use super::{depth, points};
use crate::files::error::{Context as _, Result, bail};
use crate::{ConfidenceMap, DepthMap, DisparityMap, Image, Params};
use image::RgbImage;

/// What is written.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// The disparities.
    pub map: &'a DisparityMap,
    /// Their confidence, if it was computed.
    pub confidence: Option<&'a ConfidenceMap>,
    /// Their depth, if it was computed.
    pub depth: Option<&'a DepthMap>,
    /// The left image, for the colours of points.
    pub left: Option<&'a Image>,
    /// The picture of its errors, if there is a truth.
    pub errors: Option<&'a RgbImage>,
    /// The settings.
    pub params: &'a Params,
}

impl<'a> Maps<'a> {
    /// A map alone.
    pub fn of(map: &'a DisparityMap, params: &'a Params) -> Self {
        Self { map, confidence: None, depth: None, left: None, errors: None, params }
    }
}

/// The bytes of a file.
pub struct Encoded {
    /// All of them.
    pub bytes: Vec<u8>,
    /// Which values of the map the file cannot hold, for a warning.
    pub doubt: Option<String>,
}

/// A map in a format.
///
/// # Errors
/// Where the format cannot hold the map, or `maps` lacks what it is of.
pub fn encode(format: Format, maps: &Maps<'_>) -> Result<Encoded> {
    let mut doubt = None;
    let Maps { map, confidence, params, .. } = maps;
    let (width, height) = (map.width, map.height);
    let floats = |invalid: f32| map.data.iter().map(|&value| pixels(value).unwrap_or(invalid)).collect::<Vec<_>>();
    let bytes = match format {
        Format::Kitti => png16(width, height, kitti(map)?),
        Format::Pfm => pfm(width, height, &floats(f32::INFINITY)),
        Format::Npy => npy(width, height, &floats(f32::NAN)),
        Format::Tiff => tiff(width, height, &floats(f32::NAN)),
        Format::Color => png(&picture(map, searched(params))),
        Format::Mask => {
            let samples: Vec<u8> =
                map.data.iter().map(|&value| if pixels(value).is_some() { 255 } else { 0 }).collect();
            png8(width, height, &samples)
        }
        Format::Confidence => png8(width, height, &confidence.context("no confidence was computed")?.data),
        Format::Depth(format) => {
            let (Some(found), Some(camera), Some(left)) = (maps.depth, &params.depth, maps.left) else {
                bail!("no depth was computed")
            };
            match format {
                DepthFormat::Png => {
                    let (samples, lost) = depth::millimetres(found);
                    if lost > 0 {
                        doubt = Some(format!(
                            "{lost} pixels are 65.5355 m away or farther at a baseline of {} m, beyond a 16-bit PNG in \
                             millimetres, and are 0 there; if the baseline is right, use .pfm, .npy or .tif",
                            camera.baseline
                        ));
                    }
                    png16(width, height, samples)
                }
                DepthFormat::Pfm => pfm(width, height, &depth::metres(found, f32::INFINITY)),
                DepthFormat::Npy => npy(width, height, &depth::metres(found, f32::NAN)),
                DepthFormat::Tiff => tiff(width, height, &depth::metres(found, f32::NAN)),
                DepthFormat::Ply => points::ply(found, camera, left),
                DepthFormat::Pcd => points::pcd(found, camera, left),
            }
        }
        Format::ErrorMap => png(maps.errors.context("no truth was read")?),
    }?;
    Ok(Encoded { bytes, doubt })
}
