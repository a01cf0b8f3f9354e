//! Run: read the pair, compute, check, write.

use crate::adapter::{self, Opened};
use crate::args::{Backend, DeviceArgs};
use crate::calibration::Fitted;
use crate::evaluate::Evaluation;
use crate::output::{Format, Maps};
use crate::report::{FrameMs, Report};
use crate::resolve::Job;
use crate::views::{self, Views};
use crate::{diagnosis, environment, output, warnings};
use anyhow::{Result, bail};
use gpu_stereo::evaluation::FloatMap;
use gpu_stereo::{
    Camera, Error, Image, Matched, Method, Params, Rectification, StageCheck, StageTime, StereoMatcher, memory,
    reference,
};
use std::time::Instant;

/// What computes.
pub enum Engine {
    Adapter(Box<OnAdapter>),
    Reference,
}

pub struct OnAdapter {
    pub opened: Opened,
    pub matcher: StereoMatcher,
}

/// Does the job.
pub fn run(job: &Job) -> Result<Report> {
    let views = views::read_pair(&job.left, &job.right, &job.input)?;
    let (samples, turned) = (views.samples(), views.turns());
    views.doubts.iter().for_each(|doubt| warnings::warn(doubt));
    let Views { left, right, bits, .. } = views;
    output::ensure_size(&job.outputs, left.width(), left.height())?;
    let truth = job.truth.as_ref().map(|truth| truth.read((left.width(), left.height()), &job.left)).transpose()?;

    let (params, camera) = &params_for(job, &left)?;
    let start = Instant::now();
    let engine = Engine::open(&job.device, job.check, &left, params)?;
    // Stage times come from the frames that are told, so that stages and transfers add up to the frame.
    let timed = job.timings || job.json;
    let Frames { matched, first, times, stages } = engine.frames(&left, &right, params, timed, job.repeat)?;
    let first_frame_ms = (first - start).as_secs_f64() * 1e3;
    if let Some(finding) = diagnosis::finding(&left, &right, params)? {
        warnings::warn(&finding.to_string());
    }

    let check = if job.check {
        // Column sums of four bytes, the cost, every direction, and an aggregate of two bytes.
        let directions = match params.method {
            Method::Sgm => params.paths.count().into(),
            _ => 0,
        };
        ensure_memory("the reference that --check compares with", params, &left, 7 + directions)?;
        Some(engine.check(&left, &right)?)
    } else {
        None
    };
    let passed = check.iter().flatten().all(|stage| stage.mismatches == 0);
    let mut evaluation = None;
    if passed {
        let mut errors = None;
        if let Some(truth) = &truth {
            let estimate = FloatMap::from(&matched.map);
            evaluation = Some(Evaluation::from(&truth.score(&estimate)?));
            if job.outputs.iter().any(|output| output.format == Format::ErrorMap) {
                errors = Some(truth.error_picture(&estimate)?);
            }
        }
        let errors = errors.as_ref();
        let Matched { map, confidence, depth, .. } = &matched;
        let (confidence, depth) = (confidence.as_ref(), depth.as_ref());
        let rectified = params.rectify.as_ref().map(|rectification| reference::rectify(&left, rectification, 0));
        let left = rectified.transpose()?.unwrap_or(left);
        output::write_maps(&job.outputs, &Maps { map, confidence, errors, depth, left: Some(&left), params })?;
    }
    let outputs = if passed { job.outputs.iter().map(|output| output.path.clone()).collect() } else { Vec::new() };
    let (adapter, backend, driver) = engine.names();
    Ok(Report {
        adapter,
        backend,
        driver,
        width: matched.map.width,
        height: matched.map.height,
        bits,
        samples,
        turned,
        min_disparity: params.min_disparity,
        disparities: params.disparities,
        camera: camera.map(Into::into),
        valid: matched.map.valid_fraction(),
        frame_ms: times,
        first_frame_ms,
        stages,
        peak_device_bytes: engine.device_bytes(),
        evaluation,
        check: check.map(|stages| stages.into_iter().map(Into::into).collect()),
        warnings: warnings::all(),
        outputs,
    })
}

/// The settings of the job for images of this size, and the rectified cameras, if they are known.
fn params_for(job: &Job, image: &Image) -> Result<(Params, Option<Camera>)> {
    let (width, height) = (image.width(), image.height());
    let mut params = job.params.clone();
    params.masks = job.masks.read_for(image)?;
    let Some(calibration) = &job.calibration else { return Ok((params, None)) };
    let Fitted { mut camera, lenses } = calibration.fit(width, height)?;
    if let Some(doubt) = calibration.doubt(&camera) {
        warnings::warn(&doubt);
    }
    if let Some(lenses) = lenses {
        params.rectify = Some(Rectification::new(width, height, lenses)?);
    }
    for (is_middle, place, side) in [(job.middle[0], &mut camera.cx, width), (job.middle[1], &mut camera.cy, height)] {
        if is_middle {
            *place = f64::from(side - 1) / 2.0;
        }
    }
    params.depth = job.depth.then_some(camera);
    Ok((params, Some(camera)))
}

