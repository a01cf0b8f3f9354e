//! How much two pixels differ, for [`LANES`] disparities at once: the twins of
//! [`pixel_cost`](crate::reference::pixel_cost).

use fearless_simd::{Simd, SimdFrom, u8x32, u16x16};

use crate::cpu::LANES;
use crate::cpu::cost::sums::Value;

/// A cost of two pixels, which are `P` bytes each. `left` is one pixel, `right` are the pixels at the disparities.
pub trait Compare<const P: usize>: Copy {
    /// What holds the cost of two pixels.
    type Value: Value;

    fn compare<V: Simd>(self, simd: V, left: [u8; P], right: [u8x32<V>; P]) -> <Self::Value as Value>::Vector<V>;
}

/// Absolute differences of one byte.
#[inline(always)]
fn difference<V: Simd>(simd: V, left: u8, right: u8x32<V>) -> u8x32<V> {
    let left = simd.splat_u8x32(left);
    simd.sub_u8x32(simd.max_u8x32(left, right), simd.min_u8x32(left, right))
}

/// floor((a + b) / 2).
#[inline(always)]
fn mean<V: Simd>(simd: V, a: u8x32<V>, b: u8x32<V>) -> u8x32<V> {
    simd.add_u8x32(simd.and_u8x32(a, b), simd.shr_u8x32(simd.xor_u8x32(a, b), 1))
}

/// One value for three colours.
#[inline(always)]
fn colours<V: Simd>(simd: V, [red, green, blue]: [u8x32<V>; 3]) -> u8x32<V> {
    mean(simd, mean(simd, red, blue), green)
}

/// The sum of absolute differences: at most 255.
#[derive(Clone, Copy)]
pub struct Differences;

impl<const P: usize> Compare<P> for Differences {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; P], right: [u8x32<V>; P]) -> u8x32<V> {
        let mut cost = difference(simd, left[0], right[0]);
        for p in 1..P {
            cost = simd.add_u8x32(cost, difference(simd, left[p], right[p]));
        }
        cost
    }
}

/// Absolute differences of red, green and blue.
#[derive(Clone, Copy)]
pub struct ColourDifferences;

impl Compare<3> for ColourDifferences {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 3], right: [u8x32<V>; 3]) -> u8x32<V> {
        colours(
            simd,
            [
                difference(simd, left[0], right[0]),
                difference(simd, left[1], right[1]),
                difference(simd, left[2], right[2]),
            ],
        )
    }
}

/// Birchfield and Tomasi, of three bytes a channel: the value, the smallest and the largest around it.
#[derive(Clone, Copy)]
pub struct Intervals;

/// How far a value lies outside an interval.
#[inline(always)]
fn outside<V: Simd>(simd: V, value: u8x32<V>, low: u8x32<V>, high: u8x32<V>) -> u8x32<V> {
    simd.max_u8x32(simd.saturating_sub_u8x32(low, value), simd.saturating_sub_u8x32(value, high))
}

/// The smaller of the distances of each value from the other one's interval, of the channel that begins at `p`.
#[inline(always)]
fn interval<V: Simd, const P: usize>(simd: V, left: &[u8; P], right: &[u8x32<V>; P], p: usize) -> u8x32<V> {
    let (low, high) = (simd.splat_u8x32(left[p + 1]), simd.splat_u8x32(left[p + 2]));
    let of_left = outside(simd, simd.splat_u8x32(left[p]), right[p + 1], right[p + 2]);
    simd.min_u8x32(of_left, outside(simd, right[p], low, high))
}

impl Compare<3> for Intervals {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 3], right: [u8x32<V>; 3]) -> u8x32<V> {
        interval(simd, &left, &right, 0)
    }
}

/// The prefiltered image and the gray one: of the latter a quarter, together at most 255.
impl Compare<6> for Intervals {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 6], right: [u8x32<V>; 6]) -> u8x32<V> {
        let quarter = simd.shr_u8x32(interval(simd, &left, &right, 3), 2);
        let room = simd.sub_u8x32(simd.splat_u8x32(255), quarter);
        simd.add_u8x32(quarter, simd.min_u8x32(interval(simd, &left, &right, 0), room))
    }
}

impl Compare<9> for Intervals {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 9], right: [u8x32<V>; 9]) -> u8x32<V> {
        colours(
            simd,
            [interval(simd, &left, &right, 0), interval(simd, &left, &right, 3), interval(simd, &left, &right, 6)],
        )
    }
}

