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
#[inline(always)]
pub(super) fn steps<const K: usize>(mut paths: [Stepping<'_>; K], cost: &[u8], p1: u8, to: &mut impl Receive<K>) {
    let n = cost.len();
    let mut leasts = [255u8; K];
    let mut waiting = [[0u8; BLOCK]; K];
    let whole = n - n % BLOCK;
    let mut at = 0;
    // What is written of a block waits until the next one has read its neighbour in it.
    while at < whole {
        let mut t = [[0u8; BLOCK]; K];
        for k in 0..K {
            let path = &mut paths[k];
            let least = *path.least;
            let (made, l) = block::<BLOCK>(&path.state[at..], &cost[at..], least, p1, least + path.p2);
            t[k] = made;
            leasts[k] = l.iter().fold(leasts[k], |least, &l| least.min(l));
            if at > 0 {
                path.state[at - BLOCK + 1..][..BLOCK].copy_from_slice(&waiting[k]);
            }
            waiting[k] = l;
        }
        to.receive(at, &t);
        at += BLOCK;
    }
    if at < n {
        let mut t = [[0u8; LANES]; K];
        for k in 0..K {
            let path = &mut paths[k];
            let least = *path.least;
            let (made, l) = block::<LANES>(&path.state[at..], &cost[at..], least, p1, least + path.p2);
            t[k] = made;
            leasts[k] = l.iter().fold(leasts[k], |least, &l| least.min(l));
            if at > 0 {
                path.state[at - BLOCK + 1..][..BLOCK].copy_from_slice(&waiting[k]);
            }
            path.state[at + 1..][..LANES].copy_from_slice(&l);
        }
        to.receive(at, &t);
    } else {
        for k in 0..K {
            paths[k].state[at - BLOCK + 1..][..BLOCK].copy_from_slice(&waiting[k]);
        }
    }
    for k in 0..K {
        *paths[k].least = leasts[k];
    }
}
