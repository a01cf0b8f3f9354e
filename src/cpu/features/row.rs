//! A row of a layer.

use fearless_simd::{Bytes, Simd, SimdBase, SimdFrom, f32x16, i16x32, i32x16};

use crate::cpu::features::prepared::{Prepared, TOGETHER};
use crate::cpu::instructions::Kernel;
use crate::features::LayerKind;

/// Columns of a vector.
const COLUMNS: usize = 16;

/// Columns that may be computed at once: as many more than asked for may be written, fewer one.
pub const AT_ONCE: usize = 3 * COLUMNS;

/// What a layer reads.
#[derive(Clone, Copy)]
pub enum From<'a> {
    /// The rows above, at and below a pixel, `[channel][column]`.
    Rows([&'a [f32]; 3]),
    /// Two channels as the halves of a number, `[channels / 2][column]`.
    Pairs(&'a [i32]),
}

/// What a layer writes.
pub enum To<'a> {
    /// `[channel][column]`.
    Floats(&'a mut [f32]),
    /// `[channels / 2][column]`.
    Pairs(&'a mut [i32]),
    /// `[channel][column]`.
    Values(&'a mut [i32]),
}

/// A row of a layer's outputs, from the column `start` to before `end` and up to [`AT_ONCE`] more.
pub struct Row<'a> {
    pub layer: &'a Prepared,
    pub from: From<'a>,
    pub to: To<'a>,
    /// Columns of all buffers.
    pub stride: usize,
    pub start: usize,
    pub end: usize,
}

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        // As many sums as registers hold.
        match V::f32s::LEN {
            16 => self.blocks::<V, 3, 4>(simd),
            8 => self.blocks::<V, 1, 4>(simd),
            _ => self.blocks::<V, 1, 2>(simd),
        }
    }
}

/// Sums of `OUT` outputs at `N` vectors of columns.
type Sums<V, const N: usize, const OUT: usize> = [[i32x16<V>; N]; OUT];

impl Row<'_> {
    #[inline(always)]
    fn blocks<V: Simd, const N: usize, const OUT: usize>(mut self, simd: V) {
        for at in (self.start..self.end).step_by(N * COLUMNS) {
            for output in (0..self.layer.outputs).step_by(OUT) {
                let sums: Sums<V, N, OUT> = match (self.from, self.layer.kind) {
                    (From::Pairs(pairs), _) => self.points(simd, pairs, output, at),
                    (From::Rows(rows), LayerKind::Depthwise) => self.depthwise(simd, rows, output, at),
                    (From::Rows(rows), _) => self.convolution(simd, rows, output, at),
                };
                self.finish(simd, sums, output, at);
            }
        }
    }

    #[inline(always)]
    fn points<V: Simd, const N: usize, const OUT: usize>(
        &self,
        simd: V,
        pairs: &[i32],
        output: usize,
        at: usize,
    ) -> Sums<V, N, OUT> {
        let mut sums = [[simd.splat_i32x16(0); N]; OUT];
        for (sums, &bias) in sums.iter_mut().zip(&self.layer.bias[output..output + OUT]) {
            *sums = [simd.splat_i32x16(bias); N];
        }
        let count = self.layer.inputs / 2;
        let weights = &self.layer.pairs[output / TOGETHER * count..][..count];
        for (weights, channels) in weights.iter().zip(pairs.chunks_exact(self.stride)) {
            let channels = &channels[at..at + N * COLUMNS];
            let mut values = [simd.splat_i32x16(0); N];
            for (value, from) in values.iter_mut().zip(channels.as_chunks::<COLUMNS>().0) {
                *value = i32x16::simd_from(simd, *from);
            }
            for (j, sums) in sums.iter_mut().enumerate() {
                let weight = simd.splat_i32x16(weights[output % TOGETHER + j]).bitcast::<i16x32<V>>();
                for (sum, value) in sums.iter_mut().zip(values) {
                    let products = simd.pairwise_dot_product_i16x32(value.bitcast::<i16x32<V>>(), weight);
                    *sum = simd.add_i32x16(*sum, products);
                }
            }
        }
        sums
    }

    /// Adds 3x3 taps of a channel, which begins at `from`, to sums of the outputs `first` to before `last` of those that lie together.
    #[inline(always)]
    fn taps<V: Simd, const N: usize, const OUT: usize>(
        simd: V,
        rows: [&[f32]; 3],
        from: usize,
        weights: &[[f32; TOGETHER]],
        first: usize,
        sums: &mut [[f32x16<V>; N]; OUT],
    ) {
        for (dy, row) in rows.iter().enumerate() {
            let row = &row[from - 1..from + N * COLUMNS + 1];
            for dx in 0..3 {
                let weights = &weights[3 * dy + dx];
                for (n, values) in row[dx..].as_chunks::<COLUMNS>().0.iter().enumerate().take(N) {
                    let values = f32x16::simd_from(simd, *values);
                    for (j, sums) in sums.iter_mut().enumerate() {
                        sums[n] = simd.mul_add_f32x16(values, simd.splat_f32x16(weights[first + j]), sums[n]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn depthwise<V: Simd, const N: usize, const OUT: usize>(
        &self,
        simd: V,
        rows: [&[f32]; 3],
        output: usize,
        at: usize,
    ) -> Sums<V, N, OUT> {
        let mut sums = [[simd.splat_i32x16(0); N]; OUT];
        let weights = &self.layer.floats[output / TOGETHER * 9..][..9];
        for (j, sums) in sums.iter_mut().enumerate() {
            let mut sum = [[simd.splat_f32x16(self.layer.bias[output + j] as f32); N]];
            Self::taps(simd, rows, (output + j) * self.stride + at, weights, output % TOGETHER + j, &mut sum);
            for (to, sum) in sums.iter_mut().zip(sum[0]) {
                *to = simd.cvt_i32_f32x16(sum);
            }
        }
        sums
    }

    #[inline(always)]
    fn convolution<V: Simd, const N: usize, const OUT: usize>(
        &self,
        simd: V,
        rows: [&[f32]; 3],
        output: usize,
        at: usize,
    ) -> Sums<V, N, OUT> {
        let mut floats = [[simd.splat_f32x16(0.0); N]; OUT];
        for (sums, &bias) in floats.iter_mut().zip(&self.layer.bias[output..output + OUT]) {
            *sums = [simd.splat_f32x16(bias as f32); N];
        }
        let count = 9 * self.layer.inputs;
        let weights = &self.layer.floats[output / TOGETHER * count..][..count];
        for (channel, weights) in weights.chunks_exact(9).enumerate() {
            Self::taps(simd, rows, channel * self.stride + at, weights, output % TOGETHER, &mut floats);
        }
        let mut sums = [[simd.splat_i32x16(0); N]; OUT];
        for (sums, floats) in sums.iter_mut().zip(floats) {
            for (to, sum) in sums.iter_mut().zip(floats) {
                *to = simd.cvt_i32_f32x16(sum);
            }
        }
        sums
    }

    /// Makes values of sums, and writes them.
    #[inline(always)]
    fn finish<V: Simd, const N: usize, const OUT: usize>(
        &mut self,
        simd: V,
        mut sums: Sums<V, N, OUT>,
        output: usize,
        at: usize,
    ) {
        let layer = self.layer;
        let (low, high) = (simd.splat_i32x16(layer.low), simd.splat_i32x16(layer.high));
        for (j, sums) in sums.iter_mut().enumerate() {
            let (multiplier, shift) = (simd.splat_i32x16(layer.multiplier[output + j]), layer.shift[output + j]);
            let half = simd.splat_i32x16((1 << shift) >> 1);
            for sum in sums {
                let product = simd.add_i32x16(simd.mul_i32x16(*sum, multiplier), half);
                *sum = simd.min_i32x16(simd.max_i32x16(simd.shr_i32x16(product, shift), low), high);
            }
        }
        let stride = self.stride;
        match &mut self.to {
            To::Floats(to) => {
                for (j, sums) in sums.iter().enumerate() {
                    let to = &mut to[(output + j) * stride + at..][..N * COLUMNS];
                    for (to, &sum) in to.as_chunks_mut::<COLUMNS>().0.iter_mut().zip(sums) {
                        *to = *simd.cvt_f32_i32x16(sum);
                    }
                }
            }
            To::Values(to) => {
                for (j, sums) in sums.iter().enumerate() {
                    let to = &mut to[(output + j) * stride + at..][..N * COLUMNS];
                    to.as_chunks_mut::<COLUMNS>().0.iter_mut().zip(sums).for_each(|(to, sum)| *to = **sum);
                }
            }
            To::Pairs(to) => {
                for (j, two) in sums.as_chunks::<2>().0.iter().enumerate() {
                    let to = &mut to[(output / 2 + j) * stride + at..][..N * COLUMNS];
                    for (n, to) in to.as_chunks_mut::<COLUMNS>().0.iter_mut().enumerate() {
                        let low = simd.and_i32x16(two[0][n], simd.splat_i32x16(0xffff));
                        *to = *simd.or_i32x16(low, simd.shl_i32x16(two[1][n], 16));
                    }
                }
            }
        }
    }
}
