//! The pace of many pairs: a bar on a terminal, a line a second elsewhere, both on stderr.

use super::print::message;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two lines where there is no terminal.
const A_LINE: Duration = Duration::from_secs(1);

/// Progress with speed and remaining time.
pub struct Pace {
    bar: ProgressBar,
    lines: bool,
    all: Option<usize>,
    unit: &'static str,
    start: Instant,
    last_line: Mutex<Instant>,
}

impl Pace {
    /// For `all` pieces, if their number is known, called `unit` in the text; nothing is shown if `quiet`.
    pub fn new(all: Option<usize>, unit: &'static str, quiet: bool) -> Self {
        let bar = match all {
            _ if quiet => ProgressBar::hidden(),
            Some(all) => ProgressBar::new(all as u64),
            None => ProgressBar::new_spinner(),
        };
        let style = if all.is_some() { "{bar:24} {pos}/{len}  {msg}" } else { "{pos}  {msg}" };
        let style = ProgressStyle::with_template(style);
        let bar = bar.with_finish(ProgressFinish::AndClear).with_style(style.unwrap_or(ProgressStyle::default_bar()));
        let lines = bar.is_hidden() && !quiet;
        let start = Instant::now();
        Self { bar, lines, all, unit, start, last_line: Mutex::new(start) }
    }

    /// Shows that `done` pieces are done.
    pub fn show(&self, done: usize) {
        let rate = done as f64 / self.start.elapsed().as_secs_f64().max(1e-9);
        let left = self.all.map(|all| format!(", {} left", time((all - done) as f64 / rate))).unwrap_or_default();
        let text = format!("{rate:.1} {} a second{left}", self.unit);
        self.bar.set_message(text.clone());
        self.bar.set_position(done as u64);
        let mut last_line = self.last_line.lock().unwrap_or_else(PoisonError::into_inner);
        if self.lines && (last_line.elapsed() >= A_LINE || self.all == Some(done)) {
            *last_line = Instant::now();
            let all = self.all.map(|all| format!("/{all}")).unwrap_or_default();
            message(&format!("{done}{all}  {text}"));
        }
    }

    /// Prints a message that stays, beside the bar.
    pub fn message(&self, text: &str) {
        self.bar.suspend(|| message(text));
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Seconds in words.
fn time(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s:02} s"),
        (h, m, _) => format!("{h} h {m:02} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_in_words() {
        assert_eq!([0.4, 59.6, 3599.0, 7384.0].map(time), ["0 s", "1 min 00 s", "59 min 59 s", "2 h 03 min"]);
    }
}
