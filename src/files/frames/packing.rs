//! Packing: how the bytes of a frame hold its pixels.

use crate::files::error::{Context as _, Result, ensure};
use crate::files::images::MAX_PIXELS;
use image::{DynamicImage, ImageBuffer};

/// How the bytes of a frame hold its pixels. Rows follow each other without padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Packing {
    /// A byte a pixel.
    Gray8,
    /// Two bytes a pixel.
    Gray16 {
        /// Whether the higher byte comes first.
        big: bool,
    },
    /// Bytes a pixel, among them red, green and blue at these places.
    Rgb8 {
        /// Bytes a pixel, 3 or 4.
        bytes: usize,
        /// The places of red, green and blue among them.
        places: [usize; 3],
    },
    /// Three numbers of two bytes a pixel, the higher byte first.
    Rgb16,
    /// A plane of luma, then the two of chroma, reduced by powers of two.
    Planar {
        /// The binary logarithm of how many columns have one chroma.
        columns: u32,
        /// The same of rows.
        rows: u32,
        /// Whether another plane of full size follows, which is ignored.
        alpha: bool,
        /// Whether luma is from 0 to 255 rather than from 16 to 235, or what stands for these.
        full: bool,
        /// Bits of a sample; above 8 it has two bytes, the lower one first.
        bits: u32,
    },
    /// A plane of luma, then one of both chromas in turn, for 2x2 pixels each.
    Nv12,
    /// Two pixels in four bytes, the first luma at this place of them; the chromas are between the lumas.
    Yuv422 {
        /// 0 of YUYV, 1 of UYVY.
        luma: usize,
    },
}

/// Red, green, blue.
pub const RGB8: Packing = Packing::Rgb8 { bytes: 3, places: [0, 1, 2] };
/// Blue, green, red.
pub const BGR8: Packing = Packing::Rgb8 { bytes: 3, places: [2, 1, 0] };
/// Red, green, blue, alpha.
pub const RGBA8: Packing = Packing::Rgb8 { bytes: 4, places: [0, 1, 2] };
/// Blue, green, red, alpha.
pub const BGRA8: Packing = Packing::Rgb8 { bytes: 4, places: [2, 1, 0] };

impl Packing {
    /// The bytes of a frame.
    ///
    /// # Errors
    /// If a side is 0, or the frame has more pixels than a map can have.
    pub fn frame_bytes(self, width: u32, height: u32) -> Result<usize> {
        let pixels = u64::from(width) * u64::from(height);
        ensure!(
            (1..=MAX_PIXELS).contains(&pixels),
            "a frame of {width}x{height} pixels is declared, but 1 to {MAX_PIXELS} pixels are read; crop or scale it"
        );
        let half = |side: u32| u64::from(side.div_ceil(2));
        let bytes = match self {
            Self::Gray8 => pixels,
            Self::Gray16 { .. } => 2 * pixels,
            Self::Rgb8 { bytes, .. } => bytes as u64 * pixels,
            Self::Rgb16 => 6 * pixels,
            Self::Planar { columns, rows, alpha, bits, .. } => {
                let chroma = u64::from(width.div_ceil(1 << columns)) * u64::from(height.div_ceil(1 << rows));
                (pixels + 2 * chroma + if alpha { pixels } else { 0 }) * if bits > 8 { 2 } else { 1 }
            }
            Self::Nv12 => pixels + 2 * half(width) * half(height),
            Self::Yuv422 { .. } => 4 * half(width) * u64::from(height),
        };
        usize::try_from(bytes).with_context(|| format!("a frame of {bytes} bytes does not fit the memory"))
    }

