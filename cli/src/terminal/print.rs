//! The only file that writes to stdout and stderr.

use super::json::json;
use super::text::{one_line, plain};
use anyhow::{Context as _, Result};
use serde::Serialize;
use std::io::{ErrorKind, Write as _};

/// Prints a message on stderr, in one line. A closed stderr is no reason to stop.
pub fn message(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", one_line(text));
}

/// Prints whole lines on stdout. A reader that closes the pipe early, such as `head`, is not an error.
pub fn print(text: &str) -> Result<()> {
    let shown: String = text.split_inclusive('\n').map(line).collect();
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(shown.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("stdout cannot be written; redirect it to a file or a pipe with room")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_text_keeps_its_lines_alone() {
        assert_eq!("a\u{1b}\n\nb\r\nc".split_inclusive('\n').map(line).collect::<String>(), "a\\u{1b}\n\nb\\r\nc");
    }
}
