//! Resolve: the options become a task.

use super::bag::Bag;
use super::film::{self, Film};
use super::numbered::{Naming, Numbered};
use super::range;
use super::source::Source;
use super::task::{Task, Video};
use crate::args::{self, InputArgs, VideoArgs};
use crate::commands::network;
use crate::engine::compute::{Cameras, ParamsBySize};
use crate::engine::pair::Pair;
use crate::engine::pairs::Pattern;
use crate::engine::store::{self, Item, Mode, Planned, Store};
use crate::engine::{adapter, disk, images, output_files, places};
use crate::terminal::message;
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::Params;
use gpu_stereo::files::encoders;
use gpu_stereo::files::encoders::{Format, SampleFormat};
use gpu_stereo::files::masks::MaskFiles;
use std::ops::RangeInclusive;
use std::path::PathBuf;

const MAX_FPS: f64 = 1000.0;

/// Endings of videos that are not written.
const OTHER_FILMS: [&str; 9] = ["avi", "mov", "gif", "m4v", "mpg", "mpeg", "wmv", "flv", "ogv"];

/// Checks everything that can be checked without reading an image or opening a device.
pub fn resolve(typed: VideoArgs) -> Result<Video> {
    let given: Vec<_> = typed.settings.iter().map(|(name, _)| name).collect();
    args::ensure_disparities(&given)?;
    let mut params = args::params(typed.settings.iter())?;
    let formats = &typed.look.dressed(&typed.formats.format);
    output_files::want(&mut params, formats);
    let source = Source::find(&typed)?;
    let cameras = Cameras::resolve(&typed.cameras)?.or(source.calibration());
    let to_record = encoders::ending(&typed.output) == "mcap";
    let in_record = (to_record && cameras.are_known()).then_some("a record");
    if to_record && !cameras.are_known() {
        message(
            "note: the record has no camera_info of a pair beside both topics, so only disparities are written; give --calib FILE, or \
             --focal PX and --baseline M, for depths and points",
        );
    }
    let asks = output_files::asks_for_depth(formats).or(in_record);
    cameras.ensure_fit(asks, typed.look.scale_bar || source.calibration().is_some())?;
    output_files::ensure_rectified(formats, &cameras)?;
    let depth = asks.is_some() || (typed.look.scale_bar && cameras.are_known());
    let keeps_right = output_files::keeps_right(formats);
    network::give(&typed.network, [&mut params])?;
    let masks = MaskFiles::resolve(typed.masks.mask_in.as_deref())?;
    params.masks = images::reported(masks.read()?);
    adapter::ensure_consistent(&typed.device)?;
    let in_flight = args::in_flight(&typed.in_flight)?;
    output_files::ensure_ranges(formats, &typed.output, &params)?;
    let input = source.as_first(&typed.input);
    let mut params = ParamsBySize::new(params, cameras, depth);
    let held = held(&typed, formats)?;
    let of_first = (&source, &input);
    let first = range::find(typed.settings.range(), of_first, &typed.device, held.as_ref(), &mut params)?;
    if first.is_some() {
        output_files::ensure_ranges(formats, &typed.output, &params.common)?;
    }
    if typed.bulk.no_sync {
        disk::leave_to_the_system();
    }

    let files = masks.paths().chain(params.cameras.files()).chain(typed.network.weights.as_deref());
    let inputs: Vec<PathBuf> = files.map(Into::into).collect();
    let task = task(&typed, source, &params, &input, inputs)?;
    args::report_unused(&[(given, &params.common)]);
    Ok(Video {
        device: typed.device,
        input,
        params,
        first,
        keeps_right,
        in_flight,
        task,
        output: typed.output,
        json: typed.bulk.json,
        quiet: typed.bulk.quiet,
    })
}

