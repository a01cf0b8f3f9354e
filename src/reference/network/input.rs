use crate::ImageView;
use crate::network::Padded;
use crate::reference::{Values, depth_unit};

/// Stage `network_input`: red, green and blue, each sample divided by the largest that its format has (255 or 65535), minus
/// [`Padded::MEAN`], divided by [`Padded::DEVIATION`]. A gray image has three equal channels. Then zeros are added above
/// and to the right.
pub fn network_input<'a>(image: impl Into<ImageView<'a>>, padded: &Padded) -> Values {
    let image = image.into();
    let largest = f64::from(255 * depth_unit(image));
    let mut values = Values::new([3, 1, padded.height, padded.width]);
    let [width, height] = [image.width() as usize, image.height() as usize];
    let above = padded.height - height;
    for channel in 0..3 {
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let sample = f64::from(image.color(x, y)[channel]) / largest;
            let value = (sample - Padded::MEAN[channel]) / Padded::DEVIATION[channel];
            values.data[(channel * padded.height + above + y) * padded.width + x] = value;
        }
    }
    values
}
