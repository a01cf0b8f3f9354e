//! The matcher, and functions of a single pair.

use crate::errors::{raised, wrong};
use crate::images::GivenPair;
use crate::matched::PyMatched;
use crate::settings::{Request, ensure_count, warn};
use crate::work::{Maker, detached, pool};
use gpu_stereo::backend::{Beforehand, Engine, Shape, ensure_environment};
use gpu_stereo::files::images::Bits;
use gpu_stereo::{Error, Image, Params, PixelFormat, RangeSearch, StageCheck, reference};
use pyo3::prelude::*;
use pyo3::types::PyDict;
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

    fn with(py: Python<'_>, request: Request, params: Params, size: [u32; 2], format: PixelFormat) -> PyResult<Self> {
        let mut notes = Vec::new();
        let opened = detached(py, || {
            params.validate()?;
            if request.place.backend.takes_adapters() {
                ensure_environment(&mut |note| notes.push(note))?;
            }
            let before = Beforehand::of(&params)?;
            let shape = Shape { size: before.size(size), format };
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
        let shape = Shape { format, ..ready.shape };
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
        ready.engine = (!matches!(done, Err(Error::Lost(_)))).then_some(engine);
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

    fn check(&self, left: &Image, right: &Image) -> Result<Vec<StageCheck>, Error> {
        self.with_engine(left.format(), |engine| {
            engine.check(&*self.before.image(left, 0)?, &*self.before.image(right, 1)?)
        })
    }

    /// The names of what computes.
    fn device(&self) -> String {
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

/// Matches rectified pairs of one size: made once, for many pairs.
///
/// Args:
///     width, height: columns and rows of the images.
///     preset: the settings to start from: ``"classic"``, ``"fast"``, ``"balanced"``, ``"strict"`` or ``"dense"``.
///     disparities: how many disparities to search, in pixels, from ``min_disp`` (0 unless given) on.
///     device: ``"auto"`` (the best GPU, else the CPU), ``"gpu"``, ``"cpu"``, ``"reference"``, or an adapter by its index or a part of
///         its name, see :func:`adapters`.
///     channels: ``"rgb"``, or ``"bgr"`` as OpenCV reads files.
///     bits: the bits that samples of 16 bits use, 8 to 16; ``"auto"``: as many as the largest of a pair needs.
///     confidence, right_map, timings: give these, too.
///     cameras: a :class:`Camera` for depths, or a :class:`Calibration`, which rectifies the pairs if it was read so.
///     mask: which pixels have content: an array of bool or uint8, or one for each image: ``(left, right)``.
///     weights: the network's weights, a file, with ``method="psmnet"``.
///     **options: any setting that :func:`options` lists, such as ``cost="census"``, ``p2=80``, ``lr_check="off"``; True and False
///         are ``"on"`` and ``"off"``, None leaves the default.
///
/// Raises:
///     InputError: an option is out of its range.
///     DeviceError: there is no such device.
///     OutOfMemoryError: the pair does not fit the memory that is left.
///
/// >>> import gpu_stereo
/// >>> left, right = gpu_stereo.read_pair("data/motorcycle/left.png", "data/motorcycle/right.png")
/// >>> matcher = gpu_stereo.StereoMatcher(741, 500, disparities=64, device="cpu")
/// >>> matcher.compute(left, right).disparity.shape
/// (500, 741)
#[pyclass(name = "StereoMatcher", module = "gpu_stereo", frozen)]
pub struct PyStereoMatcher(pub Arc<Matcher>);

#[pymethods]
impl PyStereoMatcher {
    #[new]
    #[pyo3(signature = (width, height, preset=None, disparities=None, device=None, **options))]
    fn new(
        py: Python<'_>,
        width: i64,
        height: i64,
        preset: Option<&str>,
        disparities: Option<&Bound<'_, PyAny>>,
        device: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let size = [ensure_count("width", width)?, ensure_count("height", height)?];
        let request = Request::new(py, disparities, preset, device, options)?;
        Ok(Self(Arc::new(Matcher::new(py, request, size, PixelFormat::Gray8)?)))
    }

    /// Matches a pair.
    ///
    /// Args:
    ///     left, right: images: arrays of uint8 or uint16, rows x columns, or rows x columns x 3 or 4; any strides; or what has
    ///         ``__dlpack__`` on the host, or the buffer protocol.
    ///
    /// Returns:
    ///     A :class:`Matched`. Other threads run meanwhile.
    fn compute(&self, py: Python<'_>, left: &Bound<'_, PyAny>, right: &Bound<'_, PyAny>) -> PyResult<PyMatched> {
        let (left, right, _) = self.0.images(&GivenPair::new(left, right)?, self.0.request.bits)?;
        py.detach(|| self.0.compute(&left, &right)).map_err(raised)
    }

    /// Matches pair after pair, several of them in flight: while one is computed, the next one is fetched.
    ///
    /// Args:
    ///     pairs: an iterable of ``(left, right)``.
    ///     in_flight: pairs in flight at most, from 1 to 16.
    ///
    /// Returns:
    ///     An iterator of :class:`Matched` in the order of the pairs. Where a pair is wrong or the iterable raises, the exception
    ///     comes after the results of the pairs before it.
    #[pyo3(signature = (pairs, in_flight=3))]
    fn stream(&self, pairs: &Bound<'_, PyAny>, in_flight: i64) -> PyResult<crate::stream::PyStream> {
        crate::stream::PyStream::of_matcher(Arc::clone(&self.0), pairs, in_flight)
    }

    /// Columns of the images.
    #[getter]
    fn width(&self) -> u32 {
        self.0.size[0]
    }

    /// Rows of the images.
    #[getter]
    fn height(&self) -> u32 {
        self.0.size[1]
    }

    /// The name of the adapter that computes, or of the CPU.
    #[getter]
    fn device(&self, py: Python<'_>) -> String {
        py.detach(|| self.0.device())
    }

    /// Every setting by its keyword, as :func:`options` lists them.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        crate::table::values(py, &self.0.params)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let [width, height] = self.0.size;
        let device = py.detach(|| self.0.device());
        format!("<StereoMatcher: {width}x{height}, {} disparities, on {device}>", self.0.params.disparities)
    }
}

/// A matcher for a single pair, and its images.
fn prepared(
    py: Python<'_>,
    [left, right]: [&Bound<'_, PyAny>; 2],
    mut request: Request,
) -> PyResult<(Matcher, Image, Image)> {
    let given = GivenPair::new(left, right)?;
    let size = given.size();
    let (bits, channels) = (request.bits, request.channels);
    let mut params = request.params(py, size)?;
    let images = || given.images(channels, bits).map(|pair| (pair.left, pair.right));
    if !request.finds_range {
        // What is too large is refused before it is copied.
        let matcher = Matcher::with(py, request, params, size, format(&given))?;
        let (left, right) = images()?;
        return Ok((matcher, left, right));
    }
    let (left, right) = images()?;
    find_range(py, &request, [&left, &right], &mut params)?;
    request.finds_range = false;
    let matcher = Matcher::with(py, request, params, size, format(&given))?;
    Ok((matcher, left, right))
}

/// Sets the range from a coarse match of the pair.
fn find_range(py: Python<'_>, request: &Request, [left, right]: [&Image; 2], params: &mut Params) -> PyResult<()> {
    let found = detached(py, || {
        let rectified = match &params.rectify {
            Some(lenses) => Some([reference::rectify(left, lenses, 0)?, reference::rectify(right, lenses, 1)?]),
            None => None,
        };
        let [left, right] = rectified.as_ref().map_or([left, right], |[left, right]| [left, right]);
        let search = RangeSearch::new(left, right)?;
        let engine = Engine::open(&request.place, None, Shape::of(&search.left), &search.params, &mut |_| ())?;
        let (coarse, _) = engine.compute(&search.left, &search.right, false)?;
        let min = params.min_disparity;
        search.found(&coarse.map, params)?;
        Ok(min)
    })?;
    let min = found.map_err(raised)?;
    if request.min_is_given {
        let end = params.min_disparity + params.disparities as i32;
        if min >= end {
            return Err(wrong(format!(
                "min_disp is {min}, but the disparities end at {}; give a smaller one, or none",
                end - 1
            )));
        }
        (params.min_disparity, params.disparities) = (min, (end - min) as u32);
    }
    if params.min_disparity + params.disparities as i32 <= 0 {
        warn(py, "all disparities are negative, as if left and right were exchanged; exchange them")?;
    }
    Ok(())
}

/// Matches one rectified pair.
///
/// Args:
///     left, right: images, as :meth:`StereoMatcher.compute` takes them.
///     disparities: how many disparities to search, or ``"auto"``: what a coarse match of the pair finds.
///     preset, device, **options: as of :class:`StereoMatcher`.
///
/// Returns:
///     A :class:`Matched`.
///
/// For many pairs of one size make a :class:`StereoMatcher`, or use :func:`stream`.
///
/// >>> import gpu_stereo
/// >>> left, right = gpu_stereo.read_pair("data/motorcycle/left.png", "data/motorcycle/right.png")
/// >>> gpu_stereo.match(left, right, disparities=64, device="cpu")
/// <Matched: 741x500, 89.6 % valid>
#[pyfunction(name = "match")]
#[pyo3(signature = (left, right, disparities=None, preset=None, device=None, **options))]
pub fn match_pair(
    py: Python<'_>,
    left: &Bound<'_, PyAny>,
    right: &Bound<'_, PyAny>,
    disparities: Option<&Bound<'_, PyAny>>,
    preset: Option<&str>,
    device: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyMatched> {
    let request = Request::new(py, disparities, preset, device, options)?;
    let (matcher, left, right) = prepared(py, [left, right], request)?;
    py.detach(|| matcher.compute(&left, &right)).map_err(raised)
}

/// Compares every stage of matching a pair with the definition, number by number.
///
/// Args:
///     left, right, disparities, preset, device, **options: as of :func:`match`.
///
/// Returns:
///     A list of :class:`StageCheck`; all is well where no ``mismatches`` are above 0. It is slow, and takes memory: the definition
///     is plain.
///
/// >>> import gpu_stereo, numpy
/// >>> left, right = numpy.random.default_rng(0).integers(0, 256, (2, 20, 60), dtype="uint8")
/// >>> sum(stage.mismatches for stage in gpu_stereo.check(left, right, 16, device="cpu"))
/// 0
#[pyfunction]
#[pyo3(signature = (left, right, disparities=None, preset=None, device=None, **options))]
pub fn check(
    py: Python<'_>,
    left: &Bound<'_, PyAny>,
    right: &Bound<'_, PyAny>,
    disparities: Option<&Bound<'_, PyAny>>,
    preset: Option<&str>,
    device: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<PyStageCheck>> {
    let request = Request::new(py, disparities, preset, device, options)?;
    if request.place.backend == gpu_stereo::backend::Backend::Reference {
        return Err(wrong("device is \"reference\", which check compares with; give another one"));
    }
    let (matcher, left, right) = prepared(py, [left, right], request)?;
    let stages = py.detach(|| matcher.check(&left, &right)).map_err(raised)?;
    Ok(stages.into_iter().map(PyStageCheck).collect())
}

/// How far a stage agrees with the definition.
#[pyclass(name = "StageCheck", module = "gpu_stereo", frozen)]
pub struct PyStageCheck(StageCheck);

#[pymethods]
impl PyStageCheck {
    /// The stage's name.
    #[getter]
    fn stage(&self) -> &str {
        &self.0.stage
    }

    /// Numbers that were compared.
    #[getter]
    fn elements(&self) -> u64 {
        self.0.elements
    }

    /// Numbers that differ.
    #[getter]
    fn mismatches(&self) -> u64 {
        self.0.mismatches
    }

    fn __repr__(&self) -> String {
        let StageCheck { stage, elements, mismatches, .. } = &self.0;
        format!("<StageCheck: {stage}, {mismatches} of {elements} differ>")
    }
}
