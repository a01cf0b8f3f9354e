//! `video`: the maps of all frames of two cameras.

mod film;

use super::network;
use super::outcome::Outcome;
use super::summary::Summary;
use crate::args::{self, DeviceArgs, InputArgs, VideoArgs};
use crate::engine::compute::{Cameras, ParamsBySize};
use crate::engine::pair::Pair;
use crate::engine::pairs::{self, Pattern};
use crate::engine::pipeline::{self, FailedPair, MatchedPair, Ran, Refused, Setup, Work};
use crate::engine::signals::stop_on_signals;
use crate::engine::store::{self, Item, Mode, Planned, Store};
use crate::engine::{adapter, disk, images, output_files, places, trial};
use anyhow::{Context as _, Result, bail, ensure};
use film::Film;
use gpu_stereo::Params;
use gpu_stereo::files::encoders;
use gpu_stereo::files::encoders::Format;
use gpu_stereo::files::masks::MaskFiles;
use gpu_stereo::files::outputs::Output;
use std::path::PathBuf;

const MAX_FPS: f64 = 1000.0;
/// One of so many frames is diagnosed: what is wrong with the cameras is wrong in all frames.
const DIAGNOSED: usize = 16;

/// A video, ready to start.
struct Video {
    device: DeviceArgs,
    input: InputArgs,
    params: ParamsBySize,
    in_flight: usize,
    sink: Sink,
    output: PathBuf,
    json: bool,
    quiet: bool,
}

/// Where the frames go.
enum Sink {
    Folder(Box<Store>),
    Numbered(Vec<Pair>, Numbered),
    Film(Vec<Pair>, Film),
}

/// A file a frame.
struct Numbered(Vec<Output>);

impl Work for Numbered {
    fn write(&self, pair: &MatchedPair) -> Result<(), Refused> {
        let output = &self.0[pair.place..=pair.place];
        let written = output_files::write(output, &pair.matched, &pair.left, &pair.params);
        written.map(drop).map_err(Refused::of)
    }
}

/// Endings of videos that are not written.
const OTHER_FILMS: [&str; 9] = ["avi", "mov", "gif", "m4v", "mpg", "mpeg", "wmv", "flv", "ogv"];

/// Matches all frames.
pub fn run(args: VideoArgs) -> Result<Outcome> {
    let video = resolve(args)?;
    let (json, quiet) = (video.json, video.quiet);
    let summary = video.run()?;
    summary.print(json, quiet)?;
    Ok(Outcome::failed_if(!summary.failures.is_empty()))
}

/// Checks everything that can be checked without reading an image or opening a device.
fn resolve(typed: VideoArgs) -> Result<Video> {
    let pairs = match &typed.sides[..] {
        [left, right] => pairs::find(left, right)?,
        [both] => images::find_in_one(both, &typed.input.of_many())?,
        more => bail!(
            "{} names were given, but LEFT and RIGHT are needed; put a glob in quotes, or the shell replaces it by names",
            more.len()
        ),
    };
    let given: Vec<_> = typed.settings.iter().map(|(name, _)| name).collect();
    args::ensure_disparities(&given)?;
    let mut params = args::params(typed.settings.iter())?;
    let formats = &typed.formats.format;
    output_files::want(&mut params, formats);
    let cameras = Cameras::resolve(&typed.cameras)?;
    cameras.ensure_fit(output_files::asks_for_depth(formats), false)?;
    let depth = formats.iter().any(|format| format.needs_depth());
    network::give(&typed.network, [&mut params])?;
    let masks = MaskFiles::resolve(typed.masks.mask_in.as_deref())?;
    params.masks = images::reported(masks.read()?);
    adapter::ensure_consistent(&typed.device)?;
    let in_flight = args::in_flight(&typed.in_flight)?;
    output_files::ensure_ranges(formats, &typed.output, &params)?;

    if typed.bulk.no_sync {
        disk::leave_to_the_system();
    }

    let first: Vec<_> = pairs.iter().take(images::FIRST).map(|(_, pair)| pair.clone()).collect();
    let input = images::as_first(&typed.input.of_many(), &first);
    let inputs: Vec<PathBuf> =
        masks.paths().chain(cameras.files()).chain(typed.network.weights.as_deref()).map(Into::into).collect();
    let sink = if film::is_film(&typed.output) {
        film(&typed, pairs, &params, &inputs)?
    } else {
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
        match Pattern::parse(&typed.output).with_context(|| format!("output is {:?}", typed.output))? {
            Some(pattern) => numbered(&typed, pairs, &inputs, &pattern)?,
            None => Sink::Folder(Box::new(folder(&typed, pairs, &params, &input, (&cameras, inputs))?)),
        }
    };
    args::report_unused(&[(given, &params)]);
    Ok(Video {
        device: typed.device,
        input,
        params: ParamsBySize::new(params, cameras, depth),
        in_flight,
        sink,
        output: typed.output,
        json: typed.bulk.json,
        quiet: typed.bulk.quiet,
    })
}

