//! Keywords become settings: what is to be computed, and where.

use crate::cameras::Cameras;
use crate::errors::{argument, of_file, raised, warn, wrong};
use crate::images::{self, Channels};
use crate::work::detached;
use gpu_stereo::backend::{Backend, Place};
use gpu_stereo::files::images::Bits;
use gpu_stereo::{FeatureNetwork, Masks, Method, Network, Params};
use numpy::{PyArray2, PyArrayMethods as _, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString, PyTuple};
use std::path::PathBuf;

/// How many disparities are searched, if nothing is said.
const DISPARITIES: u32 = 64;

/// What a matcher is asked for.
pub struct Request {
    /// The settings that do not depend on the images' size.
    pub common: Params,
    /// Whether the range of disparities is to be found from the pair.
    pub finds_range: bool,
    /// Whether its smallest disparity is given.
    pub min_is_given: bool,
    /// Where to compute.
    pub place: Place,
    /// The order of colours.
    pub channels: Channels,
    /// The bits of samples of 16 bits.
    pub bits: Bits,
    /// Whether the times of stages are wanted.
    pub timings: bool,
    cameras: Option<Cameras>,
    masks: [Option<Mask>; 2],
}

/// Which pixels of an image have content.
#[derive(Clone)]
struct Mask {
    /// Columns and rows.
    size: [u32; 2],
    has: Vec<u8>,
}

impl Request {
    /// Reads the keywords. `options`: all that are left, by the names of the command's table.
    pub fn new(
        py: Python<'_>,
        disparities: Option<&Bound<'_, PyAny>>,
        preset: Option<&str>,
        device: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let mut more = More::default();
        let mut texts = Vec::new();
        for (name, value) in options.into_iter().flatten() {
            let name: String = name.extract()?;
            if !more.take(&name, &value)? {
                texts.extend(text(&name, &value)?.map(|text| (name.replace('_', "-"), text)));
            }
        }
        if let Some((name, _)) = texts.iter().find(|(name, _)| name == "disp") {
            return Err(wrong(format!("{name} is given by the argument disparities here; use it")));
        }
        let count = disparities.map(|count| text("disparities", count)).transpose()?.flatten();
        let finds_range = count.as_deref() == Some("auto");
        let count = count.filter(|_| !finds_range).unwrap_or_else(|| DISPARITIES.to_string());
        let given = texts.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        let given: Vec<_> =
            given.chain(preset.map(|preset| ("preset", preset))).chain([("disp", count.as_str())]).collect();
        let mut common = Params::from_options(DISPARITIES, given.iter().copied()).map_err(raised)?;
        for option in Params::OPTIONS.iter().filter(|option| texts.iter().any(|(name, _)| name == option.name)) {
            if let Some(other) = option.idle(&common) {
                let (name, other, value) = (argument(option.name), argument(other.name), other.get(&common));
                warn(py, &format!("{name} has no effect with {other} {value}"))?;
            }
        }
        (common.confidence, common.right_map) = (more.confidence, more.right_map);
        common.network = match (more.weights, common.method) {
            (None, Method::Psmnet) => {
                return Err(wrong("method psmnet needs the weights of a network; give weights, a file"));
            }
            (Some(path), Method::Psmnet) => {
                Some(detached(py, || Network::load(&path))?.map_err(|error| of_file(&error))?)
            }
            (Some(path), _) if common.takes_features() => {
                let network = detached(py, || FeatureNetwork::load(&path))?.map_err(|error| of_file(&error))?;
                common.features = Some(network);
                None
            }
            (Some(_), _) => {
                warn(py, &format!("weights have no effect with method {} and cost {}", common.method, common.cost))?;
                None
            }
            (None, _) => None,
        };
        let place = place(device)?;
        Ok(Self {
            common,
            finds_range,
            min_is_given: texts.iter().any(|(name, _)| name == "min-disp"),
            place,
            channels: more.channels,
            bits: more.bits,
            timings: more.timings,
            cameras: more.cameras,
            masks: more.masks,
        })
    }

    /// The settings for images of a size.
    pub fn params(&self, py: Python<'_>, size: [u32; 2]) -> PyResult<Params> {
        let mut params = self.common.clone();
        if let Some(cameras) = &self.cameras {
            let fitted = cameras.fit(py, size)?;
            (params.rectify, params.depth) = (fitted.rectification, Some(fitted.camera));
        }
        if let Some(mask) = self.masks.iter().flatten().find(|mask| mask.size != size) {
            return Err(wrong(format!(
                "a mask is {}x{}, but the images are {}x{}; give one of their size",
                mask.size[0], mask.size[1], size[0], size[1]
            )));
        }
        if self.masks.iter().any(Option::is_some) {
            let sides = self.masks.each_ref().map(|mask| mask.as_ref().map(|mask| mask.has.clone()));
            params.masks = Some(Masks::new(size[0], size[1], sides).map_err(raised)?);
        }
        Ok(params)
    }
}

/// The keywords that are no options of the command's table.
#[derive(Default)]
struct More {
    confidence: bool,
    right_map: bool,
    timings: bool,
    channels: Channels,
    bits: Bits,
    cameras: Option<Cameras>,
    masks: [Option<Mask>; 2],
    weights: Option<PathBuf>,
}

