//! Warnings: notes that a result is doubtful. Each is printed once, on stderr, and listed in `--json`.

use super::print::message;
use super::text::one_line;
use std::sync::{Mutex, PoisonError};

static ALL: Warnings = Warnings(Mutex::new(Vec::new()));

/// Reports in one line why a result is doubtful and what to do; the word `note` is added.
pub fn warn(text: &str) {
    warn_by(text, message);
}

/// The same with a function that prints, for where a progress bar is on the screen.
pub fn warn_by(text: &str, print: impl FnOnce(&str)) {
    if let Some(text) = ALL.add(text) {
        print(&format!("note: {text}"));
    }
}

/// All warnings of this run so far.
pub fn all() -> Vec<String> {
    ALL.all()
}

struct Warnings(Mutex<Vec<String>>);

impl Warnings {
    /// Adds a line, unless it is there already.
    fn add(&self, text: &str) -> Option<String> {
        let text = one_line(text);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.contains(&text) {
            return None;
        }
        all.push(text.clone());
        Some(text)
    }

    fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_there_once_and_in_one_line() {
        let warnings = Warnings(Mutex::new(Vec::new()));
        assert_eq!(warnings.add("a\nb").as_deref(), Some("a b"));
        assert_eq!(warnings.add("c").as_deref(), Some("c"));
        assert_eq!(warnings.add("a b"), None);
        assert_eq!(warnings.all(), ["a b", "c"]);
    }
}
