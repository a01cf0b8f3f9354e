//! Arrays become images, and images arrays.

use crate::errors::{in_python, wrong};
use gpu_stereo::files::images::{Bits, ImagePair};
use gpu_stereo::{Image, Pixels};
use image::{DynamicImage, ImageBuffer};
use numpy::ndarray::{Array, ArrayView3, Axis, Ix3};
use numpy::{
    Element, PyArrayDescrMethods as _, PyArrayDyn, PyArrayMethods as _, PyUntypedArray, PyUntypedArrayMethods as _,
};
use numpy::{PyArray, dtype};
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::path::Path;

/// The order in which the colours of a pixel lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// Red, green, blue, and a fourth sample that is ignored.
    #[default]
    Rgb,
    /// Blue, green, red, as OpenCV reads files.
    Bgr,
}

impl Channels {
    /// By its name.
    pub fn named(name: &str) -> PyResult<Self> {
        match name {
            "rgb" => Ok(Self::Rgb),
            "bgr" => Ok(Self::Bgr),
            _ => Err(wrong(format!(
                "channels is {name:?}, but must be \"rgb\" or \"bgr\"; OpenCV reads files as \"bgr\""
            ))),
        }
    }
}

/// An image as it was given: an array of 8 or 16 bits, not copied yet.
pub struct Given<'py> {
    array: Bound<'py, PyUntypedArray>,
    name: &'static str,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: usize,
}

/// Any object that holds an array, as a NumPy array on the host that is aligned and in the host's byte order. Copied is only what
/// is neither.
pub fn array<'py>(object: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = object.py();
    let numpy = py.import("numpy")?;
    let array = if object.is_instance(&numpy.getattr("ndarray")?)? {
        if object.is_instance(&numpy.getattr("ma")?.getattr("MaskedArray")?)? {
            return Err(wrong(format!(
                "{name} is a masked array, whose mask would be ignored; give its data, and masks by the argument mask"
            )));
        }
        object.clone()
    } else if object.hasattr("__dlpack__")? {
        ensure_on_host(object, name)?;
        numpy.call_method1("from_dlpack", (object,))?
    } else if let Ok(view) = py.import("builtins")?.call_method1("memoryview", (object,)) {
        numpy.call_method1("asarray", (view,))?
    } else if object.hasattr("__array_interface__")? || object.hasattr("__array__")? {
        numpy.call_method1("asarray", (object,))?
    } else {
        return Err(wrong(format!(
            "{name} is of the type {}, but must be an array: of NumPy, or what has __dlpack__, the buffer protocol or \
             __array_interface__",
            object.get_type().name()?
        )));
    };
    let kind = array.getattr("dtype")?;
    let native = kind.getattr("isnative")?.extract::<bool>()?;
    let aligned = array.getattr("flags")?.getattr("aligned")?.extract::<bool>()?;
    let array = match native && aligned {
        true => array,
        false => numpy.call_method1("array", (array, kind.call_method1("newbyteorder", ("=",))?))?,
    };
    Ok(array.cast_into::<PyUntypedArray>()?)
}

/// Refuses what lies on a device.
fn ensure_on_host(object: &Bound<'_, PyAny>, name: &str) -> PyResult<()> {
    let (kind, _): (i64, i64) = object.call_method0("__dlpack_device__")?.extract()?;
    match kind {
        1 | 3 | 11 => Ok(()), // the host; its memory that CUDA and ROCm have pinned
        _ => Err(wrong(format!(
            "{name} lies on a device (DLPack's type {kind}), but must be on the host; copy it, for instance by .cpu()"
        ))),
    }
}

/// Whether the elements of an array are of a type.
pub fn is<T: Element>(array: &Bound<'_, PyUntypedArray>) -> bool {
    array.dtype().is_equiv_to(&dtype::<T>(array.py()))
}

impl<'py> Given<'py> {
    /// Looks at an image: rows x columns, or rows x columns x 1, 3 or 4 samples.
    pub fn new(object: &Bound<'py, PyAny>, name: &'static str) -> PyResult<Self> {
        let array = array(object, name)?;
        if !is::<u8>(&array) && !is::<u16>(&array) {
            return Err(wrong(format!(
                "{name} has samples of {}, but must have uint8 or uint16; convert it, such as by (255 * image).astype(\"uint8\") \
                 where its samples are from 0 to 1",
                PyString::new(array.py(), "").call_method1("join", ([array.dtype().str()?],))?
            )));
        }
        let shape = array.shape();
        let samples = match shape {
            [_, _] | [_, _, 1] => 1,
            [_, _, samples @ (3 | 4)] => *samples,
            _ => {
                let tip = match shape {
                    [1 | 3 | 4, _, _] => "; this looks like channels x rows x columns: transpose(1, 2, 0)",
                    [1, _, _, _] => "; give one image of the batch",
                    _ => "",
                };
                return Err(wrong(format!(
                    "{name} has the shape {}, but must have (rows, columns), or (rows, columns, samples) with 1, 3 or 4 \
                     samples{tip}",
                    shape_text(shape)
                )));
            }
        };
        let side = |count: usize| {
            u32::try_from(count)
                .map_err(|_| wrong(format!("{name} has the shape {}, which is too large", shape_text(shape))))
        };
        let size = [side(shape[1])?, side(shape[0])?];
        Ok(Self { array, name, size, samples })
    }

