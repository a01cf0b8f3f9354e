//! Video: the maps of all frames of two cameras.

use crate::args::{DeviceArgs, InputArgs, VideoArgs};
use crate::film::{self, Film};
use crate::mask::MaskFiles;
use crate::output::{self, Format, Output};
use crate::pairs::{self, Pattern};
use crate::pipeline::{self, Failure, Frame, Pair, Ran, Refused, Setup, Work};
use crate::store::{self, Item, Mode, Planned, Store};
use crate::terminal::{self, name, plain};
use crate::{Outcome, disk, report, resolve, trial, views};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::Params;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const MAX_FPS: f64 = 1000.0;
/// One of so many frames is looked at whether it can be matched: what is wrong with the cameras is wrong with all.
const LOOKED_AT: usize = 16;

/// A video, ready to start.
pub struct Video {
    device: DeviceArgs,
    input: InputArgs,
    params: Params,
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
struct Numbered {
    outputs: Vec<Output>,
    params: Params,
}

impl Work for Numbered {
    fn put(&self, frame: &Frame) -> Result<(), Refused> {
        let (output, matched) = (&self.outputs[frame.place..=frame.place], &frame.matched);
        let written = output::write(output, &matched.map, matched.confidence.as_ref(), None, &self.params);
        written.map(drop).map_err(Refused::of)
    }
}

/// Endings of videos that are not written.
const OTHER_FILMS: [&str; 9] = ["avi", "mov", "gif", "m4v", "mpg", "mpeg", "wmv", "flv", "ogv"];

/// Checks everything that can be checked without reading an image or opening a device.
pub fn resolve(args: VideoArgs) -> Result<Video> {
    let [left, right] = &args.sides[..] else {
        bail!(
            "{} names were given, but LEFT and RIGHT are needed; put a glob in quotes, or the shell replaces it by names",
            args.sides.len()
        );
    };
    let given: Vec<_> = args.settings.iter().map(|(name, _)| name).collect();
    resolve::ensure_disparities(&given)?;
    let mut params = resolve::params(args.settings.iter())?;
    params.confidence = args.format.contains(&Format::Confidence);
    let masks = MaskFiles::resolve(args.masks.mask_in.as_deref())?;
    params.masks = masks.read()?;
    resolve::ensure_adapter(&args.device)?;
    let in_flight = pipeline::in_flight(&args.in_flight)?;
    output::ensure_ranges(&args.format, &args.output, &params)?;

    if args.no_sync {
        disk::leave_to_the_system();
    }

    let pairs = pairs::find(left, right)?;
    let first: Vec<_> = pairs.iter().take(views::FIRST).map(|(_, pair)| pair.clone()).collect();
    let input = views::as_first(&args.input, &first);
    let sink = if film::is_film(&args.output) {
        film(&args, pairs, &params, &masks)?
    } else {
        ensure!(
            !OTHER_FILMS.contains(&output::ending(&args.output).as_str()) || args.output.is_dir(),
            "output {:?} looks like a video, but .mp4, .mkv and .webm are written; take one of these, or a folder",
            args.output
        );
        ensure!(
            args.fps.is_none(),
            "--fps is for a video, but output {:?} is none; drop it, or give a name that ends in .mp4, .mkv or .webm",
            args.output
        );
        match Pattern::parse(&args.output).with_context(|| format!("output is {:?}", args.output))? {
            Some(pattern) => numbered(&args, pairs, &params, &masks, &pattern)?,
            None => Sink::Folder(Box::new(folder(&args, pairs, &params, &input, masks, [left, right])?)),
        }
    };
    resolve::tell_unused(&[(given, &params)]);
    Ok(Video {
        device: args.device,
        input,
        params,
        in_flight,
        sink,
        output: args.output,
        json: args.json,
        quiet: args.quiet,
    })
}

fn film(args: &VideoArgs, pairs: Vec<(u64, Pair)>, params: &Params, masks: &MaskFiles) -> Result<Sink> {
    ensure!(
        args.format.is_empty() && !args.resume,
        "--format and --resume are for numbered files, but output {:?} is a video; drop them, or give a folder",
        args.output
    );
    output::ensure_no_input([args.output.as_path()], pairs.iter().map(|(_, pair)| pair), masks)?;
    let fps = args.fps.as_deref().unwrap_or("10");
    ensure!(
        fps.parse().is_ok_and(|fps: f64| fps > 0.0 && fps <= MAX_FPS),
        "--fps is {fps:?}, but must be above 0 and at most {MAX_FPS}; 10 is usual"
    );
    let film = Film::new(&args.output, fps, output::searched(params))?;
    Ok(Sink::Film(pairs.into_iter().map(|(_, pair)| pair).collect(), film))
}

fn numbered(
    args: &VideoArgs,
    pairs: Vec<(u64, Pair)>,
    params: &Params,
    masks: &MaskFiles,
    pattern: &Pattern,
) -> Result<Sink> {
    let out = &args.output;
    let formats = output::formats(&args.format)?;
    ensure!(!args.resume, "--resume needs a folder, but output is {out:?}; give a folder, or drop it");
    let of_name = output::map_format(&pattern.path(0))?;
    let format = match formats[..] {
        [] => of_name,
        [format] if format.suffix().ends_with(&format!(".{}", output::ending(out))) => format,
        _ => bail!("output {out:?} is one file a frame, and --format must fit its ending; drop it, or give a folder"),
    };
    let outputs: Vec<_> = pairs.iter().map(|(number, _)| Output::at(pattern.path(*number), format)).collect();
    output::make_folder(pattern.folder(), out)?;
    let paths = outputs.iter().map(|output| output.path.as_path());
    output::ensure_no_input(paths, pairs.iter().map(|(_, pair)| pair), masks)?;
    let pairs = pairs.into_iter().map(|(_, pair)| pair).collect();
    Ok(Sink::Numbered(pairs, Numbered { outputs, params: params.clone() }))
}

fn folder(
    args: &VideoArgs,
    pairs: Vec<(u64, Pair)>,
    params: &Params,
    input: &InputArgs,
    masks: MaskFiles,
    sides: [&PathBuf; 2],
) -> Result<Store> {
    let out = &args.output;
    let mut formats = output::formats(&args.format)?;
    if formats.is_empty() {
        formats.push(output::default_format(params, "NAME"));
    }
    let planned = |pair, name| Planned { pair, item: Item::new(out, name, &formats), line: None };
    let named = |(_, pair): (u64, Pair)| {
        let name = pair.left.file_stem().unwrap_or_default().into();
        planned(pair, name)
    };
    let planned: Vec<_> = match &args.suspects {
        Some(journal) => store::suspects(journal)?.into_iter().map(|(pair, name)| planned(pair, name)).collect(),
        None => pairs.into_iter().map(named).collect(),
    };
    let mode = Mode {
        resume: args.resume,
        retry: args.retry,
        video: true,
        input: input.clone(),
        masks,
        suspects: args.suspects.clone(),
    };
    let advice = format!("give a printf pattern as output, such as {:?}", out.join("%06d.png"));
    let sources = [("left", sides[0].as_path()), ("right", sides[1].as_path())];
    let mut store = Store::new(out, params, &sources, &planned, &advice, mode)?;
    store.fill(planned)?;
    Ok(store)
}

impl Video {
    /// Computes all frames and prints the summary.
    pub fn run(self) -> Result<Outcome> {
        let stop = pipeline::stop_on_signals();
        let threads = pipeline::threads();
        let setup = Setup {
            device: &self.device,
            params: &self.params,
            input: &self.input,
            looked_at: LOOKED_AT,
            in_flight: self.in_flight,
            readers: threads,
            writers: if let Sink::Film(..) = self.sink { 1 } else { threads },
            mixed: false,
            kind: None,
            alone: false,
            unit: "frames",
            quiet: self.quiet,
        };
        let (ran, skipped) = match self.sink {
            Sink::Folder(store) => {
                if store.mode.suspects.is_some() {
                    trial::stop_with_parent(stop)?;
                }
                let ran = trial::run(&store, &setup, stop);
                let closed = store.close();
                let ran = whole(ran, store.pairs.len(), "were written: --resume computes the rest")?;
                closed?;
                (ran, store.skipped)
            }
            Sink::Numbered(pairs, work) => {
                (whole(pipeline::run(&pairs, &setup, stop, &work), pairs.len(), "were written")?, 0)
            }
            Sink::Film(pairs, film) => {
                let ran = pipeline::run(&pairs, &setup, stop, &film);
                let is_whole = ran.stopped.is_none();
                match film.finish(is_whole) {
                    Err(why) if is_whole => return Err(why),
                    // ffmpeg's own words are the cause.
                    Err(why) => {
                        bail!("{why:#}, after {} of {} frames; no video was written", ran.done, pairs.len())
                    }
                    Ok(()) => (whole(ran, pairs.len(), "were done, and no video was written")?, 0),
                }
            }
        };
        let failed = !ran.failed.is_empty();
        let summary = Summary::new(ran, skipped, &self.params, &self.output);
        if self.json {
            terminal::print_json(&summary)?;
        } else if !self.quiet {
            terminal::print(&summary.text()?)?;
        }
        Ok(if failed { Outcome::FramesFailed } else { Outcome::Done })
    }
}

/// What came of all frames, unless it was stopped.
fn whole(mut ran: Ran, frames: usize, kept: &str) -> Result<Ran> {
    match ran.stopped.take() {
        Some(error) => bail!("{error:#}; {} of {frames} frames {kept}", ran.done),
        None => Ok(ran),
    }
}

/// What came of a video; `--json` prints it as it is.
#[derive(Serialize)]
struct Summary {
    /// Adapter, backend, driver and size are unknown where there was nothing to compute.
    adapter: Option<String>,
    backend: Option<String>,
    driver: Option<String>,
    width: Option<u32>,
    height: Option<u32>,
    min_disparity: i32,
    disparities: u32,
    /// All frames: those done, failed and skipped.
    frames: usize,
    done: usize,
    failed: usize,
    skipped: usize,
    /// From the start to the last frame written, with the creation of device and pipelines.
    seconds: f64,
    frames_per_second: f64,
    peak_device_bytes: u64,
    failures: Vec<Failure>,
    /// Why maps are doubtful.
    warnings: Vec<String>,
    /// The line on doubtful ones.
    #[serde(skip)]
    doubts: String,
    #[serde(serialize_with = "report::path")]
    output: PathBuf,
}

impl Summary {
    fn new(ran: Ran, skipped: usize, params: &Params, output: &Path) -> Self {
        let (warnings, doubts) = (ran.warnings(), ran.doubts("frames"));
        let (adapter, backend, driver) = ran.names.map_or((None, None, None), |(a, b, d)| (Some(a), Some(b), Some(d)));
        let round = |value: f64| (value * 1e3).round() / 1e3;
        Self {
            adapter,
            backend,
            driver,
            width: ran.size.map(|(width, _)| width),
            height: ran.size.map(|(_, height)| height),
            min_disparity: params.min_disparity,
            disparities: params.disparities,
            frames: ran.done + ran.failed.len() + skipped,
            done: ran.done,
            failed: ran.failed.len(),
            skipped,
            seconds: round(ran.seconds),
            frames_per_second: round(ran.done as f64 / ran.seconds.max(1e-9)),
            peak_device_bytes: ran.device_bytes,
            warnings,
            doubts,
            failures: ran.failed,
            output: output.into(),
        }
    }

    fn text(&self) -> Result<String> {
        let mut text = String::new();
        if let (Some(adapter), Some(backend), Some(driver)) = (&self.adapter, &self.backend, &self.driver) {
            writeln!(text, "adapter  {}", plain(&format!("{adapter} ({backend}, {driver})")))?;
        }
        if let (Some(width), Some(height)) = (self.width, self.height) {
            writeln!(text, "size     {width} x {height}")?;
        }
        let last = i64::from(self.min_disparity) + i64::from(self.disparities) - 1;
        writeln!(text, "range    {} disparities, {} to {last} px", self.disparities, self.min_disparity)?;
        writeln!(text, "frames   {} done, {} failed, {} there already", self.done, self.failed, self.skipped)?;
        text += &self.doubts;
        writeln!(text, "time     {:.1} s, {:.1} frames a second", self.seconds, self.frames_per_second)?;
        match self.done {
            0 => text += "written  nothing\n",
            _ => writeln!(text, "written  {}", name(&self.output))?,
        }
        Ok(text)
    }
}
