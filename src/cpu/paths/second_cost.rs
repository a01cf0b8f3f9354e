//! Rows of the cost of the second pass: as the winners' rows, but what becomes of the sum is C + floor((sum of T + P) / (2 P)), P the
//! paths. T is at most 127, so the quotient is at most 64.

use std::ops::Range;

use fearless_simd::{Simd, u8x32, u16x16};

use super::across::{AcrossRow, Goal, RowScratch, RowsOf, Scratch, add, rightwards, store_words};
use super::aggregation::CostSource;
use super::buffers::Lent;
use super::step::{PAD, Receive, Stepping, load, steps, store};
use crate::Params;
use crate::cpu::LANES;
use crate::cpu::instructions::{Instructions, Kernel};
use crate::reference::Volume;

/// Such a cost, `[y][x][n]`: 255 beyond the disparities.
pub(crate) struct SecondCost {
    pub(super) data: Lent,
    pub(super) width: usize,
    pub(super) n: usize,
}

impl SecondCost {
    /// Without what lies beyond the disparities.
    pub(crate) fn volume(&self, params: &Params) -> Volume<u8> {
        let (width, disparities) = (self.width, params.disparities as usize);
        let height = self.data.len() / (width * self.n);
        let data = self.data.chunks_exact(self.n).flat_map(|pixel| &pixel[..disparities]).copied().collect();
        Volume { width, height, disparities, data }
    }
}

impl CostSource for &SecondCost {
    fn row(&mut self, y: usize, columns: Range<usize>, cost: &mut [u8]) {
        let row = &self.data[y * self.width * self.n..][..self.width * self.n];
        cost.copy_from_slice(&row[columns.start * self.n..columns.end * self.n]);
    }
}

/// How rows are computed, of so many paths and disparities.
pub(super) fn second_for(paths: usize, disparities: usize) -> RowsOf {
    match (paths, disparities) {
        (3 | 4, 64) => second_costs::<1, 64>,
        (3 | 4, 128) => second_costs::<1, 128>,
        (3 | 4, _) => second_costs::<1, 0>,
        (5, _) => second_costs::<2, 0>,
        (8, 64) => second_costs::<3, 64>,
        (8, 128) => second_costs::<3, 128>,
        (8, _) => second_costs::<3, 0>,
        _ => second_costs::<7, 0>,
    }
}

/// Q planes of the paths that cross rows. N as of the winners' rows.
fn second_costs<const Q: usize, const N: usize>(
    rows: &mut [AcrossRow<'_>],
    scratch: &mut Scratch,
    params: &Params,
    instructions: Instructions,
) {
    match rows {
        [first, second] => {
            let [one, two] = &mut scratch.rows;
            instructions.launch(SecondCosts::<2, Q, N> { rows: [first, second], scratch: [one, two], params });
        }
        rows => rows.iter_mut().zip(&mut scratch.rows).for_each(|(row, scratch)| {
            instructions.launch(SecondCosts::<1, Q, N> { rows: [row], scratch: [scratch], params });
        }),
    }
}

struct SecondCosts<'a, 'b, const R: usize, const Q: usize, const N: usize> {
    rows: [&'a mut AcrossRow<'b>; R],
    scratch: [&'a mut RowScratch; R],
    params: &'a Params,
}

impl<const R: usize, const Q: usize, const N: usize> Kernel for SecondCosts<'_, '_, R, Q, N> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { rows, mut scratch, params } = self;
        let n = if N > 0 { N } else { (params.disparities as usize).next_multiple_of(LANES) };
        let mut x = rightwards(simd, &rows, &mut scratch, n);
        scratch.iter_mut().for_each(|scratch| scratch.start(n));
        for segment in (0..rows[0].segments.len()).rev() {
            for i in (0..rows[0].segments[segment].cost.len() / n).rev() {
                x -= 1;
                for r in 0..R {
                    pixel::<V, Q>(simd, rows[r], scratch[r], [segment, i, x], n, params);
                }
            }
        }
    }
}

/// The step to the left into a pixel, and its cost. It is the `i`-th of the segment, in column x.
#[inline(always)]
fn pixel<V: Simd, const Q: usize>(
    simd: V,
    row: &mut AcrossRow<'_>,
    scratch: &mut RowScratch,
    [segment, i, x]: [usize; 3],
    n: usize,
    params: &Params,
) {
    let (cost, planes) = row.segments[segment].pixel::<Q>(i, n);
    let RowScratch { right, state, least, sum, .. } = scratch;
    let path = Stepping { state: &mut state[PAD - 1..], least, penalties: row.penalties[1].at(x) };
    let Goal::SecondCost(to) = &mut row.goal else { return };
    let (paths, sums) = (params.paths.count() as u16, if row.record.is_some() { &mut sum[..n] } else { &mut [] });
    let (right, to) = (&right[x * n..][..n], &mut to[x * n..][..n]);
    steps(simd, [path], cost, &mut Mean { simd, paths, cost, planes, right, sums, to });
    row.keep(x, params.disparities as usize, cost, sum);
}

/// T of the last path, added to those of all others, and the cost that comes of it.
struct Mean<'a, V: Simd, const Q: usize> {
    simd: V,
    paths: u16,
    cost: &'a [u8],
    planes: [&'a [u8]; Q],
    right: &'a [u8],
    /// The sums of all paths, if they are recorded.
    sums: &'a mut [u16],
    to: &'a mut [u8],
}

impl<V: Simd, const Q: usize> Receive<V, 1> for Mean<'_, V, Q> {
    #[inline(always)]
    fn receive(&mut self, at: usize, [t]: [u8x32<V>; 1]) {
        let (simd, paths) = (self.simd, self.paths);
        let cost = load(simd, self.cost, at);
        let mut sum = [simd.splat_u16x16(paths); 2];
        sum = add(simd, sum, simd.add_u8x32(load(simd, self.right, at), t));
        for plane in &self.planes {
            sum = add(simd, sum, load(simd, plane, at));
        }
        if !self.sums.is_empty() {
            let (low, high) = simd.widen_u8x32(cost);
            let of = |cost: u16x16<V>, sum| {
                let less_one = simd.sub_u16x16(cost, simd.splat_u16x16(1));
                simd.add_u16x16(simd.mul_u16x16(less_one, simd.splat_u16x16(paths)), sum)
            };
            store_words([of(low, sum[0]), of(high, sum[1])], self.sums, at);
        }
        for half in &mut sum {
            if paths.is_power_of_two() {
                *half = simd.shr_u16x16(*half, paths.trailing_zeros() + 1);
            } else {
                half.iter_mut().for_each(|sum| *sum /= 2 * paths);
            }
        }
        // Beyond the disparities the cost stays 255.
        store(simd.saturating_add_u8x32(cost, simd.narrow_u16x16(sum[0], sum[1])), self.to, at);
    }
}
