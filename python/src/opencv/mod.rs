//! What `gpu_stereo.cv` computes of given maps. The functions here take rows without gaps and check nothing that the Python side
//! has checked; every array that they return is new.

mod confidence;
mod consistency;
mod median;
mod reprojection;
mod resizing;
mod smoothing;
mod speckles;
mod texture;

use confidence::{Agreement, Rectangle};
use consistency::Limits;
use numpy::ndarray::{Array2, Array3, ArrayView2};
use numpy::{Element, IntoPyArray, PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use smoothing::Smoother;
use speckles::Regions;
use texture::Response;

/// Adds the functions to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(filter_speckles_i16, module)?)?;
    module.add_function(wrap_pyfunction!(filter_speckles_u8, module)?)?;
    module.add_function(wrap_pyfunction!(validate_disparity, module)?)?;
    module.add_function(wrap_pyfunction!(check_against_right, module)?)?;
    module.add_function(wrap_pyfunction!(median_3x3, module)?)?;
    module.add_function(wrap_pyfunction!(reproject, module)?)?;
    module.add_function(wrap_pyfunction!(agreement_confidence, module)?)?;
    module.add_function(wrap_pyfunction!(smooth, module)?)?;
    module.add_function(wrap_pyfunction!(resize, module)?)?;
    module.add_function(wrap_pyfunction!(texture_of_response, module)?)
}

fn invalid(text: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(text.to_string())
}

/// The rows of an array one behind the other, with their width; an array without pixels has the width 1.
fn rows<T: Copy>(array: ArrayView2<'_, T>) -> (Vec<T>, usize) {
    (array.iter().copied().collect(), array.ncols().max(1))
}

fn shaped<'py, T: Element>(
    py: Python<'py>,
    shape: (usize, usize),
    values: Vec<T>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    Ok(Array2::from_shape_vec(shape, values).map_err(invalid)?.into_pyarray(py))
}

fn without_speckles<'py, T: Element + Copy + Into<i32> + Send>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, T>,
    replacement: T,
    (invalid, largest, difference): (i32, i64, i32),
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let shape = map.as_array().dim();
    let (mut values, width) = rows(map.as_array());
    py.detach(|| speckles::remove(&mut values, replacement, &Regions { width, invalid, largest, difference }));
    shaped(py, shape, values)
}

/// The map without its small regions.
#[pyfunction]
fn filter_speckles_i16<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, i16>,
    invalid: i32,
    largest: i64,
    difference: i32,
) -> PyResult<Bound<'py, PyArray2<i16>>> {
    without_speckles(py, map, invalid as i16, (invalid, largest, difference))
}

/// The map without its small regions.
#[pyfunction]
fn filter_speckles_u8<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, u8>,
    invalid: i32,
    largest: i64,
    difference: i32,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    without_speckles(py, map, invalid as u8, (invalid, largest, difference))
}

/// The map without the pixels that a better match of the same right pixel contradicts.
#[pyfunction]
fn validate_disparity<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, i16>,
    costs: PyReadonlyArray2<'py, i32>,
    minimum: i32,
    count: i32,
    difference: i32,
) -> PyResult<Bound<'py, PyArray2<i16>>> {
    let shape = map.as_array().dim();
    if costs.as_array().dim() != shape {
        return Err(invalid("the costs have another shape than the disparities"));
    }
    let ((mut values, width), (costs, _)) = (rows(map.as_array()), rows(costs.as_array()));
    let limits = Limits { minimum, count, difference };
    py.detach(|| {
        for (row, costs) in values.chunks_exact_mut(width).zip(costs.chunks_exact(width)) {
            consistency::validate_row(row, costs, &limits);
        }
    });
    shaped(py, shape, values)
}

/// The left map without the pixels that the right view contradicts. With `whole` whole disparities are compared.
#[pyfunction]
fn check_against_right<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, i16>,
    right: PyReadonlyArray2<'py, i16>,
    minimum: i32,
    count: i32,
    difference: i32,
    whole: bool,
) -> PyResult<Bound<'py, PyArray2<i16>>> {
    let shape = map.as_array().dim();
    if right.as_array().dim() != shape {
        return Err(invalid("the right map has another shape than the left one"));
    }
    let ((mut values, width), (right, _)) = (rows(map.as_array()), rows(right.as_array()));
    let limits = Limits { minimum, count, difference };
    py.detach(|| {
        for (row, right) in values.chunks_exact_mut(width).zip(right.chunks_exact(width)) {
            consistency::check_row(row, right, &limits, whole);
        }
    });
    shaped(py, shape, values)
}

