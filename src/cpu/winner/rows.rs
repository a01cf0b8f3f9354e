//! The winners of rows of block sums, which may be too large for keys of 16 bits.

use fearless_simd::{Simd, SimdFrom, u16x16, u32x8};

use super::finish::{Found, RowOfMaps, Sum};
use crate::cpu::LANES;
use crate::cpu::instructions::{Instructions, Kernel};
use crate::{DisparityMap, Params};

/// Finds the winners of rows of costs; reused from row to row.
pub(crate) struct WinnerRow<T> {
    found: Found<T>,
    /// The smallest cost that a right pixel has seen, and its index, at W - 1 - x + d for a left pixel x and an index d.
    right: Vec<T>,
    index: Vec<T>,
    /// n + 1 zeros, three times [`Sum::NONE`], n + 1 zeros.
    near: Vec<T>,
    n: usize,
    instructions: Instructions,
}

/// What differs between numbers of 16 and of 32 bits.
pub(crate) trait Costs: Sum {
    /// The smallest cost of a pixel, of equal ones the first, or the last one if `LAST`, and its index; and its votes for the right
    /// view. Left pixels come in rising order, so that the first of equal votes has the smallest index.
    fn smallest<V: Simd, const LAST: bool>(
        simd: V,
        costs: &[Self],
        right: &mut [Self],
        index: &mut [Self],
    ) -> (Self, usize);
    /// The smallest cost where `near` is 0; it has [`Sum::NONE`] at what is no rival.
    fn rival<V: Simd>(simd: V, costs: &[Self], near: &[Self]) -> Self;
}

macro_rules! costs {
    ($($number:ty, $vector:ident, $lanes:literal: $splat:ident $min:ident $or:ident $eq:ident $add:ident $select:ident $least:ident $largest:ident;)+) => {$(
        impl Costs for $number {
            #[inline(always)]
            fn smallest<V: Simd, const LAST: bool>(simd: V, costs: &[Self], right: &mut [Self], index: &mut [Self]) -> (Self, usize) {
                let mut places = [0; $lanes];
                places.iter_mut().enumerate().for_each(|(i, place)| *place = i as $number);
                let (places, step) = ($vector::simd_from(simd, places), simd.$splat($lanes));
                let mut best = simd.$splat(Self::NONE);
                let (mut here, mut at) = (places, places);
                let costs = costs.as_chunks::<$lanes>().0;
                let votes = right.as_chunks_mut::<$lanes>().0.iter_mut().zip(index.as_chunks_mut::<$lanes>().0);
                for (costs, (right, index)) in costs.iter().zip(votes) {
                    let costs = $vector::simd_from(simd, *costs);
                    let least = simd.$min(best, costs);
                    at = match LAST {
                        true => simd.$select(simd.$eq(least, costs), here, at),
                        false => simd.$select(simd.$eq(least, best), at, here),
                    };
                    best = least;
                    let seen = $vector::simd_from(simd, *right);
                    let least = simd.$min(seen, costs);
                    let before = $vector::simd_from(simd, *index);
                    *index = *simd.$select(simd.$eq(least, seen), before, here);
                    *right = *least;
                    here = simd.$add(here, step);
                }
                let least = simd.$least(best);
                let winners = simd.$eq(best, simd.$splat(least));
                let at = match LAST {
                    true => simd.$largest(simd.$select(winners, at, simd.$splat(0))),
                    false => simd.$least(simd.$select(winners, at, simd.$splat(Self::NONE))),
                };
                (least, at as usize)
            }

            #[inline(always)]
            fn rival<V: Simd>(simd: V, costs: &[Self], near: &[Self]) -> Self {
                let mut rival = simd.$splat(Self::NONE);
                for (costs, near) in costs.as_chunks::<$lanes>().0.iter().zip(near.as_chunks::<$lanes>().0) {
                    let (costs, near) = ($vector::simd_from(simd, *costs), $vector::simd_from(simd, *near));
                    rival = simd.$min(rival, simd.$or(costs, near));
                }
                simd.$least(rival)
            }
        }
    )+};
}

costs! {
    u16, u16x16, 16: splat_u16x16 min_u16x16 or_u16x16 simd_eq_u16x16 add_u16x16 select_u16x16 reduce_min_u16x16 reduce_max_u16x16;
    u32, u32x8, 8: splat_u32x8 min_u32x8 or_u32x8 simd_eq_u32x8 add_u32x8 select_u32x8 reduce_min_u32x8 reduce_max_u32x8;
}

impl<T: Costs> WinnerRow<T> {
    /// For rows of `width` pixels.
    pub(crate) fn new(width: usize, params: &Params, instructions: Instructions) -> Self {
        let n = (params.disparities as usize).next_multiple_of(LANES);
        let mut near = vec![T::default(); 2 * n + 5];
        near[n + 1..n + 4].fill(T::NONE);
        let right = vec![T::NONE; width + n];
        Self { found: Found::new(width), index: right.clone(), right, near, n, instructions }
    }

    /// The winners of a row of `costs`, `[x][n]` with n the disparities rounded up to a multiple of [`LANES`]. What lies beyond the
    /// disparities is overwritten; all others are less than [`Sum::NONE`].
    pub(crate) fn row(&mut self, costs: &mut [T], params: &Params, mut to: RowOfMaps<'_>) {
        let instructions = self.instructions;
        instructions.launch(Row { finder: self, costs, params, to: &mut to });
    }
}

/// A row of a [`WinnerRow`].
struct Row<'a, 'b, T> {
    finder: &'a mut WinnerRow<T>,
    costs: &'a mut [T],
    params: &'a Params,
    to: &'a mut RowOfMaps<'b>,
}

impl<T: Costs> Kernel for Row<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { finder: WinnerRow { found, right, index, near, n, .. }, costs, params, to } = self;
        let (n, width, disparities) = (*n, to.left.len(), params.disparities as usize);
        right.fill(T::NONE);
        let stereo_bm = params.chooses_as_stereo_bm();
        for (x, costs) in costs.chunks_exact_mut(n).enumerate() {
            if disparities < n {
                costs[disparities..].fill(T::NONE);
            }
            let votes = width - 1 - x;
            let (right, index) = (&mut right[votes..][..n], &mut index[votes..][..n]);
            let (best, label) = match stereo_bm {
                true => T::smallest::<V, true>(simd, costs, right, index),
                false => T::smallest::<V, false>(simd, costs, right, index),
            };
            (found.best[x], found.label[x]) = (best, label as u16);
            (found.before[x], found.after[x]) = (costs[label.saturating_sub(1)], costs[(label + 1).min(n - 1)]);
            found.rival[x] = T::rival(simd, costs, &near[n + 2 - label..][..n]);
        }
        found.finish(params, to);
        // Right pixel x has seen what lies at W - 1 - x - M.
        for (x, value) in to.right.iter_mut().enumerate() {
            let at = width as i64 - 1 - x as i64 - i64::from(params.min_disparity);
            let seen = usize::try_from(at).ok().and_then(|at| Some((right.get(at)?, index[at])));
            *value = match seen {
                Some((cost, index)) if *cost != T::NONE => 16 * (params.min_disparity as i16 + index.value() as i16),
                _ => DisparityMap::INVALID,
            };
        }
    }
}
