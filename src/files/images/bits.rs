//! Bits: cameras put 10, 12 or 14 bits into 16-bit files, where they would be nearly black.

use crate::files::error::{Result, bail};
use image::DynamicImage;
use std::path::Path;
use std::str::FromStr;

/// The bits that samples of 16-bit images have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bits {
    /// As the largest sample needs.
    #[default]
    Auto,
    /// This number.
    Given(u32),
    /// As many as the first pair of the sequence has.
    OfFirst(u32),
}

impl FromStr for Bits {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(bits @ 8..=16) => Ok(Self::Given(bits)),
            _ => Err("8 to 16 or auto is needed, such as 10".into()),
        }
    }
}

/// The most bits of a sample.
pub const ALL: u32 = 16;
/// The depths that cameras store in 16 bits; larger samples have 16.
const USUAL: [u32; 4] = [8, 10, 12, 14];

/// The largest sample of an image of 16 bits, without its alpha; `None` of any other.
pub fn largest(image: &DynamicImage) -> Option<u16> {
    let most = |samples: &[u16], channels: usize, colours: usize| {
        samples.chunks_exact(channels).flat_map(|pixel| &pixel[..colours]).copied().max()
    };
    match image {
        DynamicImage::ImageLuma16(image) => most(image, 1, 1),
        DynamicImage::ImageLumaA16(image) => most(image, 2, 1),
        DynamicImage::ImageRgb16(image) => most(image, 3, 3),
        DynamicImage::ImageRgba16(image) => most(image, 4, 3),
        _ => None,
    }
}

/// The bits of samples up to `largest`, which the file at `path` has.
pub fn of(bits: Bits, largest: u16, path: &Path) -> Result<u32> {
    let fixed = match bits {
        Bits::Auto => {
            let needed = u16::BITS - largest.leading_zeros();
            return Ok(USUAL.into_iter().find(|&bits| needed <= bits).unwrap_or(ALL));
        }
        Bits::Given(bits) | Bits::OfFirst(bits) => bits,
    };
    if u32::from(largest) >> fixed > 0 {
        let given = if let Bits::Given(_) = bits { "--bits is" } else { "the first pair's samples have" };
        let needed = u16::BITS - largest.leading_zeros();
        bail!("{path:?} has a sample of {largest}, but {given} {fixed}; give --bits {needed} or more for all");
    }
    Ok(fixed)
}

/// Brings samples of so many bits to 16: the nearest 16-bit value, 2^bits - 1 becomes 65535.
pub fn stretch(image: &mut DynamicImage, bits: u32) {
    if bits >= ALL {
        return;
    }
    let most = (1_u32 << bits) - 1;
    let table: Vec<u16> = (0..=most).map(|v| ((2 * v * 65_535 + most) / (2 * most)) as u16).collect();
    // Alpha is ignored, and may exceed the maximum.
    let wider = |sample: &mut u16| *sample = table.get(usize::from(*sample)).copied().unwrap_or(u16::MAX);
    match image {
        DynamicImage::ImageLuma16(image) => image.iter_mut().for_each(wider),
        DynamicImage::ImageLumaA16(image) => image.iter_mut().for_each(wider),
        DynamicImage::ImageRgb16(image) => image.iter_mut().for_each(wider),
        DynamicImage::ImageRgba16(image) => image.iter_mut().for_each(wider),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, Rgba};

    #[test]
    fn the_common_maximum_decides() {
        let of = |bits, largest| of(bits, largest, Path::new("l.png"));
        for (largest, bits) in
            [(0, 8), (255, 8), (256, 10), (1023, 10), (1024, 12), (4095, 12), (4096, 14), (16383, 14)]
        {
            assert_eq!(of(Bits::Auto, largest).unwrap(), bits, "{largest}");
        }
        assert_eq!([16384, u16::MAX].map(|largest| of(Bits::Auto, largest).unwrap()), [16, 16]);
        assert_eq!(of(Bits::Given(12), 5).unwrap(), 12);
        assert_eq!(of(Bits::Given(16), u16::MAX).unwrap(), 16);
        let told = of(Bits::Given(10), 1024).unwrap_err().to_string();
        assert!(told.contains("\"l.png\" has a sample of 1024, but --bits is 10; give --bits 11"), "{told}");
    }

    #[test]
    fn stretched_samples_are_the_nearest_ones() {
        for bits in 8..=16 {
            let most = (1_u32 << bits) - 1;
            let samples: Vec<u16> = (0..=most).map(|v| v as u16).collect();
            let mut image: DynamicImage = ImageBuffer::<Luma<u16>, _>::from_raw(most + 1, 1, samples).unwrap().into();
            stretch(&mut image, bits);
            for (v, sample) in image.to_luma16().iter().enumerate() {
                let exact = v as f64 * 65535.0 / f64::from(most);
                assert!((f64::from(*sample) - exact).abs() <= 0.5, "{bits} {v}");
            }
        }
        let pixel = ImageBuffer::from_pixel(1, 1, Rgba([1_u16, 2, 1023, 65535]));
        let mut image = DynamicImage::ImageRgba16(pixel);
        assert_eq!(largest(&image), Some(1023));
        stretch(&mut image, 10);
        assert_eq!(image.to_rgba16().into_raw(), [64, 128, 65535, 65535]);
    }
}
