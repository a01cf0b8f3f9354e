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

/// The WGSL block `Dispatch`: what differs between dispatches.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Dispatch {
    pub(crate) first_row: u32,
    pub(crate) rows: u32,
    pub(crate) volume_row: u32,
    pub(crate) first_line: u32,
    pub(crate) lines: u32,
    pub(crate) shift: u32,
    pub(crate) dx: i32,
    pub(crate) dy: i32,
    pub(crate) entry: i32,
    pub(crate) carried: u32,
    pub(crate) stride: u32,
    pub(crate) row_step: u32,
    pub(crate) slot: u32,
    pub(crate) map_row: u32,
    pub(crate) planes_row: u32,
    pub(crate) planes_rows: u32,
    pub(crate) own: Own,
}

/// The WGSL block `Own` of any kernel, which ends `Dispatch`: what only this kernel reads.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Own([u32; 20]);

/// What stands for [`Own`] in the text of a kernel that declares none.
pub(crate) const NO_OWN: &str = "alias Own = u32; ";

/// Structs that become [`Own`].
macro_rules! own {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty),+ })+) => {$(
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
        pub(crate) struct $name {
            $(pub(crate) $field: $type),+
        }

        impl From<$name> for Own {
            fn from(fields: $name) -> Self {
                let mut own = Self::default();
                let bytes = bytemuck::bytes_of(&fields);
                bytemuck::bytes_of_mut(&mut own)[..bytes.len()].copy_from_slice(bytes);
                own
            }
        }
    )+};
}

own! {
    /// Of `gray` and `deep_gray`.
    GrayOwn { channel: u32, reversed: u32 }
    /// Of `prefilter` and `descriptors`.
    PlaneOwn { mirrored: u32, lead: i32, first_plane: u32 }
    /// Of `window_columns` and `window_sums`.
    WindowOwn { window: u32 }
    /// Of `mi_histogram`.
    HistogramOwn { halvings: u32 }
    /// Of `mi_smooth`.
    SmoothOwn { narrowing: u32, prior: u32, logarithms: u32 }
    /// Of `sgm_aggregate`, `second_cost` and `winner`.
    PathOwn {
        accumulate: u32,
        carry_from: u32,
        carry_to: u32,
        penalties_from: u32,
        penalties_line: u32,
        penalties_step: u32,
        place: i32
    }
    /// Of `coarse_cost` and `coarse_cost_sums`.
    CoarseOwn { width: u32, rows: u32, stride: u32, coarse_stride: u32 }
    /// Of `messages_start`.
    StartOwn {
        rows: u32,
        stride: u32,
        coarse_width: u32,
        coarse_height: u32,
        coarse_stride: u32,
        coarse_first: u32,
        coarse_rows: u32,
        above: u32
    }
    /// Of `messages`, `messages_coarse` and `winner_beliefs`.
    BeliefOwn {
        width: u32,
        height: u32,
        stride: u32,
        first: u32,
        rows: u32,
        above: u32,
        odd: u32,
        share: u32
    }
    /// Of the convolutions of the network.
    LayerOwn {
        columns: u32,
        rows: u32,
        planes: u32,
        in_columns: u32,
        in_rows: u32,
        in_planes: u32,
        blocks: u32,
        first_in: u32,
        end_in: u32,
        in_stride: u32,
        out_stride: u32,
        at: u32,
        added_at: u32,
        weights: u32,
        first_block: u32,
        out_blocks: u32,
        flags: u32
    }
    /// Of `feature_point`, `feature_convolution` and `feature_depthwise`.
    FeatureOwn {
        in_first: u32,
        in_rows: u32,
        in_blocks: u32,
        out_blocks: u32,
        weights: u32,
        lowest: i32,
        highest: i32,
        wide: u32
    }
    /// Of `feature_statistics`.
    StatisticsOwn { shift: u32 }
    /// Of `average_pool`, `upsample` and `disparity_regression`.
    ImageOwn {
        columns: u32,
        rows: u32,
        in_columns: u32,
        in_rows: u32,
        in_stride: u32,
        in_at: u32,
        out_stride: u32,
        rule: u32
    }
    /// Of `round_disparities`.
    RoundOwn { columns: u32, padding: u32 }
    /// Of `validity`.
    ValidityOwn { side: u32 }
    /// Of `fill_between` and `fill_rays`.
    FillOwn { occlusions: u32 }
    /// Of `intake`.
    IntakeOwn { x: u32, y: u32, chroma_stride: u32 }
}
