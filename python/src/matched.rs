//! What matching a pair gives.

use crate::cameras::PyCamera;
use crate::images::shaped;
use gpu_stereo::{Camera, DepthMap, DisparityMap, Matched, Params, StageTime, files};
use pyo3::exceptions::PyAttributeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

/// The maps of a pair: arrays of the (rectified) left image's shape, each of which offers DLPack.
///
/// Arrays are made when they are first asked for, and are the same ones afterwards. What was not asked for when the pair was
/// matched raises an ``AttributeError`` that says how to.
#[pyclass(name = "Matched", module = "gpu_stereo", frozen)]
pub struct PyMatched {
    maps: Matched,
    camera: Option<Camera>,
    range: (i32, u32),
    stages: Option<Vec<StageTime>>,
    disparity: PyOnceLock<Py<PyAny>>,
    raw: PyOnceLock<Py<PyAny>>,
    mask: PyOnceLock<Py<PyAny>>,
    confidence: PyOnceLock<Py<PyAny>>,
    right: PyOnceLock<Py<PyAny>>,
    depth: PyOnceLock<Py<PyAny>>,
}

impl PyMatched {
    /// Of a pair that was matched with these settings. `stages`: the times of the stages, if they were asked for.
    pub fn new(maps: Matched, params: &Params, stages: Option<Vec<StageTime>>) -> Self {
        Self {
            maps,
            camera: params.depth,
            range: (params.min_disparity, params.disparities),
            stages,
            disparity: PyOnceLock::new(),
            raw: PyOnceLock::new(),
            mask: PyOnceLock::new(),
            confidence: PyOnceLock::new(),
            right: PyOnceLock::new(),
            depth: PyOnceLock::new(),
        }
    }

    /// The map as it is.
    pub fn map(&self) -> &DisparityMap {
        &self.maps.map
    }

    fn depth_map(&self) -> PyResult<(&DepthMap, &Camera)> {
        self.maps.depth.as_ref().zip(self.camera.as_ref()).ok_or_else(|| absent("depth", "the cameras: cameras=.."))
    }
}

/// Why there is no such map.
fn absent(what: &str, keyword: &str) -> PyErr {
    PyAttributeError::new_err(format!("there is no {what}: it was not asked for; match the pair with {keyword}"))
}

type Kept = PyOnceLock<Py<PyAny>>;

fn kept<'py>(py: Python<'py>, place: &Kept, make: impl FnOnce() -> PyResult<Bound<'py, PyAny>>) -> PyResult<Py<PyAny>> {
    place.get_or_try_init(py, || make().map(Bound::unbind)).map(|array| array.clone_ref(py))
}

fn pixels<'py>(py: Python<'py>, map: &DisparityMap) -> PyResult<Bound<'py, PyAny>> {
    let values = map.data.iter().map(|&value| match value {
        DisparityMap::INVALID => f32::NAN,
        value => f32::from(value) / 16.0,
    });
    shaped(py, values.collect(), [map.height as usize, map.width as usize], 1)
}

#[pymethods]
impl PyMatched {
    /// The disparities of the left image in pixels: float32, NaN where there is none. ``left[y, x]`` shows what
    /// ``right[y, x - disparity]`` shows.
    #[getter]
    fn disparity(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        kept(py, &self.disparity, || pixels(py, &self.maps.map))
    }

    /// The same in 1/16 pixel: int16, -32768 where there is none.
    #[getter]
    fn raw(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let DisparityMap { width, height, data } = &self.maps.map;
        kept(py, &self.raw, || shaped(py, data.clone(), [*height as usize, *width as usize], 1))
    }

    /// Which pixels have a disparity: bool.
    #[getter]
    fn mask(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let DisparityMap { width, height, data } = &self.maps.map;
        let valid = || data.iter().map(|&value| value != DisparityMap::INVALID).collect();
        kept(py, &self.mask, || shaped(py, valid(), [*height as usize, *width as usize], 1))
    }

    /// How far each disparity is ahead of its best rival: uint8, 1 to 255, 0 where there is none. Needs ``confidence=True``.
    #[getter]
    fn confidence(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let map = self.maps.confidence.as_ref().ok_or_else(|| absent("confidence", "confidence=True"))?;
        kept(py, &self.confidence, || shaped(py, map.data.clone(), [map.height as usize, map.width as usize], 1))
    }

    /// The disparities of the right image in pixels, before any check or filter: float32, NaN where there is none.
    /// ``right[y, x]`` shows what ``left[y, x + disparity]`` shows. Needs ``right_map=True``.
    #[getter]
    fn right(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let map = self.maps.right.as_ref().ok_or_else(|| absent("right map", "right_map=True"))?;
        kept(py, &self.right, || pixels(py, map))
    }

    /// The depth of each pixel in metres: float32, NaN where there is none. Needs ``cameras``.
    #[getter]
    fn depth(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let (map, _) = self.depth_map()?;
        let size = [map.height as usize, map.width as usize];
        kept(py, &self.depth, || shaped(py, files::encoders::metres(map, f32::NAN), size, 1))
    }

    /// The rectified cameras. Needs ``cameras``.
    #[getter]
    fn camera(&self) -> PyResult<PyCamera> {
        self.camera.map(PyCamera).ok_or_else(|| absent("camera", "the cameras: cameras=.."))
    }

    /// The position of what each pixel with a depth shows: float32, points x 3, in metres to the right, down and forward of the
    /// left camera; row by row. ``image[~numpy.isnan(matched.depth)]`` are the colours. Needs ``cameras``.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (depth, camera) = self.depth_map()?;
        let width = depth.width.max(1) as usize;
        let with_depth = depth.data.iter().enumerate().filter(|(_, value)| **value != DepthMap::NONE);
        let places = with_depth.flat_map(|(i, &value)| {
            camera.point((i % width) as u32, (i / width) as u32, value).map(|metres| metres as f32)
        });
        let places: Vec<f32> = places.collect();
        shaped(py, places.clone(), [places.len() / 3, 3], 1)
    }

    /// Milliseconds of each stage by its name. Needs ``timings=True``.
    #[getter]
    fn timings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let stages = self.stages.as_ref().ok_or_else(|| absent("timings", "timings=True"))?;
        let all = PyDict::new(py);
        stages.iter().try_for_each(|stage| all.set_item(&stage.name, stage.ms))?;
        Ok(all)
    }

    /// The smallest disparity that was searched, and how many.
    #[getter]
    fn search_range(&self) -> (i32, u32) {
        self.range
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (u32, u32) {
        (self.maps.map.height, self.maps.map.width)
    }

    fn __repr__(&self) -> String {
        let DisparityMap { width, height, .. } = &self.maps.map;
        let valid = 100.0 * self.maps.map.valid_fraction();
        format!("<Matched: {width}x{height}, {valid:.1} % valid>")
    }
}
