//! Batch: the maps of all pairs of a data set, or of a share of them.

use crate::args::{BatchArgs, DeviceArgs, InputArgs, Shard};
use crate::list::{self, Listed};
use crate::mask::MaskFiles;
use crate::output::{self, Format};
use crate::pipeline::{self, Pair, Ran, Setup};
use crate::store::{self, Failed, Item, Mode, Planned, Store};
use crate::terminal::{self, name, plain};
use crate::{Outcome, disk, pairs, report, resolve, trial};
use anyhow::{Context as _, Result, bail};
use gpu_stereo::Params;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

const MAX_THREADS: usize = 64;

/// A batch, ready to start.
pub struct Batch {
    store: Store,
    shard: Option<Shard>,
    device: DeviceArgs,
    input: InputArgs,
    params: Params,
    in_flight: usize,
    threads: usize,
    json: bool,
    quiet: bool,
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
    params.confidence = formats.contains(&Format::Confidence);
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
    if args.no_sync {
        disk::leave_to_the_system();
    }

    let planned = plan(&args, &formats)?;
    let mode = Mode {
        resume: args.resume,
        retry: args.retry,
        video: false,
        input: args.input.clone(),
        masks,
        suspects: args.suspects,
    };
    let advice = "give each a name of its own in a list";
    let mut store = Store::new(&args.output, &params, &[], &planned, advice, mode)?;
    store.fill(match args.shard {
        Some(Shard { index, count }) if store.mode.suspects.is_none() => {
            planned.into_iter().skip(index - 1).step_by(count).collect()
        }
        _ => planned,
    })?;
    resolve::tell_unused(&[(given, &params)]);
    Ok(Batch {
        store,
        shard: args.shard,
        device: args.device,
        input: args.input,
        params,
        in_flight,
        threads,
        json: args.json,
        quiet: args.quiet,
    })
}

/// All pairs, and what they become.
fn plan(args: &BatchArgs, formats: &[Format]) -> Result<Vec<Planned>> {
    let planned = |pair, name, line| Planned { pair, item: Item::new(&args.output, name, formats), line };
    if let Some(journal) = &args.suspects {
        let suspects = store::suspects(journal)?.into_iter();
        return Ok(suspects.map(|(pair, name)| planned(pair, name, None)).collect());
    }
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
    let names = list::names(&listed)?.into_iter();
    let pairs = listed.into_iter().map(|Listed { line, left, right, .. }| (Pair { left, right }, line));
    Ok(pairs.zip(names).map(|((pair, line), name)| planned(pair, name, line)).collect())
}

impl Batch {
    /// Computes all pairs and prints the summary.
    pub fn run(self) -> Result<Outcome> {
        let Self { store, shard, device, input, params, in_flight, threads, json, quiet } = self;
        let stop = pipeline::stop_on_signals();
        if store.mode.suspects.is_some() {
            trial::stop_with_parent(stop)?;
        }
        let setup = Setup {
            device: &device,
            params: &params,
            input: &input,
            looked_at: 1,
            in_flight,
            readers: threads,
            writers: threads,
            mixed: true,
            kind: None,
            alone: false,
            unit: "pairs",
            quiet,
        };
        let mut ran = trial::run(&store, &setup, stop);
        let closed = store.close();
        if let Some(error) = ran.stopped.take() {
            let (done, pairs) = (ran.done, store.pairs.len());
            bail!("{error:#}; {done} of {pairs} pairs were written: --resume computes the rest");
        }
        closed?;
        let any_failed = !ran.failed.is_empty();
        let summary = Summary::new(&store, &params, shard, ran);
        if json {
            terminal::print_json(&summary)?;
        } else if !quiet {
            terminal::print(&summary.text(&params, &store)?)?;
        }
        Ok(if any_failed { Outcome::FramesFailed } else { Outcome::Done })
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
    failures: Vec<Failed>,
    /// Why maps are doubtful.
    warnings: Vec<String>,
    /// The line on doubtful ones.
    #[serde(skip)]
    doubts: String,
    #[serde(serialize_with = "report::path")]
    output: PathBuf,
}

impl Summary {
    fn new(store: &Store, params: &Params, shard: Option<Shard>, ran: Ran) -> Self {
        let (warnings, doubts) = (ran.warnings(), ran.doubts("pairs"));
        let (adapter, backend, driver) = ran.names.map_or((None, None, None), |(a, b, d)| (Some(a), Some(b), Some(d)));
        let round = |value: f64| (value * 1e3).round() / 1e3;
        Self {
            adapter,
            backend,
            driver,
            min_disparity: params.min_disparity,
            disparities: params.disparities,
            shard: shard.map(|Shard { index, count }| format!("{index}/{count}")),
            pairs: ran.done + ran.failed.len() + store.skipped,
            done: ran.done,
            failed: ran.failed.len(),
            skipped: store.skipped,
            seconds: round(ran.seconds),
            pairs_per_second: round(ran.done as f64 / ran.seconds.max(1e-9)),
            peak_device_bytes: ran.device_bytes,
            failures: ran.failed.iter().map(|failure| store.failure(failure.place, &failure.error)).collect(),
            warnings,
            doubts,
            output: store.out.clone(),
        }
    }

    fn text(&self, params: &Params, store: &Store) -> Result<String> {
        let mut text = String::new();
        if let (Some(adapter), Some(backend), Some(driver)) = (&self.adapter, &self.backend, &self.driver) {
            writeln!(text, "adapter  {}", plain(&format!("{adapter} ({backend}, {driver})")))?;
        }
        let (first, last) = output::searched(params);
        writeln!(text, "range    {} disparities, {first} to {last} px", self.disparities)?;
        if let Some(shard) = &self.shard {
            writeln!(text, "shard    {shard}")?;
        }
        writeln!(text, "pairs    {} done, {} failed, {} there already", self.done, self.failed, self.skipped)?;
        text += &self.doubts;
        writeln!(text, "time     {:.1} s, {:.1} pairs a second", self.seconds, self.pairs_per_second)?;
        match self.done {
            0 => text += "written  nothing\n",
            _ => writeln!(text, "written  {}", name(&self.output))?,
        }
        if self.failed > 0 {
            writeln!(text, "failed   {}", name(&store.failures.path))?;
        }
        Ok(text)
    }
}
