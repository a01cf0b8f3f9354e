//! Arrays of NumPy.

use super::samples::{MAX_DIGITS, MAX_HEADER, Samples, ensure_length};
use crate::files::error::{Context as _, Result, bail, ensure};

/// NumPy's array of rows and columns, between sides of 1: floats or whole numbers.
pub fn npy(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    // The library allocates as much as the header declares and multiplies the sides, so both are limited before.
    let length = match bytes {
        [_, _, _, _, _, _, 1, _, a, b, ..] => 10 + usize::from(u16::from_le_bytes([*a, *b])),
        [_, _, _, _, _, _, _, _, a, b, c, d, ..] => 12 + u32::from_le_bytes([*a, *b, *c, *d]) as usize,
        _ => bail!("its header is cut short; save it again"),
    };
    let header = bytes.get(..length).filter(|_| length <= MAX_HEADER).with_context(|| {
        format!("its header declares {length} bytes, more than the file or a header of two sides has; save it again")
    })?;
    let digits = header[8..].iter().filter(|b| b.is_ascii_digit()).count();
    ensure!(
        digits <= MAX_DIGITS,
        "its header has {digits} digits, but two sides need fewer; save an array of rows and columns"
    );
    // The library's time doubles with each level of nested brackets.
    let text = &header[if bytes[6] == 1 { 10 } else { 12 }..];
    let brackets = text.iter().filter(|b| b"[({".contains(b)).count();
    ensure!(
        brackets <= 2,
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
            Samples::Float(values) => *values = transposed(values, sides),
            Samples::Whole { values, .. } => *values = transposed(values, sides),
        }
    }
    Ok((sides.0, sides.1, samples))
}

/// Samples that are stored column by column, reordered row by row.
fn transposed<T: Copy>(values: &[T], (width, height): (u32, u32)) -> Vec<T> {
    let (width, height) = (width as usize, height as usize);
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
    let (values, _) = bytes.as_chunks::<2>();
    values.iter().map(|b| half(if big_endian { u16::from_be_bytes(*b) } else { u16::from_le_bytes(*b) })).collect()
}

/// A float of 16 bits: a sign, an exponent of 5 bits and a fraction of 10.
pub(super) fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let amount = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -amount } else { amount }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_those_of_ieee_754() {
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
