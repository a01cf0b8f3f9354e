//! The passes that take the caller's pairs and leave the caller's maps: pipelines and bind groups are made at first use.

use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasher as _, RandomState};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{Middle, TextureLayer};
use crate::gpu::layout::{Frame, Pass};
use crate::gpu::scopes;
use crate::{Error, PixelFormat, color};
use wgpu::TextureFormat;

/// Bind groups that are kept: those of eight pairs, and of all that may be shown of them.
const KEPT: usize = 32;

/// Targets that are known to be ones of their format.
const KNOWN: usize = 64;

/// Invocations of a workgroup.
const LANES: u32 = 64;

macro_rules! wgsl {
    ($($folder:literal / $file:literal),+) => {
        [$(($file, include_str!(concat!("../../../shaders/", $folder, "/", $file, ".wgsl")))),+]
    };
}

/// The files that are no stages of the chain.
pub(crate) const SHADERS: [(&str, &str); 9] = wgsl!(
    "interop" / "intake",
    "interop/parts" / "intake_texture",
    "interop/parts" / "intake_buffer",
    "interop" / "surface_draw",
    "interop" / "surface_store",
    "interop/parts" / "surface_pixels",
    "interop/parts" / "surface_sixteenths",
    "interop/parts" / "surface_color",
    "interop/parts" / "surface_confidence"
);

/// How a texture is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Way {
    Draw(TextureFormat),
    Store(TextureFormat),
}

/// What a pipeline does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Work {
    Intake { textured: bool, format: PixelFormat, srgb: bool },
    Pixels(Way),
    Sixteenths(Way),
    Color(Way),
    Confidence(Way),
}

impl Work {
    /// The files of its text.
    fn files(self) -> [&'static str; 2] {
        let of = |way, shown| match way {
            Way::Draw(_) => ["surface_draw", shown],
            Way::Store(_) => ["surface_store", shown],
        };
        match self {
            Work::Intake { textured: true, .. } => ["intake", "intake_texture"],
            Work::Intake { textured: false, .. } => ["intake", "intake_buffer"],
            Work::Pixels(way) => of(way, "surface_pixels"),
            Work::Sixteenths(way) => of(way, "surface_sixteenths"),
            Work::Color(way) => of(way, "surface_color"),
            Work::Confidence(way) => of(way, "surface_confidence"),
        }
    }

    fn way(self) -> Option<Way> {
        match self {
            Work::Intake { .. } => None,
            Work::Pixels(way) | Work::Sixteenths(way) | Work::Color(way) | Work::Confidence(way) => Some(way),
        }
    }

    /// The whole text.
    fn source(self) -> String {
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
        if let Some(Way::Store(format)) = self.way() {
            let texel = if format == TextureFormat::R32Float { "r32float" } else { "rgba8unorm" };
            constants.push_str(&format!("alias Target = texture_storage_2d<{texel}, write>; "));
        }
        let text = format!("{}\n{constants}\n", self.fragments());
        #[cfg(test)]
        let text = self.files().into_iter().fold(text, |text, file| crate::gpu::edits::edited(file, text));
        text
    }

    fn fragments(self) -> String {
        let text = |name| SHADERS.iter().find(|(file, _)| *file == name).map_or("", |(_, text)| text);
        let [main, own] = self.files();
        [text(main), text(own), include_str!("../../../shaders/shared/common.wgsl")].join("\n")
    }

