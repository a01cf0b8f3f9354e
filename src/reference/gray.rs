use super::Plane;
use crate::{Image, Pixels};

/// Stage `gray`: one 8-bit luma sample a pixel.
///
/// Colour: (9798 R + 19235 G + 3735 B + 16384) >> 15, the weights of ITU-R BT.601 in 15 bits, which sum to 1. 16-bit
/// samples are weighted at full depth, then brought to 8 bits as (v + 128) / 257, the nearest of the 256 levels.
pub fn gray(image: &Image) -> Plane {
    let luma = |r: u32, g: u32, b: u32| (9798 * r + 19235 * g + 3735 * b + 16384) >> 15;
    let narrow = |v: u32| ((v + 128) / 257) as u8;
    let data = match image.pixels() {
        Pixels::Gray8(samples) => samples.clone(),
        Pixels::Gray16(samples) => samples.iter().map(|&v| narrow(v.into())).collect(),
        Pixels::Rgba8(samples) => {
            samples.chunks_exact(4).map(|p| luma(p[0].into(), p[1].into(), p[2].into()) as u8).collect()
        }
        Pixels::Rgba16(samples) => {
            samples.chunks_exact(4).map(|p| narrow(luma(p[0].into(), p[1].into(), p[2].into()))).collect()
        }
    };
    Plane { width: image.width() as usize, height: image.height() as usize, data }
}
