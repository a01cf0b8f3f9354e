//! The caller's textures, in and out.

use crate::throw::of_kind;
use gpu_stereo::{Outputs, wgpu};
use js_sys::Reflect;
use wasm_bindgen::prelude::*;
use wgpu::{TextureFormat, webgpu::GpuTexture};

/// The formats that a matcher takes or fills, by their names in JavaScript.
const FORMATS: [(&str, TextureFormat); 9] = [
    ("r8unorm", TextureFormat::R8Unorm),
    ("r16unorm", TextureFormat::R16Unorm),
    ("r16sint", TextureFormat::R16Sint),
    ("r32float", TextureFormat::R32Float),
    ("rgba8unorm", TextureFormat::Rgba8Unorm),
    ("rgba8unorm-srgb", TextureFormat::Rgba8UnormSrgb),
    ("bgra8unorm", TextureFormat::Bgra8Unorm),
    ("bgra8unorm-srgb", TextureFormat::Bgra8UnormSrgb),
    ("rgba16unorm", TextureFormat::Rgba16Unorm),
];

/// wgpu's texture around the caller's, which stays the caller's to destroy.
fn texture(device: &wgpu::Device, name: &str, given: JsValue) -> Result<wgpu::Texture, JsValue> {
    let refused = |text: &str| of_kind("misuse", &format!("{name} {text}"));
    let property = |property: &str| Reflect::get(&given, &property.into()).unwrap_or(JsValue::UNDEFINED);
    let number = |name: &str| {
        let number = property(name).as_f64().filter(|number| *number >= 0.0 && number.fract() == 0.0);
        number.map(|number| number as u32).ok_or_else(|| refused("is no GPUTexture; give one of the matcher's device"))
    };
    let (usage, format) = (number("usage")?, property("format").as_string().unwrap_or_default());
    let known = FORMATS.iter().find(|(known, _)| *known == format);
    let &(_, format) = known.ok_or_else(|| {
        let names: Vec<_> = FORMATS.iter().map(|(name, _)| *name).collect();
        refused(&format!(
            "is in {format:?}, but must be in one of {}; copy or draw it into such a texture",
            names.join(", ")
        ))
    })?;
    let dimension = match property("dimension").as_string().as_deref() {
        Some("2d") => wgpu::TextureDimension::D2,
        _ => return Err(refused("has other dimensions than 2d; give a texture of two")),
    };
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: number("width")?,
            height: number("height")?,
            depth_or_array_layers: number("depthOrArrayLayers")?,
        },
        mip_level_count: number("mipLevelCount")?,
        sample_count: number("sampleCount")?,
        dimension,
        format,
        usage: wgpu::TextureUsages::from_bits_truncate(usage),
        view_formats: &[],
    };
    Ok(device.create_texture_from_webgpu_handle(given.unchecked_into::<GpuTexture>(), &descriptor, None))
}

/// The textures of a pair.
pub fn inputs(device: &wgpu::Device, [left, right]: [JsValue; 2]) -> Result<[wgpu::Texture; 2], JsValue> {
    Ok([texture(device, "the left input", left)?, texture(device, "the right input", right)?])
}

/// A method of [`Outputs`] that takes a texture.
type Add = for<'a> fn(Outputs<'a>, &'a wgpu::Texture) -> Outputs<'a>;

/// What an object of outputs may have.
const OUTPUTS: [(&str, Add); 5] = [
    ("disparity", |outputs, texture| outputs.disparity(texture)),
    ("color", |outputs, texture| outputs.color(texture)),
    ("rightDisparity", |outputs, texture| outputs.right_disparity(texture)),
    ("rightColor", |outputs, texture| outputs.right_color(texture)),
    ("confidence", |outputs, texture| outputs.confidence(texture)),
];

/// The textures that take the results.
pub struct Targets(Vec<(wgpu::Texture, Add)>);

impl Targets {
    /// As the library takes them.
    pub fn outputs(&self) -> Outputs<'_> {
        self.0.iter().fold(Outputs::default(), |outputs, (texture, add)| add(outputs, texture))
    }
}

/// The textures of an object of outputs.
pub fn outputs(device: &wgpu::Device, given: &JsValue) -> Result<Targets, JsValue> {
    let mut targets = Vec::new();
    let keys = js_sys::Object::keys(given.unchecked_ref::<js_sys::Object>());
    for name in keys.iter().filter_map(|key| JsValue::from(key).as_string()) {
        let known = OUTPUTS.iter().find(|(known, _)| *known == name);
        let &(_, add) = known.ok_or_else(|| {
            let names: Vec<_> = OUTPUTS.iter().map(|(name, _)| *name).collect();
            of_kind("misuse", &format!("there is no output {name:?}, only {}; give one of these", names.join(", ")))
        })?;
        let value = Reflect::get(given, &name.as_str().into())?;
        if !value.is_undefined() && !value.is_null() {
            targets.push((texture(device, &format!("the output {name}"), value)?, add));
        }
    }
    Ok(Targets(targets))
}
