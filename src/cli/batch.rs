//! Batch: the maps of all pairs of a data set, or of a share of them.

use crate::args::{BatchArgs, DeviceArgs, InputArgs, Shard};
use crate::list::{self, Listed};
use crate::log::{Line, Log};
use crate::mask::MaskFiles;
use crate::output::{self, Output};
use crate::pipeline::{self, Frame, Pair, Ran, Refused, Setup};
use crate::record::{Found, Record};
use crate::terminal::{self, name, plain};
use crate::{Outcome, pairs, report, resolve};
use anyhow::{Context as _, Result, anyhow, bail};
use gpu_stereo::Params;
use serde::Serialize;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

const MAX_THREADS: usize = 64;

/// A batch, ready to start.
pub struct Batch {
    /// Those to compute.
    pairs: Vec<Pair>,
    /// Of each of these.
    items: Vec<Item>,
    /// Pairs whose files were there already.
    skipped: usize,
    shard: Option<Shard>,
    device: DeviceArgs,
    input: InputArgs,
    params: Params,
    in_flight: usize,
    threads: usize,
    record: Record,
    done: Log,
    failures: Log,
    begun: OnceLock<Result<(), String>>,
    output: PathBuf,
    json: bool,
    quiet: bool,
}

/// What a pair becomes.
struct Item {
    name: String,
    outputs: Vec<Output>,
}

/// Checks everything that can be checked without reading an image or opening a device.
pub fn resolve(args: BatchArgs) -> Result<Batch> {
    let given: Vec<_> = args.settings.iter().map(|(name, _)| name).collect();
    resolve::ensure_disparities(&given)?;
    let mut params = resolve::params(args.settings.iter())?;
    let mut formats = output::formats(&args.format)?;
    if formats.is_empty() {
        formats.push(output::default_format(&params, "NAME"));
    }
    params.confidence = formats.contains(&output::Format::Confidence);
    let masks = MaskFiles::resolve(args.masks.mask_in.as_deref())?;
    params.masks = masks.read()?;
    resolve::ensure_adapter(&args.device)?;
    let in_flight = pipeline::in_flight(&args.in_flight)?;
    output::ensure_ranges(&args.format, &args.output, &params)?;
    let threads = match &args.threads {
        None => pipeline::threads(),
        Some(given) => {
            let threads = usize::try_from(given.value).ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
            threads.with_context(|| {
                format!("--threads is {}, but must be from 1 to {MAX_THREADS}; half of the cores is usual", given.text)
            })?
        }
    };

    let listed = match &args.pairs[..] {
        [path] => list::read(path)?,
        [left, right] => {
            let unnamed = |(_, Pair { left, right }): (u64, Pair)| Listed { line: None, left, right, name: None };
            pairs::find(left, right)?.into_iter().map(unnamed).collect()
        }
        more => bail!(
            "{} names were given, but a list or LEFT and RIGHT are needed; put a glob in quotes, or the shell replaces it \
             by names",
            more.len()
        ),
    };
    let out = &args.output;
    let item = |name: PathBuf| {
        let file = |&format: &output::Format| {
            let mut path = out.join(&name).into_os_string();
            path.push(format.suffix());
            Output::at(path.into(), format)
        };
        Item { outputs: formats.iter().map(file).collect(), name: name.to_string_lossy().into_owned() }
    };
    let items: Vec<_> = list::names(&listed)?.into_iter().map(item).collect();
    ensure_distinct(&items, &listed)?;
    let pairs = listed.into_iter().map(|Listed { left, right, .. }| Pair { left, right });
    let all: Vec<_> = pairs.zip(items).collect();

    output::make_folder(out, out)?;
    let paths = all.iter().flat_map(|(_, item)| &item.outputs).map(|output| output.path.as_path());
    output::ensure_no_input(paths, all.iter().map(|(pair, _)| pair), &masks)?;
    let record = Record::new(out, &params, &args.input, &[]);
    let found = record.ensure_no_other()?;
    let log = |name: &str| Log { path: out.join(name) };
    let (done, failures) = (log("done.jsonl"), log("failures.jsonl"));

    let mut share: Vec<_> = match args.shard {
        Some(Shard { index, count }) => all.into_iter().skip(index - 1).step_by(count).collect(),
        None => all,
    };
    let before = share.len();
    if args.resume && found == Found::Same {
        // The last line of a name tells what its files show.
        let done: HashMap<_, _> = done.read()?.into_iter().map(|line| (line.name.clone(), line)).collect();
        share.retain(|(pair, item)| {
            let whole = |output: &Output| fs::metadata(&output.path).is_ok_and(|file| file.is_file() && file.len() > 0);
            !(done.get(&item.name) == Some(&Line::new(&item.name, pair)) && item.outputs.iter().all(whole))
        });
    }
    resolve::tell_unused(&[(given, &params)]);
    let skipped = before - share.len();
    let (pairs, items) = share.into_iter().unzip();
    Ok(Batch {
        pairs,
        items,
        skipped,
        shard: args.shard,
        device: args.device,
        input: args.input,
        params,
        in_flight,
        threads,
        record,
        done,
        failures,
        begun: OnceLock::new(),
        output: args.output,
        json: args.json,
        quiet: args.quiet,
    })
}

