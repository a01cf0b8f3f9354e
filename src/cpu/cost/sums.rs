//! Sums of pixel costs over blocks, [`LANES`] disparities at once.

use bytemuck::Pod;
use fearless_simd::{Simd, SimdFrom, u8x32, u16x16, u32x8};

use crate::cpu::LANES;

/// The cost of a pixel: a byte, or a product of 16 bits.
pub trait Value: Pod {
    /// [`LANES`] of them.
    type Vector<V: Simd>: Copy;

    fn store<V: Simd>(vector: Self::Vector<V>, to: &mut [Self; LANES]);
    fn load<V: Simd>(simd: V, from: &[Self; LANES]) -> Self::Vector<V>;
    fn words<V: Simd>(simd: V, vector: Self::Vector<V>) -> [u16x16<V>; 2];
}

impl Value for u8 {
    type Vector<V: Simd> = u8x32<V>;

    #[inline(always)]
    fn store<V: Simd>(vector: u8x32<V>, to: &mut [u8; LANES]) {
        *to = *vector;
    }

    #[inline(always)]
    fn load<V: Simd>(simd: V, from: &[u8; LANES]) -> u8x32<V> {
        u8x32::simd_from(simd, *from)
    }

    #[inline(always)]
    fn words<V: Simd>(simd: V, vector: u8x32<V>) -> [u16x16<V>; 2] {
        let (low, high) = simd.widen_u8x32(vector);
        [low, high]
    }
}

impl Value for u16 {
    type Vector<V: Simd> = [u16x16<V>; 2];

    #[inline(always)]
    fn store<V: Simd>(vector: [u16x16<V>; 2], to: &mut [u16; LANES]) {
        for (to, vector) in to.as_chunks_mut::<16>().0.iter_mut().zip(vector) {
            *to = *vector;
        }
    }

    #[inline(always)]
    fn load<V: Simd>(simd: V, from: &[u16; LANES]) -> [u16x16<V>; 2] {
        let mut vectors = [simd.splat_u16x16(0); 2];
        for (vector, from) in vectors.iter_mut().zip(from.as_chunks::<16>().0) {
            *vector = u16x16::simd_from(simd, *from);
        }
        vectors
    }

    #[inline(always)]
    fn words<V: Simd>(_: V, vector: [u16x16<V>; 2]) -> [u16x16<V>; 2] {
        vector
    }
}

/// A number that sums are kept in. Sums are exact modulo its range.
pub trait Sum: Pod {
    /// [`LANES`] of them.
    type Vector<V: Simd>: Copy;

    fn splat<V: Simd>(simd: V, value: Self) -> Self::Vector<V>;
    fn load<V: Simd>(simd: V, from: &[Self; LANES]) -> Self::Vector<V>;
    fn store<V: Simd>(vector: Self::Vector<V>, to: &mut [Self; LANES]);
    fn plus<V: Simd>(simd: V, a: Self::Vector<V>, b: Self::Vector<V>) -> Self::Vector<V>;
    fn minus<V: Simd>(simd: V, a: Self::Vector<V>, b: Self::Vector<V>) -> Self::Vector<V>;
    /// Values times `factor`.
    fn of<V: Simd>(simd: V, values: [u16x16<V>; 2], factor: Self) -> Self::Vector<V>;
    /// Values less other ones, times `factor`.
    fn change<V: Simd>(simd: V, new: [u16x16<V>; 2], old: [u16x16<V>; 2], factor: Self) -> Self::Vector<V>;
}

impl Sum for u16 {
    type Vector<V: Simd> = [u16x16<V>; 2];

    #[inline(always)]
    fn splat<V: Simd>(simd: V, value: u16) -> [u16x16<V>; 2] {
        [simd.splat_u16x16(value); 2]
    }

    #[inline(always)]
    fn load<V: Simd>(simd: V, from: &[u16; LANES]) -> [u16x16<V>; 2] {
        <u16 as Value>::load(simd, from)
    }

    #[inline(always)]
    fn store<V: Simd>(vector: [u16x16<V>; 2], to: &mut [u16; LANES]) {
        <u16 as Value>::store(vector, to);
    }

