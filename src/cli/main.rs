//! The command `gpu-stereo`: parse -> resolve -> run -> report. A study does so for several settings, a video and a
//! batch for several pairs.
//!
//! Exit codes: 0 done, 1 a check said no, a pair or a scene failed, 2 could not run. Data goes to stdout, messages to stderr.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod adapter;
mod args;
mod batch;
mod bench;
mod bench_log;
mod calibration;
mod depth;
mod diagnosis;
mod disk;
mod environment;
mod evaluate;
mod facts;
mod film;
mod input;
mod journal;
mod layout;
mod list;
mod log;
mod lossless;
mod maps;
mod mask;
mod output;
mod pairs;
mod pipeline;
mod places;
mod progress;
mod record;
mod report;
mod resolve;
mod run;
mod sheet;
mod store;
mod study;
mod terminal;
mod tips;
mod trial;
mod video;
mod views;
mod warnings;

use args::Verb;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::process::ExitCode;
use terminal::{name, one_line, plain, tell};

/// How a run that did not fail ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Done,
    CheckFailed,
    FramesFailed,
    ScenesFailed,
}

fn main() -> ExitCode {
    // Graphics drivers and wgpu's less trodden paths can panic. A user still gets one line and no backtrace.
    set_hook(Box::new(|panic| {
        let place = panic.location().map(|l| format!(" ({}:{})", l.file(), l.line())).unwrap_or_default();
        let payload = panic.payload();
        let text = payload.downcast_ref::<&str>().copied();
        let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        let text = text.unwrap_or("something that should not happen did");
        tell(&format!("error: {text}{place}; this is a bug, please report it"));
    }));
    survive_file_limit();
    let args = match args::parse() {
        Ok(args) => args,
        Err(code) => return code,
    };
    let device = args.verb.as_ref().map_or(Some(&args.device), Verb::device);
    if args.list_adapters || device.is_some_and(|device| device.backend != args::Backend::Cpu) {
        adapter::quiet_drivers();
    }
    // Nothing that was in use when a panic struck is used again: the process ends here.
    ExitCode::from(match catch_unwind(AssertUnwindSafe(|| execute(args))) {
        Ok(result) => exit_code(&result),
        Err(_) => 2,
    })
}

/// A file that grows beyond what is allowed (`ulimit -f`) is then an error of its own, not the end of the process.
fn survive_file_limit() {
    #[cfg(unix)]
    {
        let seen = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen) {
            tell(&format!("note: a file beyond the limit of the system will end the process ({error})"));
        }
    }
}

fn execute(args: args::Args) -> anyhow::Result<Outcome> {
    if args.list_adapters {
        environment::ensure_known()?;
        return report::list_adapters(&adapter::ranked()?, args.json).map(|()| Outcome::Done);
    }
    // What computes and what reads spread their work over threads, and without them would end in a panic.
    rayon::ThreadPoolBuilder::new().build_global().map_err(|error| {
        anyhow::anyhow!(
            "the threads for the work cannot be started ({error}); allow more processes (ulimit -u), or set \
             RAYON_NUM_THREADS=1"
        )
    })?;
    if let Some(verb) = args.verb {
        let study = match verb {
            Verb::Sweep(args) => study::resolve_sweep(args)?,
            Verb::Compare(args) => study::resolve_compare(args)?,
            Verb::Video(args) => return video::resolve(args)?.run(),
            Verb::Batch(args) => return batch::resolve(args)?.run(),
            Verb::Eval(args) => return evaluate::resolve(args)?.run().map(|()| Outcome::Done),
            Verb::Bench(args) => {
                let passed = bench::resolve(args)?.run()?;
                return Ok(if passed { Outcome::Done } else { Outcome::ScenesFailed });
            }
        };
        return study.print(&study.run()?).map(|()| Outcome::Done);
    }
    let job = resolve::resolve(args)?;
    let report = run::run(&job)?;
    report.print(&job).map_err(|error| match report.outputs.is_empty() {
        true => error,
        false => error.context("the files were written, but not the report"),
    })?;
    Ok(if report.check_passed() { Outcome::Done } else { Outcome::CheckFailed })
}

/// The exit code of a result; an error is told on the way.
fn exit_code(result: &anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::CheckFailed | Outcome::FramesFailed | Outcome::ScenesFailed) => 1,
        Err(error) => {
            tell(&error_line(error));
            2
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
    fn a_failed_check_is_exit_code_1() {
        assert_eq!(exit_code(&Ok(Outcome::CheckFailed)), 1);
        assert_eq!(exit_code(&Ok(Outcome::Done)), 0);
    }
}
