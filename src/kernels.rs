//! The table of kernels: everything that turns a WGSL file into a pipeline.

use crate::params::{Params, Paths, Prefilter};
use crate::{Error, PixelFormat};

/// What a kernel does with a storage buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
}
use Access::{Read, Write};

/// A row of the table.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// The stage's name: of its file, its reference, its label, its timing.
    pub(crate) name: &'static str,
    /// The kernel and the fragments appended to it.
    pub(crate) sources: &'static [&'static str],
    /// The storage buffers from binding 2 on; 0 and 1 are the uniform blocks.
    pub(crate) storage: &'static [Access],
}

macro_rules! wgsl {
    ($($file:literal),+) => { &[$(include_str!(concat!("../shaders/", $file, ".wgsl"))),+] };
}

#[rustfmt::skip]
pub(crate) const KERNELS: &[Kernel] = &[
    Kernel { name: "gray", sources: wgsl!("gray", "common"), storage: &[Read, Write] },
    Kernel { name: "prefilter", sources: wgsl!("prefilter", "common"), storage: &[Read, Write] },
    Kernel { name: "sad_columns", sources: wgsl!("sad_columns", "common"), storage: &[Read, Read, Write] },
    Kernel { name: "sad_cost", sources: wgsl!("sad_cost", "common"), storage: &[Read, Write] },
    Kernel { name: "sgm_aggregate", sources: wgsl!("sgm_aggregate", "path_step", "common"), storage: &[Read, Write, Read, Write] },
    Kernel { name: "winner", sources: wgsl!("winner", "path_step", "winner_row", "common"), storage: &[Read, Read, Read, Read, Read, Write, Write] },
    Kernel { name: "block_match", sources: wgsl!("block_match", "winner_row", "common"), storage: &[Read, Write, Write] },
    Kernel { name: "lr_check", sources: wgsl!("lr_check", "common"), storage: &[Read, Read, Write] },
    Kernel { name: "median", sources: wgsl!("median", "common"), storage: &[Read, Write] },
];

/// Invocations a workgroup of every kernel, along x.
pub(crate) const LANES: u32 = 32;

/// Rows that one invocation of `sad_columns` walks.
pub(crate) const SEGMENT: u32 = 128;

/// The constants that specialise a kernel, as the WGSL line that is appended to it: `override` constants cannot size
/// the arrays that hold a path's state. Only those that the source names are given, so that settings which do not
/// concern a kernel do not change its text (and the driver's cache finds it again).
pub(crate) fn constants(kernel: &Kernel, params: &Params, format: PixelFormat) -> String {
    let quads = params.disparities.div_ceil(16);
    let beyond: Vec<String> = (0..4)
        .map(|word| {
            let first = (quads - 1) * 16 + word * 4;
            let mask = (0..4).filter(|byte| first + byte >= params.disparities).map(|byte| 0xffu32 << (8 * byte));
            format!("{}u", mask.sum::<u32>())
        })
        .collect();
    let (paths, paired) = match params.paths {
        Paths::Four => (4, 1),
        Paths::Eight => (8, 3),
    };
    let number = |value: u32| ("u32", format!("{value}u"));
    let table = [
        ("LANES", number(LANES)),
        ("SEGMENT", number(SEGMENT)),
        ("DISPARITIES", number(params.disparities)),
        ("QUADS", number(quads)),
        ("WORDS", number(4 * quads)),
        ("PAIRS", number(8 * quads)),
        ("BEYOND", ("vec4<u32>", format!("vec4({})", beyond.join(", ")))),
        ("PATHS", number(paths)),
        ("PAIRED", number(paired)),
        ("SUBPIXEL", number(params.subpixel.into())),
        ("FORMAT", number(format as u32)),
        ("GRAY8", number(PixelFormat::Gray8 as u32)),
        ("GRAY16", number(PixelFormat::Gray16 as u32)),
        ("RGBA8", number(PixelFormat::Rgba8 as u32)),
        ("PREFILTER", number(params.prefilter as u32)),
        ("PREFILTER_XSOBEL", number(Prefilter::XSobel as u32)),
        ("PREFILTER_NONE", number(Prefilter::None as u32)),
    ];
    let named = |name: &str| {
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        kernel.sources.iter().any(|source| source.split(|c| !word(c)).any(|token| token == name))
    };
    let chosen = table.iter().filter(|(name, _)| named(name));
    chosen.map(|(name, (kind, value))| format!("const {name}: {kind} = {value}; ")).collect()
}

/// The whole text of a specialised kernel.
pub(crate) fn source(kernel: &Kernel, params: &Params, format: PixelFormat) -> String {
    let text = format!("{}\n{}\n", kernel.sources.join("\n"), constants(kernel, params, format));
    #[cfg(test)]
    let text = tests::edited(kernel.name, text);
    text
}

/// A kernel compiled for a device.
#[derive(Debug)]
pub(crate) struct Compiled {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) pipeline: wgpu::ComputePipeline,
}

pub(crate) fn compile(device: &wgpu::Device, kernel: &Kernel, params: &Params, format: PixelFormat) -> Compiled {
    let label = format!("gpu-stereo.{}", kernel.name);
    let entry = |binding: u32, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    };
    let mut entries =
        vec![entry(0, wgpu::BufferBindingType::Uniform, false), entry(1, wgpu::BufferBindingType::Uniform, true)];
    for (binding, access) in (2..).zip(kernel.storage) {
        entries.push(entry(binding, wgpu::BufferBindingType::Storage { read_only: *access == Read }, false));
    }
    let layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label), entries: &entries });
    let module = shader_module(
        device,
        wgpu::ShaderModuleDescriptor {
            label: Some(&label),
            source: wgpu::ShaderSource::Wgsl(source(kernel, params, format).into()),
        },
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
            // Every kernel writes what it reads before it reads it; workgroup memory is not used.
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    });
    Compiled { layout, pipeline }
}

/// Bounds checks stay on; only naga's guard against endless loops is left out. It puts a counter into every loop, which
/// keeps Mesa from unrolling the loops over a path's state, so that the state stays in memory: 2.4 times slower on
/// lavapipe (docs/PERFORMANCE.md).
#[allow(unsafe_code)]
fn shader_module(device: &wgpu::Device, descriptor: wgpu::ShaderModuleDescriptor<'_>) -> wgpu::ShaderModule {
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
    // SAFETY: what the checks left out guard against is a loop that does not end. Every loop of the kernels counts up
    // to a constant or to a size from the uniform blocks, which the matcher fills and checks.
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}

/// The limits that the kernels need, whatever the settings.
pub(crate) fn check_limits(limits: &wgpu::Limits) -> Result<(), Error> {
    let most = KERNELS.iter().map(|kernel| kernel.storage.len() as u32).max().unwrap_or(0);
    let needs = [
        ("max_storage_buffers_per_shader_stage", limits.max_storage_buffers_per_shader_stage, most),
        ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup, LANES),
        ("max_compute_workgroup_size_x", limits.max_compute_workgroup_size_x, LANES),
        ("max_dynamic_uniform_buffers_per_pipeline_layout", limits.max_dynamic_uniform_buffers_per_pipeline_layout, 1),
    ];
    let missing: Vec<String> = needs
        .iter()
        .filter(|(_, has, needed)| has < needed)
        .map(|(name, has, needed)| format!("{name} is {has}, at least {needed} needed"))
        .collect();
    if missing.is_empty() { Ok(()) } else { Err(Error::Device(missing.join("; "))) }
}

#[cfg(test)]
mod tests;