    #[inline(always)]
    fn plus<V: Simd>(simd: V, a: [u16x16<V>; 2], b: [u16x16<V>; 2]) -> [u16x16<V>; 2] {
        [simd.add_u16x16(a[0], b[0]), simd.add_u16x16(a[1], b[1])]
    }

    #[inline(always)]
    fn minus<V: Simd>(simd: V, a: [u16x16<V>; 2], b: [u16x16<V>; 2]) -> [u16x16<V>; 2] {
        [simd.sub_u16x16(a[0], b[0]), simd.sub_u16x16(a[1], b[1])]
    }

    #[inline(always)]
    fn of<V: Simd>(simd: V, values: [u16x16<V>; 2], factor: u16) -> [u16x16<V>; 2] {
        let factor = simd.splat_u16x16(factor);
        [simd.mul_u16x16(values[0], factor), simd.mul_u16x16(values[1], factor)]
    }

    #[inline(always)]
    fn change<V: Simd>(simd: V, new: [u16x16<V>; 2], old: [u16x16<V>; 2], factor: u16) -> [u16x16<V>; 2] {
        Self::of(simd, Self::minus(simd, new, old), factor)
    }
}

impl Sum for u32 {
    type Vector<V: Simd> = [u32x8<V>; 4];

    #[inline(always)]
    fn splat<V: Simd>(simd: V, value: u32) -> [u32x8<V>; 4] {
        [simd.splat_u32x8(value); 4]
    }

    #[inline(always)]
    fn load<V: Simd>(simd: V, from: &[u32; LANES]) -> [u32x8<V>; 4] {
        let mut vectors = [simd.splat_u32x8(0); 4];
        for (vector, from) in vectors.iter_mut().zip(from.as_chunks::<8>().0) {
            *vector = u32x8::simd_from(simd, *from);
        }
        vectors
    }

    #[inline(always)]
    fn store<V: Simd>(vector: [u32x8<V>; 4], to: &mut [u32; LANES]) {
        for (to, vector) in to.as_chunks_mut::<8>().0.iter_mut().zip(vector) {
            *to = *vector;
        }
    }

    #[inline(always)]
    fn plus<V: Simd>(simd: V, a: [u32x8<V>; 4], b: [u32x8<V>; 4]) -> [u32x8<V>; 4] {
        [simd.add_u32x8(a[0], b[0]), simd.add_u32x8(a[1], b[1]), simd.add_u32x8(a[2], b[2]), simd.add_u32x8(a[3], b[3])]
    }

    #[inline(always)]
    fn minus<V: Simd>(simd: V, a: [u32x8<V>; 4], b: [u32x8<V>; 4]) -> [u32x8<V>; 4] {
        [simd.sub_u32x8(a[0], b[0]), simd.sub_u32x8(a[1], b[1]), simd.sub_u32x8(a[2], b[2]), simd.sub_u32x8(a[3], b[3])]
    }

    #[inline(always)]
    fn of<V: Simd>(simd: V, values: [u16x16<V>; 2], _: u32) -> [u32x8<V>; 4] {
        let ((a, b), (c, d)) = (simd.widen_u16x16(values[0]), simd.widen_u16x16(values[1]));
        [a, b, c, d]
    }

    #[inline(always)]
    fn change<V: Simd>(simd: V, new: [u16x16<V>; 2], old: [u16x16<V>; 2], factor: u32) -> [u32x8<V>; 4] {
        Self::minus(simd, Self::of(simd, new, factor), Self::of(simd, old, factor))
    }
}

/// What becomes of sums. They are sums of values times a factor, plus a bias.
pub trait Finish<S: Sum>: Copy {
    type Out: Pod;

    /// `beyond` is 255 in the lanes that are no disparities, which become the largest number, and 0 in the others.
    fn finish<V: Simd>(self, simd: V, sums: S::Vector<V>, beyond: u8x32<V>, to: &mut [Self::Out; LANES]);
}

/// 255 from lane `lanes` on, else 0.
#[inline(always)]
pub fn beyond<V: Simd>(simd: V, lanes: usize) -> u8x32<V> {
    let mut beyond = [0; LANES];
    beyond[lanes.min(LANES)..].fill(u8::MAX);
    u8x32::simd_from(simd, beyond)
}
