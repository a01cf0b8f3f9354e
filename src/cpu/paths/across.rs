//! Rows as a whole: the path to the right, then the path to the left together with the sum of all paths and its winner.
//!
//! Two rows at a time, whose steps do not depend on each other, keep the processor busy.

use fearless_simd::{Simd, SimdFrom, u8x32, u16x16};

use super::buffers::{Buffers, Lent};
use super::penalties::PenaltyRow;
use super::step::{PAD, Receive, Stepping, load, steps, store};
use crate::Params;
use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::cpu::instructions::{Instructions, Kernel};
use crate::cpu::winner::{Found, RightKeys, RowOfMaps};

/// Rows at a time.
pub(super) const TOGETHER: usize = 2;

/// Neighbouring columns of a row, `[x][n]`.
pub(super) struct Segment<'a> {
    pub(super) cost: &'a [u8],
    /// Sums of two T, or single T, of all paths that cross rows.
    pub(super) planes: Vec<&'a [u8]>,
}

impl<'a> Segment<'a> {
    /// The cost and the planes of its `i`-th pixel.
    #[inline(always)]
    pub(super) fn pixel<const Q: usize>(&self, i: usize, n: usize) -> (&'a [u8], [&'a [u8]; Q]) {
        let mut planes: [&[u8]; Q] = [&[]; Q];
        for (here, plane) in planes.iter_mut().zip(&self.planes) {
            *here = &plane[i * n..][..n];
        }
        (&self.cost[i * n..][..n], planes)
    }
}

/// A row and where its winners go.
pub(super) struct AcrossRow<'a> {
    pub(super) segments: Vec<Segment<'a>>,
    /// The penalties of the steps to the right and to the left.
    pub(super) penalties: [PenaltyRow<'a>; 2],
    pub(super) goal: Goal<'a>,
    /// Where the cost and the sum of all paths go, `[x][d]` without padding, if they are recorded.
    pub(super) record: Option<(&'a mut [u8], &'a mut [u16])>,
}

impl AcrossRow<'_> {
    /// Records the cost and the sum of the pixel in column x, if they are recorded.
    #[inline(always)]
    pub(super) fn keep(&mut self, x: usize, disparities: usize, cost: &[u8], sum: &[u16]) {
        if let Some((costs, sums)) = &mut self.record {
            costs[x * disparities..][..disparities].copy_from_slice(&cost[..disparities]);
            sums[x * disparities..][..disparities].copy_from_slice(&sum[..disparities]);
        }
    }
}