    /// The picture in the bytes of a frame, as many as [`Packing::frame_bytes`].
    ///
    /// # Errors
    /// If there are fewer or more bytes.
    pub fn picture(self, width: u32, height: u32, bytes: Vec<u8>) -> Result<DynamicImage> {
        let expected = self.frame_bytes(width, height)?;
        ensure!(
            bytes.len() == expected,
            "a frame of {width}x{height} pixels has {} bytes, but {expected} are expected",
            bytes.len()
        );
        let wide = width as usize;
        let picture = match self {
            Self::Gray8 => ImageBuffer::from_raw(width, height, bytes).map(DynamicImage::ImageLuma8),
            Self::Gray16 { big } => {
                let samples = if big { words(&bytes, u16::from_be_bytes) } else { words(&bytes, u16::from_le_bytes) };
                ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageLuma16)
            }
            Self::Rgb8 { bytes: 3, places: [0, 1, 2] } => {
                ImageBuffer::from_raw(width, height, bytes).map(DynamicImage::ImageRgb8)
            }
            Self::Rgb8 { bytes: count, places } => {
                let pixels = bytes.chunks_exact(count).flat_map(|pixel| places.map(|place| pixel[place])).collect();
                ImageBuffer::from_raw(width, height, pixels).map(DynamicImage::ImageRgb8)
            }
            Self::Rgb16 => {
                let samples = words(&bytes, u16::from_be_bytes);
                ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageRgb16)
            }
            Self::Planar { columns, rows, full, bits, .. } => {
                let row = wide.div_ceil(1 << columns);
                let (luma, plane) = (wide * height as usize, row * (height as usize).div_ceil(1 << rows));
                let places = |x: usize, y: usize| {
                    let chroma = luma + (y >> rows) * row + (x >> columns);
                    [y * wide + x, chroma, chroma + plane]
                };
                if bits > 8 {
                    let samples = words(&bytes, u16::from_le_bytes);
                    let samples =
                        colours([width, height], (full, bits), |x, y| places(x, y).map(|i| samples[i].into()));
                    ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageRgb16)
                } else {
                    of_bytes([width, height], full, |x, y| places(x, y).map(|i| bytes[i]))
                }
            }
            Self::Nv12 => {
                let (luma, chroma) = bytes.split_at(wide * height as usize);
                let place = |x: usize, y: usize| 2 * ((y >> 1) * wide.div_ceil(2) + (x >> 1));
                let pixel = |x, y| [luma[y * wide + x], chroma[place(x, y)], chroma[place(x, y) + 1]];
                of_bytes([width, height], false, pixel)
            }
            Self::Yuv422 { luma } => {
                let row = 4 * wide.div_ceil(2);
                let pixel = |x: usize, y: usize| {
                    let four = &bytes[y * row + 4 * (x / 2)..][..4];
                    [four[luma + 2 * (x % 2)], four[1 - luma], four[3 - luma]]
                };
                of_bytes([width, height], false, pixel)
            }
        };
        picture.with_context(|| format!("a frame of {width}x{height} pixels has too few bytes"))
    }
}

/// Samples of two bytes.
fn words(bytes: &[u8], word: impl Fn([u8; 2]) -> u16) -> Vec<u16> {
    bytes.as_chunks().0.iter().map(|pair| word(*pair)).collect()
}

/// The colours of pixels in luma and two chromas of a byte each.
fn of_bytes(size: [u32; 2], full: bool, pixel: impl Fn(usize, usize) -> [u8; 3]) -> Option<DynamicImage> {
    let samples = colours(size, (full, 8), |x, y| pixel(x, y).map(i32::from));
    let samples = samples.into_iter().map(|sample| sample as u8).collect(); // of 8 bits
    ImageBuffer::from_raw(size[0], size[1], samples).map(DynamicImage::ImageRgb8)
}

