//! Resolve: options become valid settings, before an image is decoded or a device opened.

use super::shaders;
use crate::args::{self, DeviceArgs, InputArgs, SingleArgs};
use crate::commands::{energy, network};
use crate::engine::compute::Cameras;
use crate::engine::pair::Pair;
use crate::engine::{adapter, images, output_files};
use anyhow::{Result, bail, ensure};
use gpu_stereo::Params;
use gpu_stereo::backend::Backend;
use gpu_stereo::files::encoders::Format;
use gpu_stereo::files::masks::MaskFiles;
use gpu_stereo::files::outputs::Output;
use gpu_stereo::files::truth::TruthFile;
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
    /// Where the range of disparities comes from.
    pub range: args::Range,
    /// Which pixels have content.
    pub masks: MaskFiles,
    /// The cameras.
    pub cameras: Cameras,
    /// Whether the depth is wanted.
    pub depth: bool,
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
    let Some(left) = &typed.left else { bail!("two images are needed, LEFT and RIGHT; see gpu-stereo --help") };
    let (Pair { left, right }, input) = images::given(left, typed.right.as_deref(), &typed.input)?;
    let cameras = Cameras::resolve(&typed.cameras)?;
    let wanted = wanted(&typed)?;
    let formats: Vec<_> = wanted.iter().map(|(_, format)| *format).collect();
    output_files::want(&mut params, &formats);
    cameras.ensure_fit(output_files::asks_for_depth(&formats), typed.truth.gt_depth || typed.look.scale_bar)?;
    output_files::ensure_rectified(&formats, &cameras)?;
    let truth = match &typed.gt {
        Some(path) => Some(typed.truth.file(path, typed.cameras.optics.both()?)?),
        None => typed.truth.ensure_unused().map(|()| None)?,
    };
    let masks = MaskFiles::resolve(typed.masks.mask_in.as_deref())?;
    let inputs: Vec<_> = truth
        .iter()
        .flat_map(TruthFile::files)
        .chain(cameras.files())
        .chain(masks.paths())
        .chain(typed.network.weights.as_deref())
        .chain([left.as_path(), &right])
        .collect();
    let outputs = output_files::resolve(wanted, &inputs, &params, typed.look.look())?;
    output_files::note_look(typed.look.look(), &outputs.iter().map(|output| output.format).collect::<Vec<_>>());
    if let Some(folder) = &typed.dump_shaders {
        shaders::ensure_empty(folder, &inputs)?;
    }
    Ok(Job {
        left,
        right,
        input,
        params,
        range: typed.settings.range(),
        masks,
        cameras,
        depth: formats.iter().any(|format| format.needs_depth()),
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

/// The files that the options name.
fn wanted(typed: &SingleArgs) -> Result<Vec<(PathBuf, Format)>> {
    let pictures = [
        ("color", &typed.color, Format::Color(typed.look.look())),
        ("mask", &typed.mask, Format::Mask),
        ("confidence", &typed.confidence, Format::Confidence),
        ("error-map", &typed.truth.error_map, Format::ErrorMap),
    ];
    let wanted = [
        output_files::maps(&typed.depth, Format::Depth)?,
        output_files::points(&typed.points)?,
        output_files::maps(&typed.output, Format::Disparity)?,
        output_files::maps(&typed.right_map, Format::Right)?,
        output_files::rectified(typed.rectified.as_deref())?,
        output_files::pictures(&pictures)?,
    ];
    Ok(wanted.concat())
}