/// No two pairs have a file in common.
fn ensure_distinct(items: &[Item], listed: &[Listed]) -> Result<()> {
    let told = |pair: &Listed| {
        let line = pair.line.map(|line| format!(" (line {line})")).unwrap_or_default();
        format!("{:?}{line}", pair.left)
    };
    let mut known = HashMap::new();
    for (item, pair) in items.iter().zip(listed) {
        for Output { path, .. } in &item.outputs {
            // Where the system usually takes A and a for the same.
            let caseless = cfg!(any(windows, target_os = "macos"));
            let key = if caseless { path.to_string_lossy().to_lowercase().into() } else { path.clone() };
            if let Some(other) = known.insert(key, pair) {
                bail!(
                    "{} and {} would both become {path:?}; give each a name of its own in a list",
                    told(other),
                    told(pair)
                );
            }
        }
    }
    Ok(())
}

impl Batch {
    /// Computes all pairs and prints the summary.
    pub fn run(self) -> Result<Outcome> {
        let stop = pipeline::stop_on_signals();
        let setup = Setup {
            device: &self.device,
            params: &self.params,
            input: &self.input,
            looked_at: 1,
            in_flight: self.in_flight,
            readers: self.threads,
            writers: self.threads,
            mixed: true,
            unit: "pairs",
            quiet: self.quiet,
        };
        let failed = |place: usize, error: &str| {
            let line = Line::new(&self.items[place].name, &self.pairs[place]);
            self.failures.append(&Line { error: Some(error.into()), ..line })
        };
        let mut ran = pipeline::run(&self.pairs, &setup, stop, |frame| self.put(frame), failed);
        if let Some(error) = ran.stopped.take() {
            let (done, pairs) = (ran.done, self.pairs.len());
            bail!("{error:#}; {done} of {pairs} pairs were written: --resume computes the rest");
        }
        let any_failed = !ran.failed.is_empty();
        let summary = self.summary(ran);
        if self.json {
            terminal::print_json(&summary)?;
        } else if !self.quiet {
            terminal::print(&self.text(&summary)?)?;
        }
        Ok(if any_failed { Outcome::FramesFailed } else { Outcome::Done })
    }

