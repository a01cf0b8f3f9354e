//! Rows as a whole: the path to the right, then the path to the left together with the sum of all paths and its winner.
//!
//! Two rows at a time, whose steps do not depend on each other, keep the processor busy.

use super::penalties::PenaltyRow;
use super::step::{BLOCK, PAD, Receive, Stepping, steps};
use crate::Params;
use crate::cpu::LANES;
use crate::cpu::aligned::{Aligned, Local};
use crate::cpu::instructions::Instructions;
use crate::cpu::winner::{Found, RightKeys, RowOfMaps};

/// Rows at a time.
pub(super) const TOGETHER: usize = 2;

/// Neighbouring columns of a row, `[x][n]`.
pub(super) struct Segment<'a> {
    pub(super) cost: &'a [u8],
    /// Sums of two T, or single T, of all paths that cross rows.
    pub(super) planes: Vec<&'a [u8]>,
}

/// A row and where its winners go.
pub(super) struct AcrossRow<'a> {
    pub(super) segments: Vec<Segment<'a>>,
    /// P2 of the steps to the right and to the left.
    pub(super) p2: [PenaltyRow<'a>; 2],
    pub(super) maps: RowOfMaps<'a>,
    /// Where the cost and the sum of all paths go, `[x][d]` without padding, if they are recorded.
    pub(super) record: Option<(&'a mut [u8], &'a mut [u16])>,
}

/// What a thread needs for rows; reused.
pub(super) struct Scratch {
    rows: [RowScratch; TOGETHER],
}

struct RowScratch {
    /// T of the path to the right, `[x][n]`.
    right: Aligned<u8>,
    state: Aligned<u8>,
    least: u8,
    /// The sum of all paths of a pixel.
    sum: Aligned<u16>,
    /// n + 1 zeros, three times `u16::MAX`, n + 1 zeros.
    near: Aligned<u16>,
    /// `u16::MAX` beyond the disparities, else 0.
    beyond: Aligned<u16>,
    /// n and [`BLOCK`], as numbers that the compiler does not know: else it unrolls the search for a minimum.
    lengths: [usize; 2],
    found: Found<u16>,
    keys: RightKeys,
}

impl Scratch {
    pub(super) fn new(width: usize, disparities: usize, paths: usize) -> Self {
        let n = disparities.next_multiple_of(LANES);
        let row = || {
            let mut beyond = Aligned::new(n, 0);
            beyond[disparities..].fill(u16::MAX);
            let mut near = Aligned::new(2 * n + 5, 0);
            near[n + 1..n + 4].fill(u16::MAX);
            RowScratch {
                right: Aligned::zeroed(width * n),
                state: Aligned::new(n + 2 * PAD, 255),
                least: 0,
                sum: Aligned::zeroed(n),
                near,
                beyond,
                lengths: [n, n.min(BLOCK)],
                found: Found::new(width),
                keys: RightKeys::new(width, n, group_of(paths)),
            }
        };
        Self { rows: std::array::from_fn(|_| row()) }
    }

    /// Its bytes.
    pub(super) fn bytes(width: usize, n: usize, paths: usize) -> u64 {
        let keys = n / group_of(paths) * (width + 2 * LANES) * 2;
        (TOGETHER * (width * n + keys + 14 * width + 10 * n)) as u64
    }
}

/// Disparities whose keys go together: a sum of at most 16 * (89 + 127) and an index fit 16 bits.
fn group_of(paths: usize) -> usize {
    if paths > 8 { LANES / 2 } else { LANES }
}

impl RowScratch {
    fn start(&mut self, n: usize) {
        self.state[PAD..PAD + n].fill(0);
        self.least = 0;
    }
}

