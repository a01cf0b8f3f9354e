//! Pairs in flight: a stream on the adapter for each pixel format, or one pair at a time on the CPU.

use super::work::{MatchedPair, PairKind, Setup};
use crate::engine::compute::{self, EngineNames};
use anyhow::{Result, anyhow};
use gpu_stereo::backend::{Beforehand, Engine, OnAdapter, OnCpu, Opened, Shape};
use gpu_stereo::{Error, Image, Matched, Params, PixelFormat, StereoMatcher, StereoStream};
use std::collections::VecDeque;
use std::sync::Arc;

/// The engine of the pipeline, and the pairs in flight.
pub struct Flow {
    /// The names of the adapter and its driver.
    pub names: EngineNames,
    /// Columns and rows of the first pair.
    pub size: (u32, u32),
    /// The pixel format of the pairs in flight.
    pub format: PixelFormat,
    engine: FlowEngine,
    /// Size and samples of the first pair.
    pub kind: PairKind,
    /// The settings for pairs of the present size.
    params: Arc<Params>,
    before: Beforehand,
    waiting: VecDeque<Waiting>,
}

/// A pair in flight: its place, its images as far as they are kept, and its settings.
type Waiting = (usize, (Image, Option<Image>), Arc<Params>);

enum FlowEngine {
    Streams(Box<Streams>),
    /// With the result of the last pair.
    Cpu(OnCpu, Option<Box<Matched>>),
}

/// A stream for each pixel format, so that kernels are compiled once. The last one is in use.
struct Streams {
    opened: Opened,
    all: Vec<StereoStream>,
    in_flight: usize,
    peak_bytes: u64,
}

impl Streams {
    fn current(&mut self) -> Result<&mut StereoStream> {
        self.all.last_mut().ok_or_else(|| anyhow!("there is no stream"))
    }

    /// Prepares for pairs of this shape. If `idle`, other streams may be dropped for it.
    fn fit(&mut self, shape: Shape, params: &Params, idle: bool) -> Result<()> {
        let mut turned = self.turn(shape, params);
        if idle && matches!(turned, Err(Error::TooLarge { .. } | Error::Image(_))) {
            turned = self.renew(shape, params); // a wide pair and a high one need less room one after the other
        }
        if idle && matches!(turned, Err(Error::OutOfMemory | Error::Memory { .. })) {
            self.all.clear();
            turned = self.renew(shape, params);
        }
        self.opened.fault()?;
        turned?;
        self.peak_bytes = self.peak_bytes.max(self.all.iter().map(|stream| stream.matcher().device_bytes()).sum());
        Ok(())
    }

    /// Uses the stream for this format.
    fn turn(&mut self, shape: Shape, params: &Params) -> Result<(), Error> {
        let Shape { size: [width, height], format, .. } = shape;
        let Some(place) = self.all.iter().position(|stream| stream.matcher().format() == format) else {
            return self.renew(shape, params);
        };
        self.all[place..].rotate_left(1);
        match self.all.last_mut() {
            // A rectification is of one size.
            Some(stream) if stream.matcher().params() != params => self.renew(shape, params),
            Some(stream) if stream.matcher().size() != [width, height] => stream.resize(width, height),
            _ => Ok(()),
        }
    }

    /// Replaces the stream for this format by a new one.
    fn renew(&mut self, Shape { size: [width, height], format, .. }: Shape, params: &Params) -> Result<(), Error> {
        let Opened { device, queue, .. } = &self.opened;
        // What another one has compiled is not compiled again.
        let matcher = match self.all.first() {
            Some(stream) => stream.matcher().another(width, height, format, params)?,
            None => StereoMatcher::new(device, queue, width, height, format, params)?,
        };
        let stream = StereoStream::new(matcher, self.in_flight)?;
        self.all.retain(|stream| stream.matcher().format() != format);
        self.all.push(stream);
        Ok(())
    }
}