/// The disparities that all files can hold.
fn held(args: &VideoArgs, formats: &[Format]) -> Result<Option<RangeInclusive<i32>>> {
    if film::is_film(&args.output) || encoders::ending(&args.output) == "mcap" {
        return Ok(None);
    }
    let pattern = Pattern::parse(&args.output).with_context(|| format!("output is {:?}", args.output))?;
    let usual = match pattern {
        Some(pattern) if formats.is_empty() => encoders::sample_format(&pattern.path(0))?,
        _ => SampleFormat::Png,
    };
    let usual = formats.is_empty().then_some(Format::Disparity(usual));
    Ok(output_files::held(formats.iter().copied().chain(usual)))
}

/// Which frames go where.
fn task(
    typed: &VideoArgs,
    source: Source,
    params: &ParamsBySize,
    input: &InputArgs,
    inputs: Vec<PathBuf>,
) -> Result<Task> {
    let formats = &typed.look.dressed(&typed.formats.format);
    let (cameras, params) = (&params.cameras, &params.common);
    if film::is_film(&typed.output) {
        ensure!(
            !typed.look.scale_bar,
            "--scale-bar is for pictures, but output {:?} is a video; drop it",
            typed.output
        );
        return film(typed, source, params, &inputs);
    }
    if encoders::ending(&typed.output) == "mcap" {
        return bag(typed, source, &inputs);
    }
    output_files::note_look(typed.look.look(), formats);
    ensure!(
        !OTHER_FILMS.contains(&encoders::ending(&typed.output).as_str()) || typed.output.is_dir(),
        "output {:?} looks like a video, but .mp4, .mkv and .webm are written; use one of these, or a folder",
        typed.output
    );
    ensure!(
        typed.fps.is_none(),
        "--fps is for a video, but output {:?} is not one; drop it, or give a name that ends in .mp4, .mkv or .webm",
        typed.output
    );
    Ok(match (Pattern::parse(&typed.output).with_context(|| format!("output is {:?}", typed.output))?, source) {
        (Some(pattern), source) => numbered(typed, source, &inputs, pattern)?,
        (None, Source::Files(_, pairs)) => {
            Task::Folder(Box::new(folder(typed, pairs, params, input, (cameras, inputs))?))
        }
        (None, source) => numbered_folder(typed, source, params, &inputs)?,
    })
}

fn film(args: &VideoArgs, source: Source, params: &Params, inputs: &[PathBuf]) -> Result<Task> {
    ensure!(
        args.formats.format.is_empty() && !args.bulk.resume,
        "--format and --resume are for numbered files, but output {:?} is a video; drop them, or give a folder",
        args.output
    );
    places::ensure_apart([args.output.as_path()], source.files().chain(inputs.iter().map(PathBuf::as_path)))?;
    let rate = if let Source::Stream(stream) = &source { stream.rate } else { None };
    let rate = rate.filter(|rate| *rate <= MAX_FPS).map(|rate| rate.to_string());
    let fps = args.fps.clone().or(rate).unwrap_or_else(|| "10".into());
    ensure!(
        fps.parse().is_ok_and(|fps: f64| fps > 0.0 && fps <= MAX_FPS),
        "--fps is {fps:?}, but must be above 0 and at most {MAX_FPS}; 10 is usual"
    );
    let film = Film::new(&args.output, fps, encoders::searched(params), args.look.colors)?;
    Ok(Task::Film(source, film))
}

fn bag(args: &VideoArgs, source: Source, inputs: &[PathBuf]) -> Result<Task> {
    let out = &args.output;
    places::ensure_apart([out.as_path()], source.files().chain(inputs.iter().map(PathBuf::as_path)))?;
    let Source::Stream(stream) = source else {
        bail!("output {out:?} is a record, which is made of another record (.mcap) alone; give one, or another output")
    };
    ensure!(
        stream.is_record(),
        "output {out:?} is a record, which is made of another record (.mcap) alone; give one, or another output"
    );
    ensure!(
        args.formats.format.is_empty() && !args.bulk.resume && args.fps.is_none(),
        "--format, --fps and --resume are not for a record, but output {out:?} is one; drop them"
    );
    let topics = [args.left.as_deref(), args.right.as_deref()].map(Option::unwrap_or_default);
    Ok(Task::Bag(stream, Box::new(Bag::new(out, topics)?)))
}

