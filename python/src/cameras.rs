//! Cameras and calibrations.

use crate::errors::{ensure_count, in_python, of_file, raised, warn_in_python, wrong};
use crate::images::{self, Channels, GivenPair};
use crate::work::detached;
use gpu_stereo::backend::upright;
use gpu_stereo::files::calibration::{Calibration, Fitted, KittiPair, LensModel, Reading, Scale, Unit};
use gpu_stereo::files::images::Bits;
use gpu_stereo::{Camera, Rectification, reference};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::path::PathBuf;

/// The cameras of a rectified pair, which turn disparities into depths.
///
/// Args:
///     focal: focal length in pixels.
///     baseline: distance between the cameras in metres.
///     cx, cy: the left principal point in pixels, where 0 is the centre of the first pixel.
///     doffs: column of the right principal point less that of the left one.
///
/// A disparity of ``d`` pixels is ``focal * baseline / (d + doffs)`` metres away.
///
/// >>> import gpu_stereo
/// >>> gpu_stereo.Camera(focal=700, baseline=0.12, cx=319.5, cy=239.5)
/// Camera(focal=700, baseline=0.12, cx=319.5, cy=239.5, doffs=0)
#[pyclass(name = "Camera", module = "gpu_stereo", frozen, eq)]
#[derive(Clone, Copy, PartialEq)]
pub struct PyCamera(pub Camera);

#[pymethods]
impl PyCamera {
    #[new]
    #[pyo3(signature = (focal, baseline, cx, cy, doffs=0.0))]
    fn new(focal: f64, baseline: f64, cx: f64, cy: f64, doffs: f64) -> PyResult<Self> {
        let camera = Camera::new(focal, baseline).with_doffs(doffs).with_principal_point(cx, cy);
        camera.validate().map_err(raised)?;
        Ok(Self(camera))
    }

    /// Focal length in pixels.
    #[getter]
    fn focal(&self) -> f64 {
        self.0.focal
    }

    /// Distance between the cameras in metres.
    #[getter]
    fn baseline(&self) -> f64 {
        self.0.baseline
    }

    /// Column of the left principal point in pixels.
    #[getter]
    fn cx(&self) -> f64 {
        self.0.cx
    }

    /// Row of the principal points in pixels.
    #[getter]
    fn cy(&self) -> f64 {
        self.0.cy
    }

    /// Column of the right principal point less that of the left one, in pixels.
    #[getter]
    fn doffs(&self) -> f64 {
        self.0.doffs
    }

    fn __reduce__<'py>(this: &Bound<'py, Self>) -> (Bound<'py, PyType>, (f64, f64, f64, f64, f64)) {
        let Camera { focal, baseline, doffs, cx, cy, .. } = this.get().0;
        (this.get_type(), (focal, baseline, cx, cy, doffs))
    }

    fn __repr__(&self) -> String {
        let Camera { focal, baseline, doffs, cx, cy, .. } = self.0;
        format!("Camera(focal={focal}, baseline={baseline}, cx={cx}, cy={cy}, doffs={doffs})")
    }
}

/// The calibration of a pair, as :func:`read_calibration` gives it.
///
/// Give it as ``cameras`` to match a pair, or to :func:`rectify`.
#[pyclass(name = "Calibration", module = "gpu_stereo", frozen)]
pub struct PyCalibration(Calibration);

#[pymethods]
impl PyCalibration {
    /// The kind of file that it was read from.
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    /// Whether pairs are rectified with it: it was read with ``rectify=True``.
    #[getter]
    fn rectifies(&self) -> bool {
        self.0.has_lenses()
    }

    /// The cameras of images of ``width`` x ``height`` pixels, as they are once rectified.
    fn camera(&self, py: Python<'_>, width: i64, height: i64) -> PyResult<PyCamera> {
        let size = [ensure_count("width", width)?, ensure_count("height", height)?];
        Ok(PyCamera(fit(py, &self.0, size)?.camera))
    }

    fn __repr__(&self) -> String {
        format!("<Calibration: {}>", self.0.kind())
    }
}

/// What the keyword `cameras` may be.
pub enum Cameras {
    /// Of rectified pairs.
    Rectified(Camera),
    /// Of a file.
    Calibration(Calibration),
}

/// Cameras and rectification of images of one size.
pub struct OfSize {
    /// The rectified cameras.
    pub camera: Camera,
    /// How pairs are rectified, if they are.
    pub rectification: Option<Rectification>,
}

impl Cameras {
    /// From a `Camera` or a `Calibration`.
    pub fn new(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(camera) = given.cast::<PyCamera>() {
            return Ok(Self::Rectified(camera.get().0));
        }
        if let Ok(calibration) = given.cast::<PyCalibration>() {
            return Ok(Self::Calibration(calibration.get().0.clone()));
        }
        Err(wrong(format!(
            "cameras is of the type {}, but must be a gpu_stereo.Camera, or what gpu_stereo.read_calibration gives",
            given.get_type().name()?
        )))
    }

    /// Fits them to images of a size.
    pub fn fit(&self, py: Python<'_>, size: [u32; 2]) -> PyResult<OfSize> {
        match self {
            Self::Rectified(camera) => Ok(OfSize { camera: *camera, rectification: None }),
            Self::Calibration(calibration) => fit(py, calibration, size),
        }
    }
}

