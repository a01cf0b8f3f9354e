//! `StereoMatcher`, and functions of a single pair.

use crate::errors::{ensure_count, raised, warn, wrong};
use crate::images::GivenPair;
use crate::matched::PyMatched;
use crate::matcher::{Matcher, format};
use crate::settings::Request;
use crate::stream::PyStream;
use crate::table;
use crate::work::detached;
use gpu_stereo::backend::{Backend, Engine, Shape};
use gpu_stereo::{Image, Params, PixelFormat, RangeSearch, StageCheck};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Matches rectified pairs of one size: made once, for many pairs.
///
/// Args:
///     width, height: columns and rows of the images.
///     preset: the settings to start from: ``"classic"``, ``"fast"``, ``"balanced"``, ``"strict"``, ``"dense"`` or ``"accurate"``.
///     disparities: how many disparities to search, in pixels, from ``min_disp`` (0 unless given) on.
///     device: ``"auto"`` (the best GPU, else the CPU), ``"gpu"``, ``"cpu"``, ``"reference"``, or an adapter by its index or a part of
///         its name, see :func:`adapters`.
///     channels: ``"rgb"``, or ``"bgr"`` as OpenCV reads files.
///     bits: the bits that samples of 16 bits use, 8 to 16; ``"auto"``: as many as the largest of a pair needs.
///     confidence, right_map, timings: give these, too.
///     cameras: a :class:`Camera` for depths, or a :class:`Calibration`, which rectifies the pairs if it was read so.
///     mask: which pixels have content: an array of bool or uint8, or one for each image: ``(left, right)``.
///     weights: the network's weights, a file, with ``method="psmnet"``; with ``cost="learned"`` and ``cost="learned-census"`` another
///         network of features than the one of the library.
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
    fn stream(&self, pairs: &Bound<'_, PyAny>, in_flight: i64) -> PyResult<PyStream> {
        PyStream::of_matcher(Arc::clone(&self.0), pairs, in_flight)
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
        table::values(py, &self.0.params)
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
        let search = RangeSearch::rectified(left, right, params.rectify.as_ref())?;
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
/// <Matched: 741x500, 89.3 % valid>
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
    if request.place.backend == Backend::Reference {
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
