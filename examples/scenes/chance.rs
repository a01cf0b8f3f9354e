//! Random numbers that are the same everywhere: SplitMix64 in integers.

use std::array::from_fn;

use crate::caster::{V, add, dot, unit};

/// A sequence of random numbers.
pub struct Chance(u64);

impl Chance {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        let mut chance = Self(seed.wrapping_mul(0xd134_2543_de82_ef95));
        chance.bits(); // neighbouring seeds part here
        chance
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Evenly from `low` up to `high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// From `low` up to `high`, small values more often: the square of an even one between the roots.
    pub fn skewed(&mut self, low: f64, high: f64) -> f64 {
        let t = self.within(0.0, 1.0);
        low + (high - low) * t * t
    }

    /// 0 to n - 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// True in `share` of the cases.
    pub fn happens(&mut self, share: f64) -> bool {
        self.within(0.0, 1.0) < share
    }

    /// A point of the box between two corners.
    pub fn point(&mut self, low: V, high: V) -> V {
        from_fn(|i| self.within(low[i], high[i]))
    }

    /// Any direction.
    pub fn direction(&mut self) -> V {
        loop {
            let v = self.point([-1.0; 3], [1.0; 3]);
            if (0.01..=1.0).contains(&dot(v, v)) {
                return unit(v);
            }
        }
    }

    /// Three directions at right angles, the first of which is near `towards`, nearer with a smaller `tilt`.
    pub fn frame(&mut self, towards: V, tilt: f64) -> [V; 3] {
        let first = unit(add(towards, self.direction(), tilt));
        let other = self.direction();
        let second = unit(add(other, first, -dot(other, first)));
        [first, second, cross(first, second)]
    }
}

/// The vector product.
pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