    /// A picture of the samples.
    fn picture(&self, channels: Channels) -> PyResult<DynamicImage> {
        let [width, height] = self.size;
        let picture = if is::<u8>(&self.array) {
            let samples = self.samples::<u8>(channels, u8::MAX)?;
            match self.samples {
                1 => ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageLuma8),
                _ => ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageRgba8),
            }
        } else {
            let samples = self.samples::<u16>(channels, u16::MAX)?;
            match self.samples {
                1 => ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageLuma16),
                _ => ImageBuffer::from_raw(width, height, samples).map(DynamicImage::ImageRgba16),
            }
        };
        picture.ok_or_else(|| wrong(format!("{} has no samples of {width}x{height}", self.name)))
    }

    /// One sample a pixel, or red, green, blue and one more.
    fn samples<T: Element + Copy>(&self, channels: Channels, full: T) -> PyResult<Vec<T>> {
        let array = self.array.cast::<PyArrayDyn<T>>()?.try_readonly().map_err(|error| wrong(error.to_string()))?;
        let view = array.as_array();
        let view = if view.ndim() == 2 { view.insert_axis(Axis(2)) } else { view };
        let view: ArrayView3<'_, T> = view.into_dimensionality::<Ix3>().map_err(|error| wrong(error.to_string()))?;
        if self.samples == 1 {
            let mut all = Vec::with_capacity(view.len());
            for row in view.index_axis(Axis(2), 0).rows() {
                match row.as_slice() {
                    Some(samples) => all.extend_from_slice(samples),
                    None => all.extend(row),
                }
            }
            return Ok(all);
        }
        let order = if channels == Channels::Rgb { [0, 1, 2] } else { [2, 1, 0] };
        let mut all = Vec::with_capacity(view.len() / self.samples * 4);
        for row in view.outer_iter() {
            match row.as_slice() {
                Some(samples) => {
                    let first = all.len();
                    all.resize(first + row.len_of(Axis(0)) * 4, full);
                    let colors = all[first..].as_chunks_mut::<4>().0;
                    for (color, pixel) in colors.iter_mut().zip(samples.chunks_exact(self.samples)) {
                        *color = [pixel[order[0]], pixel[order[1]], pixel[order[2]], full];
                    }
                }
                None => all.extend(
                    row.outer_iter().flat_map(|pixel| [pixel[order[0]], pixel[order[1]], pixel[order[2]], full]),
                ),
            }
        }
        Ok(all)
    }
}

/// A pair as it was given.
pub struct GivenPair<'py> {
    left: Given<'py>,
    right: Given<'py>,
}

impl<'py> GivenPair<'py> {
    /// Looks at two images.
    pub fn new(left: &Bound<'py, PyAny>, right: &Bound<'py, PyAny>) -> PyResult<Self> {
        let (left, right) = (Given::new(left, "left")?, Given::new(right, "right")?);
        if left.size != right.size {
            let ([l, r], [a, b]) = (left.size, right.size);
            return Err(wrong(format!(
                "left is {l}x{r} and right {a}x{b}, but a rectified pair has one size; crop or rectify them again"
            )));
        }
        Ok(Self { left, right })
    }

    /// Columns and rows of the left image.
    pub fn size(&self) -> [u32; 2] {
        self.left.size
    }

    /// Samples a pixel of the left image.
    pub fn samples(&self) -> usize {
        self.left.samples
    }

    /// Whether samples have 16 bits, and whether there are colours, of either image.
    pub fn kind(&self) -> (bool, bool) {
        let both = [&self.left, &self.right];
        (both.iter().any(|given| is::<u16>(&given.array)), both.iter().any(|given| given.samples > 1))
    }

    /// Refuses a pair that is not of this size, before anything is copied.
    pub fn ensure(&self, [width, height]: [u32; 2]) -> PyResult<()> {
        if self.size() == [width, height] {
            return Ok(());
        }
        let [columns, rows] = self.size();
        Err(wrong(format!(
            "the images are {columns}x{rows}, but the matcher was made for {width}x{height}; resize them, or make another one"
        )))
    }

    /// The images, brought to one format.
    pub fn images(&self, channels: Channels, bits: Bits) -> PyResult<ImagePair> {
        let pictures = [self.left.picture(channels)?, self.right.picture(channels)?];
        ImagePair::of(pictures, ["left", "right"].map(Path::new), bits)
            .map_err(|error| wrong(in_python(&error.to_string())))
    }
}

/// The shape of an array as Python shows it.
pub fn shape_text(shape: &[usize]) -> String {
    let sides = shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    if shape.len() == 1 { format!("({sides},)") } else { format!("({sides})") }
}

/// An image as an array: rows x columns, or rows x columns x `samples` where it has colours.
pub fn to_array<'py>(py: Python<'py>, image: &Image, samples: usize) -> PyResult<Bound<'py, PyAny>> {
    let size = [image.height() as usize, image.width() as usize];
    match image.pixels() {
        Pixels::Gray8(all) => shaped(py, all.clone(), size, 1),
        Pixels::Gray16(all) => shaped(py, all.clone(), size, 1),
        Pixels::Rgba8(all) => shaped(py, colors(all, samples), size, samples),
        Pixels::Rgba16(all) => shaped(py, colors(all, samples), size, samples),
        _ => Err(wrong("the image has samples of an unknown kind")),
    }
}

/// The first samples of each pixel.
fn colors<T: Copy>(all: &[T], samples: usize) -> Vec<T> {
    all.chunks_exact(4).flat_map(|pixel| &pixel[..samples.min(4)]).copied().collect()
}

/// An array of such values; nothing is copied.
pub fn shaped<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
    [rows, columns]: [usize; 2],
    samples: usize,
) -> PyResult<Bound<'_, PyAny>> {
    let shape = if samples == 1 { vec![rows, columns] } else { vec![rows, columns, samples] };
    let array = Array::from_shape_vec(shape, values).map_err(|error| wrong(error.to_string()))?;
    Ok(PyArray::from_owned_array(py, array).into_any())
}