/// Computes at most [`TOGETHER`] rows.
pub(super) type Across = fn(&mut [AcrossRow<'_>], &mut Scratch, &Params, Instructions);

/// The function for so many paths and n bytes a pixel.
pub(super) fn across_for(paths: usize, n: usize) -> Across {
    match (paths, n) {
        (3, 64) => across::<3, 1, 32, 64>,
        (3, 128) => across::<3, 1, 32, 128>,
        (3, _) => across::<3, 1, 32, 0>,
        (4, 64) => across::<4, 1, 32, 64>,
        (4, 128) => across::<4, 1, 32, 128>,
        (4, _) => across::<4, 1, 32, 0>,
        (5, _) => across::<5, 2, 32, 0>,
        (8, 64) => across::<8, 3, 32, 64>,
        (8, 128) => across::<8, 3, 32, 128>,
        (8, _) => across::<8, 3, 32, 0>,
        _ => across::<16, 7, 16, 0>,
    }
}

/// P paths, Q planes of those that cross rows, groups of G keys. N: the bytes of a pixel where they are known, else 0.
fn across<const P: u16, const Q: usize, const G: usize, const N: usize>(
    rows: &mut [AcrossRow<'_>],
    scratch: &mut Scratch,
    params: &Params,
    instructions: Instructions,
) {
    instructions.run(
        #[inline(always)]
        || {
            let n = (params.disparities as usize).next_multiple_of(LANES);
            let n = if N > 0 { N } else { n };
            match rows {
                [first, second] => {
                    let [one, two] = &mut scratch.rows;
                    across_in_set::<2, P, Q, G>([first, second], [one, two], n, params);
                }
                rows => rows.iter_mut().zip(&mut scratch.rows).for_each(
                    #[inline(always)]
                    |(row, scratch)| across_in_set::<1, P, Q, G>([row], [scratch], n, params),
                ),
            }
        },
    );
}

#[inline(always)]
fn across_in_set<const R: usize, const P: u16, const Q: usize, const G: usize>(
    rows: [&mut AcrossRow<'_>; R],
    mut scratch: [&mut RowScratch; R],
    n: usize,
    params: &Params,
) {
    let p1 = params.p1 as u8;
    scratch.iter_mut().for_each(|scratch| scratch.start(n));
    let mut x = 0;
    for segment in 0..rows[0].segments.len() {
        let costs = rows.each_ref().map(|row| row.segments[segment].cost);
        let columns = costs[0].len() / n;
        for i in 0..columns {
            for r in 0..R {
                let p2 = rows[r].p2[0].at(x);
                let scratch = &mut *scratch[r];
                let to = &mut scratch.right[x * n..][..n];
                let path = Stepping { state: &mut scratch.state[PAD - 1..PAD + n + 1], least: &mut scratch.least, p2 };
                steps([path], &costs[r][i * n..][..n], p1, &mut Store(to));
            }
            x += 1;
        }
    }
    scratch.iter_mut().for_each(|scratch| {
        scratch.start(n);
        scratch.keys.clear();
    });
    for segment in (0..rows[0].segments.len()).rev() {
        let columns = rows[0].segments[segment].cost.len() / n;
        for i in (0..columns).rev() {
            x -= 1;
            for r in 0..R {
                pixel::<P, Q, G>(rows[r], scratch[r], segment, i, x, n, params);
            }
        }
    }
    for r in 0..R {
        scratch[r].found.finish(params, &mut rows[r].maps);
        scratch[r].keys.finish::<G>(params, rows[r].maps.right);
    }
}

/// The step to the left into a pixel, its sum and its winner.
#[inline(always)]
fn pixel<const P: u16, const Q: usize, const G: usize>(
    row: &mut AcrossRow<'_>,
    scratch: &mut RowScratch,
    segment: usize,
    i: usize,
    x: usize,
    n: usize,
    params: &Params,
) {
    let Segment { cost, planes } = &row.segments[segment];
    let cost = &cost[i * n..][..n];
    let planes: [&[u8]; Q] = std::array::from_fn(|q| &planes[q][i * n..][..n]);
    let p2 = row.p2[1].at(x);
    let RowScratch { right, state, least, sum, near, beyond, lengths, found, keys } = scratch;
    let path = Stepping { state: &mut state[PAD - 1..PAD + n + 1], least, p2 };
    let right = &right[x * n..][..n];
    let [length, lanes] = *lengths;
    let sums = &mut sum[..n];
    let smallest =
        Smallest { keys: [u16::MAX; BLOCK], blocks: 0, first: 0, best: u32::MAX, last: n.max(BLOCK) - BLOCK, lanes };
    let beyond = &beyond[..n];
    let mut total = Total::<P, Q, G> { cost, planes, right, beyond, sums, keys, x, smallest };
    steps([path], cost, params.p1 as u8, &mut total);
    let best = total.smallest.winner::<G>();
    let label = (best & 0xffff) as usize;
    let sum = &sum[..length];
    found.best[x] = (best >> 16) as u16;
    found.label[x] = label as u16;
    found.before[x] = sum[label.saturating_sub(1)];
    found.after[x] = sum[(label + 1).min(length - 1)];
    let mut rival = u16::MAX;
    for (&sum, &near) in sum.iter().zip(&near[length + 2 - label..][..length]) {
        rival = rival.min(sum | near);
    }
    found.rival[x] = rival;
    if let Some((costs, sums)) = &mut row.record {
        let disparities = params.disparities as usize;
        costs[x * disparities..][..disparities].copy_from_slice(&cost[..disparities]);
        sums[x * disparities..][..disparities].copy_from_slice(&sum[..disparities]);
    }
}

/// T of a path to a row.
struct Store<'a>(&'a mut [u8]);

impl Receive<1> for Store<'_> {
    #[inline(always)]
    fn receive<const B: usize>(&mut self, at: usize, t: &[[u8; B]; 1]) {
        self.0[at..][..B].copy_from_slice(&t[0]);
    }
}

/// T of the last path, added to those of all others: the sum, its winner, and the votes for the right view.
struct Total<'a, const P: u16, const Q: usize, const G: usize> {
    cost: &'a [u8],
    planes: [&'a [u8]; Q],
    right: &'a [u8],
    beyond: &'a [u16],
    sums: &'a mut [u16],
    keys: &'a mut RightKeys,
    x: usize,
    smallest: Smallest,
}

/// The smallest sums so far, each by a key: the sum, then the number of its block.
struct Smallest {
    keys: [u16; BLOCK],
    /// Blocks so far.
    blocks: usize,
    /// The first block that the keys count from.
    first: usize,
    /// The smallest sum of the blocks before that, and in the lower half its index.
    best: u32,
    /// Where the last block begins.
    last: usize,
    /// Values of a block.
    lanes: usize,
}

impl Smallest {
    /// The smallest sum, and in the lower half its index, of equal ones the smallest.
    #[inline(always)]
    fn winner<const G: usize>(&self) -> u32 {
        let keys = &self.keys[..self.lanes];
        let (mut least, mut at) = (u16::MAX, u16::MAX);
        for &key in keys {
            least = least.min(key);
        }
        for (lane, &key) in keys.iter().enumerate() {
            at = at.min(if key == least { lane as u16 } else { u16::MAX });
        }
        let block = self.first + usize::from(least) % G;
        let index = (block * BLOCK).min(self.last) + usize::from(at);
        self.best.min(((u32::from(least) / G as u32) << 16) | index as u32)
    }
}

impl<const P: u16, const Q: usize, const G: usize> Receive<1> for Total<'_, P, Q, G> {
    #[inline(always)]
    fn receive<const B: usize>(&mut self, at: usize, t: &[[u8; B]; 1]) {
        let (cost, right, beyond) = (&self.cost[at..][..B], &self.right[at..][..B], &self.beyond[at..][..B]);
        let planes: [&[u8]; Q] = std::array::from_fn(|q| &self.planes[q][at..][..B]);
        let mut sums = Local([0u16; B]);
        for d in 0..B {
            let mut sum = P * u16::from(cost[d]) + u16::from(right[d].wrapping_add(t[0][d]));
            for plane in &planes {
                sum += u16::from(plane[d]);
            }
            // What lies beyond the disparities never wins and is no rival.
            sums.0[d] = sum | beyond[d];
        }
        self.sums[at..][..B].copy_from_slice(&sums.0);
        let bits = G.trailing_zeros();
        let Smallest { keys, blocks, first, .. } = &mut self.smallest;
        let number = (*blocks - *first) as u16;
        let (mut seen, mut smaller, mut least) = (Local([0u16; B]), Local([0u16; B]), Local([0u16; B]));
        for group in 0..B / G {
            seen.0[group * G..][..G].copy_from_slice(self.keys.seen::<G>(self.x, at + group * G));
        }
        for d in 0..B {
            let shifted = sums.0[d] << bits;
            smaller.0[d] = seen.0[d].min(shifted | (d % G) as u16);
            least.0[d] = keys[d].min(shifted | number);
        }
        for group in 0..B / G {
            self.keys.seen::<G>(self.x, at + group * G).copy_from_slice(&smaller.0[group * G..][..G]);
        }
        keys[..B].copy_from_slice(&least.0);
        *blocks += 1;
        if *blocks - *first == G {
            self.smallest.best = self.smallest.winner::<G>();
            self.smallest.first = self.smallest.blocks;
            self.smallest.keys = [u16::MAX; BLOCK];
        }
    }
}
