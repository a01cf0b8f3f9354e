//! The shaders between the caller's resources and the matcher's, and what they are bound to.

use crate::PixelFormat;
use crate::gpu::layout::NO_OWN;
use wgpu::TextureFormat;

/// Invocations of a workgroup.
pub(super) const LANES: u32 = 64;

macro_rules! wgsl {
    ($($folder:literal / $file:literal),+) => {
        [$(($file, include_str!(concat!("../../../shaders/", $folder, "/", $file, ".wgsl")))),+]
    };
}

/// The files that are no stages of the chain.
pub(crate) const SHADERS: [(&str, &str); 12] = wgsl!(
    "interop" / "intake",
    "interop/parts" / "intake_texture",
    "interop/parts" / "intake_buffer",
    "interop" / "surface_draw",
    "interop" / "surface_store",
    "interop/parts" / "surface_pixels",
    "interop/parts" / "surface_sixteenths",
    "interop/parts" / "surface_color",
    "interop/parts" / "surface_confidence",
    "interop/parts" / "surface_metres",
    "interop/parts" / "surface_micrometres",
    "interop/parts" / "surface_values"
);

/// How a shader reads the matcher's buffers.
pub(crate) const VALUES: &str = include_str!("../../../shaders/interop/parts/surface_values.wgsl");

/// How a texture is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum WriteMethod {
    Draw(TextureFormat),
    Store(TextureFormat),
}

/// What a pipeline does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Work {
    Intake { textured: bool, format: PixelFormat, srgb: bool },
    Pixels(WriteMethod),
    Sixteenths(WriteMethod),
    Color(WriteMethod),
    Confidence(WriteMethod),
    Metres(WriteMethod),
    Micrometres(WriteMethod),
}

impl Work {
    /// The files of its text.
    pub(super) fn files(self) -> Vec<&'static str> {
        let main = match self.method() {
            None => "intake",
            Some(WriteMethod::Draw(_)) => "surface_draw",
            Some(WriteMethod::Store(_)) => "surface_store",
        };
        let values = self.method().map(|_| "surface_values");
        [main, self.name()].into_iter().chain(values).collect()
    }

    /// The file that is its own.
    pub(super) fn name(self) -> &'static str {
        match self {
            Work::Intake { textured: true, .. } => "intake_texture",
            Work::Intake { textured: false, .. } => "intake_buffer",
            Work::Pixels(_) => "surface_pixels",
            Work::Sixteenths(_) => "surface_sixteenths",
            Work::Color(_) => "surface_color",
            Work::Confidence(_) => "surface_confidence",
            Work::Metres(_) => "surface_metres",
            Work::Micrometres(_) => "surface_micrometres",
        }
    }

    pub(super) fn method(self) -> Option<WriteMethod> {
        match self {
            Work::Intake { .. } => None,
            Work::Pixels(method)
            | Work::Sixteenths(method)
            | Work::Color(method)
            | Work::Confidence(method)
            | Work::Metres(method)
            | Work::Micrometres(method) => Some(method),
        }
    }

    /// The whole text.
    pub(super) fn source(self) -> String {
        let number = |name: &str, value: u32| format!("const {name}: u32 = {value}u; ");
        let mut constants = number("LANES", LANES);
        if let Work::Intake { format, srgb, .. } = self {
            let (bits, units) = match format.bytes_per_pixel() {
                bytes @ 1..=4 => (8 * bytes, 1),
                bytes => (32, bytes / 4),
            };
            let kinds = [
                ("GRAY8", PixelFormat::Gray8),
                ("GRAY16", PixelFormat::Gray16),
                ("RGBA8", PixelFormat::Rgba8),
                ("FORMAT", format),
            ];
            constants.extend(kinds.map(|(name, format)| number(name, format as u32)));
            let rest = [("BITS", bits), ("UNITS_A_PIXEL", units), ("SRGB", srgb.into())];
            constants.extend(rest.map(|(name, value)| number(name, value)));
        }
        if let Some(WriteMethod::Draw(format) | WriteMethod::Store(format)) = self.method() {
            constants.push_str(NO_OWN);
            constants += &number("DIGITS", if format == TextureFormat::R16Float { 11 } else { 24 });
        }
        if let Some(WriteMethod::Store(format)) = self.method() {
            let texel = match format {
                TextureFormat::R32Float => "r32float",
                TextureFormat::R32Uint => "r32uint",
                _ => "rgba8unorm",
            };
            constants.push_str(&format!("alias Target = texture_storage_2d<{texel}, write>; "));
        }
        let text = format!("{}\n{constants}\n", self.fragments());
        #[cfg(test)]
        let text = self.files().into_iter().fold(text, |text, file| crate::gpu::edits::edited(file, text));
        text
    }

    fn fragments(self) -> String {
        let text = |name| SHADERS.iter().find(|(file, _)| *file == name).map_or("", |(_, text)| text);
        let own = self.files().into_iter().map(text);
        own.chain([include_str!("../../../shaders/shared/common.wgsl")]).collect::<Vec<_>>().join("\n")
    }

    /// What it is bound to.
    pub(super) fn entries(self) -> Vec<wgpu::BindGroupLayoutEntry> {
        let stage = match self.method() {
            Some(WriteMethod::Draw(_)) => wgpu::ShaderStages::FRAGMENT,
            _ => wgpu::ShaderStages::COMPUTE,
        };
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: stage, ty, count: None };
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let stored = |format| wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: wgpu::TextureViewDimension::D2,
        };
        let read = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let uniform = buffer(wgpu::BufferBindingType::Uniform);
        let mut entries = vec![entry(0, uniform)];
        match self {
            Work::Intake { textured, .. } => {
                let image = wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                };
                entries.push(entry(1, uniform));
                entries.push(entry(2, stored(TextureFormat::Rgba32Uint)));
                entries.push(entry(3, if textured { image } else { read }));
            }
            Work::Color(_) => entries.extend([entry(2, read), entry(3, read)]),
            _ => entries.push(entry(2, read)),
        }
        if let Some(WriteMethod::Store(format)) = self.method() {
            entries.push(entry(4, stored(format)));
        }
        entries
    }
}
