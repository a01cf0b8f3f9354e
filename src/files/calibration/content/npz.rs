//! NumPy's archives of arrays, .npz: what `np.savez` writes.

use super::tree::Tree;
use crate::files::error::{Context as _, Result, bail, ensure};
use crate::files::maps::npy::{MAX_BRACKETS, brackets, header_length, transposed};
use crate::files::zip;
use flate2::read::DeflateDecoder;
use std::io::Read as _;

/// The largest array that is read, in bytes; larger ones, such as maps of remap, are skipped.
const MAX_BYTES: u64 = 1 << 16;
/// What an array's header needs at most.
const MAX_HEADER: usize = 1024;

/// Whether a file begins as an archive does.
pub fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
}

/// The arrays of numbers of at most two sides, each with its rows and columns.
pub fn npz(bytes: &[u8]) -> Result<Tree> {
    let mut tree = Tree::new();
    for file in zip::files(bytes)? {
        let name = String::from_utf8_lossy(file.name);
        let Some(name) = name.strip_suffix(".npy") else { continue };
        let mut array = Vec::new();
        match file.method {
            0 => array.extend_from_slice(file.stored),
            8 => {
                let read = DeflateDecoder::new(file.stored).take(MAX_BYTES + 1).read_to_end(&mut array);
                read.with_context(|| format!("its {name} is damaged; save it again by np.savez"))?;
            }
            other => {
                bail!("its {name} is compressed by method {other}, but by deflate is known; save it again by np.savez")
            }
        }
        if array.len() as u64 > MAX_BYTES {
            continue;
        }
        let Some((shape, numbers)) = numbers(&array).with_context(|| format!("its {name}"))? else { continue };
        let mut put = |part: &str, values: Vec<String>| tree.insert(format!("{name}{part}"), values);
        put(".data", numbers.iter().map(|number| format!("{number:?}")).collect());
        if let [rows, cols] = shape[..] {
            put(".rows", vec![rows.to_string()]);
            put(".cols", vec![cols.to_string()]);
        }
    }
    ensure!(
        !tree.is_empty(),
        "it has no array of numbers; save the matrices by np.savez(\"calib.npz\", M1=.., D1=.., ..)"
    );
    Ok(tree)
}

/// The sides and the numbers of an array, row by row; `None` of those that are no matrix of numbers.
fn numbers(bytes: &[u8]) -> Result<Option<(Vec<u64>, Vec<f64>)>> {
    // The library allocates what the header declares.
    let length = Some(bytes).filter(|bytes| bytes.starts_with(b"\x93NUMPY")).and_then(header_length);
    let length = length.context("is no array; save it again by np.savez")?;
    let header =
        bytes.get(10..length).filter(|_| length <= MAX_HEADER).context("has a damaged header; save it again")?;
    if brackets(header) > MAX_BRACKETS {
        return Ok(None);
    }
    let file = npyz::NpyFile::new(bytes).context("has a header that is not NumPy's; save it again")?;
    let shape = file.shape().to_vec();
    let count = shape.iter().try_fold(1u64, |count, side| count.checked_mul(*side));
    let Some(count) = count.filter(|count| shape.len() <= 2 && *count <= MAX_BYTES) else { return Ok(None) };
    let by_columns = file.order() == npyz::Order::Fortran;
    let npyz::DType::Plain(kind) = file.dtype() else { return Ok(None) };
    let kind = kind.to_string();
    let size: u64 = kind.get(2..).and_then(|size| size.parse().ok()).unwrap_or(0);
    ensure!(count * size <= (bytes.len() - length) as u64, "is cut short; save it again");
    fn all<T: npyz::Deserialize>(file: npyz::NpyFile<&[u8]>, number: fn(T) -> f64) -> Result<Vec<f64>> {
        let values = file.into_vec().context("cannot be read; save it again")?;
        Ok(values.into_iter().map(number).collect())
    }
    let numbers = match kind.get(1..).unwrap_or_default() {
        "f8" => all(file, |value: f64| value),
        "f4" => all(file, |value: f32| value.into()),
        "i8" => all(file, |value: i64| value as f64),
        "i4" => all(file, |value: i32| value.into()),
        "u2" => all(file, |value: u16| value.into()),
        "u1" => all(file, |value: u8| value.into()),
        _ => return Ok(None),
    }?;
    let numbers = match shape[..] {
        [rows, cols] if by_columns => transposed(&numbers, [cols as usize, rows as usize]),
        _ => numbers,
    };
    Ok(Some((shape, numbers)))
}
