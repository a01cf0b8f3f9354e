//! Resolve: options become valid settings, before an image is decoded or a device opened.

use super::shaders;
use crate::args::{self, Backend, CameraArgs, DeviceArgs, InputArgs, SingleArgs};
use crate::commands::{energy, network};
use crate::engine::{adapter, output_files};
use crate::terminal::message;
use anyhow::{Result, bail, ensure};
use gpu_stereo::files::calibration::{Calibration, LensModel, Reading};
use gpu_stereo::files::encoders::Format;
use gpu_stereo::files::masks::MaskFiles;
use gpu_stereo::files::outputs::Output;
use gpu_stereo::files::truth::TruthFile;
use gpu_stereo::{Camera, Params};
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
    /// What of this only an adapter can do.
    pub needs_adapter: Option<&'static str>,
    /// Print the table of stages.
    pub timings: bool,
    /// Frames after one warm-up; `None`: the first frame is the only one.
    pub repeat: Option<u32>,
    /// The folder for the text of the kernels.
    pub shaders: Option<PathBuf>,
    /// Print JSON.
    pub json: bool,
    /// Print no summary.
    pub quiet: bool,
}

/// Checks everything that can be checked without the images and without a device.
pub fn resolve(typed: SingleArgs) -> Result<Job> {
    let given: Vec<_> = typed.settings.iter().map(|(name, _)| name).collect();
    args::ensure_disparities(&given)?;
    let mut params = args::params(typed.settings.iter())?;
    params.confidence = typed.confidence.is_some();
    energy::want(&mut params, typed.json || typed.timings);
    args::report_unused(&[(given, &params)]);
    network::give(&typed.network, [&mut params])?;
    let needs_adapter = needs_adapter(&typed);
    if let Some(what) = needs_adapter.filter(|_| !typed.device.backend.takes_adapters()) {
        bail!("{what}, but --backend is {}; use gpu", typed.device.backend.name());
    }
    let compares = !typed.check || typed.device.backend != Backend::Reference;
    ensure!(compares, "--check compares with the reference, but --backend is reference; use auto, gpu or cpu");
    adapter::ensure_consistent(&typed.device)?;
    let repeat = typed.repeat.as_ref().map(args::repeat).transpose()?.or(typed.timings.then_some(1));
    let (Some(left), Some(right)) = (typed.left, typed.right) else {
        bail!("two images are needed, LEFT and RIGHT; see gpu-stereo --help");
    };
    let optics = typed.optics.both()?;
    let calibration = calibration(&typed.cameras, optics)?;
    let depths = output_files::depth_formats(&typed.cameras.depth, &typed.cameras.points)?;
    match &calibration {
        Some(_) if !depths.is_empty() => {}
        Some(calibration) if calibration.has_lenses() => {}
        Some(_) if typed.truth.gt_depth => {}
        Some(_) => message("note: the cameras have no effect without --depth or --points"),
        None if depths.is_empty() => {}
        None => bail!(
            "--depth and --points need the cameras; give --calib FILE, --rectify FILE, or --focal PX and --baseline M"
        ),
    }
    let pictures = [
        ("color", &typed.color, Format::Color),
        ("mask", &typed.mask, Format::Mask),
        ("confidence", &typed.confidence, Format::Confidence),
        ("error-map", &typed.truth.error_map, Format::ErrorMap),
    ];
    let truth = match &typed.gt {
        Some(path) => Some(typed.truth.file(path, optics)?),
        None => typed.truth.ensure_unused().map(|()| None)?,
    };
    let masks = MaskFiles::resolve(typed.masks.mask_in.as_deref())?;
    let CameraArgs { calib, rectify, calib_right, .. } = &typed.cameras;
    let calibrations = [calib, rectify, calib_right].into_iter().flatten().map(PathBuf::as_path);
    let inputs: Vec<_> = truth
        .iter()
        .flat_map(TruthFile::files)
        .chain(calibrations)
        .chain(masks.paths())
        .chain(typed.network.weights.as_deref())
        .chain([left.as_path(), &right])
        .collect();
    let outputs = output_files::resolve(&typed.output, &pictures, &depths, &inputs, &params)?;
    if let Some(folder) = &typed.dump_shaders {
        shaders::ensure_empty(folder, &inputs)?;
    }
    Ok(Job {
        left,
        right,
        input: typed.input,
        params,
        masks,
        calibration,
        depth: !depths.is_empty(),
        middle: [typed.cameras.cx, typed.cameras.cy].map(|given| optics.is_some() && given.is_none()),
        device: typed.device,
        truth,
        outputs,
        check: typed.check,
        needs_adapter,
        timings: typed.timings,
        repeat,
        shaders: typed.dump_shaders,
        json: typed.json,
        quiet: typed.quiet,
    })
}

/// What of the run only an adapter can do.
fn needs_adapter(typed: &SingleArgs) -> Option<&'static str> {
    typed.dump_shaders.is_some().then_some("--dump-shaders writes the kernels that an adapter runs")
}

/// The cameras that the options name.
fn calibration(cameras: &CameraArgs, optics: Option<[f64; 2]>) -> Result<Option<Calibration>> {
    let CameraArgs { calib, rectify, calib_right, .. } = cameras;
    if let Some(path) = calib.as_ref().or(rectify.as_ref()) {
        // Clap does not require --rectify for --lens if --calib, which excludes it, is given.
        ensure!(
            cameras.lens == LensModel::Auto || rectify.is_some(),
            "--lens goes with --rectify, since --calib takes a rectified pair; drop it, or give the file with --rectify"
        );
        let reading = Reading {
            unit: cameras.calib_unit,
            pair: cameras.calib_pair,
            lens: cameras.lens,
            scale: cameras.calib_scale,
            lenses: rectify.is_some(),
        };
        return Ok(Some(Calibration::read(path, calib_right.as_deref(), reading)?));
    }
    let Some([focal, baseline]) = optics else { return Ok(None) };
    let [doffs, cx, cy] = [cameras.doffs, cameras.cx, cameras.cy].map(Option::unwrap_or_default);
    let camera = Camera { focal, baseline, doffs, cx, cy };
    camera.validate().map_err(args::by_option)?;
    Ok(Some(Calibration::typed(camera)))
}