impl Flow {
    /// Opens an engine for pairs of the size and format of `left`.
    pub fn open(setup: &Setup<'_>, left: &Image, params: &Arc<Params>) -> Result<Self> {
        let engine = compute::open(setup.device, None, left, params)?;
        let names = engine.names([&**params]).into();
        let engine = match engine {
            Engine::Cpu(on) => FlowEngine::Cpu(on, None),
            Engine::Adapter(on) => {
                let OnAdapter { opened, matcher } = *on;
                let stream = StereoStream::new(matcher, setup.in_flight);
                opened.fault()?;
                let stream = stream?;
                let peak_bytes = stream.matcher().device_bytes();
                let in_flight = setup.in_flight;
                FlowEngine::Streams(Box::new(Streams { opened, all: vec![stream], in_flight, peak_bytes }))
            }
        };
        let size = (left.width(), left.height());
        let (kind, format) = (PairKind::of(left), left.format());
        let (before, params) = (Beforehand::of(params)?, Arc::clone(params));
        Ok(Self { engine, names, size, kind, format, params, before, waiting: VecDeque::new() })
    }

    /// Makes sure that a pair can be pushed; those in flight have its format and settings.
    pub fn fit(&mut self, left: &Image, params: &Arc<Params>) -> Result<()> {
        let format = left.format();
        if !Arc::ptr_eq(params, &self.params) {
            self.before = Beforehand::of(params)?;
        }
        let shape = self.before.shape(left);
        match &mut self.engine {
            FlowEngine::Streams(on) => on.fit(shape, &self.before.params, self.waiting.is_empty())?,
            FlowEngine::Cpu(on, _) => on.fit(shape, &self.before.params)?,
        }
        (self.format, self.params) = (format, Arc::clone(params));
        Ok(())
    }

    /// Whether a pair needs a stream of its own, so that those in flight must be done before: its samples are of another format,
    /// the cameras fit its size otherwise, or its range is another.
    pub fn is_other(&self, left: &Image, params: &Arc<Params>) -> bool {
        self.format != left.format() || *params != self.params
    }

    /// The number of pairs in flight.
    pub fn in_flight(&self) -> usize {
        self.waiting.len()
    }

    /// The most pairs in flight.
    pub fn capacity(&self) -> usize {
        match &self.engine {
            FlowEngine::Streams(on) => on.in_flight,
            FlowEngine::Cpu(..) => 1,
        }
    }

    /// The most bytes in use on the device.
    pub fn device_bytes(&self) -> u64 {
        match &self.engine {
            FlowEngine::Streams(on) => on.peak_bytes,
            FlowEngine::Cpu(..) => 0,
        }
    }

    /// Begins to match a pair that fits; fewer than the most are in flight.
    pub fn push(&mut self, place: usize, left: Image, right: Image, keeps_right: bool) -> Result<()> {
        let (first, second) = (self.before.image(&left, 0)?, self.before.image(&right, 1)?);
        match &mut self.engine {
            FlowEngine::Streams(on) => {
                let pushed = on.current()?.try_push(&first, &second);
                on.opened.fault()?;
                pushed?.ok_or_else(|| anyhow!("the stream is full before its time"))?;
            }
            FlowEngine::Cpu(on, result) => *result = Some(Box::new(on.compute(&first, &second)?.0)),
        }
        drop((first, second));
        let right = keeps_right.then_some(right);
        self.waiting.push_back((place, (left, right), Arc::clone(&self.params)));
        Ok(())
    }

    /// The next result. An error here is one of the device, so that no further pair could be matched.
    pub fn next(&mut self) -> Result<Option<MatchedPair>> {
        let matched = match &mut self.engine {
            FlowEngine::Streams(on) => {
                let frame = on.current()?.next_blocking();
                on.opened.fault()?;
                frame.map(|frame| frame.result).transpose()?
            }
            FlowEngine::Cpu(_, result) => result.take().map(|matched| *matched),
        };
        let ended = || Error::Lost("the stream gave no result".into());
        let Some((place, (left, right), params)) = self.waiting.pop_front() else { return Ok(None) };
        // The settings change only when nothing is in flight.
        let matched = self.before.upright(matched.ok_or_else(ended)?);
        Ok(Some(MatchedPair { place, left, right, matched, params }))
    }
}
