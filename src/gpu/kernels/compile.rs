//! From the text of a kernel to its pipeline.

use std::sync::Arc;

use super::table::Access::{Costs, Edges, Penalties, Planes, Read, Table, Texels, Trees, Write};
use super::table::Kernel;
use crate::gpu::plan::Plan;
use crate::params::Params;

/// A kernel compiled for a device.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) pipeline: wgpu::ComputePipeline,
    /// What it was compiled from.
    pub(crate) text: Arc<str>,
}

/// What decides about what is compiled for a device: the number of the kernel, [`Params::shader_checks`] and the text.
pub(crate) type CompiledKey = (usize, bool, Arc<str>);

/// Compiles `text`, a kernel's [`source`].
pub(crate) fn compile(
    device: &wgpu::Device,
    kernel: &Kernel,
    text: impl Into<Arc<str>>,
    params: &Params,
    plan: &Plan,
) -> Compiled {
    let text = text.into();
    let label = format!("gpu-stereo.{}", kernel.name);
    let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    let storage = kernel.storage(params, plan);
    let storage = storage.iter().map(|access| match access {
        Read | Costs => buffer(wgpu::BufferBindingType::Storage { read_only: true }, false),
        Write | Trees => buffer(wgpu::BufferBindingType::Storage { read_only: false }, false),
        Table | Penalties | Edges | Planes => unreachable!("there is none, or it is bound as what holds it"),
        Texels(format) => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::ReadOnly,
            format: *format,
            view_dimension: wgpu::TextureViewDimension::D2,
        },
    });
    let uniform = wgpu::BufferBindingType::Uniform;
    let types = [buffer(uniform, false), buffer(uniform, true)].into_iter().chain(storage);
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let entries: Vec<_> = (0..).zip(types).map(entry).collect();
    let layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label), entries: &entries });
    let module = shader_module(
        device,
        wgpu::ShaderModuleDescriptor { label: Some(&label), source: wgpu::ShaderSource::Wgsl((&*text).into()) },
        params.shader_checks,
    );
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&label),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(&label),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            // Every kernel writes what it reads before it reads it.
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    });
    Compiled { layout, pipeline, text }
}

/// The kernels run without naga's guards against endless loops and against indices out of range, unless
/// [`Params::shader_checks`] asks for them. Both keep Mesa from unrolling the loops over a path's state, which then stays
/// in memory: 2 to 5 times slower on lavapipe (docs/PERFORMANCE.md). The exactness tests run with and without them.
#[allow(unsafe_code)]
fn shader_module(
    device: &wgpu::Device,
    descriptor: wgpu::ShaderModuleDescriptor<'_>,
    shader_checks: bool,
) -> wgpu::ShaderModule {
    if shader_checks {
        return device.create_shader_module(descriptor);
    }
    let checks = wgpu::ShaderRuntimeChecks {
        force_loop_bounding: false,
        bounds_checks: false,
        ..wgpu::ShaderRuntimeChecks::checked()
    };
    // SAFETY: every loop of the kernels counts up to a constant, to a size from the uniform blocks or to a column below one, and
    // every index is made of such; the matcher fills the blocks and sizes the buffers from one source (src/gpu/layout).
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}
