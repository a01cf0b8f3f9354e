//! A matcher of pairs on the CPU.

use crate::maps::{format, maps, pair};
use crate::settings::wanted;
use crate::stages::stages;
use crate::throw::thrown;
use gpu_stereo::cpu;
use wasm_bindgen::prelude::*;

/// Matches pairs of one size, one format and one set of settings, on one thread, by the native schedule.
#[wasm_bindgen]
pub struct CpuMatcher(cpu::CpuMatcher);

#[wasm_bindgen]
impl CpuMatcher {
    /// As `GpuMatcher::create`, without a device.
    ///
    /// # Errors
    /// For settings out of their range.
    #[allow(clippy::too_many_arguments)] // of JavaScript's one object
    #[wasm_bindgen(constructor)]
    pub fn new(
        width: u32,
        height: u32,
        format_name: &str,
        disparities: u32,
        options: Vec<String>,
        right: bool,
        confidence: bool,
        camera: &[f64],
    ) -> Result<CpuMatcher, JsValue> {
        let params = wanted(disparities, &options, [right, confidence], camera)?;
        Ok(Self(cpu::CpuMatcher::new(width, height, format(format_name)?, &params).map_err(thrown)?))
    }

    /// The maps of a pair ([`maps`]).
    ///
    /// # Errors
    /// If an image is not what the matcher was made for.
    pub fn compute(&self, left: Vec<u8>, right: Vec<u8>) -> Result<JsValue, JsValue> {
        let [left, right] = pair(self.0.size(), self.0.format(), [left, right])?;
        Ok(maps(&self.0.compute(&left, &right).map_err(thrown)?))
    }

    /// Computes a pair and compares what each stage made with the reference ([`stages`]).
    ///
    /// # Errors
    /// As [`CpuMatcher::compute`].
    pub fn check(&self, left: Vec<u8>, right: Vec<u8>) -> Result<JsValue, JsValue> {
        let [left, right] = pair(self.0.size(), self.0.format(), [left, right])?;
        Ok(stages(&self.0.check(&left, &right).map_err(thrown)?))
    }
}
