//! Plain objects.

use js_sys::{Object, Reflect};
use wasm_bindgen::prelude::*;

/// An object with these properties.
pub fn object<const N: usize>(properties: [(&str, JsValue); N]) -> JsValue {
    let object = Object::new();
    for (name, value) in properties {
        let _ = Reflect::set(&object, &name.into(), &value); // a new object takes every property
    }
    object.into()
}

/// An array of these values.
pub fn array(values: impl IntoIterator<Item = JsValue>) -> JsValue {
    let array = js_sys::Array::new();
    values.into_iter().for_each(|value| {
        array.push(&value);
    });
    array.into()
}
