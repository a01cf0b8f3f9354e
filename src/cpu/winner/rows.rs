//! The winners of rows of block sums, which may be too large for keys of 16 bits.

use super::finish::{Found, RowOfMaps, Sum};
use crate::cpu::LANES;
use crate::cpu::instructions::Instructions;
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
    /// Winner and rival of one pixel, and its votes for the right view. `near` has [`Sum::NONE`] at what is no rival.
    fn smallest(costs: &[Self]) -> (Self, usize);
    fn rival(costs: &[Self], near: &[Self]) -> Self;
    fn vote(costs: &[Self], right: &mut [Self], index: &mut [Self]);
}

macro_rules! costs {
    ($($number:ty)+) => {$(
        impl Costs for $number {
            #[inline(always)]
            fn smallest(costs: &[Self]) -> (Self, usize) {
                let best = costs.iter().fold(Self::NONE, |best, &cost| best.min(cost));
                let mut at = Self::NONE;
                for (d, &cost) in costs.iter().enumerate() {
                    at = at.min(if cost == best { d as $number } else { Self::NONE });
                }
                (best, at as usize)
            }

            #[inline(always)]
            fn rival(costs: &[Self], near: &[Self]) -> Self {
                costs.iter().zip(near).fold(Self::NONE, |best, (&cost, &near)| best.min(cost | near))
            }

            /// Columns come in rising order, so that the first of equal costs has the smallest index.
            #[inline(always)]
            fn vote(costs: &[Self], right: &mut [Self], index: &mut [Self]) {
                for (d, ((right, index), &cost)) in right.iter_mut().zip(index).zip(costs).enumerate() {
                    let least = cost.min(*right);
                    // By masks, since a choice became a branch, and without `<`, which AVX2 lacks for unsigned numbers.
                    let less = ((least != *right) as $number).wrapping_neg();
                    *index = (d as $number & less) | (*index & !less);
                    *right = least;
                }
            }
        }
    )+};
}

costs! { u16 u32 }

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
        instructions.run(
            #[inline(always)]
            || self.row_of_set(costs, params, &mut to),
        );
    }

    #[inline(always)]
    fn row_of_set(&mut self, costs: &mut [T], params: &Params, to: &mut RowOfMaps<'_>) {
        let (n, width, disparities) = (self.n, to.left.len(), params.disparities as usize);
        self.right.fill(T::NONE);
        for (x, costs) in costs.chunks_exact_mut(n).enumerate() {
            if disparities < n {
                costs[disparities..].fill(T::NONE);
            }
            let (best, label) = T::smallest(costs);
            let found = &mut self.found;
            (found.best[x], found.label[x]) = (best, label as u16);
            (found.before[x], found.after[x]) = (costs[label.saturating_sub(1)], costs[(label + 1).min(n - 1)]);
            found.rival[x] = T::rival(costs, &self.near[n + 2 - label..][..n]);
            let votes = width - 1 - x;
            T::vote(costs, &mut self.right[votes..][..n], &mut self.index[votes..][..n]);
        }
        self.found.finish(params, to);
        // Right pixel x has seen what lies at W - 1 - x - M.
        for (x, value) in to.right.iter_mut().enumerate() {
            let at = width as i64 - 1 - x as i64 - i64::from(params.min_disparity);
            let seen = usize::try_from(at).ok().and_then(|at| Some((self.right.get(at)?, self.index[at])));
            *value = match seen {
                Some((cost, index)) if *cost != T::NONE => 16 * (params.min_disparity as i16 + index.value() as i16),
                _ => DisparityMap::INVALID,
            };
        }
    }
}
