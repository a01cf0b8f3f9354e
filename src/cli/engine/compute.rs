//! The engine computes the maps of pairs of one size and format: on an adapter, or by the CPU reference.

use super::adapter::{self, Opened};
use super::environment;
use crate::args::{Backend, DeviceArgs};
use crate::terminal::{message, plain, to_microseconds, watched};
use anyhow::{Result, bail};
use gpu_stereo::network::{Operation, Padded};
use gpu_stereo::{Error, Image, Matched, Method, Params, StageCheck, StageTime, StereoMatcher, cpu, memory, reference};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// An adapter with a matcher, or the CPU reference.
pub enum Engine {
    Adapter(Box<OnAdapter>),
    Reference,
}

pub struct OnAdapter {
    pub opened: Opened,
    pub matcher: StereoMatcher,
}

/// The names of the adapter and its driver; `--json` prints them as they are.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EngineNames {
    /// The adapter's name.
    pub adapter: String,
    /// The graphics interface, or `cpu` for the reference.
    pub backend: String,
    /// The driver's name and version.
    pub driver: String,
}

/// Frame times in milliseconds.
#[derive(Debug, Serialize)]
pub struct FrameMs {
    /// The median.
    #[serde(serialize_with = "to_microseconds")]
    pub median: f64,
    /// The smallest.
    #[serde(serialize_with = "to_microseconds")]
    pub min: f64,
}

/// The result of computing one pair, once or several times.
pub struct Computed {
    /// The map and its confidence.
    pub matched: Matched,
    /// When the first frame was done.
    pub first: Instant,
    /// The time of a frame.
    pub times: FrameMs,
    /// The median time of each stage, where it was asked for.
    pub stages: Vec<StageTime>,
}

impl Engine {
    /// What computes with `params` maps of pairs that are as `image` is. `needed_for`: what
    /// only an adapter can do.
    pub fn open(device: &DeviceArgs, needed_for: Option<&str>, image: &Image, params: &Params) -> Result<Self> {
        let (backend, wanted) = (device.backend, device.adapter.as_deref());
        if backend == Backend::Cpu {
            return Self::reference(image, params);
        }
        let mut adapters = adapter::ranked()?;
        if let Some(wanted) = wanted {
            let names: Vec<_> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
            adapters = vec![adapters.swap_remove(adapter::choose(&names, wanted)?)];
        }
        let only = adapters.len() == 1 && wanted.is_some();
        for adapter in &adapters {
            let opened = adapter::open(adapter).and_then(|opened| Self::on(opened, image, params));
            match opened {
                Ok(engine) => return Ok(engine),
                // An adapter that cannot run the kernels is skipped, and that is reported.
                Err(error @ (Error::Adapter(_) | Error::Device(_))) if !only => {
                    message(&format!("note: {}: {error}", plain(&adapter.get_info().name)));
                }
                Err(error) => return Err(error.into()),
            }
        }
        let why = environment::why_none();
        if backend == Backend::Gpu {
            bail!("--backend is gpu, but there is no usable adapter{why}; install a Vulkan driver, or use auto or cpu");
        }
        if let Some(what) = needed_for {
            bail!("{what}, but there is no usable adapter{why}; install a Vulkan driver");
        }
        let by = if params.method == Method::Psmnet { "on the CPU" } else { "with the CPU reference" };
        message(&format!("note: no usable GPU or CPU adapter{why}; computing {by}"));
        Self::reference(image, params)
    }