/// What came of frames of one pair.
pub struct Frames {
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
    /// What computes with `params` maps of pairs that are as `image` is. `check`: it must be an adapter.
    pub fn open(device: &DeviceArgs, check: bool, image: &Image, params: &Params) -> Result<Self> {
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
                // An adapter that cannot run the kernels at all is passed over, but not in silence.
                Err(error @ (Error::Adapter(_) | Error::Device(_))) if !only => {
                    crate::tell(&format!("note: {}: {error}", crate::plain(&adapter.get_info().name)));
                }
                Err(error) => return Err(error.into()),
            }
        }
        let why = environment::why_none();
        if backend == Backend::Gpu {
            bail!(
                "--backend is gpu, but there is no usable adapter{why}; install a Vulkan driver, or take auto or cpu"
            );
        }
        if check {
            bail!(
                "--check compares an adapter with the CPU reference, but there is no usable adapter{why}; install a Vulkan driver"
            );
        }
        crate::tell(&format!("note: no usable GPU or CPU adapter{why}; computing with the CPU reference"));
        Self::reference(image, params)
    }

    /// The same with other settings.
    pub fn again(self, image: &Image, params: &Params) -> Result<Self> {
        match self {
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = *on;
                drop(matcher); // its memory goes to the next one
                Ok(Self::on(opened, image, params)?)
            }
            Self::Reference => Self::reference(image, params),
        }
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

    /// `repeat` frames after a warm-up; `None`: the first frame is the only one.
    pub fn frames(
        &self,
        left: &Image,
        right: &Image,
        params: &Params,
        timed: bool,
        repeat: Option<u32>,
    ) -> Result<Frames, Error> {
        let before_first = Instant::now();
        let (mut matched, stages) = self.compute(left, right, params, timed)?;
        let first = Instant::now();
        let mut frames = vec![(milliseconds(before_first), stages)];
        if let Some(repeat) = repeat {
            frames.clear(); // the first frame was the warm-up
            for _ in 0..repeat {
                let before = Instant::now();
                let (frame, stages) = self.compute(left, right, params, timed)?;
                frames.push((milliseconds(before), stages));
                matched = frame;
            }
        }
        let (times, stages): (Vec<_>, Vec<_>) = frames.into_iter().unzip();
        let times = FrameMs { min: times.iter().copied().fold(f64::INFINITY, f64::min), median: median(times) };
        Ok(Frames { matched, first, times, stages: median_stages(stages) })
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
            Self::Reference if timed => reference::compute_timed(left, right, params),
            Self::Reference => reference::compute_all(left, right, params).map(|matched| (matched, Vec::new())),
        }
    }

    fn check(&self, left: &Image, right: &Image) -> Result<Vec<StageCheck>, Error> {
        match self {
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = on.as_ref();
                let stages = matcher.check_blocking(left, right);
                opened.fault()?;
                stages
            }
            Self::Reference => Ok(Vec::new()), // refused before: there is nothing to compare
        }
    }

    /// Adapter, backend and driver.
    pub fn names(&self) -> (String, String, String) {
        match self {
            Self::Adapter(on) => {
                let info = &on.opened.info;
                (info.name.clone(), info.backend.to_string(), adapter::driver(info))
            }
            Self::Reference => {
                let version = concat!("gpu-stereo ", env!("CARGO_PKG_VERSION"));
                ("CPU reference".into(), "cpu".into(), version.into())
            }
        }
    }

    pub fn device_bytes(&self) -> u64 {
        match self {
            Self::Adapter(on) => on.matcher.device_bytes(),
            Self::Reference => 0,
        }
    }
}

/// Refuses what the reference has no memory for, and a pair of another size than its masks.
pub fn ensure_reference(params: &Params, image: &Image) -> Result<()> {
    params.accepts(image.width(), image.height())?;
    // At the peak: column sums of four bytes, and with sgm the costs of one that are made of them.
    let bytes = if params.method == Method::Sgm { 5 } else { 4 };
    ensure_memory("the CPU reference", params, image, bytes)
}

/// Refuses what the host's memory cannot hold, volumes of `bytes` a pixel and disparity and what the reference keeps for each
/// pixel: the system would kill the process without a word, or a failed allocation abort it.
fn ensure_memory(what: &str, params: &Params, image: &Image, bytes: u64) -> Result<()> {
    if !params.memory_check {
        return Ok(());
    }
    let (width, height) = (u64::from(image.width()), u64::from(image.height()));
    let columns = width + u64::from(params.block) - 1;
    let volumes = bytes * columns * height * u64::from(params.disparities);
    let needed = volumes + PIXEL_BYTES * width * height;
    let what = format!("{what} of {width}x{height} pixels at {} disparities", params.disparities);
    memory::ensure(&what, needed)?;
    Ok(())
}

/// Bytes a pixel of the images, the planes and the maps of the reference, about.
const PIXEL_BYTES: u64 = 36;

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// The middle value, or the mean of the two; 0 of none.
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