impl More {
    /// Takes a keyword, if it is one of these.
    fn take(&mut self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
        match name {
            "confidence" => self.confidence = switch(name, value)?,
            "right_map" => self.right_map = switch(name, value)?,
            "timings" => self.timings = switch(name, value)?,
            "channels" => self.channels = Channels::named(&word(name, value)?)?,
            "bits" => {
                let text = text(name, value)?.unwrap_or_else(|| "auto".into());
                self.bits = text.parse().map_err(|allowed| wrong(format!("bits is {text}, but {allowed}")))?;
            }
            _ if value.is_none() && matches!(name, "cameras" | "mask" | "weights") => {}
            "cameras" => self.cameras = Some(Cameras::new(value)?),
            "mask" => self.masks = masks(value)?,
            "weights" => self.weights = Some(value.extract()?),
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// True or False.
pub fn switch(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.extract().map_err(|_| wrong(format!("{name} is {value}, but must be True or False")))
}

/// A text.
fn word(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.extract().map_err(|_| wrong(format!("{name} is {value}, but must be a text")))
}

/// The value of an option as the command takes it; nothing for None, which leaves the default.
fn text(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<String>> {
    let integer =
        || value.call_method0("__index__").ok().and_then(|value| value.str().ok()).map(|text| text.to_string());
    Ok(Some(match value {
        value if value.is_none() => return Ok(None),
        value if value.is_instance_of::<PyBool>() => if value.is_truthy()? { "on" } else { "off" }.into(),
        value if value.is_instance_of::<PyString>() => value.extract()?,
        value if value.is_instance_of::<PyInt>() => value.str()?.to_string(),
        value if value.is_instance_of::<PyFloat>() => {
            let number: f64 = value.extract()?;
            // 8.0 is a whole number for options that take such.
            if number.fract() == 0.0 && number.abs() < 1e15 { format!("{number:.0}") } else { number.to_string() }
        }
        _ => match integer() {
            Some(text) => text, // such as NumPy's
            None => {
                return Err(wrong(format!(
                    "{name} is of the type {}, but must be a number, a text, True or False",
                    value.get_type().name()?
                )));
            }
        },
    }))
}

/// Where to compute: `auto`, `gpu`, `cpu`, `reference`, or an adapter by its index or a part of its name.
pub fn place(device: Option<&Bound<'_, PyAny>>) -> PyResult<Place> {
    let Some(device) = device.filter(|device| !device.is_none()) else { return Ok(Place::default()) };
    if device.is_instance_of::<PyBool>() || device.is_instance_of::<PyFloat>() {
        return Err(wrong(format!(
            "device is {device}, but must be \"auto\", \"gpu\", \"cpu\", \"reference\", or an adapter's index or name"
        )));
    }
    let text = text("device", device)?.unwrap_or_default();
    let backend = Backend::NAMED.iter().find(|(name, _)| *name == text);
    Ok(match backend {
        Some((_, backend)) => Place::new(*backend, None),
        None => Place::new(Backend::Auto, Some(text)),
    })
}

/// A mask for both images, or one for each, of which one may be None.
fn masks(value: &Bound<'_, PyAny>) -> PyResult<[Option<Mask>; 2]> {
    let one = |value: &Bound<'_, PyAny>| if value.is_none() { Ok(None) } else { mask(value, "mask").map(Some) };
    if let Ok(sides) = value.cast::<PyTuple>() {
        let (left, right): (Bound<'_, PyAny>, Bound<'_, PyAny>) =
            sides.extract().map_err(|_| wrong("mask must be an array for both images, or two: (left, right)"))?;
        return Ok([one(&left)?, one(&right)?]);
    }
    let both = one(value)?;
    Ok([both.clone(), both])
}

/// An array of bool or uint8, rows x columns: where it is 0, there is no content.
fn mask(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Mask> {
    let (size, has) = flags(value, name)?;
    Ok(Mask { size, has: has.into_iter().map(u8::from).collect() })
}

/// An array of bool or uint8 as whether each is other than 0, with columns and rows.
pub fn flags(value: &Bound<'_, PyAny>, name: &str) -> PyResult<([u32; 2], Vec<bool>)> {
    let array = images::array(value, name)?;
    let [rows, columns] = *array.shape() else {
        return Err(wrong(format!(
            "{name} has the shape {}, but must have (rows, columns)",
            images::shape_text(array.shape())
        )));
    };
    let unread = |error: numpy::BorrowError| wrong(error.to_string());
    let has: Vec<bool> = if images::is::<bool>(&array) {
        array.cast::<PyArray2<bool>>()?.try_readonly().map_err(unread)?.as_array().iter().copied().collect()
    } else if images::is::<u8>(&array) {
        array.cast::<PyArray2<u8>>()?.try_readonly().map_err(unread)?.as_array().iter().map(|&has| has != 0).collect()
    } else {
        return Err(wrong(format!("{name} has elements of {}, but must have bool or uint8", array.dtype())));
    };
    let side = |count: usize| u32::try_from(count).map_err(|_| wrong(format!("{name} is too large")));
    Ok(([side(columns)?, side(rows)?], has))
}
