//! Arrays of NumPy.

use super::samples::{MAX_DIGITS, MAX_HEADER, Samples, ensure_length};
use crate::files::error::{Context as _, Result, bail, ensure};
use half::f16;

/// NumPy's array of rows and columns, between sides of 1: floats or whole numbers.
pub fn npy(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    // The library allocates as much as the header declares and multiplies the sides, so both are limited before.
    let Some(length) = header_length(bytes) else { bail!("its header is cut short; save it again") };
    let header = bytes.get(..length).filter(|_| length <= MAX_HEADER).with_context(|| {
        format!("its header declares {length} bytes, more than the file or a header of two sides has; save it again")
    })?;
    let digits = header[8..].iter().filter(|b| b.is_ascii_digit()).count();
    ensure!(
        digits <= MAX_DIGITS,
        "its header has {digits} digits, but two sides need fewer; save an array of rows and columns"
    );
    let brackets = brackets(&header[if bytes[6] == 1 { 10 } else { 12 }..]);
    ensure!(
        brackets <= MAX_BRACKETS,
        "its header opens {brackets} brackets, as for an array of records, but at most 2 are allowed; save one field as numbers"
    );
    let file = npyz::NpyFile::new(bytes).context("its header is not NumPy's; save it again")?;
    let [height, width] = rows_and_columns(file.shape())[..] else {
        bail!(
            "its shape is {:?}, but rows and columns are needed, others of length 1 at most; save one channel",
            file.shape()
        );
    };
    let npyz::DType::Plain(kind) = file.dtype() else {
        bail!("it is an array of records, but numbers are needed; save one field");
    };
    let kind = kind.to_string();
    let by_columns = file.order() == npyz::Order::Fortran;
    let each = kind.get(2..).and_then(|size| size.parse().ok()).unwrap_or(0);
    let sides = ensure_length(width, height, each, bytes.len() - length)?;
    fn all<T: npyz::Deserialize>(file: npyz::NpyFile<&[u8]>) -> Result<Vec<T>> {
        file.into_vec().context("its samples cannot be read; save it again")
    }
    let all_whole = |values: Vec<i64>| Samples::whole(values);
    let mut samples = match kind.get(1..).unwrap_or_default() {
        "f2" => Samples::Float(halves(&bytes[length..], kind.starts_with('>'))),
        "f4" => Samples::Float(all::<f32>(file)?.into_iter().map(f64::from).collect()),
        "f8" => Samples::Float(all(file)?),
        "u1" => all_whole(widened(all::<u8>(file)?)),
        "u2" => all_whole(widened(all::<u16>(file)?)),
        "u4" => all_whole(widened(all::<u32>(file)?)),
        "i1" => all_whole(widened(all::<i8>(file)?)),
        "i2" => Samples::signed16(widened(all::<i16>(file)?)),
        "i4" => all_whole(widened(all::<i32>(file)?)),
        "i8" => all_whole(all(file)?),
        "u8" => all_whole(all::<u64>(file)?.into_iter().map(|v| i64::try_from(v).unwrap_or(i64::MAX)).collect()),
        _ => bail!("its type is {kind:?}, but f2, f4, f8 or whole numbers are needed; save it with astype(\"f4\")"),
    };
    if by_columns {
        match &mut samples {
            Samples::Float(values) => *values = transposed(values, [width as usize, height as usize]),
            Samples::Whole { values, .. } => *values = transposed(values, [width as usize, height as usize]),
        }
    }
    Ok((sides.0, sides.1, samples))
}

/// Where the samples of an array begin, by its header; nothing if that is cut short.
pub fn header_length(bytes: &[u8]) -> Option<usize> {
    match bytes {
        [_, _, _, _, _, _, 1, _, a, b, ..] => Some(10 + usize::from(u16::from_le_bytes([*a, *b]))),
        [_, _, _, _, _, _, _, _, a, b, c, d, ..] => Some(12 + u32::from_le_bytes([*a, *b, *c, *d]) as usize),
        _ => None,
    }
}

/// The most brackets that a header may open: the library's time doubles with each level of nested ones.
pub const MAX_BRACKETS: usize = 2;

/// The brackets that a header opens.
pub fn brackets(header: &[u8]) -> usize {
    header.iter().filter(|b| b"[({".contains(b)).count()
}

/// Samples that are stored column by column, reordered row by row.
pub fn transposed<T: Copy>(values: &[T], [width, height]: [usize; 2]) -> Vec<T> {
    (0..width * height).map(|i| values[i % width * height + i / width]).collect()
}

/// The shape without leading sides of 1, then without those at the end, as far as more than two sides are left.
fn rows_and_columns(shape: &[u64]) -> &[u64] {
    let mut shape = shape;
    while let ([1, rest @ ..], 3..) = (shape, shape.len()) {
        shape = rest;
    }
    while let ([rest @ .., 1], 3..) = (shape, shape.len()) {
        shape = rest;
    }
    shape
}

fn widened<T: Into<i64>>(values: Vec<T>) -> Vec<i64> {
    values.into_iter().map(Into::into).collect()
}

/// Floats of 16 bits, which the library does not read.
fn halves(bytes: &[u8], big_endian: bool) -> Vec<f64> {
    let half = if big_endian { f16::from_be_bytes } else { f16::from_le_bytes };
    bytes.as_chunks::<2>().0.iter().map(|b| half(*b).to_f64()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_those_of_ieee_754() {
        let half = |bits: u16| {
            let [little, big] = [halves(&bits.to_le_bytes(), false), halves(&bits.to_be_bytes(), true)];
            assert!(little[0].to_bits() == big[0].to_bits(), "{bits:x}");
            little[0]
        };
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 5.960_464_477_539_063e-8),
            (0x4900, 10.0),
            (0, 0.0),
        ] {
            assert_eq!(half(bits), value, "{bits:x}");
        }
        assert!(half(0x7c00) == f64::INFINITY && half(0xfc00) == f64::NEG_INFINITY && half(0x7e00).is_nan());
    }

    #[test]
    fn sides_of_1_are_left_out() {
        for (shape, expected) in [
            (&[1, 1, 4, 5][..], &[4, 5][..]),
            (&[1, 4, 5], &[4, 5]),
            (&[4, 5, 1], &[4, 5]),
            (&[4, 5], &[4, 5]),
            (&[1, 5], &[1, 5]),
            (&[1, 1, 1], &[1, 1]),
            (&[2, 4, 5], &[2, 4, 5]),
            (&[7], &[7]),
        ] {
            assert_eq!(rows_and_columns(shape), expected, "{shape:?}");
        }
    }
}
