//! The numbers of a tensor: types, strides and what they become as 32-bit floats.

use crate::files::error::{Context as _, Result, ensure};
use crate::network::Tensor;
use half::f16;
use std::fmt;

/// The most dimensions of a tensor.
const MAX_DIMENSIONS: usize = 16;

/// The type of a tensor's numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Element {
    /// 64-bit floats.
    F64,
    /// 32-bit floats.
    F32,
    /// 16-bit floats of IEEE 754.
    F16,
    /// The upper half of 32-bit floats.
    Bf16,
    /// 64-bit whole numbers.
    I64,
    /// 32-bit whole numbers.
    I32,
    /// 16-bit whole numbers.
    I16,
    /// 8-bit whole numbers.
    I8,
    /// 8-bit whole numbers without a sign.
    U8,
    /// Bytes that are 0 or 1.
    Bool,
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Bf16 => "bf16",
            Self::I64 => "i64",
            Self::I32 => "i32",
            Self::I16 => "i16",
            Self::I8 => "i8",
            Self::U8 => "u8",
            Self::Bool => "bool",
        })
    }
}

impl Element {
    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::F64 | Self::I64 => 8,
            Self::F32 | Self::I32 => 4,
            Self::F16 | Self::Bf16 | Self::I16 => 2,
            Self::I8 | Self::U8 | Self::Bool => 1,
        }
    }

    /// All numbers of `bytes`, little endian, the nearest f32 of each.
    fn values(self, bytes: &[u8]) -> Vec<f32> {
        let two = |value: fn([u8; 2]) -> f32| bytes.as_chunks::<2>().0.iter().map(|b| value(*b)).collect();
        let four = |value: fn([u8; 4]) -> f32| bytes.as_chunks::<4>().0.iter().map(|b| value(*b)).collect();
        let eight = |value: fn([u8; 8]) -> f32| bytes.as_chunks::<8>().0.iter().map(|b| value(*b)).collect();
        match self {
            Self::F64 => eight(|b| f64::from_le_bytes(b) as f32),
            Self::F32 => four(f32::from_le_bytes),
            Self::F16 => two(|b| f16::from_le_bytes(b).to_f32()),
            Self::Bf16 => two(|b| f32::from_bits(u32::from(u16::from_le_bytes(b)) << 16)),
            Self::I64 => eight(|b| i64::from_le_bytes(b) as f32),
            Self::I32 => four(|b| i32::from_le_bytes(b) as f32),
            Self::I16 => two(|b| i16::from_le_bytes(b).into()),
            Self::I8 => bytes.iter().map(|&b| f32::from(b as i8)).collect(),
            Self::U8 | Self::Bool => bytes.iter().map(|&b| f32::from(b)).collect(),
        }
    }
}

/// How many values may still be read. A small file can declare many: views may share a storage, and a stride may be 0.
pub(super) struct Budget(usize);

impl Budget {
    /// As many values as the file has bytes, which only views of shared storages could exceed.
    pub fn of(file: &[u8]) -> Self {
        Self(file.len())
    }

    /// The number of values of a shape, taken from the budget.
    pub fn take(&mut self, shape: &[usize]) -> Result<usize> {
        ensure!(
            shape.len() <= MAX_DIMENSIONS,
            "it has {} dimensions, but at most {MAX_DIMENSIONS} are read; save weights of PSMNet",
            shape.len()
        );
        let count = if shape.contains(&0) { Some(0) } else { product(shape) };
        let left = count.and_then(|count| self.0.checked_sub(count)).with_context(|| {
            format!("with its shape {shape:?} the tensors have more values than the file has bytes; save it again")
        })?;
        let count = self.0 - left;
        self.0 = left;
        Ok(count)
    }
}

fn product(shape: &[usize]) -> Option<usize> {
    shape.iter().try_fold(1_usize, |product, &side| product.checked_mul(side))
}

/// A view of a storage: value (i, j, ..) is number `offset` + i `strides`\[0\] + j `strides`\[1\] + .. of it.
pub(super) struct View<'a> {
    /// The type of the storage.
    pub element: Element,
    /// All of the storage.
    pub storage: &'a [u8],
    /// The first number of the view.
    pub offset: usize,
    /// Values along each dimension.
    pub shape: &'a [usize],
    /// Numbers from one value to the next along each dimension.
    pub strides: &'a [usize],
}