/// Bits that differ in the first `B` bytes of two pixels.
#[inline(always)]
fn bits<V: Simd, const B: usize, const P: usize>(simd: V, left: &[u8; P], right: &[u8x32<V>; P]) -> u8x32<V> {
    let mut bits = simd.splat_u8x32(0);
    for p in 0..B {
        bits = simd.add_u8x32(bits, simd.count_ones_u8x32(simd.xor_u8x32(right[p], simd.splat_u8x32(left[p]))));
    }
    bits
}

/// The Hamming distance of census strings.
#[derive(Clone, Copy)]
pub struct Bits;

impl<const P: usize> Compare<P> for Bits {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; P], right: [u8x32<V>; P]) -> u8x32<V> {
        bits::<V, P, P>(simd, &left, &right)
    }
}

/// Twice the Hamming distance of the first `B` bytes, and two absolute differences: at most 255.
#[derive(Clone, Copy)]
pub struct BitsAndGradients<const B: usize>;

impl<const B: usize, const P: usize> Compare<P> for BitsAndGradients<B> {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; P], right: [u8x32<V>; P]) -> u8x32<V> {
        let bits = bits::<V, B, P>(simd, &left, &right);
        let (horizontal, vertical) = (difference(simd, left[B], right[B]), difference(simd, left[B + 1], right[B + 1]));
        simd.add_u8x32(simd.add_u8x32(bits, bits), simd.add_u8x32(horizontal, vertical))
    }
}

/// The Hamming distance of the first `B` bytes and an absolute difference, with a weight in sixteenths each.
#[derive(Clone, Copy)]
pub struct BitsAndValue<const B: usize> {
    pub of_bits: u16,
    pub of_value: u16,
}

impl<const B: usize> BitsAndValue<B> {
    #[inline(always)]
    fn weighted<V: Simd>(self, simd: V, bits: u16x16<V>, value: u16x16<V>) -> u16x16<V> {
        let bits = simd.mul_u16x16(bits, simd.splat_u16x16(self.of_bits));
        let value = simd.mul_u16x16(value, simd.splat_u16x16(self.of_value));
        simd.shr_u16x16(simd.add_u16x16(simd.add_u16x16(bits, value), simd.splat_u16x16(8)), 4)
    }
}

impl<const B: usize, const P: usize> Compare<P> for BitsAndValue<B> {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; P], right: [u8x32<V>; P]) -> u8x32<V> {
        let bits = simd.widen_u8x32(bits::<V, B, P>(simd, &left, &right));
        let value = simd.widen_u8x32(difference(simd, left[B], right[B]));
        let (low, high) = (self.weighted(simd, bits.0, value.0), self.weighted(simd, bits.1, value.1));
        simd.saturating_narrow_u16x16(low, high)
    }
}

/// What a table says of two values, `[left][right]`.
#[derive(Clone, Copy)]
pub struct Table<'a>(pub &'a [u8]);

impl Compare<1> for Table<'_> {
    type Value = u8;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 1], right: [u8x32<V>; 1]) -> u8x32<V> {
        let row = &self.0[usize::from(left[0]) * 256..][..256];
        let right: &[u8; LANES] = &right[0];
        u8x32::simd_from(simd, right.map(|value| row[usize::from(value)]))
    }
}

/// Squared differences.
#[derive(Clone, Copy)]
pub struct Squares;

impl Compare<1> for Squares {
    type Value = u16;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 1], right: [u8x32<V>; 1]) -> [u16x16<V>; 2] {
        let difference = simd.widen_u8x32(difference(simd, left[0], right[0]));
        [simd.mul_u16x16(difference.0, difference.0), simd.mul_u16x16(difference.1, difference.1)]
    }
}

/// Products.
#[derive(Clone, Copy)]
pub struct Products;

impl Compare<1> for Products {
    type Value = u16;

    #[inline(always)]
    fn compare<V: Simd>(self, simd: V, left: [u8; 1], right: [u8x32<V>; 1]) -> [u16x16<V>; 2] {
        let right = simd.widen_u8x32(right[0]);
        let left = simd.splat_u16x16(left[0].into());
        [simd.mul_u16x16(right.0, left), simd.mul_u16x16(right.1, left)]
    }
}
