//! Resolve: what was typed becomes settings that are known to be good, before an image is decoded or a device opened.

use crate::args::{Args, Backend, DeviceArgs, InputArgs, Scene, Whole};
use crate::calibration::{Calibration, LensModel, Reading};
use crate::evaluate::TruthFile;
use crate::mask::MaskFiles;
use crate::output::{Format, Output};
use crate::{environment, tips};
use anyhow::{Result, anyhow, bail, ensure};
use gpu_stereo::{Camera, Error, Params};
use std::path::PathBuf;

/// A run, ready to start.
#[derive(Debug)]
pub struct Job {
    /// The left image's path.
    pub left: PathBuf,
    /// The right image's path.
    pub right: PathBuf,
    /// How they are read.
    pub input: InputArgs,
    /// The matcher's settings, validated.
    pub params: Params,
    /// Which pixels have content.
    pub masks: MaskFiles,
    /// What the calibration says.
    pub calibration: Option<Calibration>,
    /// Whether the depth is wanted.
    pub depth: bool,
    /// Whether the principal point is to be in the middle of the image, along each axis.
    pub middle: [bool; 2],
    /// Where to compute.
    pub device: DeviceArgs,
    /// The truth to score the map against.
    pub truth: Option<TruthFile>,
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
    let given: Vec<_> = args.settings.iter().map(|(name, _)| name).collect();
    ensure_disparities(&given)?;
    let mut params = params(args.settings.iter())?;
    params.confidence = args.confidence.is_some();
    tell_unused(&[(given, &params)]);
    if args.check && args.device.backend == Backend::Cpu {
        bail!("--check compares an adapter with the CPU reference, but --backend is cpu; take auto or gpu");
    }
    ensure_adapter(&args.device)?;
    let repeat = args.repeat.as_ref().map(repeat).transpose()?.or(args.timings.then_some(1));
    let (Some(left), Some(right)) = (args.left, args.right) else {
        bail!("two images are needed, LEFT and RIGHT; see gpu-stereo --help");
    };
    let optics = args.optics.both()?;
    let calibration = calibration(&args.scene, optics)?;
    let depths = crate::output::depth_formats(&args.scene.depth, &args.scene.points)?;
    match &calibration {
        Some(_) if !depths.is_empty() => {}
        Some(calibration) if calibration.has_lenses() => {}
        Some(_) if args.truth.gt_depth => {}
        Some(_) => crate::tell("note: the cameras change nothing without --depth and --points"),
        None if depths.is_empty() => {}
        None => bail!(
            "--depth and --points need the cameras; give --calib FILE, --rectify FILE, or --focal PX and --baseline M"
        ),
    }
    let pictures = [
        ("color", &args.color, Format::Color),
        ("mask", &args.mask, Format::Mask),
        ("confidence", &args.confidence, Format::Confidence),
        ("error-map", &args.truth.error_map, Format::ErrorMap),
    ];
    let truth = TruthFile::resolve(args.gt.as_deref(), &args.truth, optics)?;
    let masks = MaskFiles::resolve(args.masks.mask_in.as_deref())?;
    let Scene { calib, rectify, calib_right, .. } = &args.scene;
    let calibrations = [calib, rectify, calib_right].into_iter().flatten().map(PathBuf::as_path);
    let inputs: Vec<_> = truth
        .iter()
        .flat_map(TruthFile::files)
        .chain(calibrations)
        .chain(masks.paths())
        .chain([left.as_path(), &right])
        .collect();
    let outputs = crate::output::resolve(&args.output, &pictures, &depths, &inputs, &params)?;
    Ok(Job {
        left,
        right,
        input: args.input,
        params,
        masks,
        calibration,
        depth: !depths.is_empty(),
        middle: [args.scene.cx, args.scene.cy].map(|given| optics.is_some() && given.is_none()),
        device: args.device,
        truth,
        outputs,
        check: args.check,
        timings: args.timings,
        repeat,
        json: args.json,
        quiet: args.quiet,
    })
}

