//! Video: the maps of all frames of two cameras.

use crate::args::{DeviceArgs, InputArgs, VideoArgs};
use crate::film::{self, Film};
use crate::mask::MaskFiles;
use crate::output::{self, Format, Output};
use crate::pairs::{self, Pattern};
use crate::pipeline::{self, Failure, Frame, Pair, Ran, Refused, Setup};
use crate::record::Record;
use crate::terminal::{self, name, plain};
use crate::{Outcome, report, resolve, views};
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use gpu_stereo::Params;
use serde::Serialize;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const MAX_FPS: f64 = 1000.0;
/// One of so many frames is looked at whether it can be matched: what is wrong with the cameras is wrong with all.
const LOOKED_AT: usize = 16;

/// A video, ready to start.
pub struct Video {
    /// Those to compute.
    pairs: Vec<Pair>,
    /// The first ones of all, which decide how all are read.
    first: Vec<Pair>,
    /// Frames that were there already.
    skipped: usize,
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
    Files(Files),
    Film(Film),
}

struct Files {
    /// Of each pair to compute.
    outputs: Vec<Vec<Output>>,
    /// Of the pairs that were there already.
    skipped: Vec<Vec<Output>>,
    record: Option<Record>,
    begun: OnceLock<Result<(), String>>,
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

    let mut pairs = pairs::find(left, right)?;
    let first = pairs.iter().take(views::FIRST).map(|(_, pair)| pair.clone()).collect();
    let mut skipped = 0;
    let sink = if film::is_film(&args.output) {
        ensure!(
            args.format.is_empty() && !args.resume,
            "--format and --resume are for numbered files, but output {:?} is a video; drop them, or give a folder",
            args.output
        );
        output::ensure_no_input([args.output.as_path()], pairs.iter().map(|(_, pair)| pair), &masks)?;
        let fps = args.fps.as_deref().unwrap_or("10");
        ensure!(
            fps.parse().is_ok_and(|fps: f64| fps > 0.0 && fps <= MAX_FPS),
            "--fps is {fps:?}, but must be above 0 and at most {MAX_FPS}; 10 is usual"
        );
        Sink::Film(Film::new(&args.output, fps, output::searched(&params))?)
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
        let mut files = Files::resolve(&args, &pairs, &params, [left, right], &masks)?;
        if args.resume {
            skipped = files.skip(&mut pairs)?;
        }
        Sink::Files(files)
    };
    resolve::tell_unused(&[(given, &params)]);
    Ok(Video {
        pairs: pairs.into_iter().map(|(_, pair)| pair).collect(),
        first,
        skipped,
        device: args.device,
        input: args.input,
        params,
        in_flight,
        sink,
        output: args.output,
        json: args.json,
        quiet: args.quiet,
    })
}

impl Files {
    fn resolve(
        args: &VideoArgs,
        pairs: &[(u64, Pair)],
        params: &Params,
        sides: [&PathBuf; 2],
        masks: &MaskFiles,
    ) -> Result<Self> {
        let out = &args.output;
        let mut formats = output::formats(&args.format)?;
        let pattern = Pattern::parse(out).with_context(|| format!("output is {out:?}"))?;
        let (folder, names): (&Path, Vec<Vec<Output>>) = match &pattern {
            Some(pattern) => {
                ensure!(!args.resume, "--resume needs a folder, but output is {out:?}; give a folder, or drop it");
                let of_name = output::map_format(&pattern.path(0))?;
                let format = match formats[..] {
                    [] => of_name,
                    [format] if format.suffix().ends_with(&format!(".{}", output::ending(out))) => format,
                    _ => bail!(
                        "output {out:?} is one file a frame, and --format must fit its ending; drop it, or give a folder"
                    ),
                };
                let file = |(number, _): &(u64, Pair)| vec![Output::at(pattern.path(*number), format)];
                (pattern.folder(), pairs.iter().map(file).collect())
            }
            None => {
                if formats.is_empty() {
                    formats.push(output::default_format(params, "NAME"));
                }
                let files = |(_, pair): &(u64, Pair)| {
                    let stem = pair.left.file_stem().unwrap_or_default();
                    let file = |&format: &Format| {
                        let mut name = stem.to_owned();
                        name.push(format.suffix());
                        Output::at(out.join(name), format)
                    };
                    formats.iter().map(file).collect()
                };
                (out, pairs.iter().map(files).collect())
            }
        };
        let mut frames = HashMap::new();
        for (outputs, (_, pair)) in names.iter().zip(pairs) {
            for output in outputs {
                if let Some(other) = frames.insert(&output.path, &pair.left) {
                    bail!(
                        "{:?} and {other:?} would both become {:?}; give a printf pattern as output, such as {:?}",
                        pair.left,
                        output.path,
                        out.join("%06d.png")
                    );
                }
            }
        }
        output::make_folder(folder, out)?;
        let all = names.iter().flatten().map(|output| output.path.as_path());
        output::ensure_no_input(all, pairs.iter().map(|(_, pair)| pair), masks)?;
        let record = pattern
            .is_none()
            .then(|| Record::new(out, params, &args.input, &[("left", sides[0]), ("right", sides[1])]));
        Ok(Self { outputs: names, skipped: Vec::new(), record, begun: OnceLock::new() })
    }

