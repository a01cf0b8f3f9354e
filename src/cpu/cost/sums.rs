//! Sums of pixel costs over blocks, from sums over columns that are brought from row to row.
#![allow(clippy::needless_range_loop)] // loops by index over arrays are what is vectorised

use bytemuck::Pod;

use crate::cpu::LANES;
use crate::cpu::cost::quantise::Finish;

/// A number that sums are kept in. Sums are exact modulo its range.
pub trait Sum: Pod {
    fn of(value: u32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
}

macro_rules! sums {
    ($($number:ty)+) => {$(
        impl Sum for $number {
            #[inline(always)]
            fn of(value: u32) -> Self {
                value as Self
            }

            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }

            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }

            #[inline(always)]
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
        }
    )+};
}

sums! { u16 u32 }

/// Adds the pixel costs of a row, times `factor`, to sums over columns.
#[inline(always)]
pub fn add<V: Pod + Into<u32>, S: Sum>(values: &[V], factor: S, columns: &mut [S]) {
    for (column, values) in columns.as_chunks_mut::<LANES>().0.iter_mut().zip(values.as_chunks::<LANES>().0) {
        let mut sums = [S::zeroed(); LANES];
        for d in 0..LANES {
            sums[d] = column[d].plus(S::of(values[d].into()).times(factor));
        }
        *column = sums;
    }
}

/// The same less those of another row.
#[inline(always)]
pub fn exchange<V: Pod + Into<u32>, S: Sum>(new: &[V], old: &[V], factor: S, columns: &mut [S]) {
    let (new, old) = (new.as_chunks::<LANES>().0, old.as_chunks::<LANES>().0);
    for ((column, new), old) in columns.as_chunks_mut::<LANES>().0.iter_mut().zip(new).zip(old) {
        let mut sums = [S::zeroed(); LANES];
        for d in 0..LANES {
            sums[d] = column[d].plus(S::of(new[d].into()).minus(S::of(old[d].into())).times(factor));
        }
        *column = sums;
    }
}

/// Blocks of `block` columns: `sum` begins with the bias and takes the first `block` - 1 columns here. Result i, of columns i
/// to i + block - 1, is written to `out[i * stride..]`, with `beyond` over the last lanes.
#[inline(always)]
pub fn slide<S: Sum, F: Finish<S>>(
    columns: &[S],
    block: usize,
    bias: S,
    finish: F,
    (out, stride): (&mut [F::Out], usize),
    (from, beyond): (usize, F::Out),
) where
    F::Out: Copy,
{
    let columns = columns.as_chunks::<LANES>().0;
    let mut sum = [bias; LANES];
    for column in &columns[..block - 1] {
        for d in 0..LANES {
            sum[d] = sum[d].plus(column[d]);
        }
    }
    let leaving = columns;
    for ((entering, leaving), out) in columns[block - 1..].iter().zip(leaving).zip(out.chunks_mut(stride)) {
        let (mut whole, mut next) = ([bias; LANES], [bias; LANES]);
        for d in 0..LANES {
            whole[d] = sum[d].plus(entering[d]);
            next[d] = whole[d].minus(leaving[d]);
        }
        sum = next;
        let mut finished = finish.finish(whole);
        for lane in &mut finished[from..] {
            *lane = beyond;
        }
        out[..LANES].copy_from_slice(&finished);
    }
}