/// The cameras that the options name.
fn calibration(scene: &Scene, optics: Option<[f64; 2]>) -> Result<Option<Calibration>> {
    let Scene { calib, rectify, calib_right, .. } = scene;
    if let Some(path) = calib.as_ref().or(rectify.as_ref()) {
        // The parser lets it pass where --calib excludes --rectify.
        ensure!(
            scene.lens == LensModel::Auto || rectify.is_some(),
            "--lens goes with --rectify, since --calib takes a rectified pair; drop it, or give the file with --rectify"
        );
        let reading = Reading {
            unit: scene.calib_unit,
            pair: scene.calib_pair,
            lens: scene.lens,
            scale: scene.calib_scale,
            lenses: rectify.is_some(),
        };
        return Calibration::read(path, calib_right.as_deref(), reading).map(Some);
    }
    let Some([focal, baseline]) = optics else { return Ok(None) };
    let [doffs, cx, cy] = [scene.doffs, scene.cx, scene.cy].map(Option::unwrap_or_default);
    let camera = Camera { focal, baseline, doffs, cx, cy };
    camera.validate().map_err(told)?;
    Ok(Some(Calibration::typed(camera)))
}

/// There is no usual number of disparities.
pub fn ensure_disparities(given: &[&str]) -> Result<()> {
    ensure!(given.contains(&"disp"), "--disp <N> is needed, the number of disparities; see gpu-stereo --help");
    Ok(())
}

/// An adapter that was asked for is used, and what the environment says of adapters is understood.
pub fn ensure_adapter(device: &DeviceArgs) -> Result<()> {
    if device.backend != Backend::Cpu {
        environment::ensure_known()?;
    }
    match &device.adapter {
        Some(adapter) if device.backend == Backend::Cpu => {
            bail!("--adapter is {adapter:?}, but --backend cpu uses none; drop one of the two")
        }
        _ => Ok(()),
    }
}

/// The frames after the warm-up.
pub fn repeat(given: &Whole) -> Result<u32> {
    match u32::try_from(given.value) {
        Ok(frames @ 1..=MAX_REPEAT) => Ok(frames),
        _ => bail!("--repeat is {}, but must be from 1 to {MAX_REPEAT}; 20 is usual", given.text),
    }
}

/// The settings that the options make.
pub fn params<'a>(settings: impl Iterator<Item = (&'a str, &'a str)>) -> Result<Params> {
    Params::from_options(DISPARITIES, settings).map_err(told)
}

/// An error of the library by the names of the options.
fn told(error: Error) -> anyhow::Error {
    match error {
        Error::Parameter { name: "option", given, allowed, remedy, .. } => {
            let meant =
                tips::setting(given.trim_matches('"')).map(|meant| format!("take {meant}; ")).unwrap_or_default();
            anyhow!("{given} is no option; {allowed} is; {meant}{remedy}")
        }
        Error::Parameter { name, given, allowed, remedy, .. } => {
            let meant = tips::value(name, &given).map(|meant| format!("take {meant}; ")).unwrap_or_default();
            anyhow!("--{name} is {given}, but must be {allowed}; {meant}{remedy}")
        }
        other => other.into(),
    }
}

/// Options that change nothing wherever they are given are told: nothing is ignored in silence.
pub fn tell_unused(given: &[(Vec<&str>, &Params)]) {
    for option in Params::OPTIONS {
        let with = given.iter().filter(|(names, _)| names.contains(&option.name));
        let others: Option<Vec<_>> = with.map(|(_, params)| Some((option.idle(params)?, params))).collect();
        if let Some((other, params)) = others.and_then(|others| others.into_iter().next()) {
            let value = other.get(params);
            crate::tell(&format!("note: --{} changes nothing with --{} {value}", option.name, other.name));
        }
    }
}
