//! Images that are continued by their borders in memory.

use rayon::prelude::*;

use bytemuck::Pod;

use crate::cpu::aligned::Aligned;
use crate::reference::Plane;

/// Columns before and behind the image: as far as any window reaches.
pub const MARGIN: usize = 32;

/// An image, each row continued by its first and last value to [`MARGIN`] columns on both sides.
#[derive(Clone)]
pub struct Padded<T> {
    pub width: usize,
    pub height: usize,
    data: Aligned<T>,
}

impl<T: Pod + Send + Sync> Padded<T> {
    /// An image whose rows are written by `write(y, row)`, rows in parallel, in bands of at least 16.
    pub fn from_rows(width: usize, height: usize, write: impl Fn(usize, &mut [T]) + Sync) -> Self {
        let stride = width + 2 * MARGIN;
        let mut data = Aligned::zeroed(stride * height);
        data.par_chunks_exact_mut(stride).enumerate().with_min_len(16).for_each(|(y, row)| {
            write(y, &mut row[MARGIN..MARGIN + width]);
            let (first, last) = (row[MARGIN], row[MARGIN + width - 1]);
            row[..MARGIN].fill(first);
            row[MARGIN + width..].fill(last);
        });
        Self { width, height, data }
    }

    /// Of row y, or the nearest one that there is, `width` values from column `dx` on, which is at least -[`MARGIN`] and at
    /// most [`MARGIN`].
    #[inline(always)]
    pub fn row(&self, y: i64, dx: i64) -> &[T] {
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        let at = y * (self.width + 2 * MARGIN) + (MARGIN as i64 + dx) as usize;
        &self.data[at..at + self.width]
    }

    /// A row with its margins.
    #[inline(always)]
    pub fn whole_row(&self, y: i64) -> &[T] {
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        let stride = self.width + 2 * MARGIN;
        &self.data[y * stride..][..stride]
    }
}

/// Samples of 8 bits, or of 16 with the unit 257.
#[derive(Clone)]
pub enum Samples {
    Bytes(Padded<u8>),
    Words(Padded<u16>),
}

impl Samples {
    /// Of an image in the definition's layout, whose unit is `unit`.
    pub fn of(image: &Plane<u16>, unit: i32) -> Self {
        let row = |y: usize| &image.data[y * image.width..][..image.width];
        match unit {
            1 => Self::Bytes(Padded::from_rows(image.width, image.height, |y, to| {
                to.iter_mut().zip(row(y)).for_each(|(to, &v)| *to = v as u8);
            })),
            _ => Self::Words(Padded::from_rows(image.width, image.height, |y, to| to.copy_from_slice(row(y)))),
        }
    }

    /// In the definition's layout.
    pub fn plane(&self) -> Plane<u16> {
        let (width, height) = match self {
            Self::Bytes(image) => (image.width, image.height),
            Self::Words(image) => (image.width, image.height),
        };
        let row = |y: usize| match self {
            Self::Bytes(image) => image.row(y as i64, 0).iter().map(|&v| v.into()).collect::<Vec<_>>(),
            Self::Words(image) => image.row(y as i64, 0).to_vec(),
        };
        Plane { width, height, data: (0..height).flat_map(row).collect() }
    }
}
