use rayon::prelude::*;

use crate::{DisparityMap, Error, Image, ImageView, Pixels};

/// Stage `mirror`: a map with each row reversed. The left view of the pair (mirrored right image, mirrored left image) is
/// the mirrored right view of the pair.
pub fn mirror(map: &DisparityMap) -> DisparityMap {
    DisparityMap { data: reversed_rows(&map.data, map.width, 1), ..*map }
}

/// An image with each row reversed.
///
/// # Errors
/// None for an image: it has the size that it had.
pub fn mirrored<'a>(image: impl Into<ImageView<'a>>) -> Result<Image, Error> {
    let image = image.into().image();
    let width = image.width();
    let pixels = match image.pixels() {
        Pixels::Gray8(samples) => Pixels::Gray8(reversed_rows(samples, width, 1)),
        Pixels::Gray16(samples) => Pixels::Gray16(reversed_rows(samples, width, 1)),
        Pixels::Rgba8(samples) => Pixels::Rgba8(reversed_rows(samples, width, 4)),
        Pixels::Rgba16(samples) => Pixels::Rgba16(reversed_rows(samples, width, 4)),
    };
    Image::new(width, image.height(), pixels)
}

fn reversed_rows<T: Copy + Default + Send + Sync>(samples: &[T], width: u32, a_pixel: usize) -> Vec<T> {
    let row = width as usize * a_pixel;
    let mut reversed = vec![T::default(); samples.len()];
    reversed.par_chunks_exact_mut(row).zip(samples.par_chunks_exact(row)).with_min_len(16).for_each(|(to, from)| {
        if a_pixel == 1 {
            to.iter_mut().zip(from.iter().rev()).for_each(|(to, from)| *to = *from);
        } else {
            let pixels = to.chunks_exact_mut(a_pixel).zip(from.chunks_exact(a_pixel).rev());
            pixels.for_each(|(to, from)| to.copy_from_slice(from));
        }
    });
    reversed
}