    fn put(&self, frame: &Frame) -> Result<(), Refused> {
        // Only now, so that a run that cannot compute changes nothing.
        let begun =
            self.begun.get_or_init(|| self.record.join(|| self.done.remove()).map_err(|error| format!("{error:#}")));
        if let Err(error) = begun {
            return Err(Refused::All(anyhow!("{error}")));
        }
        let (item, matched) = (&self.items[frame.place], &frame.matched);
        for folder in item.outputs.iter().filter_map(|output| output.path.parent()) {
            fs::create_dir_all(folder)
                .with_context(|| format!("output folder {folder:?} cannot be made; check what is in its place"))
                .map_err(Refused::Frame)?;
        }
        output::write(&item.outputs, &matched.map, matched.confidence.as_ref(), None, &self.params)
            .map_err(Refused::Frame)?;
        self.done.append(&Line::new(&item.name, &self.pairs[frame.place])).map_err(Refused::All)
    }

    fn summary(&self, ran: Ran) -> Summary {
        let (warnings, doubts) = (ran.warnings(), ran.doubts("pairs"));
        let (adapter, backend, driver) = ran.names.map_or((None, None, None), |(a, b, d)| (Some(a), Some(b), Some(d)));
        let round = |value: f64| (value * 1e3).round() / 1e3;
        let failed = ran.failed.iter().map(|failure| {
            let line = Line::new(&self.items[failure.place].name, &self.pairs[failure.place]);
            Line { error: Some(failure.error.clone()), ..line }
        });
        Summary {
            adapter,
            backend,
            driver,
            min_disparity: self.params.min_disparity,
            disparities: self.params.disparities,
            shard: self.shard.map(|Shard { index, count }| format!("{index}/{count}")),
            pairs: ran.done + ran.failed.len() + self.skipped,
            done: ran.done,
            failed: ran.failed.len(),
            skipped: self.skipped,
            seconds: round(ran.seconds),
            pairs_per_second: round(ran.done as f64 / ran.seconds.max(1e-9)),
            peak_device_bytes: ran.device_bytes,
            warnings,
            doubts,
            failures: failed.collect(),
            output: self.output.clone(),
        }
    }

    fn text(&self, summary: &Summary) -> Result<String> {
        let mut text = String::new();
        if let (Some(adapter), Some(backend), Some(driver)) = (&summary.adapter, &summary.backend, &summary.driver) {
            writeln!(text, "adapter  {}", plain(&format!("{adapter} ({backend}, {driver})")))?;
        }
        let (first, last) = output::searched(&self.params);
        writeln!(text, "range    {} disparities, {first} to {last} px", summary.disparities)?;
        if let Some(shard) = &summary.shard {
            writeln!(text, "shard    {shard}")?;
        }
        writeln!(text, "pairs    {} done, {} failed, {} there already", summary.done, summary.failed, summary.skipped)?;
        text += &summary.doubts;
        writeln!(text, "time     {:.1} s, {:.1} pairs a second", summary.seconds, summary.pairs_per_second)?;
        match summary.done {
            0 => text += "written  nothing\n",
            _ => writeln!(text, "written  {}", name(&summary.output))?,
        }
        if summary.failed > 0 {
            writeln!(text, "failed   {}", name(&self.failures.path))?;
        }
        Ok(text)
    }
}

/// What came of a batch; `--json` prints it as it is.
#[derive(Serialize)]
struct Summary {
    /// Adapter, backend and driver are unknown where there was nothing to compute.
    adapter: Option<String>,
    backend: Option<String>,
    driver: Option<String>,
    min_disparity: i32,
    disparities: u32,
    shard: Option<String>,
    /// All pairs of the shard: those done, failed and skipped.
    pairs: usize,
    done: usize,
    failed: usize,
    skipped: usize,
    /// From the start to the last pair written, with the creation of device and pipelines.
    seconds: f64,
    pairs_per_second: f64,
    peak_device_bytes: u64,
    failures: Vec<Line>,
    /// Why maps are doubtful.
    warnings: Vec<String>,
    /// The line on doubtful ones.
    #[serde(skip)]
    doubts: String,
    #[serde(serialize_with = "report::path")]
    output: PathBuf,
}
