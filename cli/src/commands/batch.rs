//! `batch`: the maps of all pairs of a data set, or of a share of them.

use super::network;
use super::outcome::Outcome;
use super::summary::{Searched, Summary};
use crate::args::{self, BatchArgs, DeviceArgs, InputArgs, Shard};
use crate::engine::compute::{Cameras, ParamsBySize};
use crate::engine::pair::Pair;
use crate::engine::pipeline::Setup;
use crate::engine::signals::stop_on_signals;
use crate::engine::store::{self, FailedLine, Item, Mode, Planned, Store};
use crate::engine::{adapter, pairs, trial};
use crate::engine::{disk, images, output_files};
use anyhow::{Result, bail};
use gpu_stereo::files::encoders::Format;
use gpu_stereo::files::lists::{self, Listed};
use gpu_stereo::files::masks::MaskFiles;

/// A batch, ready to start.
struct Batch {
    store: Store,
    shard: Option<Shard>,
    device: DeviceArgs,
    input: InputArgs,
    params: ParamsBySize,
    keeps_right: bool,
    in_flight: usize,
    threads: usize,
    json: bool,
    quiet: bool,
}

/// Matches all pairs.
pub fn run(args: BatchArgs) -> Result<Outcome> {
    let batch = resolve(args)?;
    let (json, quiet) = (batch.json, batch.quiet);
    let summary = batch.run()?;
    summary.print(json, quiet)?;
    Ok(Outcome::failed_if(!summary.failures.is_empty()))
}

/// Checks everything that can be checked without reading an image or opening a device.
fn resolve(typed: BatchArgs) -> Result<Batch> {
    let given: Vec<_> = typed.settings.iter().map(|(name, _)| name).collect();
    args::ensure_disparities(&given)?;
    let mut params = args::params(typed.settings.iter())?;
    let formats = output_files::formats(&typed.formats.format, &typed.look, &params)?;
    output_files::want(&mut params, &formats);
    let cameras = Cameras::resolve(&typed.cameras)?;
    cameras.ensure_fit(output_files::asks_for_depth(&formats), typed.look.scale_bar)?;
    output_files::ensure_rectified(&formats, &cameras)?;
    output_files::note_look(typed.look.look(), &formats);
    network::give(&typed.network, [&mut params])?;
    let masks = MaskFiles::resolve(typed.masks.mask_in.as_deref())?;
    params.masks = images::reported(masks.read()?);
    adapter::ensure_consistent(&typed.device)?;
    let in_flight = args::in_flight(&typed.in_flight)?;
    output_files::ensure_ranges(&formats, &typed.output, &params)?;
    let (range, held) = (typed.settings.range(), output_files::held(formats.iter().copied()));
    let threads = typed.threads.as_ref().map_or(Ok(args::usual_threads()), args::threads)?;
    if typed.bulk.no_sync {
        disk::leave_to_the_system();
    }

    let planned = plan(&typed, &formats)?;
    let mode = Mode {
        resume: typed.bulk.resume,
        retry: typed.bulk.retry,
        video: false,
        own_ranges: range.is_found(),
        input: typed.input.of_many(),
        more: [output_files::decisive(&cameras, &typed.look), output_files::decisive_range(range, held.as_ref())]
            .concat(),
        inputs: masks.paths().chain(cameras.files()).chain(typed.network.weights.as_deref()).map(Into::into).collect(),
        suspects: typed.bulk.suspects,
    };
    let advice = "give each a name of its own in a list";
    let mut store = Store::new(&typed.output, &params, &[], &planned, advice, mode)?;
    store.fill(match typed.shard {
        Some(Shard { index, count }) if store.mode.suspects.is_none() => {
            planned.into_iter().skip(index - 1).step_by(count).collect()
        }
        _ => planned,
    })?;
    args::report_unused(&[(given, &params)]);
    let depth = formats.iter().any(|format| format.needs_depth()) || (typed.look.scale_bar && cameras.are_known());
    let params = ParamsBySize::new(params, cameras, depth).with_ranges(range, held, &typed.device);
    Ok(Batch {
        shard: typed.shard,
        device: typed.device,
        input: store.mode.input.clone(),
        store,
        params,
        keeps_right: output_files::keeps_right(&formats),
        in_flight,
        threads,
        json: typed.bulk.json,
        quiet: typed.bulk.quiet,
    })
}

/// All pairs, and what they become.
fn plan(args: &BatchArgs, formats: &[Format]) -> Result<Vec<Planned>> {
    let planned = |pair, name, line| Planned { pair, item: Item::new(&args.output, name, formats), line };
    if let Some(journal) = &args.bulk.suspects {
        let suspects = store::suspects(journal)?.into_iter();
        return Ok(suspects.map(|(pair, name)| planned(pair, name, None)).collect());
    }
    let unnamed = |(_, Pair { left, right }): (u64, Pair)| Listed { line: None, left, right, name: None };
    let listed = match &args.pairs[..] {
        [path] if args.input.split.is_none() || lists::is_list(path) => lists::read(path)?,
        [both] => images::find_in_one(both, &args.input)?.into_iter().map(unnamed).collect(),
        [left, right] => pairs::find(left, right)?.into_iter().map(unnamed).collect(),
        more => bail!(
            "{} names were given, but a list or LEFT and RIGHT are needed; put a glob in quotes, or the shell replaces it \
             by names",
            more.len()
        ),
    };
    let names = lists::names(&listed)?.into_iter();
    let pairs = listed.into_iter().map(|Listed { line, left, right, .. }| (Pair { left, right }, line));
    Ok(pairs.zip(names).map(|((pair, line), name)| planned(pair, name, line)).collect())
}

impl Batch {
    /// Computes all pairs.
    fn run(self) -> Result<Summary<FailedLine>> {
        let Self { store, shard, device, input, params, keeps_right, in_flight, threads, quiet, .. } = self;
        let stop = stop_on_signals();
        if store.mode.suspects.is_some() {
            trial::stop_with_parent(stop)?;
        }
        let setup = Setup {
            device: &device,
            params: &params,
            input: &input,
            diagnosed: 1,
            keeps_right,
            in_flight,
            readers: threads,
            writers: threads,
            mixed: true,
            kind: None,
            alone: false,
            unit: "pairs",
            of_first: false,
            quiet,
        };
        let mut ran = trial::run(&store, &setup, stop);
        let closed = store.close();
        if let Some(error) = ran.stopped.take() {
            let (done, pairs) = (ran.done, store.pairs.len());
            bail!("{error:#}; {done} of {pairs} pairs were written: --resume computes the rest");
        }
        closed?;
        let failures = ran.failed.iter().map(|failed| store.failure(failed.place, &failed.error)).collect();
        let skipped = store.skipped();
        let summary = Summary::new("pairs", ran, Searched::of(&params), store.out, failures);
        let shard = shard.map(|Shard { index, count }| format!("{index}/{count}"));
        Ok(Summary { shard: Some(shard), skipped, log: Some(store.failures.path), ..summary })
    }
}
