use crate::network::Padded;
use crate::reference::Values;
use crate::{Image, Pixels};

/// Stage `network_input`: red, green and blue, each sample divided by the largest that its format has (255 or 65535), minus
/// [`Padded::MEAN`], divided by [`Padded::DEVIATION`]. A gray image has three equal channels. Then zeros are added above
/// and to the right.
pub fn network_input(image: &Image, padded: &Padded) -> Values {
    let mut values = Values::new([3, 1, padded.height, padded.width]);
    let [width, height] = [image.width() as usize, image.height() as usize];
    let above = padded.height - height;
    for channel in 0..3 {
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let value = (sample(image, y * width + x, channel) - Padded::MEAN[channel]) / Padded::DEVIATION[channel];
            values.data[(channel * padded.height + above + y) * padded.width + x] = value;
        }
    }
    values
}

/// A channel of a pixel, 0 to 1.
fn sample(image: &Image, pixel: usize, channel: usize) -> f64 {
    match image.pixels() {
        Pixels::Gray8(samples) => f64::from(samples[pixel]) / 255.0,
        Pixels::Gray16(samples) => f64::from(samples[pixel]) / 65535.0,
        Pixels::Rgba8(samples) => f64::from(samples[4 * pixel + channel]) / 255.0,
        Pixels::Rgba16(samples) => f64::from(samples[4 * pixel + channel]) / 65535.0,
    }
}
