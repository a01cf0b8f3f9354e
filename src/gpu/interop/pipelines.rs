//! Pipelines, bind groups and recorded work.

use crate::gpu::interop::context::Context;
use crate::gpu::interop::regions::Region;
use crate::gpu::interop::resources::{PixelBuffer, TextureLayer};
use crate::gpu::interop::work::{Work, WriteMethod};
use crate::gpu::layout::{Dispatch, IntakeOwn};
use crate::{Error, color};
use wgpu::TextureFormat;

/// A resource of the caller's.
#[derive(Clone, Copy)]
pub(super) enum CallerResource<'a> {
    /// Seen in a format.
    Layer(TextureLayer<'a>, TextureFormat),
    /// And how many bytes of it.
    Buffer(PixelBuffer<'a>, u64),
}

impl<'a> CallerResource<'a> {
    /// What it covers.
    pub(super) fn region(&self) -> Region<'a> {
        match *self {
            CallerResource::Layer(layer, _) => layer.into(),
            CallerResource::Buffer(PixelBuffer { buffer, offset, .. }, bytes) => {
                Region::Bytes(buffer, offset, offset + bytes)
            }
        }
    }

    /// Whether both are of one picture.
    pub(super) fn is_of(&self, other: &Self) -> bool {
        match (*self, *other) {
            (CallerResource::Layer(layer, _), CallerResource::Layer(other, _)) => {
                (layer.texture, layer.layer.unwrap_or(0)) == (other.texture, other.layer.unwrap_or(0))
            }
            (CallerResource::Buffer(pixels, _), CallerResource::Buffer(other, _)) => {
                (pixels.buffer, pixels.offset) == (other.buffer, other.offset)
            }
            _ => false,
        }
    }

    /// Words a row, of a buffer.
    fn stride(&self) -> u32 {
        if let CallerResource::Buffer(pixels, _) = self { pixels.bytes_per_row / 4 } else { 0 }
    }

    /// Column and row of the first pixel.
    pub(super) fn origin(&self) -> [u32; 2] {
        match self {
            CallerResource::Layer(layer, _) => layer.origin.unwrap_or_default(),
            CallerResource::Buffer(pixels, _) => pixels.origin,
        }
    }

    /// The error for a resource that passed the checks and that the device refused.
    pub(super) fn refused(&self, context: &Context<'_>, name: &str, error: Error) -> Error {
        let error = context.pulse.cause(error);
        let Error::Refused(text) = &error else { return error };
        let remedy = match self {
            CallerResource::Layer(TextureLayer { texture, .. }, format) if texture.format() != *format => {
                format!("create the texture with {format:?} among its view_formats, or in that format")
            }
            CallerResource::Layer(..) => "it was destroyed or serves another purpose: create another texture".into(),
            CallerResource::Buffer(..) => "it was destroyed: create another buffer".into(),
        };
        Error::Image(format!("{name} was refused by the device: {text}; {remedy}"))
    }
}

/// A resource of the matcher's.
#[derive(Clone, Copy)]
pub(super) enum MatcherResource<'a> {
    Texture(&'a wgpu::Texture),
    /// The first bytes of a buffer.
    Buffer(&'a wgpu::Buffer, u64),
}

#[derive(Clone, Debug)]
pub(super) enum Pipeline {
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
    /// Whether it is a pass, not a copy.
    pub(crate) fn is_pass(&self) -> bool {
        !matches!(self, Prepared::Copy { .. })
    }

    /// `writes`: the timestamps that the pass writes, if it is one.
    pub(crate) fn record<'a>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        writes: impl FnOnce() -> Option<wgpu::ComputePassTimestampWrites<'a>>,
    ) {
        match self {
            Prepared::Compute { label, pipeline, bind_group, workgroups: [x, y] } => {
                let descriptor = wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes: writes() };
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
                    timestamp_writes: writes().map(|writes| wgpu::RenderPassTimestampWrites {
                        query_set: writes.query_set,
                        beginning_of_pass_write_index: writes.beginning_of_pass_write_index,
                        end_of_pass_write_index: writes.end_of_pass_write_index,
                    }),
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

/// A buffer with these contents.
pub(super) fn filled(context: &Context<'_>, label: &str, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    let size = contents.len() as u64;
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    });
    context.queue.write_buffer(&buffer, 0, contents);
    buffer
}

/// The bind group of a piece of work.
pub(super) fn bind(
    context: &Context<'_>,
    work: Work,
    layout: &wgpu::BindGroupLayout,
    resources: [Option<CallerResource<'_>>; 2],
    end: MatcherResource<'_>,
) -> wgpu::BindGroup {
    let uniform = |label, contents: &[u8]| filled(context, label, wgpu::BufferUsages::UNIFORM, contents);
    let frame = uniform("gpu-stereo.frame", bytemuck::bytes_of(context.frame));
    let mut colors = None;
    let mut dispatch = None;
    let (source, views);
    let mut entries = vec![(0, frame.as_entire_binding())];
    match end {
        MatcherResource::Texture(texture) => {
            let [stride, chroma_stride] = resources.map(|resource| resource.map_or(0, |resource| resource.stride()));
            let [x, y] = resources[0].map_or([0, 0], |resource| resource.origin());
            let own = IntakeOwn { x, y, chroma_stride }.into();
            let block = Dispatch { stride, own, ..Dispatch::default() };
            let block = dispatch.insert(uniform("gpu-stereo.dispatch", bytemuck::bytes_of(&block)));
            source = texture.create_view(&wgpu::TextureViewDescriptor::default());
            entries.push((1, block.as_entire_binding()));
            entries.push((2, wgpu::BindingResource::TextureView(&source)));
        }
        MatcherResource::Buffer(buffer, bytes) => {
            let size = wgpu::BufferSize::new(bytes);
            entries.push((2, wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })));
        }
    }
    if matches!(work, Work::Color(_)) {
        let table = color::table(&context.params.searched());
        let table = filled(context, "gpu-stereo.colors", wgpu::BufferUsages::STORAGE, bytemuck::cast_slice(&table));
        entries.push((3, colors.insert(table).as_entire_binding()));
    }
    // A target that is drawn to is in no bind group.
    let bound = if matches!(work.method(), Some(WriteMethod::Draw(_))) { [None; 2] } else { resources };
    views = bound.map(|resource| match resource {
        Some(CallerResource::Layer(layer, format)) => Some(layer.view(format)),
        _ => None,
    });
    let first = if work.method().is_some() { 4 } else { 3 };
    for ((binding, resource), view) in (first..).zip(bound).zip(&views) {
        let entry = match (resource, view) {
            (Some(CallerResource::Buffer(PixelBuffer { buffer, offset, .. }, bytes)), _) => {
                let size = wgpu::BufferSize::new(bytes);
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size })
            }
            (_, Some(view)) => wgpu::BindingResource::TextureView(view),
            (_, None) => continue,
        };
        entries.push((binding, entry));
    }
    let entries: Vec<_> =
        entries.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    context.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(&format!("gpu-stereo.{}", work.name())),
        layout,
        entries: &entries,
    })
}

/// The pipeline of a piece of work.
pub(super) fn compile(device: &wgpu::Device, work: Work) -> (wgpu::BindGroupLayout, Pipeline) {
    let label = format!("gpu-stereo.{}", work.name());
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
    let pipeline = match work.method() {
        Some(WriteMethod::Draw(format)) => {
            Pipeline::Render(device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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
            }))
        }
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
