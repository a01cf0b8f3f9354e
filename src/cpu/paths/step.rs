//! A step of a path, in bytes.
//!
//! L(d) = C(d) + T(d) with T(d) = min(L'(d), L'(d - 1) + P1, L'(d + 1) + P1, min L' + P2) - min L'. Where L' is smallest, T is 0,
//! so min L <= max C, and min L' + P2 <= max C + P2 <= 255, as the ranges of the settings have it: nothing that can win exceeds a byte,
//! and what is larger saturates at 255. A state of zeros starts a path: T is 0 everywhere.
//!
//! What lies around a state is 255 and so never the best, and where the cost is 255, beyond the last disparity, L stays 255.

use fearless_simd::{Simd, SimdFrom, u8x32};

use crate::cpu::LANES;

/// Bytes of 255 around each state; as many as keep the states aligned to vectors.
pub(super) const PAD: usize = LANES;

/// A state that takes a step.
pub(super) struct Stepping<'a> {
    /// L' behind a byte of 255 and before [`PAD`] of them.
    pub(super) state: &'a mut [u8],
    /// The smallest L'.
    pub(super) least: &'a mut u8,
    /// P1 and P2 of this step.
    pub(super) penalties: [u8; 2],
}

/// Receives the T of a pixel along several paths.
pub(super) trait Receive<V: Simd, const K: usize> {
    /// What comes next is of the pixel that begins here, in a row.
    #[inline(always)]
    fn column(&mut self, _first: usize) {}

    /// Those of the disparities from `at` on.
    fn receive(&mut self, at: usize, t: [u8x32<V>; K]);
}

/// The values from `at` on.
#[inline(always)]
pub(super) fn load<V: Simd>(simd: V, from: &[u8], at: usize) -> u8x32<V> {
    let mut values = [0; LANES];
    values.copy_from_slice(&from[at..at + LANES]);
    u8x32::simd_from(simd, values)
}

/// Writes the values from `at` on.
#[inline(always)]
pub(super) fn store<V: Simd>(vector: u8x32<V>, to: &mut [u8], at: usize) {
    to[at..at + LANES].copy_from_slice(&*vector);
}

/// The steps into a pixel of cost `cost` along K paths.
#[inline(always)]
pub(super) fn steps<V: Simd, const K: usize>(
    simd: V,
    mut paths: [Stepping<'_>; K],
    cost: &[u8],
    to: &mut impl Receive<V, K>,
) {
    let zero = simd.splat_u8x32(0);
    for path in &mut paths {
        // So that no access below is checked.
        path.state = &mut std::mem::take(&mut path.state)[..cost.len() + PAD + 1];
    }
    let (mut leasts, mut most, mut before, mut smallest) = ([zero; K], [zero; K], [zero; K], [zero; K]);
    let mut p1 = [zero; K];
    for k in 0..K {
        let path = &paths[k];
        leasts[k] = simd.splat_u8x32(*path.least);
        p1[k] = simd.splat_u8x32(path.penalties[0]);
        most[k] = simd.splat_u8x32(*path.least + path.penalties[1]);
        before[k] = load(simd, path.state, 0);
        smallest[k] = simd.splat_u8x32(255);
    }
    for at in (0..cost.len()).step_by(LANES) {
        let cost = load(simd, cost, at);
        let mut t = [zero; K];
        for k in 0..K {
            let state = &mut *paths[k].state;
            let (here, after) = (load(simd, state, at + 1), load(simd, state, at + 2));
            let beside = simd.saturating_add_u8x32(simd.min_u8x32(before[k], after), p1[k]);
            let best = simd.min_u8x32(simd.min_u8x32(beside, here), most[k]);
            t[k] = simd.sub_u8x32(best, leasts[k]);
            let l = simd.saturating_add_u8x32(cost, t[k]);
            // What the next disparities have before them is read before it is overwritten.
            before[k] = load(simd, state, at + LANES);
            store(l, state, at + 1);
            smallest[k] = simd.min_u8x32(smallest[k], l);
        }
        to.receive(at, t);
    }
    for k in 0..K {
        *paths[k].least = simd.reduce_min_u8x32(smallest[k]);
    }
}