fn film(args: &VideoArgs, pairs: Vec<(u64, Pair)>, params: &Params, inputs: &[PathBuf]) -> Result<Sink> {
    ensure!(
        args.formats.format.is_empty() && !args.bulk.resume,
        "--format and --resume are for numbered files, but output {:?} is a video; drop them, or give a folder",
        args.output
    );
    places::ensure_no_input([args.output.as_path()], pairs.iter().map(|(_, pair)| pair), inputs)?;
    let fps = args.fps.as_deref().unwrap_or("10");
    ensure!(
        fps.parse().is_ok_and(|fps: f64| fps > 0.0 && fps <= MAX_FPS),
        "--fps is {fps:?}, but must be above 0 and at most {MAX_FPS}; 10 is usual"
    );
    let film = Film::new(&args.output, fps, encoders::searched(params))?;
    Ok(Sink::Film(pairs.into_iter().map(|(_, pair)| pair).collect(), film))
}

fn numbered(args: &VideoArgs, pairs: Vec<(u64, Pair)>, inputs: &[PathBuf], pattern: &Pattern) -> Result<Sink> {
    let out = &args.output;
    ensure!(!args.bulk.resume, "--resume needs a folder, but output is {out:?}; give a folder, or drop it");
    let format = match args.formats.format[..] {
        [] => Format::Disparity(encoders::sample_format(&pattern.path(0))?),
        [format] if format.suffix().ends_with(&format!(".{}", encoders::ending(out))) => format,
        _ => bail!("output {out:?} is one file a frame, and --format must fit its ending; drop it, or give a folder"),
    };
    let outputs: Vec<_> = pairs.iter().map(|(number, _)| Output::at(pattern.path(*number), format)).collect();
    places::make_folder(pattern.folder(), out)?;
    let paths = outputs.iter().map(|output| output.path.as_path());
    places::ensure_no_input(paths, pairs.iter().map(|(_, pair)| pair), inputs)?;
    let pairs = pairs.into_iter().map(|(_, pair)| pair).collect();
    Ok(Sink::Numbered(pairs, Numbered(outputs)))
}

fn folder(
    args: &VideoArgs,
    pairs: Vec<(u64, Pair)>,
    params: &Params,
    input: &InputArgs,
    (cameras, inputs): (&Cameras, Vec<PathBuf>),
) -> Result<Store> {
    let out = &args.output;
    let formats = output_files::formats(&args.formats.format, params)?;
    let planned = |pair, name| Planned { pair, item: Item::new(out, name, &formats), line: None };
    let named = |(_, pair): (u64, Pair)| {
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
        input: input.clone(),
        cameras: cameras.digest(),
        inputs,
        suspects: args.bulk.suspects.clone(),
    };
    let advice = format!("give a printf pattern as output, such as {:?}", out.join("%06d.png"));
    let sources: Vec<_> = ["left", "right"].into_iter().zip(args.sides.iter().map(PathBuf::as_path)).collect();
    let mut store = Store::new(out, params, &sources, &planned, &advice, mode)?;
    store.fill(planned)?;
    Ok(store)
}

impl Video {
    /// Computes all frames.
    fn run(self) -> Result<Summary<FailedPair>> {
        let stop = stop_on_signals();
        let threads = args::usual_threads();
        let setup = Setup {
            device: &self.device,
            params: &self.params,
            input: &self.input,
            diagnosed: DIAGNOSED,
            in_flight: self.in_flight,
            readers: threads,
            writers: if let Sink::Film(..) = self.sink { 1 } else { threads },
            mixed: false,
            kind: None,
            alone: false,
            unit: "frames",
            quiet: self.quiet,
        };
        let (mut ran, skipped) = match self.sink {
            Sink::Folder(store) => {
                if store.mode.suspects.is_some() {
                    trial::stop_with_parent(stop)?;
                }
                let ran = trial::run(&store, &setup, stop);
                let closed = store.close();
                let ran = whole(ran, store.pairs.len(), "were written: --resume computes the rest")?;
                closed?;
                (ran, store.skipped())
            }
            Sink::Numbered(pairs, work) => {
                (whole(pipeline::run(&pairs, &setup, stop, &work), pairs.len(), "were written")?, 0)
            }
            Sink::Film(pairs, film) => {
                let ran = pipeline::run(&pairs, &setup, stop, &film);
                let is_whole = ran.stopped.is_none();
                match film.finish(is_whole) {
                    Err(why) if is_whole => return Err(why),
                    // ffmpeg's message is the cause.
                    Err(why) => {
                        bail!("{why:#}, after {} of {} frames; no video was written", ran.done, pairs.len())
                    }
                    Ok(()) => (whole(ran, pairs.len(), "were done, and no video was written")?, 0),
                }
            }
        };
        let (size, failures) = (ran.size, std::mem::take(&mut ran.failed));
        let summary = Summary::new("frames", ran, &self.params.common, self.output, failures);
        Ok(Summary { size: Some(size), skipped, ..summary })
    }
}

/// The results, or the error if the run was stopped.
fn whole(mut ran: Ran, frames: usize, kept: &str) -> Result<Ran> {
    match ran.stopped.take() {
        Some(error) => bail!("{error:#}; {} of {frames} frames {kept}", ran.done),
        None => Ok(ran),
    }
}