/// The colours of pixels in luma and two chromas of so many bits, by ITU-R BT.601 in integers.
fn colours([width, height]: [u32; 2], (full, bits): (bool, u32), pixel: impl Fn(usize, usize) -> [i32; 3]) -> Vec<u16> {
    let (most, more) = ((1 << bits) - 1, bits - 8);
    let sample = |value: i32| (value >> 8).clamp(0, most) as u16;
    let mut samples = Vec::with_capacity(3 * width as usize * height as usize);
    for y in 0..height as usize {
        for x in 0..width as usize {
            let [luma, u, v] = pixel(x, y).map(|sample| sample.min(most));
            let (u, v) = (u - (128 << more), v - (128 << more));
            samples.extend(if full {
                let luma = (luma << 8) + 128;
                [luma + 359 * v, luma - 88 * u - 183 * v, luma + 454 * u].map(sample)
            } else {
                let luma = 298 * (luma - (16 << more)) + 128;
                [luma + 409 * v, luma - 100 * u - 208 * v, luma + 516 * u].map(sample)
            });
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    const I420: Packing = Packing::Planar { columns: 1, rows: 1, alpha: false, full: false, bits: 8 };

    #[test]
    fn frames_of_odd_sides_have_chroma_for_their_last_pixels() {
        for (packing, bytes) in [
            (Packing::Gray8, 15),
            (Packing::Gray16 { big: false }, 30),
            (RGB8, 45),
            (BGRA8, 60),
            (I420, 15 + 2 * 3 * 2),
            (Packing::Planar { columns: 2, rows: 0, alpha: true, full: true, bits: 8 }, 15 + 2 * 2 * 3 + 15),
            (Packing::Planar { columns: 1, rows: 0, alpha: false, full: false, bits: 10 }, 2 * (15 + 2 * 3 * 3)),
            (Packing::Nv12, 15 + 12),
            (Packing::Yuv422 { luma: 0 }, 36),
        ] {
            assert_eq!(packing.frame_bytes(5, 3).unwrap(), bytes, "{packing:?}");
            let picture = packing.picture(5, 3, vec![100; bytes]).unwrap();
            assert_eq!((picture.width(), picture.height()), (5, 3), "{packing:?}");
            assert!(packing.picture(5, 3, vec![100; bytes - 1]).is_err(), "{packing:?}");
        }
        assert!(Packing::Gray8.frame_bytes(0, 5).is_err() && Packing::Gray8.frame_bytes(1 << 20, 1 << 20).is_err());
    }

    #[test]
    fn luma_and_chroma_become_colours() {
        let first =
            |packing: Packing, bytes: &[u8]| packing.picture(2, 2, bytes.to_vec()).unwrap().to_rgb8().get_pixel(0, 0).0;
        // Black, white, and BT.601's red: 81, 90, 240.
        assert_eq!(first(I420, &[16, 0, 0, 0, 128, 128]), [0, 0, 0]);
        assert_eq!(first(I420, &[235, 0, 0, 0, 128, 128]), [255, 255, 255]);
        assert_eq!(first(I420, &[81, 0, 0, 0, 90, 240]), [255, 0, 0]);
        assert_eq!(first(Packing::Nv12, &[81, 0, 0, 0, 90, 240]), [255, 0, 0]);
        assert_eq!(first(Packing::Yuv422 { luma: 0 }, &[81, 90, 0, 240, 0, 0, 0, 0]), [255, 0, 0]);
        assert_eq!(first(Packing::Yuv422 { luma: 1 }, &[90, 81, 240, 0, 0, 0, 0, 0]), [255, 0, 0]);
        // The same in 10 and 16 bits, where all is 4 and 256 times as much; what is beyond the bits counts as the most.
        for (bits, scale, most) in [(10, 4_u16, 1023), (16, 256, 65535)] {
            let deep = Packing::Planar { columns: 1, rows: 1, alpha: false, full: false, bits };
            let pixel = |samples: [u16; 3]| {
                let [luma, u, v] = samples.map(|sample| sample.to_le_bytes());
                let bytes = [luma, [0; 2], [0; 2], [0; 2], u, v].concat();
                deep.picture(2, 2, bytes).unwrap().into_rgb16().get_pixel(0, 0).0
            };
            assert_eq!(pixel([16, 128, 128].map(|sample| sample * scale)), [0, 0, 0]);
            let [red, green, blue] = pixel([81, 90, 240].map(|sample| sample * scale));
            assert!(red >= most - 2 * scale && green <= scale && blue <= scale, "{red} {green} {blue}");
            let [red, ..] = pixel([u16::MAX, 128 * scale, 128 * scale]);
            assert_eq!(red, most);
        }
        let full = Packing::Planar { columns: 1, rows: 1, alpha: false, full: true, bits: 8 };
        assert_eq!(first(full, &[255, 0, 0, 0, 128, 128]), [255, 255, 255]);
        assert_eq!(first(full, &[76, 0, 0, 0, 85, 255]), [254, 0, 0]);
        assert_eq!(first(BGR8, &[1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0]), [3, 2, 1]);
    }
}
