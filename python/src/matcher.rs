//! The matcher: an engine for pairs of one size, which threads may share.

use crate::errors::{raised, warn, wrong};
use crate::images::GivenPair;
use crate::matched::PyMatched;
use crate::settings::Request;
use crate::work::{Maker, detached, pool};
use gpu_stereo::backend::{Beforehand, Engine, Shape, ensure_environment};
use gpu_stereo::files::images::Bits;
use gpu_stereo::{Error, Image, Params, PixelFormat, StageCheck};
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

/// Computes pairs of one size. What is in it is guarded, so that threads may share it; they compute one after the other.
pub struct Matcher {
    pub request: Request,
    /// Columns and rows of the pairs.
    pub size: [u32; 2],
    pub params: Params,
    pub before: Beforehand,
    ready: Mutex<Ready>,
    pool: Arc<ThreadPool>,
    maker: Maker,
}

/// An engine, and what it was made for.
struct Ready {
    /// Nothing after a failure.
    engine: Option<Engine>,
    shape: Shape,
}

/// What a pair gives, or why not.
pub type Computed = Result<PyMatched, Error>;

impl Matcher {
    /// A matcher for pairs of this size. It is made for samples of `format` at first.
    pub fn new(py: Python<'_>, request: Request, size: [u32; 2], format: PixelFormat) -> PyResult<Self> {
        if request.finds_range {
            return Err(wrong(
                "disparities is \"auto\", which finds the range of a single pair; give it to gpu_stereo.match, or give a number here",
            ));
        }
        let params = request.params(py, size)?;
        Self::with(py, request, params, size, format)
    }

    /// With these settings.
    pub fn with(
        py: Python<'_>,
        request: Request,
        params: Params,
        size: [u32; 2],
        format: PixelFormat,
    ) -> PyResult<Self> {
        let mut notes = Vec::new();
        let opened = detached(py, || {
            params.validate()?;
            if request.place.backend.takes_adapters() {
                ensure_environment(&mut |note| notes.push(note))?;
            }
            let before = Beforehand::of(&params)?;
            let shape = Shape::new(before.size(size), format);
            let engine = Engine::open(&request.place, None, shape, &before.params, &mut |note| notes.push(note))?;
            Ok((before, shape, engine))
        })?;
        notes.iter().try_for_each(|note| warn(py, note))?;
        let (before, shape, engine) = opened.map_err(raised)?;
        Ok(Self {
            request,
            size,
            params,
            before,
            ready: Mutex::new(Ready { engine: Some(engine), shape }),
            pool: pool()?,
            maker: Maker::here(),
        })
    }

    /// Does something with the engine for samples of `format`, on the pool's threads. The lock is taken by the calling thread, which
    /// must be none of these: one that waits for others takes up work of other callers, and would wait for its own lock.
    fn with_engine<T: Send>(
        &self,
        format: PixelFormat,
        work: impl FnOnce(&Engine) -> Result<T, Error> + Send,
    ) -> Result<T, Error> {
        let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        let shape = Shape::new(ready.shape.size, format);
        let (place, params) = (&self.request.place, &self.before.params);
        let mut quiet = |_| (); // it was said when the matcher was made
        let (kept, is_same) = (ready.engine.take(), shape == ready.shape);
        let (engine, done) = self.pool.install(|| {
            let engine = match kept {
                Some(engine) if is_same => engine,
                Some(engine) => engine.again(place, shape, params, &mut quiet)?,
                None => Engine::open(place, None, shape, params, &mut quiet)?,
            };
            let done = work(&engine);
            Ok((engine, done))
        })?;
        // A device that was lost is opened anew the next time.
        ready.engine = (!matches!(done, Err(Error::Lost(_) | Error::Refused(_)))).then_some(engine);
        ready.shape = shape;
        done
    }

    /// The images as the engine takes them.
    pub fn images(&self, given: &GivenPair<'_>, bits: Bits) -> PyResult<(Image, Image, u32)> {
        self.maker.ensure_here("the matcher")?;
        given.ensure(self.size)?;
        let pair = given.images(self.request.channels, bits)?;
        Ok((pair.left, pair.right, pair.bits))
    }

    /// Computes a pair. Call it without Python, and not on the pool's threads.
    pub fn compute(&self, left: &Image, right: &Image) -> Computed {
        let timed = self.request.timings;
        let (maps, stages) = self.with_engine(left.format(), |engine| {
            engine.compute(&*self.before.image(left, 0)?, &*self.before.image(right, 1)?, timed)
        })?;
        Ok(PyMatched::new(self.before.upright(maps), &self.params, timed.then_some(stages)))
    }

    /// The images as the matcher of a stream takes them.
    pub fn prepared<'a>(&self, left: &'a Image, right: &'a Image) -> Result<(Cow<'a, Image>, Cow<'a, Image>), Error> {
        self.pool.install(|| Ok((self.before.image(left, 0)?, self.before.image(right, 1)?)))
    }

    /// Compares every stage of a pair. As for [`Matcher::compute`].
    pub fn check(&self, left: &Image, right: &Image) -> Result<Vec<StageCheck>, Error> {
        self.with_engine(left.format(), |engine| {
            engine.check(&*self.before.image(left, 0)?, &*self.before.image(right, 1)?)
        })
    }

    /// The names of what computes.
    pub fn device(&self) -> String {
        let ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        ready.engine.as_ref().map(|engine| engine.names([&self.params]).adapter).unwrap_or_default()
    }

    /// Makes a stream on the adapter, if there is one.
    pub fn stream(&self, format: PixelFormat, in_flight: usize) -> Result<Option<gpu_stereo::StereoStream>, Error> {
        self.with_engine(format, |engine| match engine {
            Engine::Adapter(on) => {
                let [width, height] = self.before.size(self.size);
                let matcher = on.matcher.another(width, height, format, &self.before.params)?;
                on.opened.fault()?;
                gpu_stereo::StereoStream::new(matcher, in_flight).map(Some)
            }
            Engine::Cpu(_) => Ok(None),
        })
    }

    /// An error that the device reported outside any call.
    pub fn fault(&self) -> Result<(), Error> {
        let ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        match &ready.engine {
            Some(Engine::Adapter(on)) => on.opened.fault(),
            _ => Ok(()),
        }
    }
}

/// The format of the pair's images.
pub fn format(given: &GivenPair<'_>) -> PixelFormat {
    match given.kind() {
        (false, false) => PixelFormat::Gray8,
        (true, false) => PixelFormat::Gray16,
        (false, true) => PixelFormat::Rgba8,
        (true, true) => PixelFormat::Rgba16,
    }
}