impl View<'_> {
    /// The values, the last index fastest.
    pub fn values(&self, budget: &mut Budget) -> Result<Vec<f32>> {
        let Self { element, storage, offset, shape, strides } = *self;
        ensure!(
            shape.len() == strides.len(),
            "it has {} sides, but {} strides; save it again",
            shape.len(),
            strides.len()
        );
        let count = budget.take(shape)?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let last = shape.iter().zip(strides).try_fold(offset, |at, (side, stride)| {
            at.checked_add((side - 1).checked_mul(*stride)?) // no side is 0
        });
        let there = storage.len() / element.size();
        let last = last.filter(|&last| last < there).with_context(|| {
            format!("with shape {shape:?} and strides {strides:?} it ends behind its storage of {there} values; save it again")
        })?;
        let numbers = element.values(&storage[offset * element.size()..(last + 1) * element.size()]);
        if numbers.len() == count && contiguous(shape, strides) {
            return Ok(numbers);
        }
        let mut values = Vec::with_capacity(count);
        let mut index = vec![0; shape.len()];
        let mut at = 0;
        for _ in 0..count {
            values.push(numbers[at]);
            for (axis, place) in index.iter_mut().enumerate().rev() {
                *place += 1;
                at += strides[axis];
                if *place < shape[axis] {
                    break;
                }
                at -= *place * strides[axis];
                *place = 0;
            }
        }
        Ok(values)
    }
}

/// Whether values lie one after the other. The stride of a side of 1 is of no importance.
fn contiguous(shape: &[usize], strides: &[usize]) -> bool {
    let mut each = 1;
    shape.iter().zip(strides).rev().all(|(&side, &stride)| {
        let fits = side == 1 || stride == each;
        each *= side;
        fits
    })
}

/// A tensor as it was read.
pub(super) struct Found {
    pub element: Element,
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
}

/// The same with its name.
pub(super) struct Given {
    pub name: String,
    pub element: Element,
    pub tensor: Tensor,
}

impl Given {
    /// Of what was read; an error tells the name.
    pub fn new(name: &str, found: Result<Found>) -> Result<Self> {
        let Found { element, shape, values } = found.with_context(|| format!("tensor {}", shown(name)))?;
        Ok(Self { name: name.into(), element, tensor: Tensor::new(shape, values)? })
    }
}

/// A name as an error shows it.
pub(super) fn shown(name: &str) -> String {
    let start: String = name.chars().take(80).collect();
    format!("{start:?}{}", if start.len() < name.len() { ".." } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_type_become_floats() {
        let half = |bits: u16| Element::F16.values(&bits.to_le_bytes())[0];
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 5.960_464_5e-8),
            (0x03ff, 6.097_555e-5),
            (0x0400, 6.103_515_6e-5),
            (0x8000, -0.0),
            (0xfc00, f32::NEG_INFINITY),
        ] {
            assert_eq!(half(bits).to_bits(), f32::to_bits(value), "{bits:x}");
        }
        assert!(half(0x7e00).is_nan());
        assert_eq!(Element::Bf16.values(&[0x80, 0x3f, 0x20, 0xc0]), [1.0, -2.5]);
        assert_eq!(Element::F64.values(&0.1_f64.to_le_bytes()), [0.1]);
        assert_eq!(Element::I64.values(&(-3_i64).to_le_bytes()), [-3.0]);
        assert_eq!(Element::I32.values(&70_000_i32.to_le_bytes()), [70_000.0]);
        assert_eq!(Element::I16.values(&(-2_i16).to_le_bytes()), [-2.0]);
        assert_eq!((Element::I8.values(&[255]), Element::U8.values(&[255])), (vec![-1.0], vec![255.0]));
    }

    #[test]
    fn strides_and_offsets_are_honoured() {
        let storage: Vec<u8> = (0..24).collect();
        let values = |offset: usize, shape: &[usize], strides: &[usize]| {
            View { element: Element::U8, storage: &storage, offset, shape, strides }.values(&mut Budget(100))
        };
        assert_eq!(values(2, &[2, 3], &[3, 1]).unwrap(), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!(values(1, &[2, 3], &[1, 4]).unwrap(), [1.0, 5.0, 9.0, 2.0, 6.0, 10.0], "transposed");
        assert_eq!(values(5, &[1, 4], &[99, 0]).unwrap(), [5.0; 4], "expanded");
        assert_eq!(values(23, &[], &[]).unwrap(), [23.0]);
        assert!(values(24, &[0, 5], &[5, 1]).unwrap().is_empty());
        for (offset, shape, strides) in [
            (24, &[][..], &[][..]),
            (23, &[2], &[1]),
            (0, &[2], &[usize::MAX]),
            (usize::MAX, &[2], &[1]),
            (0, &[usize::MAX, 2], &[0, 0]),
            (0, &[101], &[0]),
            (0, &[2, 2], &[1]),
            (0, &[1; 17], &[1; 17]),
        ] {
            assert!(values(offset, shape, strides).is_err(), "{offset} {shape:?} {strides:?}");
        }
    }
}
