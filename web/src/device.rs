//! Devices: the browser's own, or the caller's.

use crate::throw::of_kind;
use gpu_stereo::{StereoMatcher, wgpu};
use wasm_bindgen::prelude::*;

/// wgpu's way to the WebGPU of this page or worker: it reads `navigator.gpu` when it is made.
#[wasm_bindgen]
pub struct Instance(wgpu::Instance);

#[wasm_bindgen]
impl Instance {
    /// # Errors
    /// Where there is neither a window nor a worker.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Result<Instance, JsValue> {
        let has = |name: &str| js_sys::Reflect::has(&js_sys::global(), &name.into()).unwrap_or(false);
        if !has("Window") && !has("WorkerGlobalScope") {
            let text = "there is no WebGPU here: this is neither a page nor a dedicated worker; give a device";
            return Err(of_kind("adapter", text));
        }
        let backends = wgpu::Backends::BROWSER_WEBGPU;
        let descriptor =
            wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
        Ok(Self(wgpu::Instance::new(descriptor)))
    }

    /// The device of the adapter, with all features and limits that a matcher makes use of. `low_power` asks for the adapter that
    /// takes less power.
    ///
    /// # Errors
    /// If there is no adapter, or it gives no device.
    pub async fn request(&self, low_power: bool) -> Result<Device, JsValue> {
        let power_preference = match low_power {
            true => wgpu::PowerPreference::LowPower,
            false => wgpu::PowerPreference::HighPerformance,
        };
        let options = wgpu::RequestAdapterOptions { power_preference, ..Default::default() };
        let adapter = self.0.request_adapter(&options).await.map_err(|_| {
            let text = "the browser has no adapter for WebGPU; switch on hardware acceleration, take another browser, or compute \
                        on the CPU";
            of_kind("adapter", text)
        })?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("gpu-stereo"),
            required_features: StereoMatcher::required_features(&adapter),
            required_limits: StereoMatcher::required_limits(&adapter),
            ..Default::default()
        };
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(|error| {
            of_kind("adapter", &format!("the adapter gives no device: {error}; reload the page, or compute on the CPU"))
        })?;
        let info = adapter.get_info();
        Ok(Device { device, queue, name: [info.name, info.driver].join(" ").trim().into() })
    }
}

/// A device and its queue.
#[wasm_bindgen]
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    name: String,
}

#[wasm_bindgen]
impl Device {
    /// The browser's own object, a `GPUDevice`.
    #[wasm_bindgen(getter)]
    pub fn gpu(&self) -> JsValue {
        self.device.as_webgpu().map_or(JsValue::UNDEFINED, Into::into)
    }

    /// What the browser says of the adapter; it may say nothing.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.name.clone()
    }
}
