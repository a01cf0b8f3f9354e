use crate::reference::Plane;
use crate::{Image, Pixels};

/// What a pixel is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// (9798 R + 19235 G + 3735 B + 16384) >> 15: the weights of ITU-R BT.601 in 15 bits, which sum to 1.
    Luma,
    /// Of a colour image the red, green or blue sample (0 to 2), of a gray one the only sample.
    Sample(usize),
}

/// The nearest of the 256 levels 257 k to a 16-bit sample.
pub(crate) fn narrow(v: u16) -> u8 {
    ((u32::from(v) + 128) / 257) as u8
}

/// Stage `gray`: one 8-bit sample a pixel. 16-bit samples are weighted at full depth, then brought to 8 bits.
pub fn gray(image: &Image, channel: Channel) -> Plane<u8> {
    let deep = deep_gray(image, channel);
    let data = deep.data.iter().map(|&v| if depth_unit(image) == 1 { v as u8 } else { narrow(v) }).collect();
    Plane { data, width: deep.width, height: deep.height }
}

/// Stage `deep_gray`: one sample a pixel at the depth of the image's samples, 8 or 16 bits.
pub fn deep_gray(image: &Image, channel: Channel) -> Plane<u16> {
    let read = |r: u16, g: u16, b: u16| match channel {
        Channel::Luma => ((9798 * u32::from(r) + 19235 * u32::from(g) + 3735 * u32::from(b) + 16384) >> 15) as u16,
        Channel::Sample(sample) => [r, g, b][sample],
    };
    let data = match image.pixels() {
        Pixels::Gray8(samples) => samples.iter().map(|&v| v.into()).collect(),
        Pixels::Gray16(samples) => samples.clone(),
        Pixels::Rgba8(samples) => {
            samples.chunks_exact(4).map(|p| read(p[0].into(), p[1].into(), p[2].into())).collect()
        }
        Pixels::Rgba16(samples) => samples.chunks_exact(4).map(|p| read(p[0], p[1], p[2])).collect(),
    };
    Plane { width: image.width() as usize, height: image.height() as usize, data }
}

/// How much of a sample of [`deep_gray`] stands for one of 256 levels.
pub fn depth_unit(image: &Image) -> i32 {
    match image.pixels() {
        Pixels::Gray8(_) | Pixels::Rgba8(_) => 1,
        Pixels::Gray16(_) | Pixels::Rgba16(_) => 257,
    }
}
