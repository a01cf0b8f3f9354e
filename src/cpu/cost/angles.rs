//! The cost of features: what the angle between two vectors says, for [`LANES`] disparities at once.

use std::ops::Range;

use fearless_simd::{Simd, SimdFrom, u8x32, u16x16, u16x32};

use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::cpu::cost::sums::Value;
use crate::cpu::images::Planes;
use crate::cpu::instructions::Kernel;

/// Compares a piece of a row by features.
pub struct Angles<'a> {
    pub sides: [&'a Planes; 2],
    /// The planes of the features.
    pub planes: Range<usize>,
    /// With weights of features and of another cost, which is in `out`, in 64ths, the two are mixed.
    pub weights: Option<[u16; 2]>,
    pub y: i64,
    pub columns: Range<usize>,
    pub d: usize,
    pub out: &'a mut [u8],
}

/// A feature of this byte; the sums of their products are exact in 16 bits, with or without the carries that are lost.
#[inline(always)]
fn feature(byte: u8) -> u16 {
    u16::from(byte).wrapping_sub(128)
}

/// The features of the pixels of the left side and of those that any of them is compared with: `[plane][column]`.
#[inline(always)]
fn gather(of: &Angles<'_>, left: &mut [u16], right: &mut [u16]) {
    let Angles { sides: [left_side, right_side], planes, y, columns, d, .. } = of;
    let count = columns.len();
    // The right pixels of the last column come first.
    let first = left_side.stride() - columns.end + d;
    let (left_row, right_row) = (left_side.row(*y), right_side.row(*y));
    let outs = left.chunks_exact_mut(count).zip(right.chunks_exact_mut(count + LANES));
    for (plane, (left, right)) in planes.clone().zip(outs) {
        let from = &left_row[plane * left_side.stride() + columns.start..][..count];
        left.iter_mut().zip(from).for_each(|(to, byte)| *to = feature(*byte));
        let from = &right_row[plane * right_side.stride() + first..][..count + LANES - 1];
        right.iter_mut().zip(from).for_each(|(to, byte)| *to = feature(*byte));
    }
}

impl Kernel for Angles<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let (count, planes) = (self.columns.len(), self.planes.len());
        let (mut left, mut right) = (Aligned::zeroed(count * planes), Aligned::zeroed(planes * (count + LANES)));
        gather(&self, &mut left, &mut right);
        let (left, right) = (&left[..], &right[..]);
        for (i, out) in self.out.as_chunks_mut::<LANES>().0[..count].iter_mut().enumerate() {
            let mut sums = simd.splat_u16x32(0);
            for (here, there) in left.chunks_exact(count).zip(right.chunks_exact(count + LANES)) {
                let Some((there, _)) = there[count - 1 - i..].split_first_chunk::<LANES>() else { return };
                let products = simd.mul_u16x32(u16x32::simd_from(simd, *there), simd.splat_u16x32(here[i]));
                sums = simd.add_u16x32(sums, products);
            }
            let (low, high) = simd.split_u16x32(sums);
            let costs = [cost(simd, low), cost(simd, high)];
            let cost = match self.weights {
                None => simd.relaxed_narrow_u16x16(costs[0], costs[1]),
                Some(weights) => mixed(simd, costs, u8x32::simd_from(simd, *out), weights),
            };
            u8::store(cost, out);
        }
    }
}

/// clamp((28900 - sum) >> 7, 0, 225), of sums with a sign.
#[inline(always)]
fn cost<V: Simd>(simd: V, sums: u16x16<V>) -> u16x16<V> {
    let above = simd.xor_u16x16(sums, simd.splat_u16x16(0x8000)); // above the smallest number
    let less = simd.saturating_sub_u16x16(simd.splat_u16x16(28900 + 0x8000), above);
    simd.shr_u16x16(simd.min_u16x16(less, simd.splat_u16x16(28900)), 7)
}

/// Two costs, each with a weight in 64ths: at most 255.
#[inline(always)]
fn mixed<V: Simd>(simd: V, costs: [u16x16<V>; 2], beside: u8x32<V>, weights: [u16; 2]) -> u8x32<V> {
    let (low, high) = simd.widen_u8x32(beside);
    let (low, high) = (mix(simd, [costs[0], low], weights), mix(simd, [costs[1], high], weights));
    simd.saturating_narrow_u16x16(low, high)
}

#[inline(always)]
fn mix<V: Simd>(simd: V, costs: [u16x16<V>; 2], weights: [u16; 2]) -> u16x16<V> {
    let features = simd.mul_u16x16(costs[0], simd.splat_u16x16(weights[0]));
    let beside = simd.mul_u16x16(costs[1], simd.splat_u16x16(weights[1]));
    simd.shr_u16x16(simd.add_u16x16(simd.add_u16x16(features, beside), simd.splat_u16x16(32)), 6)
}