fn fit(py: Python<'_>, calibration: &Calibration, given: [u32; 2]) -> PyResult<OfSize> {
    let Fitted { camera, lenses, size, vertical, .. } =
        py.detach(|| calibration.fit(given[0], given[1])).map_err(|error| wrong(in_python(&error.to_string())))?;
    if let Some(doubt) = calibration.doubt(&camera) {
        warn_in_python(py, &doubt)?;
    }
    let rectification = detached(py, || match (lenses, vertical) {
        (Some(lenses), false) => Rectification::of_size(given, size, lenses).map(Some),
        (Some(lenses), true) => Rectification::vertical(given, size, lenses).map(Some),
        (None, true) => Rectification::turn(given).map(Some),
        (None, false) => Ok(None),
    })?;
    Ok(OfSize { camera, rectification: rectification.map_err(raised)? })
}

/// Reads a calibration file.
///
/// Known are Middlebury, KITTI, ROS (``camera_info``), Kalibr, EuRoC, Basalt, ZED, RealSense, DepthAI, OpenCV's samples and others;
/// the structure of a file shows its kind.
///
/// Args:
///     path: the file.
///     right: the right camera's file, where each camera has one.
///     rectify: read the lenses, too: pairs are then rectified.
///     calib_unit: the unit of lengths: ``"m"``, ``"cm"`` or ``"mm"``.
///     calib_pair: of KITTI: ``"color"`` or ``"gray"``.
///     calib_cams: the numbers of the left and the right camera, where the file has more.
///     calib_scale: the size of the images relative to the calibrated ones.
///     lens: ``"auto"``, ``"pinhole"`` or ``"fisheye"``, where the file names no model.
///     alpha: how much rectified images show, from 0 to 1, as in OpenCV.
///     rectified_size: columns and rows of rectified images.
///     vertical: the cameras lie one above the other.
///
/// >>> import gpu_stereo
/// >>> calibration = gpu_stereo.read_calibration("data/motorcycle/calib.txt")
/// >>> calibration.camera(741, 500).baseline
/// 0.193001
#[pyfunction]
#[pyo3(signature = (path, right=None, *, rectify=false, calib_unit=None, calib_pair=None, calib_cams=None, calib_scale=None, lens="auto",
    alpha=None, rectified_size=None, vertical=false))]
#[allow(clippy::too_many_arguments)] // a keyword each
pub fn read_calibration(
    py: Python<'_>,
    path: PathBuf,
    right: Option<PathBuf>,
    rectify: bool,
    calib_unit: Option<&str>,
    calib_pair: Option<&str>,
    calib_cams: Option<[u32; 2]>,
    calib_scale: Option<f64>,
    lens: &str,
    alpha: Option<f64>,
    rectified_size: Option<[u32; 2]>,
    vertical: bool,
) -> PyResult<PyCalibration> {
    let reading = Reading {
        unit: calib_unit
            .map(|unit| one_of("calib_unit", unit, &[("m", Unit::M), ("cm", Unit::Cm), ("mm", Unit::Mm)]))
            .transpose()?,
        pair: calib_pair
            .map(|pair| one_of("calib_pair", pair, &[("color", KittiPair::Color), ("gray", KittiPair::Gray)]))
            .transpose()?,
        cameras: calib_cams,
        lens: one_of(
            "lens",
            lens,
            &[("auto", LensModel::Auto), ("pinhole", LensModel::Pinhole), ("fisheye", LensModel::Fisheye)],
        )?,
        scale: calib_scale.map(scale).transpose()?,
        lenses: rectify,
        alpha,
        vertical,
        rectified_size,
    };
    let read = detached(py, || Calibration::read(&path, right.as_deref(), reading))?;
    read.map(PyCalibration).map_err(|error| of_file(&error))
}

fn one_of<T: Copy>(name: &str, given: &str, known: &[(&str, T)]) -> PyResult<T> {
    let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let found = known.iter().find(|(name, _)| *name == given).map(|(_, value)| *value);
    found.ok_or_else(|| wrong(format!("{name} is {given:?}, but must be one of {}", names())))
}

fn scale(given: f64) -> PyResult<Scale> {
    given.to_string().parse().map_err(|allowed| wrong(format!("calib_scale is {given}, but {allowed}")))
}

/// Rectifies a pair.
///
/// Args:
///     left, right: images, arrays of uint8 or uint16, rows x columns or rows x columns x 3 or 4.
///     calibration: what :func:`read_calibration` gave with ``rectify=True``.
///
/// Returns:
///     The left and the right image, as they were given but for their size, and the rectified :class:`Camera`.
///     Samples from outside the given images are 0.
///
/// >>> import gpu_stereo, numpy
/// >>> calibration = gpu_stereo.read_calibration("python/tests/data/camchain.yaml", rectify=True)
/// >>> left, right, camera = gpu_stereo.rectify(*numpy.zeros((2, 480, 752), "uint8"), calibration)
/// >>> left.shape
/// (480, 752)
#[pyfunction]
pub fn rectify<'py>(
    py: Python<'py>,
    left: &Bound<'py, PyAny>,
    right: &Bound<'py, PyAny>,
    calibration: &Bound<'py, PyCalibration>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, PyCamera)> {
    let given = GivenPair::new(left, right)?;
    let OfSize { camera, rectification } = fit(py, &calibration.get().0, given.size())?;
    let Some(rectification) = rectification else {
        return Err(wrong("the calibration is of a rectified pair; read it with rectify=True for its lenses"));
    };
    let samples = given.samples();
    let pair = given.images(Channels::Rgb, Bits::Given(16))?;
    let rectified = detached(py, || {
        let one = |image, side| {
            let image = reference::rectify(image, &rectification, side)?;
            if rectification.is_turned() { upright(&image, &rectification) } else { Ok(image) }
        };
        Ok((one(&pair.left, 0)?, one(&pair.right, 1)?))
    })?;
    let (left, right) = rectified.map_err(raised)?;
    Ok((images::to_array(py, &left, samples)?, images::to_array(py, &right, samples)?, PyCamera(camera)))
}
