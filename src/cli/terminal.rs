//! Terminal: all that the command prints. Data goes to stdout, messages go to stderr, and nothing that a terminal would obey
//! passes: not from the name of a file or of an adapter, not from the text of a file, not from a library's words.

mod text;

use anyhow::{Context as _, Result};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};
pub use text::{is_obeyed, name, one_line, plain};

/// A message on stderr, in one line. That stderr is closed is no reason to stop.
pub fn tell(message: &str) {
    let _ = writeln!(std::io::stderr(), "{}", one_line(message));
}

/// Prints text of whole lines on stdout. A reader that has seen enough, such as `head`, is no error.
pub fn print(text: &str) -> Result<()> {
    let shown: String = text.split_inclusive('\n').map(line).collect();
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(shown.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("stdout cannot be written; give it a file or a pipe with room")
        }
        _ => Ok(()),
    }
}

/// A line with its end, if it has one.
fn line(text: &str) -> String {
    match text.strip_suffix('\n') {
        Some(text) => plain(text) + "\n",
        None => plain(text),
    }
}

/// Prints a value as one line of JSON on stdout.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    print(&(json(value)? + "\n"))
}

/// A value as one line of JSON, in which strings escape what a terminal would obey, as JSON escapes it.
pub fn json(value: &impl Serialize) -> Result<String> {
    Ok(escaped_json(&serde_json::to_string(value)?))
}

/// The same in lines that people read.
pub fn pretty_json(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value)?;
    Ok(text.lines().map(escaped_json).collect::<Vec<_>>().join("\n") + "\n")
}

/// Outside its strings JSON has no such characters.
fn escaped_json(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match is_obeyed(c) {
            true => c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| {
                let _ = write!(escaped, "\\u{unit:04x}"); // a string takes all
            }),
            false => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_read_as_it_was_and_obeyed_by_no_terminal() {
        let names = ["a\u{1b}[2J\n\u{7f}\u{9b}2J", "\u{202e}gnp", "\u{2028}", "\u{e0001}", "Straße \"立体\" \\"];
        for text in [json(&names).unwrap(), pretty_json(&names).unwrap()] {
            assert!(!text.replace('\n', "").contains(is_obeyed), "{text:?}");
            assert_eq!(serde_json::from_str::<Vec<String>>(&text).unwrap(), names);
        }
    }

    #[test]
    fn printed_text_keeps_its_lines_alone() {
        assert_eq!("a\u{1b}\n\nb\r\nc".split_inclusive('\n').map(line).collect::<String>(), "a\\u{1b}\n\nb\\r\nc");
    }
}
