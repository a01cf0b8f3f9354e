//! The limits of a device that the kernels need.

use super::table::Access::{self, Costs, Penalties, Read, Table, Texels, Trees, Write};
use super::table::KERNELS;
use crate::Error;
use crate::gpu::layout::{Dispatch, Frame};
use crate::gpu::plan::GROUP_LANES;

/// Bytes of workgroup memory of `shared_path_workgroup` and of `mi_range`, which have most of it.
pub(crate) const SHARED_BYTES: u32 = 2048;

/// The limits that the kernels need, whatever the settings; all that the device lacks is named at once. The sizes of
/// buffers and textures, which depend on the pair, are checked where they are computed (src/gpu/layout).
pub(crate) fn check_limits(limits: &wgpu::Limits) -> Result<(), Error> {
    let most = |bound: fn(&Access) -> bool| {
        KERNELS.iter().map(|kernel| kernel.storage.iter().filter(|access| bound(access)).count()).max().unwrap_or(0)
    };
    let buffers = most(|access| matches!(access, Read | Write | Costs | Penalties | Trees));
    let textures = most(|access| matches!(access, Texels(_) | Costs | Table));
    let lanes = KERNELS.iter().map(|kernel| kernel.lanes).max().unwrap_or(0).max(GROUP_LANES);
    let uniform = size_of::<Frame>().max(size_of::<Dispatch>());
    let mut lacking = Vec::new();
    macro_rules! need {
        ($($name:ident $needed:expr;)+) => {$(
            if u64::from(limits.$name) < $needed as u64 {
                lacking.push(format!("{} is {}, at least {} needed", stringify!($name), limits.$name, $needed));
            }
        )+};
    }
    need! {
        max_bind_groups 1;
        max_bindings_per_bind_group 2 + most(|_| true);
        max_dynamic_uniform_buffers_per_pipeline_layout 1;
        max_storage_buffers_per_shader_stage buffers;
        max_storage_textures_per_shader_stage textures;
        max_sampled_textures_per_shader_stage 2; // Y, and U and V, of the caller's
        max_uniform_buffers_per_shader_stage 2;
        max_buffers_and_acceleration_structures_per_shader_stage 2 + buffers;
        max_uniform_buffer_binding_size uniform;
        max_compute_workgroup_storage_size SHARED_BYTES;
        max_compute_invocations_per_workgroup lanes;
        max_compute_workgroup_size_x lanes;
        max_compute_workgroup_size_y 1;
        max_compute_workgroup_size_z 1;
    }
    if lacking.is_empty() { Ok(()) } else { Err(Error::Device(lacking.join("; "))) }
}
