//! What the cost compares, laid out as the cost reads it.

use std::slice::ChunksExactMut;

use rayon::prelude::*;

use crate::Params;
use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::params::{Census, Descriptor};
use crate::reference::Descriptors;

/// The descriptors of one side as planes of bytes, `[y][plane][column]`, with r = block / 2, W columns in the image, and n
/// disparities, rounded up to a multiple of [`LANES`]. Rows are continued by the border, so that the cost needs no clamping.
///
/// - Left: W + 2 r columns; column c is x = c - r.
/// - Right: W + 2 r + n columns, mirrored, so that d rises with the address; column c is x = W - 1 + r - min_disparity - c. So
///   the left column c is compared at the disparity `min_disparity + d` with the right column W + 2 r - 1 - c + d.
///
/// Bits of a census string are packed, eight a plane, in the order of the definition's bytes and bits.
pub struct Planes {
    /// Pixels a row of the image.
    pub width: usize,
    /// Rows of the image.
    pub height: usize,
    /// Bytes of a pixel.
    pub planes: usize,
    stride: usize,
    data: Aligned<u8>,
}

/// A side of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

impl Planes {
    /// For images of `width` x `height` pixels, from what `write(y, row)` writes of each row, in parallel.
    pub fn from_rows(
        width: usize,
        height: usize,
        side: Side,
        params: &Params,
        write: impl Fn(usize, &mut RowOfPlanes<'_>) + Sync,
    ) -> Self {
        let around = 2 * params.radius() as usize;
        let disparities = (params.disparities as usize).next_multiple_of(LANES);
        let stride = width + around + if side == Side::Left { 0 } else { disparities };
        let planes = packed_planes(params);
        let mut data = Aligned::zeroed(height * planes * stride);
        let radius = i64::from(params.radius());
        let start = if side == Side::Left { radius } else { radius - i64::from(params.min_disparity) };
        data.par_chunks_exact_mut(planes * stride).enumerate().with_min_len(8).for_each(|(y, row)| {
            let values = vec![0; width];
            write(y, &mut RowOfPlanes { planes: row.chunks_exact_mut(stride), values, start, side });
        });
        Self { width, height, planes, stride, data }
    }

    /// From the descriptors of the definition.
    pub fn of(descriptors: &Descriptors, side: Side, params: &Params) -> Self {
        let (width, bits) = (descriptors.width, census_bits(params));
        let strings = params.census_planes() as usize;
        Self::from_rows(width, descriptors.height, side, params, |y, row| {
            let pixels = &descriptors.data[y * width * descriptors.planes..][..width * descriptors.planes];
            for eight in bits.chunks(8) {
                row.next(|out| {
                    for (out, pixel) in out.iter_mut().zip(pixels.chunks_exact(descriptors.planes)) {
                        let one = |(k, &(byte, bit)): (usize, &(usize, u32))| (pixel[byte] >> bit & 1) << k;
                        *out = eight.iter().enumerate().map(one).sum();
                    }
                });
            }
            for plane in strings..descriptors.planes {
                row.next(|out| {
                    for (out, pixel) in out.iter_mut().zip(pixels.chunks_exact(descriptors.planes)) {
                        *out = pixel[plane];
                    }
                });
            }
        })
    }

    /// In the definition's layout, of planes that were made for [`Side::Left`], whichever image they are of.
    pub fn descriptors(&self, params: &Params) -> Descriptors {
        let bits = census_bits(params);
        let strings = params.census_planes() as usize;
        let packed = bits.len().div_ceil(8);
        let planes = strings + self.planes - packed;
        let mut data = vec![0; self.width * self.height * planes];
        for (i, pixel) in data.chunks_exact_mut(planes).enumerate() {
            let (x, row) = (i % self.width, self.row((i / self.width) as i64));
            let byte = |plane: usize| row[plane * self.stride + x + params.radius() as usize];
            for (k, &(at, bit)) in bits.iter().enumerate() {
                pixel[at] |= (byte(k / 8) >> (k % 8) & 1) << bit;
            }
            for (plane, value) in pixel[strings..].iter_mut().enumerate() {
                *value = byte(packed + plane);
            }
        }
        Descriptors { width: self.width, height: self.height, planes, data }
    }

    /// Of row y of the image, or the nearest one that there is, all planes, one after the other.
    #[inline(always)]
    pub fn row(&self, y: i64) -> &[u8] {
        let len = self.planes * self.stride;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        &self.data[y * len..][..len]
    }

    /// Columns a row of a plane.
    #[inline(always)]
    pub fn stride(&self) -> usize {
        self.stride
    }
}

/// The planes of a row that are still to be written.
pub struct RowOfPlanes<'a> {
    planes: ChunksExactMut<'a, u8>,
    values: Vec<u8>,
    /// The column of the first pixel of the image, or on the right side of the last one.
    start: i64,
    side: Side,
}

