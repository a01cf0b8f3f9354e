//! What a check found.

use crate::objects::{array, object};
use gpu_stereo::StageCheck;
use wasm_bindgen::prelude::*;

/// An array of objects with `stage`, `compared` and `different` (elements), and `first` (null, or `x`, `y`, `d`, `expected` and `got` of
/// the first that differs).
pub fn stages(checks: &[StageCheck]) -> JsValue {
    array(checks.iter().map(stage))
}

fn stage(check: &StageCheck) -> JsValue {
    let first = check.first.map_or(JsValue::NULL, |first| {
        object([
            ("x", first.x.into()),
            ("y", first.y.into()),
            ("d", first.d.map_or(JsValue::NULL, Into::into)),
            ("expected", (first.expected as f64).into()),
            ("got", (first.got as f64).into()),
        ])
    });
    object([
        ("stage", check.stage.as_str().into()),
        ("compared", (check.elements as f64).into()),
        ("different", (check.mismatches as f64).into()),
        ("first", first),
    ])
}
