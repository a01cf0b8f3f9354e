//! The loops over pixel costs and sums.

use std::ops::Range;

use fearless_simd::Simd;

use crate::cpu::LANES;
use crate::cpu::cost::sums::{Finish, Sum, Value, beyond};
use crate::cpu::instructions::Kernel;

/// Costs of single pixels of a byte where the scale is a power of two, `Params::scale_shift`: (value + half) >> shift.
pub struct Shift<'a> {
    pub values: &'a [u8],
    pub shift: u32,
    /// Disparities from here on.
    pub lanes: usize,
    pub out: &'a mut [u8],
    pub stride: usize,
}

impl Kernel for Shift<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let beyond = beyond(simd, self.lanes);
        let half = simd.splat_u8x32((1 << self.shift) >> 1);
        let pixels = self.values.as_chunks::<LANES>().0;
        for (values, out) in pixels.iter().zip(self.out.chunks_mut(self.stride)) {
            let Some(out) = out.first_chunk_mut() else { return };
            let cost = simd.shr_u8x32(simd.add_u8x32(u8::load(simd, values), half), self.shift);
            u8::store(simd.or_u8x32(cost, beyond), out);
        }
    }
}

/// Finished costs of single pixels.
pub struct Direct<'a, T, S, F: Finish<S>>
where
    S: Sum,
{
    pub values: &'a [T],
    pub factor: S,
    pub bias: S,
    pub finish: F,
    /// Disparities from here on.
    pub lanes: usize,
    pub out: &'a mut [F::Out],
    pub stride: usize,
}

impl<T: Value, S: Sum, F: Finish<S>> Kernel for Direct<'_, T, S, F> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let (beyond, bias) = (beyond(simd, self.lanes), S::splat(simd, self.bias));
        let pixels = self.values.as_chunks::<LANES>().0;
        for (values, out) in pixels.iter().zip(self.out.chunks_mut(self.stride)) {
            let values = S::of(simd, T::words(simd, T::load(simd, values)), self.factor);
            let Some(out) = out.first_chunk_mut() else { return };
            self.finish.finish(simd, S::plus(simd, values, bias), beyond, out);
        }
    }
}

/// Adds the pixel costs of a row, times `factor`, to sums over columns.
pub struct Add<'a, T, S> {
    pub values: &'a [T],
    pub factor: S,
    pub columns: &'a mut [S],
}

impl<T: Value, S: Sum> Kernel for Add<'_, T, S> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let columns = self.columns.as_chunks_mut::<LANES>().0;
        for (column, values) in columns.iter_mut().zip(self.values.as_chunks::<LANES>().0) {
            let values = S::of(simd, T::words(simd, T::load(simd, values)), self.factor);
            S::store(S::plus(simd, S::load(simd, column), values), column);
        }
    }
}

/// Sums over blocks of `block` columns, for the columns of a tile; the sums of the tile before go on.
pub struct Slide<'a, T, S, F: Finish<S>>
where
    S: Sum,
{
    /// Pixel costs that enter and that leave the sums over columns, of the tile; none if the sums are up to date.
    pub rows: Option<[&'a [T]; 2]>,
    /// By which pixel costs are multiplied.
    pub factor: S,
    /// Of all columns.
    pub columns: &'a mut [S],
    pub tile: Range<usize>,
    pub block: usize,
    /// The sum over the last `block` - 1 columns before the tile.
    pub sums: &'a mut [S; LANES],
    pub finish: F,
    /// Disparities from here on.
    pub lanes: usize,
    /// The block that ends at column c goes to `out[(c - (block - 1)) * stride..]`.
    pub out: &'a mut [F::Out],
    pub stride: usize,
}

impl<T: Value, S: Sum, F: Finish<S>> Kernel for Slide<'_, T, S, F> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { rows, factor, columns, tile, block, sums, finish, lanes, out, stride } = self;
        let columns = &mut columns.as_chunks_mut::<LANES>().0[..tile.end];
        let mut sum = S::load(simd, sums);
        let beyond = beyond(simd, lanes);
        let whole = tile.start.max(block - 1).min(tile.end);
        for (i, column) in columns[tile.start..whole].iter_mut().enumerate() {
            sum = S::plus(simd, sum, update(simd, rows, factor, column, i));
        }
        let outs = out[(whole + 1).saturating_sub(block) * stride..].chunks_mut(stride);
        for (c, out) in (whole..tile.end).zip(outs) {
            let block_sum = S::plus(simd, sum, update(simd, rows, factor, &mut columns[c], c - tile.start));
            sum = S::minus(simd, block_sum, S::load(simd, &columns[c + 1 - block]));
            let Some(out) = out.first_chunk_mut() else { return };
            finish.finish(simd, block_sum, beyond, out);
        }
        S::store(sum, sums);
    }
}

/// Brings the sum over a column up to date; `i` is its place in the tile.
#[inline(always)]
fn update<V: Simd, T: Value, S: Sum>(
    simd: V,
    rows: Option<[&[T]; 2]>,
    factor: S,
    column: &mut [S; LANES],
    i: usize,
) -> S::Vector<V> {
    let before = S::load(simd, column);
    let Some([new, old]) = rows else { return before };
    let (new, old) = (&new.as_chunks::<LANES>().0[i], &old.as_chunks::<LANES>().0[i]);
    let (new, old) = (T::words(simd, T::load(simd, new)), T::words(simd, T::load(simd, old)));
    let after = S::plus(simd, before, S::change(simd, new, old, factor));
    S::store(after, column);
    after
}
