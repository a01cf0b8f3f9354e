//! The share of one long computation that is done: a bar on a terminal, a line every ten seconds elsewhere, both on stderr.

use super::print::message;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// Time between two lines where there is no terminal.
const A_LINE: Duration = Duration::from_secs(10);

/// Does `work`, and tells `show` meanwhile which share of it is done, from 0 to 1.
pub fn watched<T>(share: impl Fn() -> f64 + Sync, show: &(dyn Fn(f64) + Sync), work: impl FnOnce() -> T) -> T {
    let (running, ended) = channel::<()>();
    thread::scope(|scope| {
        let share = &share;
        let watch = move || {
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                show(share().clamp(0.0, 1.0));
            }
        };
        // Without another thread it is computed all the same.
        let _ = thread::Builder::new().spawn_scoped(scope, watch);
        let result = work();
        drop(running);
        result
    })
}

/// What shows it.
pub struct Share {
    bar: ProgressBar,
    lines: bool,
    start: Instant,
    last_line: Mutex<Instant>,
}

impl Share {
    /// Of `what`; nothing is shown if `quiet`.
    pub fn new(what: &str, quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1000) };
        let style = ProgressStyle::with_template("{bar:24} {percent} %  {msg}");
        let bar = bar.with_finish(ProgressFinish::AndClear).with_style(style.unwrap_or(ProgressStyle::default_bar()));
        bar.set_message(what.to_owned());
        let lines = bar.is_hidden() && !quiet;
        let start = Instant::now();
        Self { bar, lines, start, last_line: Mutex::new(start) }
    }

    /// Shows it.
    pub fn show(&self, share: f64) {
        self.bar.set_position((1000.0 * share) as u64);
        let mut last_line = self.last_line.lock().unwrap_or_else(PoisonError::into_inner);
        if self.lines && last_line.elapsed() >= A_LINE {
            *last_line = Instant::now();
            message(&format!("{:.0} % after {:.0} s", 100.0 * share, self.start.elapsed().as_secs_f64()));
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn work_is_watched_and_its_end_waits_for_no_look() {
        let (looks, start) = (AtomicUsize::new(0), Instant::now());
        let show = |share: f64| {
            assert_eq!(share, 1.0);
            looks.fetch_add(1, Ordering::Relaxed);
        };
        assert_eq!(watched(|| 7.0, &show, || 5), 5);
        assert!(start.elapsed() < LOOK || looks.load(Ordering::Relaxed) > 0);
        watched(
            || 7.0,
            &show,
            || {
                while looks.load(Ordering::Relaxed) < 2 {
                    thread::sleep(LOOK)
                }
            },
        );
    }
}
