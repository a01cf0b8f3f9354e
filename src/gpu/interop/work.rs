//! The shaders between the caller's resources and the matcher's, and what they are bound to.

use crate::gpu::layout::NO_OWN;
use crate::yuv::Weights;
use crate::{PixelFormat, YuvColors};
use wgpu::TextureFormat;

/// Invocations of a workgroup.
pub(super) const LANES: u32 = 64;

macro_rules! wgsl {
    ($($folder:literal / $file:literal),+) => {
        [$(($file, include_str!(concat!("../../../shaders/", $folder, "/", $file, ".wgsl")))),+]
    };
}

/// The files that are no stages of the chain.
pub(crate) const SHADERS: [(&str, &str); 17] = wgsl!(
    "interop" / "intake",
    "interop/parts" / "intake_texture",
    "interop/parts" / "intake_buffer",
    "interop/parts" / "intake_planes",
    "interop/parts" / "intake_plane_buffers",
    "interop/parts" / "intake_packed",
    "interop/parts" / "intake_packed_buffer",
    "interop/parts" / "intake_yuv",
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

/// What the caller's pixels are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Source {
    Texture {
        srgb: bool,
    },
    Buffer,
    /// Y in one texture, U and V in another one.
    Planes(YuvColors),
    /// The same in two buffers.
    PlaneBuffers(YuvColors),
    /// Y, U, Y and V of two columns in a texel.
    Packed(YuvColors),
    /// The same in a word.
    PackedBuffer(YuvColors),
}

impl Source {
    fn file(self) -> &'static str {
        match self {
            Source::Texture { .. } => "intake_texture",
            Source::Buffer => "intake_buffer",
            Source::Planes(_) => "intake_planes",
            Source::PlaneBuffers(_) => "intake_plane_buffers",
            Source::Packed(_) => "intake_packed",
            Source::PackedBuffer(_) => "intake_packed_buffer",
        }
    }

    fn colors(self) -> Option<YuvColors> {
        match self {
            Source::Texture { .. } | Source::Buffer => None,
            Source::Planes(colors)
            | Source::PlaneBuffers(colors)
            | Source::Packed(colors)
            | Source::PackedBuffer(colors) => Some(colors),
        }
    }

    /// Whether it is one texture or two, and not buffers.
    fn is_textured(self) -> bool {
        matches!(self, Source::Texture { .. } | Source::Planes(_) | Source::Packed(_))
    }

    /// The constants of its text.
    fn constants(self) -> String {
        let srgb = matches!(self, Source::Texture { srgb: true });
        let mut constants = format!("const SRGB: u32 = {}u; ", u32::from(srgb));
        if let Some(Weights { zero, y, v_red, u_green, v_green, u_blue }) = self.colors().map(YuvColors::weights) {
            for (name, value) in [
                ("Y_ZERO", zero),
                ("Y_WEIGHT", y),
                ("V_RED", v_red),
                ("U_GREEN", u_green),
                ("V_GREEN", v_green),
                ("U_BLUE", u_blue),
            ] {
                constants.push_str(&format!("const {name}: i32 = {value}; "));
            }
        }
        constants
    }
}

/// What a pipeline does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Work {
    Intake { source: Source, format: PixelFormat },
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
        let common = match self {
            Work::Intake { source, .. } => source.colors().map(|_| "intake_yuv"),
            _ => Some("surface_values"),
        };
        [main, self.name()].into_iter().chain(common).collect()
    }

    /// The file that is its own.
    pub(super) fn name(self) -> &'static str {
        match self {
            Work::Intake { source, .. } => source.file(),
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
        if let Work::Intake { format, source } = self {
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
            constants.extend([("BITS", bits), ("UNITS_A_PIXEL", units)].map(|(name, value)| number(name, value)));
            constants.push_str(&source.constants());
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
            Work::Intake { source, .. } => {
                let image = wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                };
                entries.push(entry(1, uniform));
                entries.push(entry(2, stored(TextureFormat::Rgba32Uint)));
                let planes = if matches!(source, Source::Planes(_) | Source::PlaneBuffers(_)) { 2 } else { 1 };
                let ty = if source.is_textured() { image } else { read };
                entries.extend((3..).take(planes).map(|binding| entry(binding, ty)));
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