    /// What it is bound to.
    fn entries(self) -> Vec<wgpu::BindGroupLayoutEntry> {
        let stage = match self.way() {
            Some(Way::Draw(_)) => wgpu::ShaderStages::FRAGMENT,
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
        if let Some(Way::Store(format)) = self.way() {
            entries.push(entry(4, stored(format)));
        }
        entries
    }
}

/// A resource of the caller's.
#[derive(Clone, Copy)]
pub(super) enum Theirs<'a> {
    /// Seen in a format.
    Layer(TextureLayer<'a>, TextureFormat),
    Buffer {
        buffer: &'a wgpu::Buffer,
        offset: u64,
        bytes: u64,
        bytes_per_row: u32,
    },
}

impl Theirs<'_> {
    /// Why a resource that looked right does not do.
    fn refused(&self, middle: &Middle<'_>, name: &str, error: Error) -> Error {
        let error = middle.pulse.cause(error);
        let Error::Lost(text) = &error else { return error };
        let Some(text) = scopes::refusal(text) else { return error };
        let remedy = match self {
            Theirs::Layer(TextureLayer { texture, .. }, format) if texture.format() != *format => {
                format!("create the texture with {format:?} among its view_formats, or in that format")
            }
            Theirs::Layer(..) => "it was destroyed or serves another purpose: create another texture".into(),
            Theirs::Buffer { .. } => "it was destroyed: create another buffer".into(),
        };
        Error::Image(format!("{name} was refused by the device: {text}; {remedy}"))
    }
}

/// A layer and the format in which it is seen.
type Seen = (wgpu::Texture, u32, TextureFormat);

/// A resource of the matcher's.
#[derive(Clone, Copy)]
pub(super) enum Ours<'a> {
    Texture(&'a wgpu::Texture),
    /// The first bytes of a buffer.
    Buffer(&'a wgpu::Buffer, u64),
}

/// All that a bind group follows from.
#[derive(PartialEq)]
struct Key {
    work: Work,
    source: Option<wgpu::Texture>,
    map: Option<wgpu::Buffer>,
    layer: Option<Seen>,
    buffer: Option<(wgpu::Buffer, u64, u64, u32)>,
    frame: Frame,
    disparities: u32,
}

#[derive(Clone, Debug)]
enum Pipeline {
    Compute(wgpu::ComputePipeline),
    Render(wgpu::RenderPipeline),
}

/// Work that only has to be recorded.
pub(crate) enum Prepared {
    Compute { label: &'static str, pipeline: wgpu::ComputePipeline, bind_group: wgpu::BindGroup, workgroups: [u32; 2] },
    Draw { label: &'static str, pipeline: wgpu::RenderPipeline, bind_group: wgpu::BindGroup, target: wgpu::TextureView },
    Copy { from: wgpu::Buffer, to: wgpu::Buffer, offset: u64, bytes: u64 },
}

impl Prepared {
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        match self {
            Prepared::Compute { label, pipeline, bind_group, workgroups: [x, y] } => {
                let descriptor = wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: None };
                let mut pass = encoder.begin_compute_pass(&descriptor);
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, bind_group, &[]);
                pass.dispatch_workgroups(*x, *y, 1);
            }
            Prepared::Draw { label, pipeline, bind_group, target } => {
                let attachment = wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                };
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some(label),
                    color_attachments: &[Some(attachment)],
                    ..Default::default()
                });
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, bind_group, &[]);
                pass.draw(0..3, 0..1);
            }
            Prepared::Copy { from, to, offset, bytes } => {
                encoder.copy_buffer_to_buffer(from, 0, to, *offset, *bytes);
            }
        }
    }
}

/// What is kept from frame to frame.
#[derive(Default)]
struct Made {
    pipelines: HashMap<Work, (wgpu::BindGroupLayout, Pipeline)>,
    /// The latest used one comes last.
    bind_groups: Vec<(Key, wgpu::BindGroup)>,
    /// Targets that are drawn to, from the second time on: a window gives another texture each time. The latest used one
    /// comes last.
    targets: Vec<(Seen, wgpu::TextureView)>,
    /// Hashes of targets, which do not keep them alive.
    known: VecDeque<u64>,
}

/// The pipelines and bind groups for the caller's resources.
#[derive(Default)]
pub(crate) struct Surfaces {
    made: Mutex<Made>,
    hasher: RandomState,
}

impl std::fmt::Debug for Surfaces {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let made = self.made();
        let (pipelines, bind_groups) = (made.pipelines.len(), made.bind_groups.len());
        f.debug_struct("Surfaces").field("pipelines", &pipelines).field("bind_groups", &bind_groups).finish()
    }
}

