//! The command line: what is typed becomes a verb with its arguments, and the verb is run.

#[cfg(test)]
mod tests;
mod tips;

use crate::args::{
    self, BatchArgs, BenchArgs, CalibArgs, CompareArgs, DeviceArgs, EvalArgs, SingleArgs, StudyArgs, VideoArgs,
    WeightsArgs,
};
use crate::commands::{Outcome, adapters, batch, bench, calib, eval, single, study, video, weights};
use crate::engine::adapter;
use anyhow::{Result, anyhow};
use clap::{CommandFactory as _, Parser, Subcommand};

const USAGE: &str = "\
gpu-stereo <LEFT> <RIGHT> --disp <N> [OPTIONS]
       gpu-stereo <BOTH> [--split <HOW>] --disp <N> [OPTIONS]
       gpu-stereo sweep|compare <LEFT> <RIGHT> --disp <N> [OPTIONS]
       gpu-stereo video <LEFT> <RIGHT> -o <OUT> --disp <N> [OPTIONS]
       gpu-stereo batch <LIST>|<LEFT> <RIGHT> -o <DIR> --disp <N> [OPTIONS]
       gpu-stereo eval <ESTIMATE> <TRUTH> [OPTIONS]
       gpu-stereo bench <DATASET> --layout <LAYOUT> [OPTIONS]
       gpu-stereo calib <FILE> [FILE] [OPTIONS]
       gpu-stereo weights <FILE> [--convert <OUT.safetensors>]
       gpu-stereo --list-adapters";

/// Dense disparity of a stereo pair, on any GPU.
///
/// LEFT and RIGHT are rectified images of one size (else see --rectify), 8 or 16 bits, gray or colour (an alpha channel is ignored): PNG,
/// JPEG, PNM, TIFF, BMP, WebP and others. A disparity d at (x, y) says that LEFT(x, y) shows what RIGHT(x - d, y) shows.
#[derive(Debug, Parser)]
#[command(name = "gpu-stereo", version, override_usage = USAGE, after_help = args::SINGLE_HELP, max_term_width = 100)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, disable_help_subcommand = true)]
pub struct CommandLine {
    /// Something else than a run of one pair
    #[command(subcommand)]
    verb: Option<Verb>,

    /// A run of one pair
    #[command(flatten)]
    single: SingleArgs,
}

/// What is not the run of one pair.
#[derive(Debug, Subcommand)]
enum Verb {
    /// Maps for every combination of values on one sheet, with times
    #[command(after_help = args::SWEEP_HELP, max_term_width = 100)]
    Sweep(StudyArgs),
    /// Maps of several variants on one sheet, with times
    #[command(after_help = args::COMPARE_HELP, max_term_width = 100)]
    Compare(CompareArgs),
    /// Score a map against a truth
    #[command(after_help = args::EVAL_HELP, max_term_width = 100)]
    Eval(EvalArgs),
    /// Score every scene of a data set, with a report and files to submit
    #[command(after_help = args::BENCH_HELP, max_term_width = 100)]
    Bench(BenchArgs),
    /// Maps of all frames of a video: two folders, two printf patterns or two globs
    #[command(after_help = args::VIDEO_HELP, max_term_width = 100, override_usage = args::VIDEO_USAGE)]
    Video(VideoArgs),
    /// Maps of all pairs of a data set, or a share of them: a list, two folders or two globs
    #[command(after_help = args::BATCH_HELP, max_term_width = 100, override_usage = args::BATCH_USAGE)]
    Batch(BatchArgs),
    /// What is understood of a calibration, and both fields of view
    #[command(after_help = args::CALIB_HELP, max_term_width = 100)]
    Calib(CalibArgs),
    /// What is in a file of weights, and the same as .safetensors
    #[command(after_help = args::WEIGHTS_HELP, max_term_width = 100)]
    Weights(WeightsArgs),
}

impl CommandLine {
    /// What was typed; nothing if the help or the version was wanted, which is printed.
    pub fn parse() -> Result<Option<Self>> {
        match Self::try_parse() {
            Ok(line) => Ok(Some(line)),
            Err(error) if error.use_stderr() => {
                let typed: Vec<_> = std::env::args_os().skip(1).collect();
                Err(anyhow!(tips::error_line(error, &Self::command(), &typed)))
            }
            Err(help) => {
                let _ = help.print(); // perhaps into a pipe that is closed
                Ok(None)
            }
        }
    }

    /// Runs the verb.
    pub fn run(self) -> Result<Outcome> {
        let Self { verb, single } = self;
        let device = verb.as_ref().map_or(Some(&single.device), Verb::device);
        if single.list_adapters || device.is_some_and(|device| device.backend.takes_adapters()) {
            adapter::quiet_drivers();
        }
        if single.list_adapters {
            return adapters::run(single.json);
        }
        start_threads()?;
        match verb {
            None => single::run(single),
            Some(Verb::Sweep(args)) => study::sweep(args),
            Some(Verb::Compare(args)) => study::compare(args),
            Some(Verb::Eval(args)) => eval::run(args),
            Some(Verb::Bench(args)) => bench::run(args),
            Some(Verb::Video(args)) => video::run(args),
            Some(Verb::Batch(args)) => batch::run(args),
            Some(Verb::Calib(args)) => calib::run(&args),
            Some(Verb::Weights(args)) => weights::run(args),
        }
    }
}

impl Verb {
    /// Where it computes, if it does.
    fn device(&self) -> Option<&DeviceArgs> {
        match self {
            Self::Sweep(study) | Self::Compare(CompareArgs { study, .. }) => Some(&study.device),
            Self::Video(video) => Some(&video.device),
            Self::Batch(batch) => Some(&batch.device),
            Self::Bench(bench) => Some(&bench.device),
            Self::Calib(_) | Self::Eval(_) | Self::Weights(_) => None,
        }
    }
}

/// What computes and what reads spread their work over threads, and without them would end in a panic.
fn start_threads() -> Result<()> {
    rayon::ThreadPoolBuilder::new().build_global().map_err(|error| {
        anyhow!(
            "the worker threads cannot be started ({error}); allow more processes (ulimit -u), or set \
             RAYON_NUM_THREADS=1"
        )
    })
}