    /// The engine in `kept` with other settings, or a new one if there is none; it stays in `kept`.
    pub fn again<'a>(
        kept: &'a mut Option<Self>,
        device: &DeviceArgs,
        image: &Image,
        params: &Params,
    ) -> Result<&'a Self> {
        let engine = match kept.take() {
            None => Self::open(device, None, image, params)?,
            Some(Self::Adapter(on)) => {
                let OnAdapter { opened, matcher } = *on;
                drop(matcher); // its memory goes to the next one
                Self::on(opened, image, params)?
            }
            Some(Self::Reference) => Self::reference(image, params)?,
        };
        Ok(kept.insert(engine))
    }

    fn on(opened: Opened, image: &Image, params: &Params) -> Result<Self, Error> {
        let (width, height) = (image.width(), image.height());
        let matcher = StereoMatcher::new(&opened.device, &opened.queue, width, height, image.format(), params);
        opened.fault()?;
        let matcher = matcher?;
        Ok(Self::Adapter(Box::new(OnAdapter { opened, matcher })))
    }

    /// The reference, if its volumes fit.
    fn reference(image: &Image, params: &Params) -> Result<Self> {
        ensure_reference(params, image)?;
        Ok(Self::Reference)
    }

    /// `repeat` frames after a warm-up; `None`: the first frame is the only one. `show`: is told which share of a frame is
    /// done, from 0 to 1, where a network takes long.
    pub fn frames(
        &self,
        left: &Image,
        right: &Image,
        params: &Params,
        timed: bool,
        repeat: Option<u32>,
        show: &(dyn Fn(f64) + Sync),
    ) -> Result<Computed, Error> {
        let compute = || with_progress(left, params, show, || self.compute(left, right, params, timed));
        let before_first = Instant::now();
        let (mut matched, stages) = compute()?;
        let first = Instant::now();
        let mut frames = vec![(milliseconds(before_first), stages)];
        if let Some(repeat) = repeat {
            frames.clear(); // the first frame was the warm-up
            for _ in 0..repeat {
                let before = Instant::now();
                let (frame, stages) = compute()?;
                frames.push((milliseconds(before), stages));
                matched = frame;
            }
        }
        let (times, stages): (Vec<_>, Vec<_>) = frames.into_iter().unzip();
        let times = FrameMs { min: times.iter().copied().fold(f64::INFINITY, f64::min), median: median(times) };
        Ok(Computed { matched, first, times, stages: median_stages(stages) })
    }

    fn compute(
        &self,
        left: &Image,
        right: &Image,
        params: &Params,
        timed: bool,
    ) -> Result<(Matched, Vec<StageTime>), Error> {
        match self {
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = on.as_ref();
                let frame = if timed {
                    matcher.compute_timed_blocking(left, right)
                } else {
                    matcher.compute_blocking(left, right).map(|matched| (matched, Vec::new()))
                };
                opened.fault()?;
                frame
            }
            Self::Reference if timed => without_adapter(left, right, params),
            Self::Reference => without_adapter(left, right, params).map(|(matched, _)| (matched, Vec::new())),
        }
    }

    /// Compares each stage with the reference.
    pub fn check(&self, left: &Image, right: &Image, params: &Params) -> Result<Vec<StageCheck>> {
        // Column sums of four bytes, the cost, every direction, and an aggregate of two bytes.
        let more = match params.method {
            Method::Sgm => params.paths.count().into(),
            Method::Bp => BELIEF_BYTES,
            Method::Psmnet => 1, // doubles
            _ => 0,
        };
        ensure_memory("the reference that --check compares with", params, left, 7 + more)?;
        match self {
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = on.as_ref();
                let stages = matcher.check_blocking(left, right);
                opened.fault()?;
                Ok(stages?)
            }
            Self::Reference => Ok(Vec::new()), // refused before: there is nothing to compare
        }
    }

    /// The names and texts of the kernels.
    pub fn shaders(&self) -> Vec<(String, &str)> {
        match self {
            Self::Adapter(on) => on.matcher.shaders(),
            Self::Reference => Vec::new(), // refused before: there are none
        }
    }

    /// The names of the adapter and its driver. Without one networks are computed by the CPU, all else by the reference.
    pub fn names<'a>(&self, settings: impl IntoIterator<Item = &'a Params>) -> EngineNames {
        match self {
            Self::Adapter(on) => {
                let info = &on.opened.info;
                let (adapter, backend) = (info.name.clone(), info.backend.to_string());
                EngineNames { adapter, backend, driver: adapter::driver(info) }
            }
            Self::Reference => {
                let version = concat!("gpu-stereo ", env!("CARGO_PKG_VERSION"));
                let by_networks = settings.into_iter().all(|params| params.method == Method::Psmnet);
                let adapter = if by_networks { "CPU" } else { "CPU reference" };
                EngineNames { adapter: adapter.into(), backend: "cpu".into(), driver: version.into() }
            }
        }
    }

    /// Bytes in use on the device, 0 for the reference.
    pub fn device_bytes(&self) -> u64 {
        match self {
            Self::Adapter(on) => on.matcher.device_bytes(),
            Self::Reference => 0,
        }
    }
}

