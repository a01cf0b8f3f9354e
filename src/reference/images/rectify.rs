use crate::{Error, Image, ImageView, Pixels, Rectification};

/// Stage `rectify`: the image of a `side` (0: left) as the rectified camera would have taken it.
///
/// Each sample is the mean of the four around its position, weighted in 1/256 px, rounded to the nearest, a half upwards.
/// Outside the image all samples are 0.
///
/// # Errors
/// [`Error::Image`] if the image is not of the rectification's size.
pub fn rectify<'a>(
    image: impl Into<ImageView<'a>>,
    rectification: &Rectification,
    side: usize,
) -> Result<Image, Error> {
    let image = image.into().image();
    let (width, height) = (image.width(), image.height());
    rectification.accepts(width, height)?;
    let sampled = |count: usize, sample: &dyn Fn(usize) -> u32| -> Vec<u32> {
        let at = |x: i32, y: i32, channel: usize| match x >= 0 && y >= 0 && x < width as i32 && y < height as i32 {
            true => sample((y as usize * width as usize + x as usize) * count + channel),
            false => 0,
        };
        let blend = |&[x, y]: &[i32; 2], channel: usize| {
            let (a, b) = ((x & 255) as u32, (y & 255) as u32);
            let (x, y) = (x >> 8, y >> 8);
            let above = (256 - a) * at(x, y, channel) + a * at(x + 1, y, channel);
            let below = (256 - a) * at(x, y + 1, channel) + a * at(x + 1, y + 1, channel);
            ((256 - b) * above + b * below + 32_768) >> 16
        };
        let positions = rectification.positions(side).iter();
        positions.flat_map(|position| (0..count).map(move |channel| blend(position, channel))).collect()
    };
    let bytes = |samples: Vec<u32>| samples.into_iter().map(|v| v as u8).collect();
    let deep = |samples: Vec<u32>| samples.into_iter().map(|v| v as u16).collect();
    let pixels = match image.pixels() {
        Pixels::Gray8(s) => Pixels::Gray8(bytes(sampled(1, &|i| s[i].into()))),
        Pixels::Gray16(s) => Pixels::Gray16(deep(sampled(1, &|i| s[i].into()))),
        Pixels::Rgba8(s) => Pixels::Rgba8(bytes(sampled(4, &|i| s[i].into()))),
        Pixels::Rgba16(s) => Pixels::Rgba16(deep(sampled(4, &|i| s[i].into()))),
    };
    let [width, height] = rectification.rectified_size();
    Image::new(width, height, pixels)
}
