//! Values as JSON: `--json`, the files of a report and the lines of logs.

use super::text::must_be_escaped;
use anyhow::Result;
use serde::{Serialize, Serializer};
use std::fmt::Write as _;
use std::path::PathBuf;

/// A value as one line of JSON, with control characters escaped in JSON's way.
pub fn json(value: &impl Serialize) -> Result<String> {
    Ok(escaped_json(&serde_json::to_string(value)?))
}

/// The same in indented lines.
pub fn pretty_json(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value)?;
    Ok(text.lines().map(escaped_json).collect::<Vec<_>>().join("\n") + "\n")
}

/// Outside its strings JSON has no such characters.
fn escaped_json(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match must_be_escaped(c) {
            true => c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| {
                let _ = write!(escaped, "\\u{unit:04x}"); // a string takes all
            }),
            false => escaped.push(c),
        }
    }
    escaped
}

/// To three decimals: more would be noise.
pub fn rounded(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// Milliseconds to three decimals.
pub fn to_microseconds<S: Serializer>(ms: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(rounded(*ms))
}

/// Paths need not be Unicode, JSON must.
pub fn paths<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_read_as_it_was_and_escapes_control_characters() {
        let names = ["a\u{1b}[2J\n\u{7f}\u{9b}2J", "\u{202e}gnp", "\u{2028}", "\u{e0001}", "Straße \"立体\" \\"];
        for text in [json(&names).unwrap(), pretty_json(&names).unwrap()] {
            assert!(!text.replace('\n', "").contains(must_be_escaped), "{text:?}");
            assert_eq!(serde_json::from_str::<Vec<String>>(&text).unwrap(), names);
        }
    }
}
