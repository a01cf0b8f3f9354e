//! Opens the engine that the options ask for, and computes a pair with it once or several times.

use crate::args::{DeviceArgs, by_option};
use crate::terminal::{message, to_microseconds, watched};
use anyhow::Result;
use gpu_stereo::backend::{Beforehand, Engine};
use gpu_stereo::{Error, Image, Matched, Params, StageCheck, StageTime};
use serde::Serialize;
use std::time::Instant;

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

/// What computes with `params` maps of pairs that are as `image` is. `needed_for`: what only an adapter can do.
pub fn open(device: &DeviceArgs, needed_for: Option<&str>, image: &Image, params: &Params) -> Result<Engine> {
    let before = Beforehand::of(params)?;
    Engine::open(&device.place(), needed_for, before.shape(image), &before.params, &mut note).map_err(by_option)
}

/// The engine in `kept` with other settings, or a new one if there is none or another one computes faster with these; it
/// stays in `kept`.
pub fn again<'a>(
    kept: &'a mut Option<Engine>,
    device: &DeviceArgs,
    image: &Image,
    params: &Params,
) -> Result<&'a Engine> {
    let Some(engine) = kept.take() else { return Ok(kept.insert(open(device, None, image, params)?)) };
    let before = Beforehand::of(params)?;
    let engine = engine.again(&device.place(), before.shape(image), &before.params, &mut note).map_err(by_option)?;
    Ok(kept.insert(engine))
}

fn note(text: String) {
    message(&format!("note: {text}"));
}

/// `repeat` frames after a warm-up; `None`: the first frame is the only one. `show`: is told which share of a frame is
/// done, from 0 to 1, where a network takes long.
pub fn frames(
    engine: &Engine,
    left: &Image,
    right: &Image,
    params: &Params,
    timed: bool,
    repeat: Option<u32>,
    show: &(dyn Fn(f64) + Sync),
) -> Result<Computed, Error> {
    let before = Beforehand::of(params)?;
    let (left, right, params) = (&*before.image(left, 0)?, &*before.image(right, 1)?, &before.params);
    let compute = || with_progress(left, params, show, || engine.compute(left, right, timed));
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

/// Compares each stage with the reference.
pub fn check(engine: &Engine, left: &Image, right: &Image, params: &Params) -> Result<Vec<StageCheck>, Error> {
    let before = Beforehand::of(params)?;
    engine.check(&*before.image(left, 0)?, &*before.image(right, 1)?)
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
