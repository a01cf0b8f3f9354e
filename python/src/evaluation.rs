//! Scores of maps.

use crate::errors::{of_file, raised, warn_in_python, wrong};
use crate::images::{array, is, shape_text, shaped};
use crate::matched::PyMatched;
use crate::settings::flags;
use crate::work::detached;
use gpu_stereo::evaluation::{self, FloatMap, Scores};
use gpu_stereo::files::maps::{self, Encoding, EncodingOptions};
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods as _, PyUntypedArray, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// How far a map is from the truth: errors in pixels, shares from 0 to 1. A figure is None where no pixel is valid.
#[pyclass(name = "Scores", module = "gpu_stereo", frozen)]
pub struct PyScores(Scores);

#[pymethods]
impl PyScores {
    /// Pixels whose truth is known and that the mask has.
    #[getter]
    fn pixels(&self) -> u64 {
        self.0.pixels
    }

    /// The share of them that has an estimate.
    #[getter]
    fn density(&self) -> f64 {
        self.0.density()
    }

    /// The share that is invalid or off by more than 0.5 px.
    #[getter]
    fn bad_0_5(&self) -> f64 {
        self.0.bad(0)
    }

    /// The share that is invalid or off by more than 1 px.
    #[getter]
    fn bad_1(&self) -> f64 {
        self.0.bad(1)
    }

    /// The share that is invalid or off by more than 2 px.
    #[getter]
    fn bad_2(&self) -> f64 {
        self.0.bad(2)
    }

    /// The share that is invalid or off by more than 4 px.
    #[getter]
    fn bad_4(&self) -> f64 {
        self.0.bad(3)
    }

    /// Of the valid pixels, the share that is off by more than 1 px.
    #[getter]
    fn bad_1_of_valid(&self) -> Option<f64> {
        self.0.bad_of_valid(1)
    }

    /// Of the valid pixels, the share that is off by more than 2 px.
    #[getter]
    fn bad_2_of_valid(&self) -> Option<f64> {
        self.0.bad_of_valid(2)
    }

    /// The mean error of valid pixels.
    #[getter]
    fn average_error(&self) -> Option<f64> {
        self.0.average()
    }

    /// The root of the mean squared error of valid pixels.
    #[getter]
    fn rms_error(&self) -> Option<f64> {
        self.0.rms()
    }

    /// KITTI's D1 of valid pixels: off by more than 3 px and 5 %.
    #[getter]
    fn d1_est(&self) -> Option<f64> {
        self.0.d1_est()
    }

    /// The same of all pixels, after holes were filled as KITTI does.
    #[getter]
    fn d1_all(&self) -> f64 {
        self.0.d1_all()
    }

    /// All figures by their names, as ``gpu-stereo eval --json`` has them.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let scores = &self.0;
        all.set_item("pixels", scores.pixels)?;
        all.set_item("density", scores.density())?;
        for (i, name) in ["0_5", "1", "2", "4"].into_iter().enumerate() {
            all.set_item(format!("bad_{name}"), scores.bad(i))?;
        }
        for (i, name) in ["0_5", "1", "2", "4"].into_iter().enumerate() {
            all.set_item(format!("bad_{name}_of_valid"), scores.bad_of_valid(i))?;
        }
        all.set_item("average_error", scores.average())?;
        all.set_item("rms_error", scores.rms())?;
        for (i, name) in ["a50", "a90", "a95", "a99"].into_iter().enumerate() {
            all.set_item(name, scores.quantiles.map(|errors| errors[i]))?;
        }
        all.set_item("d1_est", scores.d1_est())?;
        all.set_item("d1_all", scores.d1_all())?;
        Ok(all)
    }

    fn __repr__(&self) -> String {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        format!(
            "<Scores: bad 2 px {}, valid {}, {} pixels>",
            percent(self.0.bad(2)),
            percent(self.0.density()),
            self.0.pixels
        )
    }
}

