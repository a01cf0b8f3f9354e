//! A step of a path, in bytes.
//!
//! L(d) = C(d) + T(d) with T(d) = min(L'(d), L'(d - 1) + P1, L'(d + 1) + P1, min L' + P2) - min L'. Where L' is smallest, T is 0,
//! so min L <= max C = 89, and min L' + P2 <= 89 + 127: nothing that can win exceeds a byte, and what is larger saturates at
//! 255. A state of zeros starts a path: T is 0 everywhere.
//!
//! What lies around a state is 255 and so never the best, and where the cost is 255, beyond the last disparity, L stays 255.

use crate::cpu::LANES;

/// Bytes of 255 around each state; as many as keep the states aligned to vectors.
pub(super) const PAD: usize = LANES;

/// Disparities that are computed at once.
pub(super) const BLOCK: usize = 2 * LANES;

/// A state that takes a step.
pub(super) struct Stepping<'a> {
    /// L' between a byte of 255 on either side.
    pub(super) state: &'a mut [u8],
    /// The smallest L'.
    pub(super) least: &'a mut u8,
    /// P2 of this step.
    pub(super) p2: u8,
}

/// Receives the T of a pixel along several paths.
pub(super) trait Receive<const K: usize> {
    /// Those of the disparities from `at` on.
    fn receive<const B: usize>(&mut self, at: usize, t: &[[u8; B]; K]);
}

/// T and L of some disparities: `before` begins with L' of the disparity before the first one.
#[inline(always)]
fn block<const B: usize>(before: &[u8], cost: &[u8], least: u8, p1: u8, most: u8) -> ([u8; B], [u8; B]) {
    let (before, cost) = (&before[..B + 2], &cost[..B]);
    let (mut t, mut l) = ([0; B], [0; B]);
    for d in 0..B {
        let beside = before[d].min(before[d + 2]).saturating_add(p1);
        t[d] = beside.min(before[d + 1]).min(most).wrapping_sub(least);
        l[d] = cost[d].saturating_add(t[d]);
    }
    (t, l)
}

/// The steps into a pixel of cost `cost` along K paths.
///
/// Blocks follow each other; the last one begins where it ends at the end, and then repeats a part of the one before. Loops of fewer
/// values than a block would be unrolled and not vectorised: with up to [`LANES`] disparities they are.
#[inline(always)]
pub(super) fn steps<const K: usize>(paths: [Stepping<'_>; K], cost: &[u8], p1: u8, to: &mut impl Receive<K>) {
    if cost.len() < BLOCK {
        steps_by::<K, LANES>(paths, cost, p1, to);
    } else {
        steps_by::<K, BLOCK>(paths, cost, p1, to);
    }
}

#[inline(always)]
fn steps_by<const K: usize, const B: usize>(
    mut paths: [Stepping<'_>; K],
    cost: &[u8],
    p1: u8,
    to: &mut impl Receive<K>,
) {
    let last = cost.len() - B;
    let (mut leasts, mut waiting) = ([255u8; K], [[0u8; B]; K]);
    let (mut at, mut before) = (0, 0);
    loop {
        let mut t = [[0u8; B]; K];
        for k in 0..K {
            let path = &mut paths[k];
            let least = *path.least;
            let (made, l) = block::<B>(&path.state[at..], &cost[at..], least, p1, least + path.p2);
            t[k] = made;
            leasts[k] = l.iter().fold(leasts[k], |least, &l| least.min(l));
            // The block before is written only now that its last value has been read.
            if at > 0 {
                path.state[before + 1..][..B].copy_from_slice(&waiting[k]);
            }
            waiting[k] = l;
        }
        to.receive(at, &t);
        before = at;
        if at == last {
            break;
        }
        at = (at + B).min(last);
    }
    for k in 0..K {
        paths[k].state[last + 1..][..B].copy_from_slice(&waiting[k]);
        *paths[k].least = leasts[k];
    }
}
