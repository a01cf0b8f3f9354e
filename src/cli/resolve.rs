//! Resolve: what was typed becomes settings that are known to be good, before an image is decoded or a device opened.

use crate::args::{self, Args, Whole, WholeOrOff};
use crate::output::Output;
use anyhow::{Result, anyhow, bail};
use gpu_stereo::{Error, Median, Method, Params, Paths, Prefilter, Schedule, Subpixel};
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

/// Checks everything that can be checked without the images and without a device.
pub fn resolve(args: Args) -> Result<Job> {
    let params = params(&args)?;
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
    let outputs = crate::output::resolve(&args.output, args.color.as_deref(), [&left, &right], &params)?;
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

/// The method's defaults, changed by the options that were given.
fn params(args: &Args) -> Result<Params> {
    // A number outside the type's range is outside the parameter's range, too, so its nearest stand-in will be refused.
    let natural = |whole: &Whole| u32::try_from(whole.value.max(-1)).unwrap_or(u32::MAX);
    let Some(disp) = &args.disp else {
        bail!("--disp is needed, the number of disparities to search; 64 is a start");
    };
    let mut params = match args.method {
        args::Method::Sgm => Params::sgm(natural(disp)),
        args::Method::Bm => Params::bm(natural(disp)),
    };
    if let Some(min) = &args.min_disp {
        params.min_disparity = min.value.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    }
    if let Some(paths) = args.paths {
        params.paths = match paths {
            args::Paths::Three => Paths::Three,
            args::Paths::Four => Paths::Four,
            args::Paths::Eight => Paths::Eight,
        };
    }
    if let Some(prefilter) = args.prefilter {
        params.prefilter = match prefilter {
            args::Prefilter::Xsobel => Prefilter::XSobel,
            args::Prefilter::Sobel => Prefilter::Sobel,
            args::Prefilter::None => Prefilter::None,
        };
    }
    let numbers = [
        (&args.block, &mut params.block),
        (&args.prefilter_cap, &mut params.prefilter_cap),
        (&args.p1, &mut params.p1),
        (&args.p2, &mut params.p2),
    ];
    for (given, param) in numbers {
        if let Some(whole) = given {
            *param = natural(whole);
        }
    }
    match &args.uniqueness {
        None => {}
        Some(WholeOrOff::Off) => params.uniqueness = 0,
        Some(WholeOrOff::Whole(percent)) => params.uniqueness = natural(percent),
    }
    match &args.lr_check {
        None => {}
        Some(WholeOrOff::Off) => params.lr_check = None,
        Some(WholeOrOff::Whole(px)) => params.lr_check = Some(natural(px)),
    }
    if let Some(median) = args.median {
        params.median = match median {
            args::Median::Three => Median::Three,
            args::Median::Off => Median::Off,
        };
    }
    if let Some(checks) = args.shader_checks {
        params.shader_checks = checks == args::OnOff::On;
    }
    params.schedule = match args.schedule {
        args::Schedule::Auto => Schedule::Auto,
        args::Schedule::Lines => Schedule::Lines,
        args::Schedule::Lanes => Schedule::Lanes,
    };
    if let Some(subpixel) = args.subpixel {
        params.subpixel = if subpixel == args::OnOff::On { Subpixel::Parabola } else { Subpixel::Off };
    }
    params.validate().map_err(|error| as_typed(error, args))?;
    tell_unused(&params, args);
    Ok(params)
}

/// The library's complaint about a parameter, with the option and the value as they were typed.
fn as_typed(error: Error, args: &Args) -> anyhow::Error {
    let Error::Parameter { name, given, allowed, remedy } = error else {
        return error.into();
    };
    let number = |option: &Option<WholeOrOff>| match option {
        Some(WholeOrOff::Whole(whole)) => Some(whole.clone()),
        _ => None,
    };
    let typed = match name {
        "disp" => args.disp.clone(),
        "min-disp" => args.min_disp.clone(),
        "block" => args.block.clone(),
        "prefilter-cap" => args.prefilter_cap.clone(),
        "p1" => args.p1.clone(),
        "p2" => args.p2.clone(),
        "uniqueness" => number(&args.uniqueness),
        "lr-check" => number(&args.lr_check),
        _ => None,
    };
    let given = typed.map_or(given, |whole| whole.text);
    anyhow!("--{name} is {given}, but must be {allowed}; {remedy}")
}

/// Options that change nothing are told: nothing is ignored in silence.
fn tell_unused(params: &Params, args: &Args) {
    let unused = |option: &str, with: &str| crate::tell(&format!("note: {option} changes nothing with {with}"));
    if params.method == Method::Bm {
        let of_sgm = [("--paths", args.paths.is_some()), ("--p1", args.p1.is_some()), ("--p2", args.p2.is_some())];
        for (option, given) in of_sgm {
            if given {
                unused(option, "--method bm");
            }
        }
    }
    if params.prefilter == Prefilter::None && args.prefilter_cap.is_some() {
        unused("--prefilter-cap", "--prefilter none");
    }
}
