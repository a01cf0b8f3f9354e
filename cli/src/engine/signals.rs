//! Ctrl-C, and what else asks the process to end.

use crate::terminal::message;
use std::sync::atomic::{AtomicBool, Ordering};

/// Becomes true when the run is to end: after Ctrl-C, and where the system asks it to. The second time the process ends at
/// once.
pub fn stop_on_signals() -> &'static AtomicBool {
    static STOP: AtomicBool = AtomicBool::new(false);
    let handler = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(2);
        }
        message("interrupted: finishing what was begun");
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        message(&format!("note: signals cannot be caught ({error}), so an interrupted run may leave temporary files"));
    }
    &STOP
}
