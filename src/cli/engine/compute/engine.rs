//! The engine computes the maps of pairs of one size and format: on an adapter, by the native schedule or by the reference.

use super::beforehand::{Beforehand, Shape};
use super::names::EngineNames;
use super::on_cpu::{self, OnCpu};
use crate::args::{Backend, DeviceArgs};
use crate::engine::adapter::{self, Opened};
use crate::engine::environment;
use crate::terminal::{message, plain, to_microseconds, watched};
use anyhow::{Result, bail};
use gpu_stereo::wgpu::DeviceType;
use gpu_stereo::{Error, Image, Matched, Method, Params, StageCheck, StageTime, StereoMatcher};
use serde::Serialize;
use std::time::Instant;

/// An adapter with a matcher, or what computes without one.
pub enum Engine {
    Adapter(Box<OnAdapter>),
    Cpu(OnCpu),
}

pub struct OnAdapter {
    pub opened: Opened,
    pub matcher: StereoMatcher,
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
        let before = Beforehand::of(params)?;
        let (shape, params) = (before.shape(image), &before.params);
        let (backend, wanted) = (device.backend, device.adapter.as_deref());
        match backend {
            Backend::Cpu => return Ok(Self::Cpu(OnCpu::native(shape, params, None)?)),
            Backend::Reference => return Ok(Self::Cpu(OnCpu::reference(shape, params)?)),
            Backend::Auto | Backend::Gpu => {}
        }
        let mut adapters = adapter::ranked()?;
        if let Some(wanted) = wanted {
            let names: Vec<_> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
            adapters = vec![adapters.swap_remove(adapter::choose(&names, wanted)?)];
        }
        let only = adapters.len() == 1 && wanted.is_some();
        let takes_all = backend == Backend::Gpu || wanted.is_some() || needed_for.is_some();
        let mut passed = None;
        for adapter in &adapters {
            let info = adapter.get_info();
            if info.device_type == DeviceType::Cpu && !takes_all && !on_cpu_adapters(params.method) {
                passed.get_or_insert(info.name);
                continue;
            }
            let opened = adapter::open(adapter).and_then(|opened| Self::on(opened, shape, params));
            match opened {
                Ok(engine) => return Ok(engine),
                // An adapter that cannot run the kernels is skipped, and that is reported.
                Err(error @ (Error::Adapter(_) | Error::Device(_))) if !only => {
                    message(&format!("note: {}: {error}", plain(&info.name)));
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
        if adapters.is_empty() && !why.is_empty() {
            message(&format!("note: there is no adapter{why}; computing on the CPU"));
        }
        Ok(Self::Cpu(OnCpu::native(shape, params, passed)?))
    }

    /// The engine in `kept` with other settings, or a new one if there is none or another one computes faster with these; it
    /// stays in `kept`.
    pub fn again<'a>(
        kept: &'a mut Option<Self>,
        device: &DeviceArgs,
        image: &Image,
        params: &Params,
    ) -> Result<&'a Self> {
        let before = Beforehand::of(params)?;
        let (shape, matched) = (before.shape(image), &before.params);
        let by_method = device.backend == Backend::Auto && device.adapter.is_none();
        let fits = |kept: &Self| match kept {
            Self::Adapter(on) => on.opened.info.device_type != DeviceType::Cpu || on_cpu_adapters(params.method),
            Self::Cpu(OnCpu::Native { adapter, .. }) => adapter.is_none() || !on_cpu_adapters(params.method),
            Self::Cpu(OnCpu::Reference(_)) => true,
        };
        let engine = match kept.take().filter(|kept| !by_method || fits(kept)) {
            None => Self::open(device, None, image, params)?,
            Some(Self::Adapter(on)) => {
                let OnAdapter { opened, matcher } = *on;
                drop(matcher); // its memory goes to the next one
                Self::on(opened, shape, matched)?
            }
            Some(Self::Cpu(on)) => Self::Cpu(on.again(shape, matched)?),
        };
        Ok(kept.insert(engine))
    }

    fn on(opened: Opened, shape: Shape, params: &Params) -> Result<Self, Error> {
        let Shape { size: [width, height], format } = shape;
        let matcher = StereoMatcher::new(&opened.device, &opened.queue, width, height, format, params);
        opened.fault()?;
        let matcher = matcher?;
        Ok(Self::Adapter(Box::new(OnAdapter { opened, matcher })))
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
        let before = Beforehand::of(params)?;
        let (left, right, params) = (&*before.image(left, 0)?, &*before.image(right, 1)?, &before.params);
        let compute = || with_progress(left, params, show, || self.compute(left, right, timed));
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
        Ok(Computed { matched: before.upright(matched), first, times, stages: median_stages(stages) })
    }

    fn compute(&self, left: &Image, right: &Image, timed: bool) -> Result<(Matched, Vec<StageTime>), Error> {
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
            Self::Cpu(on) if timed => on.compute(left, right),
            Self::Cpu(on) => on.compute(left, right).map(|(matched, _)| (matched, Vec::new())),
        }
    }

    /// Compares each stage with the reference.
    pub fn check(&self, left: &Image, right: &Image, params: &Params) -> Result<Vec<StageCheck>> {
        let before = Beforehand::of(params)?;
        let (left, right, params) = (&*before.image(left, 0)?, &*before.image(right, 1)?, &before.params);
        match self {
            Self::Adapter(on) => {
                on_cpu::ensure_check(left, params, 0)?;
                let OnAdapter { opened, matcher } = on.as_ref();
                let stages = matcher.check_blocking(left, right);
                opened.fault()?;
                Ok(stages?)
            }
            Self::Cpu(on) => on.check(left, right),
        }
    }

    /// The names and texts of the kernels.
    pub fn shaders(&self) -> Vec<(String, &str)> {
        match self {
            Self::Adapter(on) => on.matcher.shaders(),
            Self::Cpu(_) => Vec::new(), // refused before: there are none
        }
    }

    /// The names of the adapter and its driver, or of what computes without one.
    pub fn names<'a>(&self, settings: impl IntoIterator<Item = &'a Params>) -> EngineNames {
        match self {
            Self::Adapter(on) => {
                let info = &on.opened.info;
                let (adapter, backend) = (info.name.clone(), info.backend.to_string());
                EngineNames { adapter, backend, driver: adapter::driver(info), also: None }
            }
            Self::Cpu(on) => on.names(settings),
        }
    }

    /// Whether frames are usually timed by several of them: where one takes little time, and the first more than others.
    pub fn is_quick(&self, params: &Params) -> bool {
        match self {
            Self::Adapter(_) => true,
            Self::Cpu(on) => on.is_quick(params),
        }
    }

    /// Bytes in use on the device, 0 without one.
    pub fn device_bytes(&self) -> u64 {
        match self {
            Self::Adapter(on) => on.matcher.device_bytes(),
            Self::Cpu(_) => 0,
        }
    }
}

/// Whether `--backend auto` takes a CPU adapter, where there is no GPU: for methods that the native schedule computes as slowly as
/// the reference does.
fn on_cpu_adapters(method: Method) -> bool {
    matches!(method, Method::Bp)
}

/// Does `work`, and tells `show` meanwhile how far a network is.
fn with_progress<T>(image: &Image, params: &Params, show: &(dyn Fn(f64) + Sync), work: impl FnOnce() -> T) -> T {
    let all = params.multiplications(image.width(), image.height());
    let Some(network) = params.network.as_ref().filter(|_| all > 0) else { return work() };
    let before = network.done();
    watched(|| network.done().saturating_sub(before) as f64 / all as f64, show, work)
}

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