fn numbered(args: &VideoArgs, source: Source, inputs: &[PathBuf], pattern: Pattern) -> Result<Task> {
    let out = &args.output;
    ensure!(!args.bulk.resume, "--resume needs a folder, but output is {out:?}; give a folder, or drop it");
    let format = match args.look.dressed(&args.formats.format)[..] {
        [] => Format::Disparity(encoders::sample_format(&pattern.path(0))?),
        [format] if format.suffix().ends_with(&format!(".{}", encoders::ending(out))) => format,
        _ => bail!("output {out:?} is one file a frame, and --format must fit its ending; drop it, or give a folder"),
    };
    places::make_folder(pattern.folder(), out)?;
    let files = Numbered::new(Naming::Pattern(pattern, format), source.first());
    apart(files, source, inputs)
}

/// The frames of a stream into a folder: they have no names, and nothing shows later whether they have changed.
fn numbered_folder(args: &VideoArgs, source: Source, params: &Params, inputs: &[PathBuf]) -> Result<Task> {
    let out = &args.output;
    ensure!(
        !args.bulk.resume,
        "--resume is for files, whose maps can be told from those of others, but the frames come from a stream; drop it"
    );
    let formats = output_files::formats(&args.formats.format, &args.look, params)?;
    ensure!(
        !out.join(store::RECORD).exists(),
        "output {out:?} is a folder of maps that --resume may keep, which are not mixed with those of a stream; give another \
         folder"
    );
    places::make_folder(out, out)?;
    apart(Numbered::new(Naming::Folder(out.clone(), formats), 0), source, inputs)
}

/// The task, once it is sure that no file is one that is read; of a stream, the first ones.
fn apart(files: Numbered, source: Source, inputs: &[PathBuf]) -> Result<Task> {
    let outputs: Vec<_> = (0..source.len().unwrap_or(1)).flat_map(|place| files.outputs(place)).collect();
    let outputs = outputs.iter().map(|output| output.path.as_path());
    places::ensure_apart(outputs, source.files().chain(inputs.iter().map(PathBuf::as_path)))?;
    Ok(Task::Numbered(source, files))
}

fn folder(
    args: &VideoArgs,
    pairs: Vec<Pair>,
    params: &Params,
    input: &InputArgs,
    (cameras, inputs): (&Cameras, Vec<PathBuf>),
) -> Result<Store> {
    let out = &args.output;
    let formats = output_files::formats(&args.formats.format, &args.look, params)?;
    let planned = |pair, name| Planned { pair, item: Item::new(out, name, &formats), line: None };
    let named = |pair: Pair| {
        let name = pair.left.file_stem().unwrap_or_default().into();
        planned(pair, name)
    };
    let planned: Vec<_> = match &args.bulk.suspects {
        Some(journal) => store::suspects(journal)?.into_iter().map(|(pair, name)| planned(pair, name)).collect(),
        None => pairs.into_iter().map(named).collect(),
    };
    let mode = Mode {
        resume: args.bulk.resume,
        retry: args.bulk.retry,
        video: true,
        own_ranges: false,
        input: input.clone(),
        more: output_files::decisive(cameras, &args.look),
        inputs,
        suspects: args.bulk.suspects.clone(),
    };
    let advice = format!("give a printf pattern as output, such as {:?}", out.join("%06d.png"));
    let sources: Vec<_> = ["left", "right"].into_iter().zip(args.sides.iter().map(PathBuf::as_path)).collect();
    let mut store = Store::new(out, params, &sources, &planned, &advice, mode)?;
    store.fill(planned)?;
    Ok(store)
}
