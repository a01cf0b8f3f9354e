//! What reaches stdout and stderr: the only file that writes to them.

use super::json::json;
use super::text::{one_line, plain};
use anyhow::{Context as _, Result};
use serde::Serialize;
use std::io::{ErrorKind, Write as _};

/// A message on stderr, in one line. That stderr is closed is no reason to stop.
pub fn message(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", one_line(text));
}

/// Prints text of whole lines on stdout. A reader that has seen enough, such as `head`, is no error.
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
