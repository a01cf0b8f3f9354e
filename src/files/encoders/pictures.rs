//! Maps as pictures.

use crate::evaluation::FloatMap;
use crate::files::error::{Error, Result};
use crate::{Colors, DisparityMap, Image, Pixels};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _, Rgb, RgbImage};

/// A map in colours over the disparities `first` to `last`, invalid black.
pub fn picture(map: &DisparityMap, (first, last): (i32, i32), colors: Colors) -> RgbImage {
    let colors = map.color_by(&(first..=last), colors);
    let mut pixels = colors.chunks_exact(4);
    RgbImage::from_fn(map.width, map.height, |_, _| Rgb(pixels.next().map_or([0; 3], |c| [c[0], c[1], c[2]])))
}

/// A truth in the colours that [`picture`] has.
pub fn truth_picture(map: &FloatMap, (first, last): (i32, i32), colors: Colors) -> RgbImage {
    let color = |&disparity: &f32| match disparity.is_finite() {
        false => [0; 3],
        true => colors.at((f64::from(disparity) - f64::from(first)) / f64::from((last - first).max(1))),
    };
    let mut values = map.data().iter();
    RgbImage::from_fn(map.width(), map.height(), |_, _| Rgb(values.next().map_or([0; 3], color)))
}

/// An image as it is shown: red, green, blue and alpha in 8 bits each.
pub fn rgba8(image: &Image) -> Vec<u8> {
    let high = |sample: u16| ((u32::from(sample) + 128) / 257) as u8;
    match image.pixels() {
        Pixels::Gray8(samples) => samples.iter().flat_map(|&s| [s, s, s, u8::MAX]).collect(),
        Pixels::Gray16(samples) => samples.iter().map(|&s| high(s)).flat_map(|s| [s, s, s, u8::MAX]).collect(),
        Pixels::Rgba8(samples) => samples.clone(),
        Pixels::Rgba16(samples) => samples.iter().map(|&s| high(s)).collect(),
    }
}

/// An image as PNG, with its own samples; the fourth one of a pixel is left out.
pub(super) fn image_png(image: &Image) -> Result<Vec<u8>> {
    fn colors<T: Copy>(samples: &[T]) -> Vec<T> {
        samples.as_chunks::<4>().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect()
    }
    let deep = |samples: &[u16]| samples.iter().copied().flat_map(u16::to_ne_bytes).collect::<Vec<u8>>();
    let (samples, kind) = match image.pixels() {
        Pixels::Gray8(samples) => (samples.clone(), ExtendedColorType::L8),
        Pixels::Gray16(samples) => (deep(samples), ExtendedColorType::L16),
        Pixels::Rgba8(samples) => (colors(samples), ExtendedColorType::Rgb8),
        Pixels::Rgba16(samples) => (deep(&colors(samples)), ExtendedColorType::Rgb16),
    };
    let mut bytes = Vec::new();
    let encoded = PngEncoder::new(&mut bytes).write_image(&samples, image.width(), image.height(), kind);
    encoded.map_err(|error| Error::of(&error))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Params;
    use crate::files::encoders::searched;
    use crate::turbo;

    fn map(data: &[i16]) -> DisparityMap {
        DisparityMap { width: data.len() as u32, height: 1, data: data.into() }
    }

    #[test]
    fn colors_span_the_searched_range() {
        let mut params = Params::sgm(17);
        params.min_disparity = -8;
        let colors = picture(&map(&[-8 * 16, 0, 8 * 16, DisparityMap::INVALID]), searched(&params), Colors::Turbo);
        let expected = [turbo(0.0), turbo(0.5), turbo(1.0), [0; 3]];
        assert!(colors.pixels().map(|color| color.0).eq(expected));
        picture(&map(&[0]), searched(&Params::sgm(1)), Colors::Gray); // a range of one disparity has no width
    }
}
