//! Portable float maps.

use super::samples::{MAX_HEADER, Samples, ensure_length};
use crate::files::error::{Context as _, Result, ensure};

/// `Pf`, width, height and scale as text, then 32-bit floats from the lowest row up, little endian if the scale is
/// negative (netpbm's pfm.html). Middlebury says that the scale's amount is ignored.
pub fn pfm(bytes: &[u8]) -> Result<(u32, u32, Samples)> {
    let mut at = 2;
    let mut words = Vec::new();
    while words.len() < 3 {
        let rest = bytes.get(at..).unwrap_or_default();
        let blank = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let rest = &rest[blank..];
        let is_comment = rest.starts_with(b"#");
        let ends = |b: &u8| if is_comment { *b == b'\n' } else { b.is_ascii_whitespace() };
        let length = rest.iter().position(ends).context("its header has no end; save it again")?;
        ensure!(blank > 0 && at < MAX_HEADER, "its header is not \"Pf\", width, height and scale; save it again");
        if !is_comment {
            words.push(String::from_utf8_lossy(&rest[..length]).into_owned());
        }
        at += blank + length;
    }
    // One white space ends the header, on Windows perhaps two.
    at += if bytes[at..].starts_with(b"\r\n") { 2 } else { 1 };
    let side = |what: &str, word: &str| {
        word.parse::<u32>().ok().filter(|side| *side > 0).with_context(|| {
            format!("its {what} is {word:?}, but must be a whole number from 1 to {}; save it again", u32::MAX)
        })
    };
    let (width, height) = (side("width", &words[0])?, side("height", &words[1])?);
    let scale = words[2].parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0).with_context(|| {
        format!(
            "its scale is {:?}, but must be a number other than 0, negative for little endian; save it again",
            words[2]
        )
    })?;
    let samples = bytes.get(at..).unwrap_or_default();
    ensure_length(width.into(), height.into(), 4, samples.len())?;
    let value = |b: &[u8; 4]| f64::from(if scale < 0.0 { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) });
    let (values, _) = samples.as_chunks::<4>();
    let rows = values.chunks_exact(width as usize).rev();
    Ok((width, height, Samples::Float(rows.flatten().map(value).collect())))
}
