//! Errors as JavaScript knows them.

use gpu_stereo::Error;
use js_sys::Reflect;
use wasm_bindgen::prelude::*;

/// An `Error` whose name is `StereoError`, whose message is that of the library, and whose `kind` is `parameter`, `image`, `network`,
/// `too-large`, `memory`, `device`, `lost`, `refused`, `misuse`, `dropped` or `adapter`.
pub fn thrown(error: Error) -> JsValue {
    let kind = match &error {
        Error::Parameter { .. } => "parameter",
        Error::Image(_) => "image",
        Error::Network(_) => "network",
        Error::TooLarge { .. } => "too-large",
        Error::Memory { .. } | Error::OutOfMemory => "memory",
        Error::Device(_) => "device",
        Error::Lost(_) => "lost",
        Error::Refused(_) => "refused",
        Error::Misuse(_) => "misuse",
        Error::Dropped { .. } => "dropped",
        Error::Adapter(_) => "adapter",
        _ => "other",
    };
    of_kind(kind, &error.to_string())
}

/// The same with a message of its own.
pub fn of_kind(kind: &str, message: &str) -> JsValue {
    let error = js_sys::Error::new(message);
    error.set_name("StereoError");
    let _ = Reflect::set(&error, &"kind".into(), &kind.into()); // a new object takes every property
    error.into()
}

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = console, js_name = error)]
    fn log_error(text: &str);
}

/// Names the place of a panic in the console, before the module traps.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| log_error(&format!("gpu-stereo: {panic}"))));
}
