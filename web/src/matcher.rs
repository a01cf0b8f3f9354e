//! A matcher of pairs, on a device or on the CPU.

use crate::device::Device;
use crate::maps::{format, image, maps};
use crate::objects::{array, object};
use crate::settings::{camera, params};
use crate::textures::{inputs, outputs};
use crate::throw::{of_kind, thrown};
use gpu_stereo::cpu::CpuMatcher;
use gpu_stereo::{Image, Params, PixelFormat, StageCheck, StereoMatcher, wgpu};
use wasm_bindgen::prelude::*;

enum Kind {
    Device { matcher: StereoMatcher, device: wgpu::Device, queue: wgpu::Queue },
    Cpu(CpuMatcher),
}

/// Matches pairs of one size, one format and one set of settings. One call at a time: await each.
#[wasm_bindgen]
pub struct Matcher {
    kind: Kind,
    size: (u32, u32),
    format: PixelFormat,
}

/// What a matcher also gives, and the camera that sees it.
fn wanted(mut params: Params, right: bool, confidence: bool, numbers: &[f64]) -> Result<Params, JsValue> {
    (params.right_map, params.confidence) = (right, confidence);
    if !numbers.is_empty() {
        params.depth = Some(camera(numbers)?);
    }
    Ok(params)
}

#[wasm_bindgen]
impl Matcher {
    /// A matcher on a device. `right` and `confidence` ask for these maps, `camera` (empty, or the five numbers of
    /// [`depth`](crate::maps::depth)) for the depth.
    ///
    /// # Errors
    /// For settings out of their range, and for what the device lacks or refuses.
    #[allow(clippy::too_many_arguments)] // of JavaScript's one object
    pub async fn on_device(
        device: &Device,
        width: u32,
        height: u32,
        format_name: String,
        disparities: u32,
        options: Vec<String>,
        right: bool,
        confidence: bool,
        camera: Vec<f64>,
    ) -> Result<Matcher, JsValue> {
        let params = wanted(params(disparities, &options)?, right, confidence, &camera)?;
        let (format, size) = (format(&format_name)?, (width, height));
        let Device { device, queue, .. } = device;
        let matcher = StereoMatcher::new_async(device, queue, width, height, format, &params).await.map_err(thrown)?;
        let kind = Kind::Device { matcher, device: device.clone(), queue: queue.clone() };
        Ok(Self { kind, size, format })
    }

    /// The same on the CPU, on one thread.
    ///
    /// # Errors
    /// For settings out of their range.
    #[allow(clippy::too_many_arguments)] // of JavaScript's one object
    pub fn on_cpu(
        width: u32,
        height: u32,
        format_name: String,
        disparities: u32,
        options: Vec<String>,
        right: bool,
        confidence: bool,
        camera: Vec<f64>,
    ) -> Result<Matcher, JsValue> {
        let params = wanted(params(disparities, &options)?, right, confidence, &camera)?;
        let (format, size) = (format(&format_name)?, (width, height));
        let matcher = CpuMatcher::new(width, height, format, &params).map_err(thrown)?;
        Ok(Self { kind: Kind::Cpu(matcher), size, format })
    }

    /// Bytes of all buffers and textures on the device; 0 on the CPU.
    #[wasm_bindgen(getter)]
    pub fn device_bytes(&self) -> f64 {
        match &self.kind {
            Kind::Device { matcher, .. } => matcher.device_bytes() as f64,
            Kind::Cpu(_) => 0.0,
        }
    }

    fn pair(&self, left: Vec<u8>, right: Vec<u8>) -> Result<(Image, Image), JsValue> {
        Ok((image(self.size, self.format, left)?, image(self.size, self.format, right)?))
    }

    /// The maps of a pair ([`maps`]).
    ///
    /// # Errors
    /// If an image is not what the matcher was made for, and if the device fails.
    pub async fn compute(&self, left: Vec<u8>, right: Vec<u8>) -> Result<JsValue, JsValue> {
        let (left, right) = self.pair(left, right)?;
        let matched = match &self.kind {
            Kind::Device { matcher, .. } => matcher.compute(&left, &right).await,
            Kind::Cpu(matcher) => matcher.compute(&left, &right),
        };
        Ok(maps(&matched.map_err(thrown)?))
    }

    /// Computes a pair and compares what each stage left with the reference: an array of objects with `stage`, `compared` and `different`
    /// (elements), and `first` (null, or `x`, `y`, `d`, `expected` and `got` of the first that differs).
    ///
    /// # Errors
    /// As [`Matcher::compute`].
    pub async fn check(&self, left: Vec<u8>, right: Vec<u8>) -> Result<JsValue, JsValue> {
        let (left, right) = self.pair(left, right)?;
        let stages = match &self.kind {
            Kind::Device { matcher, .. } => matcher.check(&left, &right).await,
            Kind::Cpu(matcher) => matcher.check(&left, &right),
        };
        Ok(array(stages.map_err(thrown)?.iter().map(stage)))
    }

    /// Submits the work of a frame from two `GPUTexture`s, and puts its results into those of `outputs`: an object that may have
    /// `disparity`, `color`, `rightDisparity`, `rightColor` and `confidence`. Does not wait for the results.
    ///
    /// # Errors
    /// For what the library does not take, and on the CPU.
    pub async fn submit_textures(&self, left: JsValue, right: JsValue, targets: JsValue) -> Result<(), JsValue> {
        let Kind::Device { matcher, device, queue } = &self.kind else {
            return Err(of_kind(
                "misuse",
                "this matcher computes on the CPU, which has no textures; make one on a device",
            ));
        };
        let [left, right] = inputs(device, [left, right])?;
        let targets = outputs(device, &targets)?;
        // A texture of another device is known to the browser alone.
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let inputs = gpu_stereo::Inputs::textures(&left, &right);
        let recorded = matcher.record(&mut encoder, &inputs, &targets.outputs()).map_err(thrown);
        if recorded.is_ok() {
            queue.submit([encoder.finish()]);
        }
        let refused = scope.pop().await;
        recorded?;
        match refused {
            Some(error) => Err(of_kind(
                "misuse",
                &format!("the browser refused the textures: {error}; give those of the matcher's device"),
            )),
            None => Ok(()),
        }
    }

    /// The maps of what was submitted last.
    ///
    /// # Errors
    /// If nothing was, if the device fails, and on the CPU.
    pub async fn read(&self) -> Result<JsValue, JsValue> {
        match &self.kind {
            Kind::Device { matcher, .. } => Ok(maps(&matcher.read().await.map_err(thrown)?)),
            Kind::Cpu(_) => Err(of_kind("misuse", "a matcher on the CPU has nothing to read; call compute")),
        }
    }
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
