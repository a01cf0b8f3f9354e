//! How much two pixels differ, for [`LANES`] disparities at once: the twins of
//! [`pixel_cost`](crate::reference::pixel_cost).
#![allow(clippy::needless_range_loop)] // loops by index over arrays are what is vectorised

use bytemuck::Pod;

use crate::cpu::LANES;

/// A cost of two pixels, which are `P` bytes each. `left` is one pixel, `right` are the pixels at the disparities.
pub trait Compare<const P: usize>: Copy {
    /// What holds the cost of two pixels.
    type Value: Pod + Into<u32>;

    fn compare(self, left: [u8; P], right: [&[u8; LANES]; P]) -> [Self::Value; LANES];
}

/// `abs_diff` in bytes: that of the standard library is computed in 32 bits.
#[inline(always)]
fn difference(a: u8, b: u8) -> u8 {
    a.max(b) - a.min(b)
}

/// floor((a + b) / 2).
#[inline(always)]
fn mean(a: u8, b: u8) -> u8 {
    (a & b) + ((a ^ b) >> 1)
}

/// One value for three colours.
#[inline(always)]
fn colours(red: u8, green: u8, blue: u8) -> u8 {
    mean(mean(red, blue), green)
}

/// The sum of absolute differences: at most 255.
#[derive(Clone, Copy)]
pub struct Differences;

impl<const P: usize> Compare<P> for Differences {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; P], right: [&[u8; LANES]; P]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            for p in 0..P {
                cost[d] += difference(left[p], right[p][d]);
            }
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
    fn compare(self, left: [u8; 3], right: [&[u8; LANES]; 3]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            let one = |p: usize| difference(left[p], right[p][d]);
            cost[d] = colours(one(0), one(1), one(2));
        }
        cost
    }
}

/// Birchfield and Tomasi, of three bytes a channel: the value, the smallest and the largest around it.
#[derive(Clone, Copy)]
pub struct Intervals;

/// The smaller of the distances of each value from the other one's interval.
#[inline(always)]
fn interval(left: [u8; 3], right: [u8; 3]) -> u8 {
    let outside = |v: u8, low: u8, high: u8| low.saturating_sub(v).max(v.saturating_sub(high));
    outside(left[0], right[1], right[2]).min(outside(right[0], left[1], left[2]))
}

impl Compare<3> for Intervals {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; 3], right: [&[u8; LANES]; 3]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            cost[d] = interval(left, [right[0][d], right[1][d], right[2][d]]);
        }
        cost
    }
}

impl Compare<9> for Intervals {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; 9], right: [&[u8; LANES]; 9]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            let one = |p: usize| {
                interval([left[p], left[p + 1], left[p + 2]], [right[p][d], right[p + 1][d], right[p + 2][d]])
            };
            cost[d] = colours(one(0), one(3), one(6));
        }
        cost
    }
}

/// Bits that differ in the first `B` bytes of two pixels at one disparity.
#[inline(always)]
fn bits<const B: usize, const P: usize>(left: &[u8; P], right: &[&[u8; LANES]; P], d: usize) -> u8 {
    let mut bits = 0;
    for p in 0..B {
        bits += (left[p] ^ right[p][d]).count_ones() as u8;
    }
    bits
}

/// The Hamming distance of census strings.
#[derive(Clone, Copy)]
pub struct Bits;

impl<const P: usize> Compare<P> for Bits {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; P], right: [&[u8; LANES]; P]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            cost[d] = bits::<P, P>(&left, &right, d);
        }
        cost
    }
}

/// Twice the Hamming distance of the first `B` bytes, and two absolute differences: at most 255.
#[derive(Clone, Copy)]
pub struct BitsAndGradients<const B: usize>;

impl<const B: usize, const P: usize> Compare<P> for BitsAndGradients<B> {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; P], right: [&[u8; LANES]; P]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            let gradients = difference(left[B], right[B][d]) + difference(left[B + 1], right[B + 1][d]);
            cost[d] = 2 * bits::<B, P>(&left, &right, d) + gradients;
        }
        cost
    }
}

/// The Hamming distance of the first `B` bytes and an absolute difference, with a weight in sixteenths each.
#[derive(Clone, Copy)]
pub struct BitsAndValue<const B: usize> {
    pub of_bits: u16,
    pub of_value: u16,
}

impl<const B: usize, const P: usize> Compare<P> for BitsAndValue<B> {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; P], right: [&[u8; LANES]; P]) -> [u8; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            let value = u16::from(difference(left[B], right[B][d]));
            let weighted = self.of_value * value + self.of_bits * u16::from(bits::<B, P>(&left, &right, d));
            cost[d] = ((weighted + 8) >> 4).min(255) as u8;
        }
        cost
    }
}

/// What a table says of two values, `[left][right]`.
#[derive(Clone, Copy)]
pub struct Table<'a>(pub &'a [u8]);

impl Compare<1> for Table<'_> {
    type Value = u8;

    #[inline(always)]
    fn compare(self, left: [u8; 1], right: [&[u8; LANES]; 1]) -> [u8; LANES] {
        let row = &self.0[usize::from(left[0]) * 256..][..256];
        right[0].map(|value| row[usize::from(value)])
    }
}

/// Squared differences.
#[derive(Clone, Copy)]
pub struct Squares;

impl Compare<1> for Squares {
    type Value = u16;

    #[inline(always)]
    fn compare(self, left: [u8; 1], right: [&[u8; LANES]; 1]) -> [u16; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            let difference = u16::from(difference(left[0], right[0][d]));
            cost[d] = difference * difference;
        }
        cost
    }
}

/// Products.
#[derive(Clone, Copy)]
pub struct Products;

impl Compare<1> for Products {
    type Value = u16;

    #[inline(always)]
    fn compare(self, left: [u8; 1], right: [&[u8; LANES]; 1]) -> [u16; LANES] {
        let mut cost = [0; LANES];
        for d in 0..LANES {
            cost[d] = u16::from(left[0]) * u16::from(right[0][d]);
        }
        cost
    }
}
