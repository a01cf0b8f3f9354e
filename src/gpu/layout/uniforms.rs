//! The uniform blocks that all kernels read, as shaders/shared/common.wgsl declares them.

/// Texels of 16 bytes in a row of the textures that hold a copy of a buffer, which are filled line by line.
pub(crate) const TEXELS: u32 = 1024;

/// Bytes of a row of [`TEXELS`].
pub(crate) const TEXTURE_ROW: u64 = 16 * TEXELS as u64;

/// The WGSL block `Frame`: what stays the same for all dispatches of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Frame {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) min_disparity: i32,
    pub(crate) block_radius: u32,
    pub(crate) prefilter_cap: u32,
    pub(crate) cost_scale: u32,
    pub(crate) p1: u32,
    pub(crate) p2: u32,
    pub(crate) lr_max_difference: u32,
    pub(crate) gray_stride: u32,
    pub(crate) left_stride: u32,
    pub(crate) right_stride: u32,
    pub(crate) map_stride: u32,
    pub(crate) volume_stride: u32,
    pub(crate) map_words: u32,
    pub(crate) texture: u32,
    pub(crate) speckle_window: u32,
    pub(crate) speckle_range: i32,
    pub(crate) fill_max_difference: i32,
    pub(crate) depth_high: u32,
    pub(crate) depth_low: u32,
    pub(crate) depth_offset: i32,
    pub(crate) source_shift: u32,
}

/// The WGSL block `Pass`: what differs between dispatches.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Pass {
    pub(crate) first_row: u32,
    pub(crate) rows: u32,
    pub(crate) volume_row: u32,
    pub(crate) first_line: u32,
    pub(crate) lines: u32,
    pub(crate) shift: u32,
    pub(crate) dx: i32,
    pub(crate) dy: i32,
    pub(crate) carried: u32,
    pub(crate) accumulate: u32,
    pub(crate) channel: u32,
    pub(crate) mirrored: u32,
    pub(crate) lead: i32,
    pub(crate) stride: u32,
    pub(crate) first_plane: u32,
    pub(crate) window: u32,
    pub(crate) row_step: u32,
    pub(crate) occlusions: u32,
    pub(crate) reversed: u32,
    pub(crate) entry: i32,
    pub(crate) carry_from: u32,
    pub(crate) carry_to: u32,
    pub(crate) slot: u32,
    pub(crate) penalties_from: u32,
    pub(crate) penalties_line: u32,
    pub(crate) penalties_step: u32,
    pub(crate) place: i32,
    pub(crate) halvings: u32,
    pub(crate) narrowing: u32,
    pub(crate) prior: u32,
    pub(crate) logarithms: u32,
    pub(crate) side: u32,
    pub(crate) map_row: u32,
    pub(crate) planes_row: u32,
    pub(crate) planes_rows: u32,
}