impl RowOfPlanes<'_> {
    /// The next plane, from what `write` writes for the pixels of the image.
    #[inline(always)]
    pub fn next(&mut self, write: impl FnOnce(&mut [u8])) {
        write(&mut self.values);
        if self.side == Side::Right {
            self.values.reverse();
        }
        let Some(out) = self.planes.next() else { return };
        let (values, len) = (&self.values, out.len() as i64);
        let from = self.start.clamp(0, len);
        let to = (self.start + values.len() as i64).clamp(from, len);
        let (first, last) = ((from - self.start).max(0) as usize, values[values.len() - 1]);
        let (from, to) = (from as usize, to as usize);
        out[..from].fill(values[0]);
        if from < to {
            out[from..to].copy_from_slice(&values[first..first + to - from]);
        }
        out[to..].fill(last);
    }
}

/// Bytes of a pixel, with the census string packed.
pub fn packed_planes(params: &Params) -> usize {
    params.planes() as usize - params.census_planes() as usize + census_bits(params).len().div_ceil(8)
}

/// Where the bits of a census string are in the definition, (byte, bit); none if the cost does not compare one.
fn census_bits(params: &Params) -> Vec<(usize, u32)> {
    if !params.compares(Descriptor::Census) {
        return Vec::new();
    }
    let bits = |byte: usize, bits: std::ops::Range<u32>, but: u32| {
        bits.filter(move |&bit| bit != but).map(move |bit| (byte, bit)).collect::<Vec<_>>()
    };
    let none = u32::MAX;
    match params.census {
        Census::Five => (0..5).flat_map(|byte| bits(byte, 2..7, if byte == 2 { 4 } else { none })).collect(),
        Census::Seven => (0..7).flat_map(|byte| bits(byte, 1..8, if byte == 3 { 4 } else { none })).collect(),
        Census::NineBySeven => {
            let rows = (0..7).flat_map(|byte| bits(byte, 0..8, if byte == 3 { 4 } else { none }));
            rows.chain(bits(7, 0..7, none)).collect()
        }
        Census::CentreSymmetric => (0..3).flat_map(|byte| bits(byte, 0..8, none)).chain(bits(3, 0..7, none)).collect(),
    }
}

/// What the bits of a census string compare, as `[dx, dy]`: a bit is 1 where the first is less than the second.
pub fn census_neighbours(params: &Params) -> Vec<[[i64; 2]; 2]> {
    let symmetric = params.census == Census::CentreSymmetric;
    let above = if params.census == Census::Five { 2 } else { 3 };
    let last = params.census.planes() as usize - 1;
    let neighbour = |(byte, bit): (usize, u32)| {
        let (byte, bit) = (byte as i64, i64::from(bit));
        let nine = matches!(params.census, Census::NineBySeven | Census::CentreSymmetric);
        match nine && byte == last as i64 {
            true if symmetric && bit >= above => [bit - 7, 0],
            true => [4, bit - above],
            false => [bit - 4, byte - above],
        }
    };
    let pair = |[dx, dy]: [i64; 2]| [[dx, dy], if symmetric { [-dx, -dy] } else { [0, 0] }];
    census_bits(params).into_iter().map(|bit| pair(neighbour(bit))).collect()
}
