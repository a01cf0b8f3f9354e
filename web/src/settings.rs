//! Settings by name: the library's own table of them.

use crate::objects::{array, object};
use crate::throw::{of_kind, thrown};
use gpu_stereo::{Camera, Params, Preset};
use wasm_bindgen::prelude::*;

/// Settings from names and values in turns.
///
/// # Errors
/// As [`Params::from_options`] and [`Params::validate`], and for a method that needs weights.
pub fn params(disparities: u32, options: &[String]) -> Result<Params, JsValue> {
    if !options.len().is_multiple_of(2) {
        let text = format!("there are {} names and values, but each name needs a value; give pairs", options.len());
        return Err(of_kind("misuse", &text));
    }
    let pairs = options.chunks_exact(2).map(|pair| (pair[0].as_str(), pair[1].as_str()));
    let params = Params::from_options(disparities, pairs).map_err(thrown)?;
    params.validate().map_err(thrown)?;
    Ok(params)
}

/// A camera from its focal length, baseline, difference of the principal points, and the left one's column and row.
///
/// # Errors
/// For another count of numbers, and as [`Camera::validate`].
pub fn camera(numbers: &[f64]) -> Result<Camera, JsValue> {
    let &[focal, baseline, doffs, cx, cy] = numbers else {
        let text = format!("a camera has {} numbers; give five: focal, baseline, doffs, cx, cy", numbers.len());
        return Err(of_kind("misuse", &text));
    };
    let camera = Camera::new(focal, baseline).with_doffs(doffs).with_principal_point(cx, cy);
    camera.validate().map_err(thrown)?;
    Ok(camera)
}

/// Settings that also ask for the right view's map and the confidence, and for the depth if there are numbers of a camera.
///
/// # Errors
/// As [`params`] and [`camera`].
pub fn wanted(disparities: u32, options: &[String], also: [bool; 2], numbers: &[f64]) -> Result<Params, JsValue> {
    let mut params = params(disparities, options)?;
    [params.right_map, params.confidence] = also;
    if !numbers.is_empty() {
        params.depth = Some(camera(numbers)?);
    }
    Ok(params)
}

fn pair((name, help): &(&str, &str)) -> JsValue {
    object([("name", (*name).into()), ("help", (*help).into())])
}

/// All options: objects with `name`, `heading`, `placeholder`, `values` (`name` and `help` of each; empty where it takes numbers) and
/// `help`.
#[wasm_bindgen]
pub fn options() -> JsValue {
    array(Params::OPTIONS.iter().map(|option| {
        object([
            ("name", option.name.into()),
            ("heading", option.heading.into()),
            ("placeholder", option.placeholder.into()),
            ("values", array(option.values.iter().map(pair))),
            ("help", option.help.into()),
        ])
    }))
}

/// The presets: objects with `name` and `help`.
#[wasm_bindgen]
pub fn presets() -> JsValue {
    array(Preset::NAMES.iter().map(pair))
}

/// What the settings become: an object with `values` (of each option by its name), `idle` (for each option that changes nothing, by its
/// name, the name of the one because of which), `first` and `last` (the disparities searched, in pixels).
///
/// # Errors
/// As [`params`].
#[wasm_bindgen]
pub fn resolve(disparities: u32, options: Vec<String>) -> Result<JsValue, JsValue> {
    let params = params(disparities, &options)?;
    let (values, idle) = (js_sys::Object::new(), js_sys::Object::new());
    for option in Params::OPTIONS {
        let set =
            |object: &js_sys::Object, value: &str| js_sys::Reflect::set(object, &option.name.into(), &value.into());
        set(&values, &option.get(&params))?;
        if let Some(other) = option.idle(&params) {
            set(&idle, other.name)?;
        }
    }
    let searched = params.searched();
    Ok(object([
        ("values", values.into()),
        ("idle", idle.into()),
        ("first", (*searched.start()).into()),
        ("last", (*searched.end()).into()),
    ]))
}