/// Scores a disparity map against the truth.
///
/// Args:
///     estimate: the map: a :class:`Matched`, or an array of float32 or float64, rows x columns, in pixels. NaN and infinity are no
///         disparity.
///     truth: an array likewise.
///     mask: which pixels count, an array of bool or uint8; all of which the truth is known, if it is not given.
///
/// Returns:
///     :class:`Scores`.
///
/// >>> import gpu_stereo
/// >>> left, right = gpu_stereo.read_pair("data/motorcycle/left.png", "data/motorcycle/right.png")
/// >>> truth = gpu_stereo.read_disparity("data/motorcycle/disp_left.pfm")
/// >>> gpu_stereo.evaluate(gpu_stereo.match(left, right, 64, device="cpu"), truth).bad_2 < 0.3
/// True
#[pyfunction]
#[pyo3(signature = (estimate, truth, mask=None))]
pub fn evaluate(
    py: Python<'_>,
    estimate: &Bound<'_, PyAny>,
    truth: &Bound<'_, PyAny>,
    mask: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyScores> {
    let (estimate, truth) = (map(estimate, "estimate")?, map(truth, "truth")?);
    let mask = mask.map(|mask| flags(mask, "mask")).transpose()?;
    if let Some((size, _)) = mask.as_ref().filter(|(size, _)| *size != [truth.width(), truth.height()]) {
        return Err(wrong(format!(
            "mask is {}x{}, but the truth is {}x{}; give one of its size",
            size[0],
            size[1],
            truth.width(),
            truth.height()
        )));
    }
    let scores =
        detached(py, || evaluation::evaluate(&estimate, &truth, mask.as_ref().map(|(_, has)| has.as_slice())))?;
    Ok(PyScores(scores.map_err(raised)?))
}

/// A map of pixels.
fn map(given: &Bound<'_, PyAny>, name: &str) -> PyResult<FloatMap> {
    if let Ok(matched) = given.cast::<PyMatched>() {
        return Ok(matched.get().map().into());
    }
    let array = array(given, name)?;
    let (values, [rows, columns]) = if is::<f32>(&array) {
        read(&array, name, |value: f32| value)?
    } else if is::<f64>(&array) {
        read(&array, name, |value: f64| value as f32)?
    } else {
        return Err(wrong(format!(
            "{name} has values of {}, but must have float32 or float64, in pixels; divide raw disparities by 16",
            array.dtype()
        )));
    };
    let side = |count: usize| u32::try_from(count).map_err(|_| wrong(format!("{name} is too large")));
    FloatMap::new(side(columns)?, side(rows)?, values).map_err(raised)
}

fn read<T: Element + Copy>(
    array: &Bound<'_, PyUntypedArray>,
    name: &str,
    value: impl Fn(T) -> f32,
) -> PyResult<(Vec<f32>, [usize; 2])> {
    let &[rows, columns] = array.shape() else {
        return Err(wrong(format!(
            "{name} has the shape {}, but must have (rows, columns)",
            shape_text(array.shape())
        )));
    };
    let array = array.cast::<PyArray2<T>>()?.try_readonly().map_err(|error| wrong(error.to_string()))?;
    let view: ArrayView2<'_, T> = array.as_array();
    Ok((view.iter().map(|&element| value(element)).collect(), [rows, columns]))
}

/// Reads a disparity map from a file: PFM, PNG of 16 bits as KITTI's, NumPy, TIFF, EXR and others.
///
/// Args:
///     path: the file.
///     scale: the value that stands for 1 px, where the file does not say so.
///     invalid: a value that means no disparity, besides those that usually do.
///
/// Returns:
///     An array of float32, rows x columns, in pixels, NaN where there is none.
///
/// >>> import gpu_stereo
/// >>> gpu_stereo.read_disparity("data/motorcycle/disp_left.pfm").shape
/// (500, 741)
#[pyfunction]
#[pyo3(signature = (path, scale=None, invalid=None))]
pub fn read_disparity(
    py: Python<'_>,
    path: PathBuf,
    scale: Option<f64>,
    invalid: Option<f64>,
) -> PyResult<Bound<'_, PyAny>> {
    let encoding = Encoding { scale, invalid, ..Encoding::default() };
    let read =
        detached(py, || maps::read(&path, encoding, EncodingOptions::ESTIMATE))?.map_err(|error| of_file(&error))?;
    for doubt in &read.doubts {
        warn_in_python(py, doubt)?;
    }
    let values = read.map.data().iter().map(|value| if value.is_finite() { *value } else { f32::NAN }).collect();
    shaped(py, values, [read.map.height() as usize, read.map.width() as usize], 1)
}
