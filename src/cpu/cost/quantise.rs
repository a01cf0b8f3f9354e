//! From block sums to costs of a byte, as in stage `matching_cost`: (sum * scale + 2^23) >> 24.

use std::hint::black_box;

use fearless_simd::{Simd, SimdFrom, u8x32, u16x16};

use crate::cpu::LANES;
use crate::cpu::cost::sums::{Finish, Sum, Value};
use crate::params::Params;

/// Costs from sums of 16 bits with one multiplication of which the upper half is kept:
/// (((factor * sum + bias) * multiplier) >> 16) >> shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    pub factor: u16,
    pub bias: u16,
    multiplier: u16,
    shift: u32,
}

impl Words {
    /// Numbers with which every sum up to `largest` gets the cost (sum * scale + 2^23) >> 24; none if sums need more than
    /// 16 bits or no such numbers are found.
    ///
    /// Both costs never fall as sums rise. So they are equal everywhere if each cost c begins at the same sum t:
    /// with v = ceil(c 2^(16 + shift) / multiplier), the smallest factor * sum + bias that gives c, factor (t - 1) + bias <
    /// v <= factor t + bias. For each factor, multiplier and shift that leaves a range for the bias, or none.
    pub fn new(largest: u32, scale: u32) -> Option<Self> {
        let most = 0xffff / (largest + largest / 128 + 1);
        let factors = (1..=most).rev().take(64).map(|factor| (factor, 0));
        let fine = (1..=9).map(|shift| (most.max(1), shift));
        let candidates = factors.chain(fine).filter(|_| most > 0).flat_map(|(factor, shift)| {
            let multiplier = ((u64::from(scale) << shift) / (256 * u64::from(factor))) as u32;
            [multiplier, multiplier + 1].map(|multiplier| (factor, shift, multiplier))
        });
        let mut candidates = candidates.filter(|&(.., multiplier)| (1..=0xffff).contains(&multiplier));
        candidates.find_map(|(factor, shift, multiplier)| {
            let bias = bias(largest, scale, factor, shift, multiplier)?;
            Some(Self { factor: factor as u16, bias, multiplier: multiplier as u16, shift })
        })
    }
}

/// The smallest bias with which these numbers give the right costs.
fn bias(largest: u32, scale: u32, factor: u32, shift: u32, multiplier: u32) -> Option<u16> {
    let (largest, scale, factor, multiplier) =
        (i64::from(largest), i64::from(scale), i64::from(factor), i64::from(multiplier));
    let costs = 1..=(largest * scale + (1 << 23)) >> 24;
    let (mut least, mut most) = (0, 0xffff - largest * factor);
    for cost in costs {
        let first = ((cost << 24) - (1 << 23) + scale - 1) / scale;
        let value = ((cost << (16 + shift)) + multiplier - 1) / multiplier;
        least = least.max(value - first * factor);
        most = most.min(value - 1 - (first - 1) * factor);
    }
    // The largest sum must not get more than its cost.
    let beyond = ((((largest * scale + (1 << 23)) >> 24) + 1) << (16 + shift)) + multiplier - 1;
    most = most.min(beyond / multiplier - 1 - largest * factor);
    (least <= most).then_some(least as u16)
}

impl Finish<u16> for Words {
    type Out = u8;

    #[inline(always)]
    fn finish<V: Simd>(self, simd: V, sums: [u16x16<V>; 2], beyond: u8x32<V>, to: &mut [u8; LANES]) {
        let low = simd.shr_u16x16(upper_half(simd, sums[0], self.multiplier), self.shift);
        let high = simd.shr_u16x16(upper_half(simd, sums[1], self.multiplier), self.shift);
        u8::store(simd.or_u8x32(simd.relaxed_narrow_u16x16(low, high), beyond), to);
    }
}

/// The upper 16 bits of products.
#[inline(always)]
fn upper_half<V: Simd>(simd: V, values: u16x16<V>, multiplier: u16) -> u16x16<V> {
    let multipliers = [multiplier; 16];
    // The compiler has one instruction for this, but widens the products instead where it sees that the multiplier stays the same.
    let (values, multipliers, mut upper): (&[u16; 16], _, _) = (&values, black_box(&multipliers), [0; 16]);
    for ((upper, &value), &multiplier) in upper.iter_mut().zip(values).zip(multipliers) {
        *upper = ((u32::from(value) * u32::from(multiplier)) >> 16) as u16;
    }
    u16x16::simd_from(simd, upper)
}

