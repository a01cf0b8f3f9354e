//! A matcher of pairs on a device.

use crate::device::Device;
use crate::maps::{format, maps, pair};
use crate::settings::wanted;
use crate::stages::stages;
use crate::textures::{inputs, outputs};
use crate::throw::{of_kind, thrown};
use gpu_stereo::{StereoMatcher, wgpu};
use wasm_bindgen::prelude::*;

/// Matches pairs of one size, one format and one set of settings. One call at a time: await each.
#[wasm_bindgen]
pub struct GpuMatcher {
    matcher: StereoMatcher,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

#[wasm_bindgen]
impl GpuMatcher {
    /// A matcher on a device. `right` and `confidence` ask for these maps, `camera` (empty, or the five numbers of
    /// [`depth`](crate::maps::depth)) for the depth.
    ///
    /// # Errors
    /// For settings out of their range, and for what the device lacks or refuses.
    #[allow(clippy::too_many_arguments)] // of JavaScript's one object
    pub async fn create(
        device: &Device,
        width: u32,
        height: u32,
        format_name: String,
        disparities: u32,
        options: Vec<String>,
        right: bool,
        confidence: bool,
        camera: Vec<f64>,
    ) -> Result<GpuMatcher, JsValue> {
        let params = wanted(disparities, &options, [right, confidence], &camera)?;
        let format = format(&format_name)?;
        let Device { device, queue, .. } = device;
        let matcher = StereoMatcher::new_async(device, queue, width, height, format, &params).await.map_err(thrown)?;
        Ok(Self { matcher, device: device.clone(), queue: queue.clone() })
    }

    /// Bytes of all buffers and textures on the device.
    #[wasm_bindgen(getter)]
    pub fn device_bytes(&self) -> f64 {
        self.matcher.device_bytes() as f64
    }

    /// The maps of a pair ([`maps`]).
    ///
    /// # Errors
    /// If an image is not what the matcher was made for, and if the device fails.
    pub async fn compute(&self, left: Vec<u8>, right: Vec<u8>) -> Result<JsValue, JsValue> {
        let [left, right] = pair(self.matcher.size(), self.matcher.format(), [left, right])?;
        Ok(maps(&self.matcher.compute(&left, &right).await.map_err(thrown)?))
    }

    /// Computes a pair and compares what each stage left with the reference ([`stages`]).
    ///
    /// # Errors
    /// As [`GpuMatcher::compute`].
    pub async fn check(&self, left: Vec<u8>, right: Vec<u8>) -> Result<JsValue, JsValue> {
        let [left, right] = pair(self.matcher.size(), self.matcher.format(), [left, right])?;
        Ok(stages(&self.matcher.check(&left, &right).await.map_err(thrown)?))
    }

    /// Submits the work of a frame from two `GPUTexture`s, and puts its results into those of `targets`: an object that may have
    /// `disparity`, `color`, `rightDisparity`, `rightColor` and `confidence`. Does not wait for the results.
    ///
    /// # Errors
    /// For what the library or the browser does not take.
    pub async fn submit_textures(&self, left: JsValue, right: JsValue, targets: JsValue) -> Result<(), JsValue> {
        let [left, right] = inputs(&self.device, [left, right])?;
        let targets = outputs(&self.device, &targets)?;
        // A texture of another device is known to the browser alone.
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let inputs = gpu_stereo::Inputs::textures(&left, &right);
        let recorded = self.matcher.record(&mut encoder, &inputs, &targets.outputs()).map_err(thrown);
        if recorded.is_ok() {
            self.queue.submit([encoder.finish()]);
        }
        let refused = scope.pop().await;
        recorded?;
        match refused {
            Some(error) => {
                let text = format!("the browser refused the textures: {error}; give those of the matcher's device");
                Err(of_kind("misuse", &text))
            }
            None => Ok(()),
        }
    }

    /// The maps of what was submitted last.
    ///
    /// # Errors
    /// If nothing was, and if the device fails.
    pub async fn read(&self) -> Result<JsValue, JsValue> {
        Ok(maps(&self.matcher.read().await.map_err(thrown)?))
    }
}
