use crate::ImageView;
use crate::reference::Plane;

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
pub fn gray<'a>(image: impl Into<ImageView<'a>>, channel: Channel) -> Plane<u8> {
    let image = image.into();
    let (deep, unit) = (deep_gray(image, channel), depth_unit(image));
    let data = deep.data.iter().map(|&v| if unit == 1 { v as u8 } else { narrow(v) }).collect();
    Plane { data, width: deep.width, height: deep.height }
}

/// Stage `deep_gray`: one sample a pixel at the depth of the image's samples, 8 or 16 bits.
pub fn deep_gray<'a>(image: impl Into<ImageView<'a>>, channel: Channel) -> Plane<u16> {
    let image = image.into();
    // Of a gray pixel all three are its sample, which is its luma.
    let read = |[r, g, b]: [u16; 3]| match channel {
        Channel::Luma => ((9798 * u32::from(r) + 19235 * u32::from(g) + 3735 * u32::from(b) + 16384) >> 15) as u16,
        Channel::Sample(sample) => [r, g, b][sample],
    };
    let (width, height) = (image.width() as usize, image.height() as usize);
    let data = (0..width * height).map(|i| read(image.color(i % width, i / width))).collect();
    Plane { width, height, data }
}

/// How much of a sample of [`deep_gray`] stands for one of 256 levels.
pub fn depth_unit<'a>(image: impl Into<ImageView<'a>>) -> i32 {
    if image.into().format().is_deep() { 257 } else { 1 }
}
