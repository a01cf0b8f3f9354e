//! Resolve: what was typed becomes settings that are known to be good, before an image is decoded or a device opened.

use crate::args::{self, Args, Settings};
use crate::output::{Format, Output};
use anyhow::{Result, anyhow, bail};
use gpu_stereo::{Error, Params};
use std::path::PathBuf;

/// A run, ready to start.
#[derive(Debug)]
pub struct Job {
    /// The left image's path.
    pub left: PathBuf,
    /// The right image's path.
    pub right: PathBuf,
    /// The matcher's settings, validated.
    pub params: Params,
    /// Where to compute.
    pub backend: args::Backend,
    /// The adapter that was asked for.
    pub adapter: Option<String>,
    /// The files to write, each known to be writable.
    pub outputs: Vec<Output>,
    /// Compare every stage.
    pub check: bool,
    /// Print the table of stages.
    pub timings: bool,
    /// Frames after one warm-up; `None`: the first frame is the only one.
    pub repeat: Option<u32>,
    /// Print JSON.
    pub json: bool,
    /// Print no summary.
    pub quiet: bool,
}

const MAX_REPEAT: u32 = 1_000_000;

/// The number of disparities before `--disp`, which must be given, sets it.
const DISPARITIES: u32 = 64;

/// Checks everything that can be checked without the images and without a device.
pub fn resolve(args: Args) -> Result<Job> {
    let params = params(&args.settings)?;
    if args.backend == args::Backend::Cpu {
        if args.check {
            bail!("--check compares an adapter with the CPU reference, but --backend is cpu; take auto or gpu");
        }
        if let Some(adapter) = &args.adapter {
            bail!("--adapter is {adapter:?}, but --backend cpu uses none; drop one of the two");
        }
    }
    let repeat = args.repeat.as_ref().map(|given| match u32::try_from(given.value) {
        Ok(frames @ 1..=MAX_REPEAT) => Ok(frames),
        _ => Err(anyhow!("--repeat is {}, but must be from 1 to {MAX_REPEAT}; 20 is usual", given.text)),
    });
    let repeat = repeat.transpose()?.or(args.timings.then_some(1));
    let (Some(left), Some(right)) = (args.left, args.right) else {
        bail!("two images are needed, LEFT and RIGHT; see gpu-stereo --help");
    };
    let pictures = [("color", &args.color, Format::Color), ("mask", &args.mask, Format::Mask)];
    let outputs = crate::output::resolve(&args.output, &pictures, [&left, &right], &params)?;
    Ok(Job {
        left,
        right,
        params,
        backend: args.backend,
        adapter: args.adapter,
        outputs,
        check: args.check,
        timings: args.timings,
        repeat,
        json: args.json,
        quiet: args.quiet,
    })
}

/// The settings that the options make.
fn params(settings: &Settings) -> Result<Params> {
    let params = Params::from_options(DISPARITIES, settings.iter()).map_err(|error| match error {
        Error::Parameter { name, given, allowed, remedy } => {
            anyhow!("--{name} is {given}, but must be {allowed}; {remedy}")
        }
        other => other.into(),
    })?;
    tell_unused(&params, settings);
    Ok(params)
}

/// Options that change nothing are told: nothing is ignored in silence.
fn tell_unused(params: &Params, settings: &Settings) {
    for option in Params::OPTIONS.iter().filter(|option| settings.iter().any(|(name, _)| name == option.name)) {
        if let Some(other) = option.idle(params) {
            let value = other.get(params);
            crate::tell(&format!("note: --{} changes nothing with --{} {value}", option.name, other.name));
        }
    }
}