/// The median of 3 x 3 pixels.
#[pyfunction]
fn median_3x3<'py>(py: Python<'py>, map: PyReadonlyArray2<'py, i16>) -> PyResult<Bound<'py, PyArray2<i16>>> {
    let shape = map.as_array().dim();
    let (values, width) = rows(map.as_array());
    let filtered = py.detach(|| median::filtered(&values, width));
    shaped(py, shape, filtered)
}

/// X, Y and Z of each pixel.
#[pyfunction]
fn reproject<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, f32>,
    q: [[f64; 4]; 4],
    missing: Option<f64>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let (height, width) = map.as_array().dim();
    let (values, columns) = rows(map.as_array());
    let points = py.detach(|| reprojection::points(&values, columns, &q, missing));
    Ok(Array3::from_shape_vec((height, width, 3), points).map_err(invalid)?.into_pyarray(py))
}

/// The confidence of the left map, 0 to 255. `part` is x, y, width and height.
#[pyfunction]
fn agreement_confidence<'py>(
    py: Python<'py>,
    left: PyReadonlyArray2<'py, i16>,
    right: PyReadonlyArray2<'py, i16>,
    part: [usize; 4],
    threshold: i32,
    radius: usize,
    roll_off: f32,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let shape = left.as_array().dim();
    if right.as_array().dim() != shape {
        return Err(invalid("the right map has another shape than the left one"));
    }
    let [x, y, width, height] = part;
    let inside = x.checked_add(width).is_some_and(|end| end <= shape.1)
        && y.checked_add(height).is_some_and(|end| end <= shape.0);
    if !inside || width == 0 || height == 0 {
        return Err(invalid("the part of the maps lies outside of them"));
    }
    let ((left, columns), (right, _)) = (rows(left.as_array()), rows(right.as_array()));
    let (part, agreement) = (Rectangle { x, y, width, height }, Agreement { threshold, radius, roll_off });
    let confidence = py.detach(|| confidence::confidence(&left, &right, columns, part, &agreement));
    shaped(py, shape, confidence)
}

/// Each of the maps, smoothed along the edges of the guide, which has 1 or 3 channels.
#[pyfunction]
fn smooth<'py>(
    py: Python<'py>,
    guide: PyReadonlyArray3<'py, u8>,
    maps: Vec<PyReadonlyArray2<'py, f32>>,
    lambda: f64,
    sigma: f64,
) -> PyResult<Vec<Bound<'py, PyArray2<f32>>>> {
    let (height, width, channels) = guide.as_array().dim();
    if maps.iter().any(|map| map.as_array().dim() != (height, width)) {
        return Err(invalid("the maps have another size than the guide"));
    }
    if width == 0 || height == 0 || channels == 0 {
        return Err(invalid("the guide has no pixels"));
    }
    let bytes: Vec<u8> = guide.as_array().iter().copied().collect();
    let mut values: Vec<Vec<f32>> = maps.iter().map(|map| rows(map.as_array()).0).collect();
    py.detach(|| {
        let smoother = Smoother::new(&bytes, width, channels, lambda, sigma);
        for map in &mut values {
            smoother.smooth(map);
        }
    });
    values.into_iter().map(|map| shaped(py, (height, width), map)).collect()
}

/// The map in another size.
#[pyfunction]
fn resize<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, f32>,
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    if map.as_array().is_empty() || width == 0 || height == 0 {
        return Err(invalid("a map without pixels cannot be resized"));
    }
    let (values, columns) = rows(map.as_array());
    let resized = py.detach(|| resizing::resized(&values, columns, (width, height)));
    shaped(py, (height, width), resized)
}

/// The texture of the block around each pixel, of the image prefiltered as with PREFILTER_NORMALIZED_RESPONSE.
#[pyfunction]
fn texture_of_response<'py>(
    py: Python<'py>,
    image: PyReadonlyArray2<'py, u8>,
    window: u32,
    cap: u32,
    block: usize,
) -> PyResult<Bound<'py, PyArray2<u32>>> {
    let shape = image.as_array().dim();
    if image.as_array().is_empty()
        || !(3..=51).contains(&window)
        || window.is_multiple_of(2)
        || !(1..=127).contains(&cap)
    {
        return Err(invalid("the window is odd, 3 to 51, the clip 1 to 127, and the image not empty"));
    }
    let (values, width) = rows(image.as_array());
    let sums = py.detach(|| texture::sums(&values, width, &Response { window, cap, block }));
    shaped(py, shape, sums)
}