    /// Drops the pairs whose files are all there.
    fn skip(&mut self, pairs: &mut Vec<(u64, Pair)>) -> Result<usize> {
        let exists = |output: &Output| fs::metadata(&output.path).is_ok_and(|file| file.is_file() && file.len() > 0);
        if let Some(record) = &self.record {
            record.ensure_same(self.outputs.iter().flatten().any(exists))?;
        }
        let all = std::mem::take(&mut self.outputs).into_iter().zip(std::mem::take(pairs));
        let (there, missing): (Vec<_>, Vec<_>) = all.partition(|(outputs, _)| outputs.iter().all(exists));
        (self.outputs, *pairs) = missing.into_iter().unzip();
        self.skipped = there.into_iter().map(|(outputs, _)| outputs).collect();
        Ok(self.skipped.len())
    }

    fn put(&self, frame: &Frame, params: &Params) -> Result<(), Refused> {
        // Only now, so that a run that cannot compute changes nothing.
        let begun = self.begun.get_or_init(|| {
            let all = self.outputs.iter().chain(&self.skipped).flatten();
            self.record.as_ref().map_or(Ok(()), |record| record.begin(all)).map_err(|error| format!("{error:#}"))
        });
        if let Err(error) = begun {
            return Err(Refused::All(anyhow!("the output folder cannot be written: {error}; check its permissions")));
        }
        let matched = &frame.matched;
        output::write(&self.outputs[frame.place], &matched.map, matched.confidence.as_ref(), None, params)
            .map_err(Refused::Frame)
    }
}

impl Video {
    /// Computes all frames and prints the summary.
    pub fn run(self) -> Result<Outcome> {
        let stop = pipeline::stop_on_signals();
        let threads = pipeline::threads();
        let input = views::as_first(&self.input, &self.first);
        let setup = Setup {
            device: &self.device,
            params: &self.params,
            input: &input,
            looked_at: LOOKED_AT,
            in_flight: self.in_flight,
            readers: threads,
            writers: if let Sink::Film(_) = self.sink { 1 } else { threads },
            mixed: false,
            unit: "frames",
            quiet: self.quiet,
        };
        let put = |frame: &Frame| match &self.sink {
            Sink::Files(files) => files.put(frame, &self.params),
            Sink::Film(film) => film.put(frame),
        };
        let mut ran = pipeline::run(&self.pairs, &setup, stop, put, |_, _| Ok(()));
        let (frames, done, stopped) = (self.pairs.len(), ran.done, ran.stopped.take());
        let kept = match self.sink {
            Sink::Files(files) => files.record.map_or("were written", |_| "were written: --resume computes the rest"),
            Sink::Film(film) => {
                let finished = film.finish(stopped.is_none());
                if stopped.is_none() {
                    finished?;
                } else if let Err(why) = finished {
                    // ffmpeg's own words are the cause.
                    bail!("{why:#}, after {done} of {frames} frames; no video was written");
                }
                "were done, and no video was written"
            }
        };
        if let Some(error) = stopped {
            bail!("{error:#}; {done} of {frames} frames {kept}");
        }
        let failed = !ran.failed.is_empty();
        let summary = Summary::new(ran, self.skipped, &self.params, &self.output);
        if self.json {
            terminal::print_json(&summary)?;
        } else if !self.quiet {
            terminal::print(&summary.text()?)?;
        }
        Ok(if failed { Outcome::FramesFailed } else { Outcome::Done })
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