/// What becomes of the sum of all paths of a row.
pub(super) enum Goal<'a> {
    /// Its winners.
    Maps(RowOfMaps<'a>),
    /// The cost of the second pass, `[x][n]`.
    SecondCost(&'a mut [u8]),
}

/// What a thread needs for rows; reused.
pub(super) struct Scratch {
    pub(super) rows: [RowScratch; TOGETHER],
}

pub(super) struct RowScratch {
    /// T of the path to the right, `[x][n]`.
    pub(super) right: Lent,
    pub(super) state: Aligned<u8>,
    pub(super) least: u8,
    /// The sum of all paths of a pixel.
    pub(super) sum: Aligned<u16>,
    /// n + 1 zeros, three times `u16::MAX`, n + 1 zeros.
    near: Aligned<u16>,
    /// `u16::MAX` beyond the disparities, else 0.
    beyond: Aligned<u16>,
    found: Found<u16>,
    keys: RightKeys,
}

impl Scratch {
    pub(super) fn new(width: usize, disparities: usize, group: usize, buffers: &Buffers) -> Self {
        let n = disparities.next_multiple_of(LANES);
        let row = || {
            let mut beyond = Aligned::new(n, 0);
            beyond[disparities..].fill(u16::MAX);
            let mut near = Aligned::new(2 * n + 5, 0u16);
            near[n + 1..n + 4].fill(u16::MAX);
            RowScratch {
                right: buffers.take(width * n),
                state: Aligned::new(n + 2 * PAD, 255),
                least: 0,
                sum: Aligned::zeroed(n),
                near,
                beyond,
                found: Found::new(width),
                keys: RightKeys::new(width, n, group),
            }
        };
        Self { rows: std::array::from_fn(|_| row()) }
    }

    /// Its bytes.
    pub(super) fn bytes(width: usize, n: usize, group: usize) -> u64 {
        let keys = n / group * (width + 2 * LANES) * 2;
        (TOGETHER * (width * n + keys + 14 * width + 10 * n)) as u64
    }
}

impl RowScratch {
    pub(super) fn start(&mut self, n: usize) {
        self.state[PAD..PAD + n].fill(0);
        self.least = 0;
    }
}

/// Computes at most [`TOGETHER`] rows.
pub(super) type RowsOf = fn(&mut [AcrossRow<'_>], &mut Scratch, &Params, Instructions);

/// How rows are computed.
pub(super) struct Across {
    /// Computes the winners.
    pub(super) rows: RowsOf,
    /// Disparities whose keys go together: a sum, of at most 255 a path, and an index fit 16 bits.
    pub(super) group: usize,
}

impl Across {
    /// Of so many paths and disparities.
    pub(super) fn new(paths: usize, disparities: usize) -> Self {
        match (paths, disparities) {
            (3, 64) => Self::of::<3, 1, 64, 64>(),
            (3, 128) => Self::of::<3, 1, 32, 128>(),
            (3, _) => Self::of::<3, 1, 32, 0>(),
            (4, 64) => Self::of::<4, 1, 64, 64>(),
            (4, 128) => Self::of::<4, 1, 32, 128>(),
            (4, _) => Self::of::<4, 1, 32, 0>(),
            (5, _) => Self::of::<5, 2, 32, 0>(),
            (8, 64) => Self::of::<8, 3, 32, 64>(),
            (8, 128) => Self::of::<8, 3, 32, 128>(),
            (8, _) => Self::of::<8, 3, 32, 0>(),
            _ => Self::of::<16, 7, 16, 0>(),
        }
    }

    fn of<const P: u16, const Q: usize, const G: usize, const N: usize>() -> Self {
        Self { rows: across::<P, Q, G, N>, group: G }
    }
}

/// P paths, Q planes of those that cross rows, groups of G keys. N: the disparities where they are known, and a multiple of
/// [`LANES`]; else 0.
fn across<const P: u16, const Q: usize, const G: usize, const N: usize>(
    rows: &mut [AcrossRow<'_>],
    scratch: &mut Scratch,
    params: &Params,
    instructions: Instructions,
) {
    match rows {
        [first, second] => {
            let [one, two] = &mut scratch.rows;
            let (rows, scratch) = ([first, second], [one, two]);
            instructions.launch(Rows::<2, P, Q, G, N> { rows, scratch, params });
        }
        rows => rows.iter_mut().zip(&mut scratch.rows).for_each(|(row, scratch)| {
            instructions.launch(Rows::<1, P, Q, G, N> { rows: [row], scratch: [scratch], params });
        }),
    }
}

struct Rows<'a, 'b, const R: usize, const P: u16, const Q: usize, const G: usize, const N: usize> {
    rows: [&'a mut AcrossRow<'b>; R],
    scratch: [&'a mut RowScratch; R],
    params: &'a Params,
}

impl<const R: usize, const P: u16, const Q: usize, const G: usize, const N: usize> Kernel
    for Rows<'_, '_, R, P, Q, G, N>
{
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { rows, mut scratch, params } = self;
        let n = if N > 0 { N } else { (params.disparities as usize).next_multiple_of(LANES) };
        let mut x = rightwards(simd, &rows, &mut scratch, n);
        scratch.iter_mut().for_each(|scratch| {
            scratch.start(n);
            scratch.keys.clear();
        });
        for segment in (0..rows[0].segments.len()).rev() {
            for i in (0..rows[0].segments[segment].cost.len() / n).rev() {
                x -= 1;
                for r in 0..R {
                    pixel::<V, P, Q, G, N>(simd, rows[r], scratch[r], [segment, i, x], n, params);
                }
            }
        }
        for (row, scratch) in rows.into_iter().zip(scratch) {
            let Goal::Maps(maps) = &mut row.goal else { continue };
            scratch.found.finish(params, maps);
            scratch.keys.finish::<G>(params, maps.right);
        }
    }
}

/// The path to the right along some rows. Returns their columns.
#[inline(always)]
pub(super) fn rightwards<V: Simd, const R: usize>(
    simd: V,
    rows: &[&mut AcrossRow<'_>; R],
    scratch: &mut [&mut RowScratch; R],
    n: usize,
) -> usize {
    scratch.iter_mut().for_each(|scratch| scratch.start(n));
    let mut x = 0;
    for segment in 0..rows[0].segments.len() {
        let costs = rows.each_ref().map(|row| row.segments[segment].cost);
        for i in 0..costs[0].len() / n {
            for r in 0..R {
                let penalties = rows[r].penalties[0].at(x);
                let RowScratch { right, state, least, .. } = &mut *scratch[r];
                let path = Stepping { state: &mut state[PAD - 1..], least, penalties };
                steps(simd, [path], &costs[r][i * n..][..n], &mut Store(&mut right[x * n..][..n]));
            }
            x += 1;
        }
    }
    x
}

/// The step to the left into a pixel, its sum and its winner. It is the `i`-th of the segment, in column x.
#[inline(always)]
fn pixel<V: Simd, const P: u16, const Q: usize, const G: usize, const N: usize>(
    simd: V,
    row: &mut AcrossRow<'_>,
    scratch: &mut RowScratch,
    [segment, i, x]: [usize; 3],
    n: usize,
    params: &Params,
) {
    let (cost, planes) = row.segments[segment].pixel::<Q>(i, n);
    let RowScratch { right, state, least, sum, near, beyond, found, keys } = scratch;
    let path = Stepping { state: &mut state[PAD - 1..], least, penalties: row.penalties[1].at(x) };
    let (right, sums, beyond) = (&right[x * n..][..n], &mut sum[..n], &beyond[..n]);
    let smallest = Smallest { keys: [simd.splat_u16x16(u16::MAX); 2], blocks: 0, first: 0, best: u32::MAX };
    let mut total = Total::<V, P, Q, G, N> { simd, cost, planes, right, beyond, sums, keys, x, smallest };
    steps(simd, [path], cost, &mut total);
    let best = total.smallest.winner::<G, N>(simd);
    let label = (best & 0xffff) as usize;
    let sum = &sum[..n];
    found.best[x] = (best >> 16) as u16;
    found.label[x] = label as u16;
    found.before[x] = sum[label.saturating_sub(1)];
    found.after[x] = sum[(label + 1).min(n - 1)];
    let near = &near[n + 2 - label..][..n];
    let mut rival = simd.splat_u16x16(u16::MAX);
    for at in (0..n).step_by(LANES) {
        for (sum, near) in words(simd, sum, at).into_iter().zip(words(simd, near, at)) {
            rival = simd.min_u16x16(rival, simd.or_u16x16(sum, near));
        }
    }
    found.rival[x] = simd.reduce_min_u16x16(rival);
    row.keep(x, params.disparities as usize, cost, sum);
}

/// [`LANES`] numbers from `at` on.
#[inline(always)]
fn words<V: Simd>(simd: V, from: &[u16], at: usize) -> [u16x16<V>; 2] {
    let from = &from[at..at + LANES];
    let mut vectors = [simd.splat_u16x16(0); 2];
    for (vector, from) in vectors.iter_mut().zip(from.as_chunks::<{ LANES / 2 }>().0) {
        *vector = u16x16::simd_from(simd, *from);
    }
    vectors
}

/// Writes them.
#[inline(always)]
pub(super) fn store_words<V: Simd>(vectors: [u16x16<V>; 2], to: &mut [u16], at: usize) {
    let to = &mut to[at..at + LANES];
    to[..LANES / 2].copy_from_slice(&*vectors[0]);
    to[LANES / 2..].copy_from_slice(&*vectors[1]);
}

/// Adds bytes to numbers of 16 bits.
#[inline(always)]
pub(super) fn add<V: Simd>(simd: V, sum: [u16x16<V>; 2], bytes: u8x32<V>) -> [u16x16<V>; 2] {
    let (low, high) = simd.widen_u8x32(bytes);
    [simd.add_u16x16(sum[0], low), simd.add_u16x16(sum[1], high)]
}

/// T of a path to a row.
struct Store<'a>(&'a mut [u8]);

impl<V: Simd> Receive<V, 1> for Store<'_> {
    #[inline(always)]
    fn receive(&mut self, at: usize, [t]: [u8x32<V>; 1]) {
        store(t, self.0, at);
    }
}

/// T of the last path, added to those of all others: the sum, its winner, and the votes for the right view.
struct Total<'a, V: Simd, const P: u16, const Q: usize, const G: usize, const N: usize> {
    simd: V,
    cost: &'a [u8],
    planes: [&'a [u8]; Q],
    right: &'a [u8],
    beyond: &'a [u16],
    sums: &'a mut [u16],
    keys: &'a mut RightKeys,
    x: usize,
    smallest: Smallest<V>,
}

/// The smallest sums so far.
///
/// Where all disparities are one group, by the keys of the right view, which hold the index. Else at each place in [`LANES`]
/// disparities, by keys: the sum, then the number of the [`LANES`] disparities.
struct Smallest<V: Simd> {
    keys: [u16x16<V>; 2],
    /// How many [`LANES`] there have been.
    blocks: usize,
    /// The first that the keys count from.
    first: usize,
    /// The smallest sum before that, and in the lower half its index.
    best: u32,
}

/// 0 to 63, by sixteen.
const PLACES: [[u16; LANES / 2]; 4] = {
    let mut places = [[0; LANES / 2]; 4];
    let mut i = 0;
    while i < 2 * LANES {
        places[i / (LANES / 2)][i % (LANES / 2)] = i as u16;
        i += 1;
    }
    places
};

impl<V: Simd> Smallest<V> {
    /// The smallest sum, and in the lower half its index, of equal ones the smallest.
    #[inline(always)]
    fn winner<const G: usize, const N: usize>(&self, simd: V) -> u32 {
        let least = simd.reduce_min_u16x16(simd.min_u16x16(self.keys[0], self.keys[1]));
        if G == N {
            return ((u32::from(least) / G as u32) << 16) | (u32::from(least) % G as u32);
        }
        let (wanted, none) = (simd.splat_u16x16(least), simd.splat_u16x16(u16::MAX));
        let mut places = none;
        for (half, of_half) in PLACES[..2].iter().enumerate() {
            let found = simd.simd_eq_u16x16(self.keys[half], wanted);
            let found = simd.select_u16x16(found, u16x16::simd_from(simd, *of_half), none);
            places = simd.min_u16x16(places, found);
        }
        let place = simd.reduce_min_u16x16(places);
        let index = (self.first + usize::from(least) % G) * LANES + usize::from(place);
        self.best.min(((u32::from(least) / G as u32) << 16) | index as u32)
    }
}

impl<V: Simd, const P: u16, const Q: usize, const G: usize, const N: usize> Receive<V, 1> for Total<'_, V, P, Q, G, N> {
    #[inline(always)]
    fn receive(&mut self, at: usize, [t]: [u8x32<V>; 1]) {
        let simd = self.simd;
        let (low, high) = simd.widen_u8x32(load(simd, self.cost, at));
        let paths = simd.splat_u16x16(P);
        let mut sum = [simd.mul_u16x16(low, paths), simd.mul_u16x16(high, paths)];
        sum = add(simd, sum, simd.add_u8x32(load(simd, self.right, at), t));
        for plane in &self.planes {
            sum = add(simd, sum, load(simd, plane, at));
        }
        if N == 0 {
            // What lies beyond the disparities never wins and is no rival.
            let beyond = words(simd, self.beyond, at);
            sum = [simd.or_u16x16(sum[0], beyond[0]), simd.or_u16x16(sum[1], beyond[1])];
        }
        store_words(sum, self.sums, at);
        let bits = G.trailing_zeros();
        let number = simd.splat_u16x16((self.smallest.blocks - self.smallest.first) as u16);
        for (half, &sum) in sum.iter().enumerate() {
            let shifted = simd.shl_u16x16(sum, bits);
            let first = at + half * LANES / 2;
            let places = u16x16::simd_from(simd, PLACES[first % G / (LANES / 2)]);
            let key = simd.or_u16x16(shifted, places);
            let own = if G == N { key } else { simd.or_u16x16(shifted, number) };
            self.smallest.keys[half] = simd.min_u16x16(self.smallest.keys[half], own);
            let seen = self.keys.seen::<G>(self.x, first);
            if let Some(seen) = seen.first_chunk_mut::<{ LANES / 2 }>() {
                *seen = *simd.min_u16x16(u16x16::simd_from(simd, *seen), key);
            }
        }
        self.smallest.blocks += 1;
        if G != N && self.smallest.blocks - self.smallest.first == G {
            let (best, next) = (self.smallest.winner::<G, N>(simd), self.smallest.blocks);
            self.smallest = Smallest { keys: [simd.splat_u16x16(u16::MAX); 2], blocks: next, first: next, best };
        }
    }
}