impl Surfaces {
    fn made(&self) -> MutexGuard<'_, Made> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Drops what holds the caller's resources.
    pub(crate) fn forget(&self) {
        let mut made = self.made();
        made.bind_groups.clear();
        made.targets.clear();
        made.known.clear();
    }

    /// Work between one resource of the caller's and one of the matcher's.
    pub(super) fn prepare(
        &self,
        middle: &Middle<'_>,
        name: &str,
        work: Work,
        theirs: Theirs<'_>,
        ours: Ours<'_>,
    ) -> Result<Prepared, Error> {
        let mut made = self.made();
        let (layout, pipeline) = match made.pipelines.get(&work) {
            Some(found) => found.clone(),
            None => {
                let compiled = scopes::guarded_or_left(middle.device, || compile(middle.device, work));
                let new = compiled.map_err(|error| middle.pulse.cause(error))?;
                made.pipelines.insert(work, new.clone());
                new
            }
        };
        let key = Key::new(middle, work, theirs, ours);
        let bind_group = match made.bind_groups.iter().position(|(other, _)| *other == key) {
            Some(at) => {
                let found = made.bind_groups.remove(at);
                let bind_group = found.1.clone();
                made.bind_groups.push(found);
                bind_group
            }
            None => {
                let bind = || bind(middle, work, &layout, theirs, ours);
                let bind_group = scopes::guarded_or_left(middle.device, bind);
                let bind_group = bind_group.map_err(|error| theirs.refused(middle, name, error))?;
                if made.bind_groups.len() >= KEPT {
                    made.bind_groups.remove(0);
                }
                made.bind_groups.push((key, bind_group.clone()));
                bind_group
            }
        };
        let label = work.files()[1];
        let Frame { width, height, .. } = *middle.frame;
        match (pipeline, theirs) {
            (Pipeline::Render(pipeline), Theirs::Layer(layer, format)) => {
                let drawn = |target| Prepared::Draw { label, pipeline, bind_group, target };
                self.target(&mut made, middle, layer, format, drawn)
                    .map_err(|error| theirs.refused(middle, name, error))
            }
            (Pipeline::Compute(pipeline), _) => {
                let workgroups = match work {
                    Work::Intake { format, .. } => {
                        let bytes = u64::from(width) * u64::from(height) * u64::from(format.bytes_per_pixel());
                        let texels = 1 << middle.frame.source_shift;
                        [texels / LANES, bytes.div_ceil(16 * u64::from(texels)) as u32]
                    }
                    _ => [width.div_ceil(LANES), height],
                };
                Ok(Prepared::Compute { label, pipeline, bind_group, workgroups })
            }
            (Pipeline::Render(_), Theirs::Buffer { .. }) => unreachable!("nothing is drawn into a buffer"),
        }
    }

    /// What is drawn into a layer.
    fn target(
        &self,
        made: &mut Made,
        middle: &Middle<'_>,
        layer: TextureLayer<'_>,
        format: TextureFormat,
        drawn: impl FnOnce(wgpu::TextureView) -> Prepared,
    ) -> Result<Prepared, Error> {
        let seen = layer.seen(format);
        if let Some(at) = made.targets.iter().position(|(other, _)| *other == seen) {
            let found = made.targets.remove(at);
            let view = found.1.clone();
            made.targets.push(found);
            return Ok(drawn(view));
        }
        let view = scopes::guarded_or_left(middle.device, || layer.view(format))?;
        let prepared = drawn(view.clone());
        let hash = self.hasher.hash_one(&seen);
        if made.known.contains(&hash) {
            if made.targets.len() >= KEPT {
                made.targets.remove(0);
            }
            made.targets.push((seen, view));
            return Ok(prepared);
        }
        // A texture that is no target would spoil the caller's encoder: it spoils another one first.
        #[cfg(not(target_arch = "wasm32"))]
        scopes::guarded(middle.device, || {
            let mut encoder = middle.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            prepared.record(&mut encoder);
            encoder.finish()
        })?;
        made.known.truncate(KNOWN - 1);
        made.known.push_front(hash);
        Ok(prepared)
    }
}

