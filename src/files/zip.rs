//! The files of a ZIP archive, as PyTorch and NumPy write them.

use crate::files::error::{Context as _, Result, bail};

/// The end of an archive: a record of at least this length, and a comment of at most 65535 bytes.
const END: usize = 22;
/// A field of 32 bits that does not hold its value has this one; then an extra field of 64 bits does.
const ELSEWHERE: u64 = u32::MAX as u64;

/// The number of `N` bytes at `at`, little endian.
fn number<const N: usize>(bytes: &[u8], at: usize) -> Option<u64> {
    let field = bytes.get(at..at.checked_add(N)?)?;
    Some(field.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
}

/// As [`number`], as a place in the file.
fn place<const N: usize>(bytes: &[u8], at: usize) -> Option<usize> {
    usize::try_from(number::<N>(bytes, at)?).ok()
}

/// A file of an archive.
pub(super) struct Packed<'a> {
    pub name: &'a [u8],
    /// How it is compressed: 0 not at all, 8 by deflate.
    pub method: u64,
    /// Its bytes in the archive.
    pub stored: &'a [u8],
}

/// Every file.
pub(super) fn files(bytes: &[u8]) -> Result<Vec<Packed<'_>>> {
    let (mut at, count) = directory(bytes).context("its end is missing; it is cut short: save or download it again")?;
    let mut files = Vec::new();
    for _ in 0..count {
        let entry = Entry::read(bytes, at).context("its list of files is damaged; save or download it again")?;
        let stored = entry.contents(bytes).context("a file of it is cut short; save or download it again")?;
        files.push(Packed { name: entry.name, method: entry.method, stored });
        at = entry.next;
    }
    if files.is_empty() {
        bail!("it is an archive without files; save it again");
    }
    Ok(files)
}

/// Where the list of files begins, and how many it has.
fn directory(bytes: &[u8]) -> Option<(usize, u64)> {
    let first = bytes.len().checked_sub(END)?;
    let end = (first.saturating_sub(usize::from(u16::MAX))..=first)
        .rev()
        .find(|&at| bytes[at..].starts_with(b"PK\x05\x06"))?;
    let short = (place::<4>(bytes, end + 16)?, number::<2>(bytes, end + 10)?);
    let locator = end.checked_sub(20).filter(|&at| bytes[at..].starts_with(b"PK\x06\x07"));
    let Some(locator) = locator else { return Some(short) };
    let end = place::<8>(bytes, locator + 8)?;
    let is_one = bytes.get(end..)?.starts_with(b"PK\x06\x06");
    if is_one {
        Some((place::<8>(bytes, end.checked_add(48)?)?, number::<8>(bytes, end.checked_add(32)?)?))
    } else {
        None
    }
}

/// A row of the list of files.
struct Entry<'a> {
    method: u64,
    name: &'a [u8],
    length: usize,
    header: usize,
    next: usize,
}

impl<'a> Entry<'a> {
    fn read(bytes: &'a [u8], at: usize) -> Option<Self> {
        let row = bytes.get(at..)?;
        if !row.starts_with(b"PK\x01\x02") {
            return None;
        }
        let [name, extra, comment] = [28, 30, 32].map(|field| place::<2>(row, field));
        let (name, extra, comment) = (46..46 + name?, extra?, comment?);
        let fields = name.end..name.end + extra;
        // Those of 64 bits that stand elsewhere, in this order.
        let mut values = [24, 20, 42].map(|field| number::<4>(row, field));
        let mut wide = extra_field(row.get(fields.clone())?, 1).unwrap_or_default();
        for value in values.iter_mut().flatten().filter(|value| **value == ELSEWHERE) {
            *value = number::<8>(wide, 0)?;
            wide = &wide[8..];
        }
        let [length, stored, header] = values.map(|value| usize::try_from(value?).ok());
        let method = number::<2>(row, 10)?;
        if method == 0 && length != stored {
            return None;
        }
        let next = at + fields.end + comment;
        Some(Self { method, name: row.get(name)?, length: stored?, header: header?, next })
    }

    fn contents(&self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let local = bytes.get(self.header..)?;
        if !local.starts_with(b"PK\x03\x04") {
            return None;
        }
        let start = 30 + place::<2>(local, 26)? + place::<2>(local, 28)?;
        local.get(start..start.checked_add(self.length)?)
    }
}

/// The contents of the extra field with this number.
fn extra_field(mut fields: &[u8], wanted: u64) -> Option<&[u8]> {
    loop {
        let (kind, length) = (number::<2>(fields, 0)?, place::<2>(fields, 2)?);
        let contents = fields.get(4..4 + length)?;
        if kind == wanted {
            return Some(contents);
        }
        fields = &fields[4 + length..];
    }
}