/// Does `work`, and tells `show` meanwhile how far a network is.
fn with_progress<T>(image: &Image, params: &Params, show: &(dyn Fn(f64) + Sync), work: impl FnOnce() -> T) -> T {
    let all = params.multiplications(image.width(), image.height());
    let Some(network) = params.network.as_ref().filter(|_| all > 0) else { return work() };
    let before = network.done();
    watched(|| network.done().saturating_sub(before) as f64 / all as f64, show, work)
}

/// What the CPU computes without an adapter: a network by matrix products, all else by the reference.
pub fn without_adapter(left: &Image, right: &Image, params: &Params) -> Result<(Matched, Vec<StageTime>), Error> {
    match params.method {
        Method::Psmnet => cpu::compute_timed(left, right, params),
        _ => reference::compute_timed(left, right, params),
    }
}

/// Refuses images for which the reference has too little memory, and images of another size than their masks.
pub fn ensure_reference(params: &Params, image: &Image) -> Result<()> {
    params.accepts(image.width(), image.height())?;
    // At the peak: column sums of four bytes, and with sgm the costs of one that are made of them; with bp messages; with a
    // network floats of four.
    let (what, bytes) = match params.method {
        Method::Sgm => ("the CPU reference", 5),
        Method::Bp => ("the CPU reference", BELIEF_BYTES),
        Method::Psmnet => ("the network on the CPU", 4),
        _ => ("the CPU reference", 4),
    };
    ensure_memory(what, params, image, bytes)
}

/// Refuses what the host's memory cannot hold: cost volumes of `bytes` per pixel and disparity, or of a network as many for each
/// value that is needed at once, and what the reference keeps per pixel. Otherwise the system would kill the process without a
/// message, or a failed allocation would abort it.
fn ensure_memory(what: &str, params: &Params, image: &Image, bytes: u64) -> Result<()> {
    if !params.memory_check {
        return Ok(());
    }
    let (width, height) = (u64::from(image.width()), u64::from(image.height()));
    let columns = width + u64::from(params.block) - 1;
    let values = match &params.network {
        Some(network) => {
            let padded = Padded::new(image.width(), image.height(), params.disparities);
            Operation::peak(network.operations(), &padded)
        }
        None => columns * height * u64::from(params.disparities),
    };
    let needed = bytes * values + PIXEL_BYTES * width * height;
    let what = format!("{what} of {width}x{height} pixels at {} disparities", params.disparities);
    memory::ensure(&what, needed)?;
    Ok(())
}

/// About the bytes per pixel and disparity that belief propagation takes in the reference: the cost, four messages of each level,
/// data terms of two bytes of the coarse ones, and what half of the pixels send at a time.
const BELIEF_BYTES: u64 = 12;

/// About the bytes per pixel that the images, planes and maps of the reference take.
const PIXEL_BYTES: u64 = 36;

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// The median; 0 if there are no values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => 0.0,
        _ => (values[(n - 1) / 2] + values[n / 2]) / 2.0,
    }
}

/// The median time of each stage over the frames, in the stages' order.
fn median_stages(frames: Vec<Vec<StageTime>>) -> Vec<StageTime> {
    let mut stages = frames.first().cloned().unwrap_or_default();
    for (i, stage) in stages.iter_mut().enumerate() {
        stage.ms = median(frames.iter().filter_map(|frame| frame.get(i)).map(|stage| stage.ms).collect());
    }
    stages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), 0.0);
        assert_eq!(median(vec![3.0]), 3.0);
        assert_eq!(median(vec![9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![9.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
