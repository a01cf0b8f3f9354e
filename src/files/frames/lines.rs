//! Lines of the headers of frames.

use crate::files::error::{Result, bail, ensure};
use std::io::{BufRead, Read as _};

/// The longest line of a header.
const MAX_LINE: u64 = 4096;

/// A line of a header, without its end; `None` at the end of the stream.
pub fn line(source: &mut impl BufRead) -> Result<Option<String>> {
    let mut bytes = Vec::new();
    source.take(MAX_LINE).read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    ensure!(bytes.pop() == Some(b'\n'), "a line of its header has no end; the stream is cut short or damaged");
    let Ok(text) = String::from_utf8(bytes) else { bail!("a line of its header is no text; the stream is damaged") };
    Ok(Some(text))
}
