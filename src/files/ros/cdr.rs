//! CDR, the encoding of ROS 2: four bytes that tell the order of bytes, then numbers aligned to their size.

use super::header::Header;
use crate::files::error::{Context as _, Result, bail, ensure};

/// Reads a message from its start.
pub struct Reader<'a> {
    /// Without the first four bytes, from which alignment counts.
    bytes: &'a [u8],
    at: usize,
    big: bool,
}

impl<'a> Reader<'a> {
    pub fn new(message: &'a [u8]) -> Result<Self> {
        let Some((&[0, order, _, _], bytes)) = message.split_first_chunk::<4>() else {
            bail!("a message does not begin as CDR does; was it cut short?")
        };
        ensure!(order <= 1, "a message is in the representation {order} of CDR, but plain CDR (0 or 1) is read");
        Ok(Self { bytes, at: 0, big: order == 0 })
    }

    /// So many bytes.
    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8]> {
        let end = self.at.checked_add(count);
        let found = end.and_then(|end| self.bytes.get(self.at..end));
        let found =
            found.with_context(|| format!("a message ends after {} bytes, within a field", self.bytes.len()))?;
        self.at += count;
        Ok(found)
    }

    /// A number of `N` bytes, the lowest byte first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N]> {
        self.at = self.at.next_multiple_of(N);
        let found = self.bytes(N)?;
        let mut digits = [0; N];
        digits.copy_from_slice(found);
        if self.big {
            digits.reverse();
        }
        Ok(digits)
    }

    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.number::<1>()?[0])
    }

    pub fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.number()?))
    }

    pub fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.number()?))
    }

    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N]> {
        let mut all = [0.0; N];
        for value in &mut all {
            *value = self.f64()?;
        }
        Ok(all)
    }

    /// A sequence of bytes.
    pub fn blob(&mut self) -> Result<&'a [u8]> {
        let count = self.u32()? as usize;
        self.bytes(count)
    }

    /// A text, whose length counts the zero at its end.
    pub fn text(&mut self) -> Result<String> {
        let bytes = self.blob()?;
        Ok(String::from_utf8_lossy(bytes.strip_suffix(&[0]).unwrap_or(bytes)).into_owned())
    }

    pub fn header(&mut self) -> Result<Header> {
        let stamp = (self.u32()?.cast_signed(), self.u32()?);
        Ok(Header { stamp, frame: self.text()? })
    }
}

/// Writes a message, the lowest byte of each number first.
pub struct Writer(Vec<u8>);

impl Writer {
    pub fn new(header: &Header) -> Self {
        let mut writer = Self(vec![0, 1, 0, 0]);
        writer.header(header);
        writer
    }

    pub fn header(&mut self, header: &Header) {
        self.u32(header.stamp.0.cast_unsigned());
        self.u32(header.stamp.1);
        self.text(&header.frame);
    }

    fn number<const N: usize>(&mut self, digits: [u8; N]) {
        while !(self.0.len() - 4).is_multiple_of(N) {
            self.0.push(0);
        }
        self.0.extend(digits);
    }

    pub fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    pub fn u32(&mut self, value: u32) {
        self.number(value.to_le_bytes());
    }

    pub fn f32(&mut self, value: f32) {
        self.number(value.to_le_bytes());
    }

    pub fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// A sequence of bytes, of which there are `count`.
    pub fn blob(&mut self, count: usize, bytes: impl IntoIterator<Item = u8>) {
        self.u32(count as u32);
        self.0.reserve(count);
        self.0.extend(bytes);
    }

    pub fn finish(self) -> Vec<u8> {
        self.0
    }
}
