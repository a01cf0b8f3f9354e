//! The command `gpu-stereo`: parse -> resolve -> run -> report.
//!
//! Imports go one way: main -> command_line -> commands -> engine -> args -> terminal. Data goes to stdout, messages to stderr.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod args;
mod command_line;
mod commands;
mod engine;
mod terminal;

use command_line::CommandLine;
use commands::Outcome;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::process::ExitCode;
use terminal::{message, one_line};

fn main() -> ExitCode {
    report_panics();
    survive_file_limit();
    let run = || CommandLine::parse()?.map_or(Ok(Outcome::Done), CommandLine::run);
    // Nothing that was in use when a panic struck is used again: the process ends here.
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(result) => ExitCode::from(exit_code(&result)),
        Err(_) => ExitCode::from(COULD_NOT_RUN),
    }
}

const COULD_NOT_RUN: u8 = 2;

/// Graphics drivers and wgpu's less trodden paths can panic. A user still gets one line and no backtrace.
fn report_panics() {
    set_hook(Box::new(|panic| {
        let place = panic.location().map(|l| format!(" ({}:{})", l.file(), l.line())).unwrap_or_default();
        let payload = panic.payload();
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        let text = text.unwrap_or("something unexpected happened");
        message(&format!("error: {text}{place}; this is a bug, please report it"));
    }));
}

/// A file that grows beyond what is allowed (`ulimit -f`) is then an error of its own, not the end of the process.
fn survive_file_limit() {
    #[cfg(unix)]
    {
        let seen = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen) {
            message(&format!("note: a file larger than the system allows will end the process ({error})"));
        }
    }
}

/// 0 done, 1 a check found a mismatch or a pair failed, 2 could not run: then the error is printed.
fn exit_code(result: &anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Failed) => 1,
        Err(error) => {
            message(&error_line(error));
            COULD_NOT_RUN
        }
    }
}

/// An error with all its causes in one line.
fn error_line(error: &anyhow::Error) -> String {
    format!("error: {}", one_line(&format!("{error:#}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_device_is_one_line_and_exit_code_2() {
        let lost = gpu_stereo::Error::Lost("Parent device is lost\n\n  in Queue::submit".into());
        let result: anyhow::Result<Outcome> = Err(lost.into());
        assert_eq!(exit_code(&result), 2);
        let line = error_line(result.as_ref().unwrap_err());
        assert_eq!(line.lines().count(), 1);
        assert!(line.starts_with("error: the device failed: Parent device is lost in Queue::submit"));
    }

    #[test]
    fn what_failed_is_exit_code_1() {
        assert_eq!(exit_code(&Ok(Outcome::Failed)), 1);
        assert_eq!(exit_code(&Ok(Outcome::Done)), 0);
    }
}
