//! Both views in one picture: where each of them lies.

use crate::files::error::{Result, ensure};
use image::{DynamicImage, GenericImageView as _};

/// How one picture shows both views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// The left half of the picture is one view, the right half the other.
    SideBySide,
    /// The upper half of the picture is one view, the lower half the other.
    TopBottom,
    /// The rows belong to the two views in turn.
    Interlaced,
}

/// Which part of a file or a frame is which view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// As the file itself says: the index of an MPO file, the marker of a JPS file.
    Auto,
    /// One picture shows both.
    Both {
        /// How.
        arrangement: Arrangement,
        /// Whether the right view comes first.
        swapped: bool,
    },
}

impl Split {
    /// Both views in one picture.
    #[must_use]
    pub const fn both(arrangement: Arrangement, swapped: bool) -> Self {
        Self::Both { arrangement, swapped }
    }
}

/// The left and the right view of a picture, which is called `name` in errors.
pub fn views(picture: &DynamicImage, arrangement: Arrangement, swapped: bool, name: &str) -> Result<[DynamicImage; 2]> {
    let (width, height) = picture.dimensions();
    let (what, side) = match arrangement {
        Arrangement::SideBySide => ("columns", width),
        Arrangement::TopBottom | Arrangement::Interlaced => ("rows", height),
    };
    ensure!(
        side.is_multiple_of(2),
        "{name} is {width}x{height}, but its {what} are to be those of two views of one size; crop it to an even number of \
         {what}, or choose another --split"
    );
    let half = side / 2;
    let [first, second] = match arrangement {
        Arrangement::SideBySide => [0, half].map(|x| picture.crop_imm(x, 0, half, height)),
        Arrangement::TopBottom => [0, half].map(|y| picture.crop_imm(0, y, width, half)),
        Arrangement::Interlaced => [0, 1].map(|first| rows(picture, first)),
    };
    Ok(if swapped { [second, first] } else { [first, second] })
}

/// Every second row, from `first` on.
fn rows(picture: &DynamicImage, first: usize) -> DynamicImage {
    fn taken<P: image::Pixel>(
        picture: &image::ImageBuffer<P, Vec<P::Subpixel>>,
        first: usize,
    ) -> image::ImageBuffer<P, Vec<P::Subpixel>> {
        let row = picture.width() as usize * usize::from(P::CHANNEL_COUNT);
        let samples = picture.as_raw().chunks_exact(row.max(1)).skip(first).step_by(2).flatten().copied().collect();
        image::ImageBuffer::from_raw(picture.width(), picture.height() / 2, samples).unwrap_or_default()
    }
    match picture {
        DynamicImage::ImageLuma8(picture) => taken(picture, first).into(),
        DynamicImage::ImageLumaA8(picture) => taken(picture, first).into(),
        DynamicImage::ImageRgb8(picture) => taken(picture, first).into(),
        DynamicImage::ImageRgba8(picture) => taken(picture, first).into(),
        DynamicImage::ImageLuma16(picture) => taken(picture, first).into(),
        DynamicImage::ImageLumaA16(picture) => taken(picture, first).into(),
        DynamicImage::ImageRgb16(picture) => taken(picture, first).into(),
        DynamicImage::ImageRgba16(picture) => taken(picture, first).into(),
        other => taken(&other.to_rgb16(), first).into(), // floats are refused before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, Rgb, RgbImage};

    #[test]
    fn each_view_is_where_the_arrangement_says() {
        let picture = DynamicImage::from(GrayImage::from_fn(4, 4, |x, y| image::Luma([(10 * y + x) as u8])));
        let parts = |arrangement, swapped| {
            views(&picture, arrangement, swapped, "p").unwrap().map(|view| view.into_luma8().into_raw())
        };
        let [left, right] = parts(Arrangement::SideBySide, false);
        assert_eq!((&left[..4], &right[..4]), (&[0, 1, 10, 11][..], &[2, 3, 12, 13][..]));
        assert_eq!(parts(Arrangement::SideBySide, true), [right, left]);
        let [left, right] = parts(Arrangement::TopBottom, false);
        assert_eq!((left[0], right[0], left.len()), (0, 20, 8));
        let [left, right] = parts(Arrangement::Interlaced, false);
        assert_eq!(left, [0, 1, 2, 3, 20, 21, 22, 23]);
        assert_eq!(right, [10, 11, 12, 13, 30, 31, 32, 33]);
        let colour = DynamicImage::from(RgbImage::from_fn(2, 2, |x, y| Rgb([x as u8, y as u8, 7])));
        let [_, right] = views(&colour, Arrangement::Interlaced, false, "p").unwrap();
        assert_eq!(right.into_rgb8().into_raw(), [0, 1, 7, 1, 1, 7]);
    }

    #[test]
    fn an_odd_side_is_refused() {
        let picture = DynamicImage::from(GrayImage::new(5, 3));
        for (arrangement, word) in
            [(Arrangement::SideBySide, "columns"), (Arrangement::TopBottom, "rows"), (Arrangement::Interlaced, "rows")]
        {
            let told = views(&picture, arrangement, false, "\"p.png\"").unwrap_err().to_string();
            assert!(told.contains("\"p.png\" is 5x3") && told.contains(word), "{told}");
        }
    }
}
