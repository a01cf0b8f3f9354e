//! The 3x3 Sobel derivatives.

use bytemuck::Pod;

use crate::cpu::images::padded::{MARGIN, Padded};

/// A number that samples are of, and how much of it stands for one of 256 levels.
pub trait Depth: Pod + Into<i32> + Send + Sync + PartialOrd {
    const UNIT: i32;

    /// From the eight neighbours, `[[above left, above, above right], [left, right], [below left, below, below right]]`, the
    /// derivatives to the right and downwards, in units of [`Depth::UNIT`], rounded to the nearest, halves upwards.
    fn sobel(above: [Self; 3], beside: [Self; 2], below: [Self; 3]) -> [i16; 2];

    /// The nearest of the 256 levels.
    fn narrow(self) -> u8;
}

impl Depth for u8 {
    const UNIT: i32 = 1;

    #[inline(always)]
    fn sobel(above: [u8; 3], beside: [u8; 2], below: [u8; 3]) -> [i16; 2] {
        let [a, b, c] = above.map(i16::from);
        let [d, e] = beside.map(i16::from);
        let [f, g, h] = below.map(i16::from);
        [c - a + 2 * (e - d) + h - f, f - a + 2 * (g - b) + h - c]
    }

    #[inline(always)]
    fn narrow(self) -> u8 {
        self
    }
}

impl Depth for u16 {
    const UNIT: i32 = 257;

    #[inline(always)]
    fn sobel(above: [u16; 3], beside: [u16; 2], below: [u16; 3]) -> [i16; 2] {
        let [a, b, c] = above.map(i32::from);
        let [d, e] = beside.map(i32::from);
        let [f, g, h] = below.map(i32::from);
        // At most 4 * 65535, so that the number that is divided is never negative.
        let unit = |v: i32| ((v + 128 + 257 * 1024) as u32 / 257) as i16 - 1024;
        [unit(c - a + 2 * (e - d) + h - f), unit(f - a + 2 * (g - b) + h - c)]
    }

    #[inline(always)]
    fn narrow(self) -> u8 {
        ((u32::from(self) + 128) / 257) as u8
    }
}

/// Writes `byte(gx, gy)` of the derivatives of each pixel of a row.
#[inline(always)]
pub fn derivatives<T: Depth>(image: &Padded<T>, y: i64, out: &mut [u8], byte: impl Fn(i16, i16) -> u8) {
    derivatives_between(image, [y - 1, y, y + 1], out, byte);
}

/// The same from three rows of the image.
#[inline(always)]
pub fn derivatives_between<T: Depth>(image: &Padded<T>, rows: [i64; 3], out: &mut [u8], byte: impl Fn(i16, i16) -> u8) {
    let width = image.width;
    let [above, here, below] = rows.map(|y| image.whole_row(y));
    let (a, b, c) = (&above[MARGIN - 1..][..width], &above[MARGIN..][..width], &above[MARGIN + 1..][..width]);
    let (d, e) = (&here[MARGIN - 1..][..width], &here[MARGIN + 1..][..width]);
    let (f, g, h) = (&below[MARGIN - 1..][..width], &below[MARGIN..][..width], &below[MARGIN + 1..][..width]);
    let out = &mut out[..width];
    for x in 0..width {
        let [gx, gy] = T::sobel([a[x], b[x], c[x]], [d[x], e[x]], [f[x], g[x], h[x]]);
        out[x] = byte(gx, gy);
    }
}