/// Costs as the definition says.
#[derive(Clone, Copy)]
pub struct Wide {
    narrowing: u32,
    scale: u32,
}

impl Wide {
    pub fn new(params: &Params) -> Self {
        Self { narrowing: params.narrowing(), scale: params.cost_scale() }
    }
}

impl Finish<u32> for Wide {
    type Out = u8;

    #[inline(always)]
    fn finish<V: Simd>(self, simd: V, sums: <u32 as Sum>::Vector<V>, beyond: u8x32<V>, to: &mut [u8; LANES]) {
        let mut cost = sums;
        for cost in &mut cost {
            let scaled = simd.mul_u32x8(simd.shr_u32x8(*cost, self.narrowing), simd.splat_u32x8(self.scale));
            *cost = simd.shr_u32x8(simd.add_u32x8(scaled, simd.splat_u32x8(1 << 23)), 24);
        }
        let (low, high) = (simd.relaxed_narrow_u32x8(cost[0], cost[1]), simd.relaxed_narrow_u32x8(cost[2], cost[3]));
        u8::store(simd.or_u8x32(simd.relaxed_narrow_u16x16(low, high), beyond), to);
    }
}

/// The sums themselves, narrowed.
#[derive(Clone, Copy)]
pub struct Sums {
    pub narrowing: u32,
}

impl Finish<u16> for Sums {
    type Out = u16;

    #[inline(always)]
    fn finish<V: Simd>(self, simd: V, sums: [u16x16<V>; 2], beyond: u8x32<V>, to: &mut [u16; LANES]) {
        let (low, high) = simd.widen_u8x32(beyond);
        let all = simd.splat_u16x16(257);
        let (low, high) = (simd.mul_u16x16(low, all), simd.mul_u16x16(high, all));
        <u16 as Sum>::store([simd.or_u16x16(sums[0], low), simd.or_u16x16(sums[1], high)], to);
    }
}

impl Finish<u32> for Sums {
    type Out = u32;

    #[inline(always)]
    fn finish<V: Simd>(self, simd: V, sums: <u32 as Sum>::Vector<V>, beyond: u8x32<V>, to: &mut [u32; LANES]) {
        let (low, high) = simd.widen_u8x32(beyond);
        let (a, b) = simd.widen_u16x16(low);
        let (c, d) = simd.widen_u16x16(high);
        let mut narrowed = sums;
        for (sum, beyond) in narrowed.iter_mut().zip([a, b, c, d]) {
            let all = simd.mul_u32x8(beyond, simd.splat_u32x8(0x0101_0101));
            *sum = simd.or_u32x8(simd.shr_u32x8(*sum, self.narrowing), all);
        }
        u32::store(narrowed, to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every sum of every range that costs have: those of one multiplication equal the definition's.
    #[test]
    fn words_equal_the_definition_for_every_sum() {
        let mut found = 0;
        for pixel_max in [1, 2, 8, 24, 31, 62, 96, 124, 127, 189, 190, 192, 200, 248, 252, 254, 255, 1024, 3844, 65025]
        {
            for block in (1..=51).step_by(2) {
                for top in [59 * 1550, 128 * pixel_max.min(255), 64 * 1024] {
                    let largest: u32 = block * block * pixel_max;
                    let scale = (top * (1 << 14) + largest / 2) / largest;
                    if largest >= 1 << 16 {
                        assert_eq!(Words::new(largest, scale), None);
                        continue;
                    }
                    let Some(words) = Words::new(largest, scale) else { continue };
                    found += 1;
                    for sum in 0..=largest {
                        let value = sum * u32::from(words.factor) + u32::from(words.bias);
                        let made = ((u32::from(u16::try_from(value).unwrap()) * u32::from(words.multiplier)) >> 16)
                            >> words.shift;
                        let expected = (sum * scale + (1 << 23)) >> 24;
                        assert_eq!(made, expected, "sum {sum} of {largest}, scale {scale}: {words:?}");
                    }
                }
            }
        }
        assert!(found > 400, "{found} ranges of sums");
    }
}