impl Key {
    fn new(middle: &Middle<'_>, work: Work, theirs: Theirs<'_>, ours: Ours<'_>) -> Self {
        let (source, map) = match ours {
            Ours::Texture(source) => (Some(source.clone()), None),
            Ours::Buffer(map, _) => (None, Some(map.clone())),
        };
        // A target that is drawn to is in no bind group.
        let (layer, buffer) = match theirs {
            Theirs::Layer(..) if matches!(work.way(), Some(Way::Draw(_))) => (None, None),
            Theirs::Layer(layer, format) => (Some(layer.seen(format)), None),
            Theirs::Buffer { buffer, offset, bytes, bytes_per_row } => {
                (None, Some((buffer.clone(), offset, bytes, bytes_per_row)))
            }
        };
        Self { work, source, map, layer, buffer, frame: *middle.frame, disparities: middle.params.disparities }
    }
}

/// A buffer with these contents.
fn filled(middle: &Middle<'_>, label: &str, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    let size = contents.len() as u64;
    let buffer = middle.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    });
    middle.queue.write_buffer(&buffer, 0, contents);
    buffer
}

fn bind(
    middle: &Middle<'_>,
    work: Work,
    layout: &wgpu::BindGroupLayout,
    theirs: Theirs<'_>,
    ours: Ours<'_>,
) -> wgpu::BindGroup {
    let uniform = |label, contents: &[u8]| filled(middle, label, wgpu::BufferUsages::UNIFORM, contents);
    let frame = uniform("gpu-stereo.frame", bytemuck::bytes_of(middle.frame));
    let stride = if let Theirs::Buffer { bytes_per_row, .. } = theirs { bytes_per_row / 4 } else { 0 };
    let mut colors = None;
    let mut pass = None;
    let (source, view);
    let mut entries = vec![(0, frame.as_entire_binding())];
    match ours {
        Ours::Texture(texture) => {
            let block = Pass { stride, ..Pass::default() };
            let block = pass.insert(uniform("gpu-stereo.passes", bytemuck::bytes_of(&block)));
            source = texture.create_view(&wgpu::TextureViewDescriptor::default());
            entries.push((1, block.as_entire_binding()));
            entries.push((2, wgpu::BindingResource::TextureView(&source)));
        }
        Ours::Buffer(buffer, bytes) => {
            let size = wgpu::BufferSize::new(bytes);
            entries.push((2, wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })));
        }
    }
    if matches!(work, Work::Color(_)) {
        let table = color::table(&middle.params.searched());
        let table = filled(middle, "gpu-stereo.colors", wgpu::BufferUsages::STORAGE, bytemuck::cast_slice(&table));
        entries.push((3, colors.insert(table).as_entire_binding()));
    }
    match (theirs, work.way()) {
        (Theirs::Layer(..), Some(Way::Draw(_))) => (),
        (Theirs::Layer(layer, format), way) => {
            view = layer.view(format);
            entries.push((if way.is_some() { 4 } else { 3 }, wgpu::BindingResource::TextureView(&view)));
        }
        (Theirs::Buffer { buffer, offset, bytes, .. }, _) => {
            let size = wgpu::BufferSize::new(bytes);
            entries.push((3, wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size })));
        }
    }
    let entries: Vec<_> =
        entries.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    middle.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(&format!("gpu-stereo.{}", work.files()[1])),
        layout,
        entries: &entries,
    })
}

fn compile(device: &wgpu::Device, work: Work) -> (wgpu::BindGroupLayout, Pipeline) {
    let label = format!("gpu-stereo.{}", work.files()[1]);
    let label = Some(label.as_str());
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &work.entries() });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let source = wgpu::ShaderSource::Wgsl(work.source().into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    let pipeline = match work.way() {
        Some(Way::Draw(format)) => Pipeline::Render(device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("main"),
                compilation_options,
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })),
        _ => Pipeline::Compute(device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options,
            cache: None,
        })),
    };
    (layout, pipeline)
}

#[cfg(test)]
pub(crate) mod tests;
