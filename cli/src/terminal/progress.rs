//! Progress: a bar on a terminal, a line for each piece of work elsewhere, both on stderr.

use super::print::message;
use super::text::plain;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};

/// How far a run is.
pub struct Progress {
    bar: ProgressBar,
    lines: bool,
}

impl Progress {
    /// For so many pieces; nothing is shown if `quiet`.
    pub fn new(pieces: usize, quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(pieces as u64) };
        let style = ProgressStyle::with_template("{bar:24} {pos}/{len}  {wide_msg}");
        let bar = bar.with_finish(ProgressFinish::AndClear).with_style(style.unwrap_or(ProgressStyle::default_bar()));
        let lines = bar.is_hidden() && !quiet;
        Self { bar, lines }
    }

    /// A piece begins.
    pub fn begin(&self, label: &str) {
        self.bar.set_message(plain(label));
    }

    /// So much of a piece is done, from 0 to 1.
    pub fn share(&self, label: &str, share: f64) {
        self.bar.set_message(format!("{} {:.0} %", plain(label), 100.0 * share));
    }

    /// The piece is done, with `result`.
    pub fn done(&self, result: &str) {
        self.bar.inc(1);
        if self.lines {
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            message(&format!("{done}/{all}  {result}"));
        }
    }

    /// Prints a message that stays, beside the bar.
    pub fn message(&self, text: &str) {
        self.bar.suspend(|| message(text));
    }
}
