//! WebGPU's default limits suffice, and what a device lacks is named.

use std::collections::BTreeSet;

use wgpu::naga;

use super::specialisations::{parse, specialisations_of, texts};
use crate::gpu::interop::are_made;
use crate::gpu::kernels::Access::{Costs, Read, Write};
use crate::gpu::kernels::limits::SHARED_BYTES;
use crate::gpu::kernels::{KERNELS, source};
use crate::gpu::kernels::{check_limits, compile};
use crate::gpu::layout::{Dispatch, Frame};

#[test]
fn webgpu_default_limits_suffice() {
    let limits = wgpu::Limits::default();
    assert!(check_limits(&limits).is_ok());
    let mut most_shared = 0;
    for kernel in KERNELS {
        let name = kernel.name;
        let storage = kernel.storage.iter().filter(|access| matches!(access, Read | Write | Costs)).count() as u32;
        assert!(storage <= limits.max_storage_buffers_per_shader_stage, "{name} has {storage} storage buffers");
        for text in texts(kernel) {
            let module = parse(kernel, text);
            assert_eq!(module.entry_points.len(), 1, "{name}: one entry point a kernel");
            let entry = &module.entry_points[0];
            assert_eq!(entry.name, "main", "{name}");
            let [x, y, z] = entry.workgroup_size;
            let lanes = x * y * z;
            assert!(lanes <= limits.max_compute_invocations_per_workgroup, "{name}: {lanes} invocations a workgroup");
            assert!(x <= limits.max_compute_workgroup_size_x, "{name}: {x} invocations along x");
            assert!(y <= limits.max_compute_workgroup_size_y, "{name}: {y} invocations along y");
            assert!(z <= limits.max_compute_workgroup_size_z, "{name}: {z} invocations along z");
            let shared = module.global_variables.iter().filter(|(_, v)| v.space == naga::AddressSpace::WorkGroup);
            let bytes: u32 = shared.map(|(_, v)| module.types[v.ty].inner.size(module.to_ctx())).sum();
            assert!(bytes <= limits.max_compute_workgroup_storage_size, "{name}: {bytes} bytes of workgroup memory");
            most_shared = most_shared.max(bytes);
        }
    }
    assert_eq!(most_shared, SHARED_BYTES);
}

type Limit = fn(&mut wgpu::Limits) -> &mut u32;

/// Every limit that WebGPU lets a device ask for and a compute shader depends on, whatever the size of a pair.
const LIMITS: &[(&str, Limit)] = &[
    ("max_bind_groups", |limits| &mut limits.max_bind_groups),
    ("max_bindings_per_bind_group", |limits| &mut limits.max_bindings_per_bind_group),
    ("max_dynamic_uniform_buffers_per_pipeline_layout", |limits| {
        &mut limits.max_dynamic_uniform_buffers_per_pipeline_layout
    }),
    ("max_dynamic_storage_buffers_per_pipeline_layout", |limits| {
        &mut limits.max_dynamic_storage_buffers_per_pipeline_layout
    }),
    ("max_sampled_textures_per_shader_stage", |limits| &mut limits.max_sampled_textures_per_shader_stage),
    ("max_samplers_per_shader_stage", |limits| &mut limits.max_samplers_per_shader_stage),
    ("max_storage_buffers_per_shader_stage", |limits| &mut limits.max_storage_buffers_per_shader_stage),
    ("max_storage_textures_per_shader_stage", |limits| &mut limits.max_storage_textures_per_shader_stage),
    ("max_uniform_buffers_per_shader_stage", |limits| &mut limits.max_uniform_buffers_per_shader_stage),
    ("max_buffers_and_acceleration_structures_per_shader_stage", |limits| {
        &mut limits.max_buffers_and_acceleration_structures_per_shader_stage
    }),
    ("max_compute_workgroup_storage_size", |limits| &mut limits.max_compute_workgroup_storage_size),
    ("max_compute_invocations_per_workgroup", |limits| &mut limits.max_compute_invocations_per_workgroup),
    ("max_compute_workgroup_size_x", |limits| &mut limits.max_compute_workgroup_size_x),
    ("max_compute_workgroup_size_y", |limits| &mut limits.max_compute_workgroup_size_y),
    ("max_compute_workgroup_size_z", |limits| &mut limits.max_compute_workgroup_size_z),
];

/// The limits named in what [`check_limits`] says.
fn lacking(limits: &wgpu::Limits) -> Vec<&'static str> {
    let told = check_limits(limits).map_or_else(|error| error.to_string(), |()| String::new());
    assert_eq!(told.lines().count(), usize::from(!told.is_empty()), "{told}");
    LIMITS.iter().map(|(name, _)| *name).filter(|name| told.contains(&format!("{name} is "))).collect()
}

/// With the least limits that [`check_limits`] lets pass, wgpu accepts every kernel; with one less anywhere it refuses
/// one, and what lacks is named: alone, and all together.
#[test]
fn the_limits_that_are_needed_are_those_that_are_checked() {
    let mut least = wgpu::Limits::default();
    for (name, limit) in LIMITS {
        while lacking(&least).is_empty() && *limit(&mut least) > 0 {
            *limit(&mut least) -= 1;
        }
        if !lacking(&least).is_empty() {
            assert_eq!(lacking(&least), [*name]);
            *limit(&mut least) += 1;
        }
    }
    least.max_uniform_buffer_binding_size = size_of::<Dispatch>().max(size_of::<Frame>()) as u64;
    assert!(check_limits(&least).is_ok());
    // What differs in its bindings, its workgroup or its shared memory.
    let differing: Vec<_> = KERNELS
        .iter()
        .flat_map(|kernel| {
            let mut seen = BTreeSet::new();
            specialisations_of(kernel)
                .filter(move |(params, _, plan)| {
                    let storage = format!("{:?}", kernel.storage(params, plan));
                    seen.insert((storage, kernel.lanes(plan), plan.exchange))
                })
                .map(move |(params, format, plan)| (kernel, source(kernel, &params, format, &plan), params, plan))
        })
        .collect();
    let accepts = |limits: &wgpu::Limits| {
        let features = wgpu::Features::SUBGROUP | wgpu::Features::SHADER_INT64;
        let required_limits = limits.clone();
        let (device, _queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor {
            required_features: features,
            required_limits,
            ..Default::default()
        });
        let kernels_are_made = differing.iter().all(|(kernel, text, params, plan)| {
            crate::gpu::scopes::guarded(&device, || compile(&device, kernel, text.as_str(), params, plan)).is_ok()
        });
        kernels_are_made && are_made(&device)
    };
    assert!(accepts(&least));
    let mut none = least.clone();
    let mut needed = Vec::new();
    for (name, limit) in LIMITS {
        let mut less = least.clone();
        if *limit(&mut less) > 0 {
            *limit(&mut less) -= 1;
            assert_eq!(lacking(&less), [*name]);
            // wgpu leaves workgroup memory to the driver; the test above compares it with the shaders.
            let left_to_driver = *name == "max_compute_workgroup_storage_size";
            assert_eq!(accepts(&less), left_to_driver, "{name} need not be {}", limit(&mut least));
            *limit(&mut none) = 0;
            needed.push(*name);
        }
    }
    assert!(needed.len() >= 10, "{needed:?}");
    assert_eq!(lacking(&none), needed);
    least.max_uniform_buffer_binding_size -= 1;
    let error = check_limits(&least).unwrap_err().to_string();
    assert!(error.contains("max_uniform_buffer_binding_size is "), "{error}");
}
