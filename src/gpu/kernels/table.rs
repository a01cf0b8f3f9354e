//! The table: a row a kernel, with its files and what it is bound to.

use crate::gpu::plan::{Exchange, GROUP_LANES, Plan, STRIP_LANES};
use crate::params::{Params, Smoothness};
use crate::reference::{median_decay, median_spacing, wls_bits};

/// What a kernel does with a storage resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
    /// A texture of this format, read as a storage texture.
    Texels(wgpu::TextureFormat),
    /// The cost, or values of the network, read as the plan has it: from a texture or from a buffer.
    Costs,
    /// What pairs of values cost: there only for [`crate::Cost::MutualInformation`].
    Table,
    /// The penalties of the pixels, where the plan has them.
    Penalties,
    /// The gray image, where the smoothness depends on its edges.
    Edges,
    /// The trees of the speckle filter, written: one binding, or its parts.
    Trees,
    /// The planes of both sides, where pixels are compared by them beside their features.
    Planes,
}
use Access::{Costs, Edges, Penalties, Planes, Read, Table, Texels, Trees, Write};

/// Fragments of which the plan or the settings choose some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// How invocations share the disparities of a pixel.
    SharedPath,
    /// How many disparities a load or store moves.
    Volumes,
    /// Where the cost is read.
    Cost,
    /// Where P1 and P2 come from.
    Penalty,
    /// How the smoothness grows with the difference of disparities.
    Smoothness,
    /// Where the smoothness between two neighbours comes from.
    Edges,
    /// How pixels are compared, as bytes.
    PixelCosts,
    /// How pixels are compared, as values of 16 bits.
    PixelPairs,
    /// How wide the sums of columns are.
    Sums,
    /// What block matching makes of a block's sum.
    BlockCosts,
    /// Whether the trees of the speckle filter are in one binding.
    Trees,
    /// Where values of the network are read.
    Values,
    /// Where its weights are read, and the values that are added.
    Weights,
    /// Who loads the weights of a line of taps.
    Taps,
    /// How products of bytes are summed.
    Products,
    /// Who loads eight texels of weights.
    EightTexels,
    /// By what pixels are compared beside their features.
    Beside,
}

/// Neighbours of a subgroup that share the weights of a line of taps.
const TAP_LANES: u32 = 8;

/// Texels of 4 bytes.
const WORD: Access = Texels(wgpu::TextureFormat::R32Uint);
const QUAD: Access = Texels(wgpu::TextureFormat::Rgba32Uint);

/// A row of the table.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// Its name: of its file and its label.
    pub(crate) name: &'static str,
    /// The stage that it computes: the name of its reference, its timing and its row of a check.
    pub(crate) stage: &'static str,
    /// The kernel and the fragments appended to it.
    pub(crate) sources: &'static [&'static str],
    /// The fragments appended after these.
    pub(crate) choices: &'static [Choice],
    /// Invocations a workgroup, along x.
    pub(super) lanes: u32,
    /// The storage resources from binding 2 on; 0 and 1 are the uniform blocks.
    pub(crate) storage: &'static [Access],
}

macro_rules! wgsl {
    ($($file:literal),+) => { &[$(include_str!(concat!("../../../shaders/", $file, ".wgsl"))),+] };
}

const TRANSPOSED: &[Choice] = &[Choice::Values, Choice::Weights];
const LAYER: &[Choice] = &[Choice::Values, Choice::Weights, Choice::Taps];
const FEATURES: &[Choice] = &[Choice::Products, Choice::EightTexels];
const PATHS: &[Choice] = &[Choice::SharedPath, Choice::Volumes, Choice::Cost, Choice::Penalty];

#[rustfmt::skip]
pub(crate) const KERNELS: &[Kernel] = &[
    Kernel { name: "rectify", stage: "rectify", lanes: 64, sources: wgsl!("images/rectify", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
    Kernel { name: "gray", stage: "gray", lanes: 64, sources: wgsl!("images/gray", "images/parts/samples", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "deep_gray", stage: "gray", lanes: 64, sources: wgsl!("images/deep_gray", "images/parts/samples", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "window_columns", stage: "window_sums", lanes: 64, sources: wgsl!("images/window_columns", "images/parts/gray_pixels", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "window_sums", stage: "window_sums", lanes: 64, sources: wgsl!("images/window_sums", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "prefilter", stage: "prefilter", lanes: 64, sources: wgsl!("images/prefilter", "shared/root", "images/parts/gray_pixels", "images/parts/plane_layout", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
    Kernel { name: "descriptors", stage: "descriptors", lanes: 64, sources: wgsl!("cost/descriptors", "images/parts/gray_pixels", "images/parts/plane_layout", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
    Kernel { name: "feature_histogram", stage: "feature_statistics", lanes: 64, sources: wgsl!("features/feature_histogram", "images/parts/gray_pixels", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "feature_statistics", stage: "feature_statistics", lanes: 128, sources: wgsl!("features/feature_statistics", "shared/root", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "feature_input", stage: "feature_layer", lanes: 32, sources: wgsl!("features/feature_input", "features/parts/quotients", "images/parts/gray_pixels", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
    Kernel { name: "feature_point", stage: "feature_layer", lanes: 32, sources: wgsl!("features/feature_point", "features/parts/groups", "features/parts/layer", "shared/common"), choices: FEATURES, storage: &[Read, Read, Write] },
    Kernel { name: "feature_convolution", stage: "feature_layer", lanes: 32, sources: wgsl!("features/feature_convolution", "features/parts/groups", "features/parts/neighbours", "features/parts/layer", "shared/common"), choices: FEATURES, storage: &[Read, Read, Write] },
    Kernel { name: "feature_depthwise", stage: "feature_layer", lanes: 32, sources: wgsl!("features/feature_depthwise", "features/parts/neighbours", "features/parts/layer", "shared/common"), choices: &[Choice::EightTexels], storage: &[Read, Read, Write] },
    Kernel { name: "features", stage: "features", lanes: 32, sources: wgsl!("features/features", "features/parts/quotients", "shared/root", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "coarse_cost", stage: "coarse_cost", lanes: STRIP_LANES, sources: wgsl!("beliefs/coarse_cost", "beliefs/parts/sum_terms", "beliefs/parts/data_cost", "beliefs/parts/pairs", "shared/common"), choices: &[Choice::SharedPath, Choice::Volumes, Choice::Cost], storage: &[Costs, Write] },
    Kernel { name: "coarse_cost_sums", stage: "coarse_cost", lanes: STRIP_LANES, sources: wgsl!("beliefs/coarse_cost_sums", "beliefs/parts/sum_terms", "beliefs/parts/data_coarse", "beliefs/parts/pairs", "shared/common"), choices: &[Choice::SharedPath, Choice::Volumes], storage: &[Read, Write] },
    Kernel { name: "messages_start", stage: "messages", lanes: 128, sources: wgsl!("beliefs/messages_start", "shared/common"), choices: &[Choice::Volumes], storage: &[Read, Read, Read, Write] },
    Kernel { name: "messages", stage: "messages", lanes: STRIP_LANES, sources: wgsl!("beliefs/messages", "beliefs/parts/send", "beliefs/parts/received", "beliefs/parts/data_cost", "beliefs/parts/pairs", "winner/parts/costs", "shared/common"), choices: &[Choice::SharedPath, Choice::Volumes, Choice::Cost, Choice::Smoothness, Choice::Edges], storage: &[Costs, Write, Read, Read, Edges] },
    Kernel { name: "messages_coarse", stage: "messages", lanes: STRIP_LANES, sources: wgsl!("beliefs/messages_coarse", "beliefs/parts/send", "beliefs/parts/received", "beliefs/parts/data_coarse", "beliefs/parts/edges_fixed", "beliefs/parts/pairs", "winner/parts/costs", "shared/common"), choices: &[Choice::SharedPath, Choice::Volumes, Choice::Smoothness], storage: &[Read, Write, Read, Read] },
    Kernel { name: "penalties", stage: "penalties", lanes: 64, sources: wgsl!("paths/penalties", "paths/parts/intensity_steps", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "penalties_lines", stage: "penalties", lanes: 64, sources: wgsl!("paths/penalties_lines", "paths/parts/intensity_steps", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "halve", stage: "halve", lanes: 64, sources: wgsl!("images/halve", "images/parts/values", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "mi_histogram", stage: "mi_histogram", lanes: 64, sources: wgsl!("cost/mi_histogram", "images/parts/values", "shared/common"), choices: &[], storage: &[QUAD, QUAD, Read, Write] },
    Kernel { name: "mi_smooth", stage: "mi_table", lanes: 64, sources: wgsl!("cost/mi_smooth", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "mi_marginals", stage: "mi_table", lanes: 64, sources: wgsl!("cost/mi_marginals", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "mi_range", stage: "mi_table", lanes: 256, sources: wgsl!("cost/mi_range", "cost/parts/mi_shared", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "mi_table", stage: "mi_table", lanes: 64, sources: wgsl!("cost/mi_table", "cost/parts/mi_shared", "shared/common"), choices: &[], storage: &[Read, Read, Read, Write] },
    Kernel { name: "cost_columns", stage: "cost_columns", lanes: 128, sources: wgsl!("cost/cost_columns", "cost/parts/differences", "shared/common"), choices: &[Choice::PixelPairs, Choice::Sums], storage: &[Read, Read, Write, Table] },
    Kernel { name: "matching_cost", stage: "matching_cost", lanes: 32, sources: wgsl!("cost/matching_cost", "cost/parts/column_sums", "cost/parts/differences", "cost/parts/quantise", "shared/common"), choices: &[Choice::Sums], storage: &[Read, Write] },
    Kernel { name: "matching_cost_pixels", stage: "matching_cost", lanes: 32, sources: wgsl!("cost/matching_cost_pixels", "cost/parts/right_bytes", "cost/parts/differences", "cost/parts/quantise", "shared/common"), choices: &[Choice::PixelCosts], storage: &[WORD, WORD, Write, Table] },
    Kernel { name: "matching_cost_parallel", stage: "matching_cost", lanes: 128, sources: wgsl!("cost/matching_cost_parallel", "cost/parts/differences", "cost/parts/quantise", "shared/common"), choices: &[Choice::PixelCosts], storage: &[Read, Read, Write, Table] },
    Kernel { name: "matching_cost_small", stage: "matching_cost", lanes: 32, sources: wgsl!("cost/matching_cost_small", "cost/parts/right_bytes", "cost/parts/differences", "cost/parts/quantise", "shared/common"), choices: &[Choice::PixelCosts], storage: &[WORD, WORD, Write, Table] },
    Kernel { name: "matching_cost_features", stage: "matching_cost", lanes: 32, sources: wgsl!("cost/matching_cost_features", "cost/parts/angles", "cost/parts/differences", "cost/parts/quantise", "shared/common"), choices: &[Choice::Products, Choice::Beside], storage: &[Read, Read, Write, Planes] },
    Kernel { name: "cost_columns_features", stage: "cost_columns", lanes: 128, sources: wgsl!("cost/cost_columns_features", "cost/parts/angles", "cost/parts/differences", "shared/common"), choices: &[Choice::Products, Choice::Beside, Choice::Sums], storage: &[Read, Read, Write, Planes] },
    Kernel { name: "sgm_aggregate", stage: "sgm_aggregate", lanes: STRIP_LANES, sources: wgsl!("paths/sgm_aggregate", "paths/parts/path_step", "shared/common"), choices: PATHS, storage: &[Costs, Write, Read, Write, Penalties] },
    Kernel { name: "second_cost", stage: "second_cost", lanes: STRIP_LANES, sources: wgsl!("paths/second_cost", "paths/parts/path_step", "paths/parts/row_step", "beliefs/parts/pairs", "shared/common"), choices: PATHS, storage: &[Costs, Read, Write, Read, Read, Penalties] },
    Kernel { name: "winner", stage: "winner", lanes: STRIP_LANES, sources: wgsl!("winner/winner", "paths/parts/path_step", "paths/parts/row_step", "winner/parts/winner_row", "winner/parts/refinement", "winner/parts/totals_pairs", "beliefs/parts/pairs", "shared/common"), choices: PATHS, storage: &[Costs, Read, Read, Read, Read, Write, Write, Penalties] },
    Kernel { name: "block_statistics", stage: "block_statistics", lanes: 32, sources: wgsl!("winner/block_statistics", "shared/root", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "block_match", stage: "block_match", lanes: 32, sources: wgsl!("winner/block_match", "cost/parts/column_sums", "winner/parts/costs", "winner/parts/totals_wide", "winner/parts/winner_row", "winner/parts/refinement", "shared/common"), choices: &[Choice::SharedPath, Choice::Sums, Choice::BlockCosts], storage: &[Read, Write, Write, Read] },
    Kernel { name: "block_match_small", stage: "block_match", lanes: 8, sources: wgsl!("winner/block_match_small", "winner/parts/refinement", "shared/common"), choices: &[], storage: &[WORD, WORD, Write, Write] },
    Kernel { name: "winner_beliefs", stage: "winner", lanes: STRIP_LANES, sources: wgsl!("winner/winner_beliefs", "beliefs/parts/received", "winner/parts/winner_row", "winner/parts/refinement", "winner/parts/totals_wide", "winner/parts/costs", "shared/common"), choices: &[Choice::SharedPath, Choice::Volumes, Choice::Cost], storage: &[Costs, Read, Read, Read, Write, Write] },
    Kernel { name: "network_input", stage: "network_input", lanes: 64, sources: wgsl!("network/network_input", "images/parts/samples", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "conv2d", stage: "conv2d", lanes: 32, sources: wgsl!("network/conv2d", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv2d_half", stage: "conv2d", lanes: 32, sources: wgsl!("network/conv2d_half", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv2d_dilated", stage: "conv2d", lanes: 32, sources: wgsl!("network/conv2d_dilated", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv2d_point", stage: "conv2d", lanes: 32, sources: wgsl!("network/conv2d_point", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv2d_point_half", stage: "conv2d", lanes: 32, sources: wgsl!("network/conv2d_point_half", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "average_pool", stage: "average_pool", lanes: 32, sources: wgsl!("network/average_pool", "network/parts/image_layer", "shared/common"), choices: &[Choice::Values], storage: &[Costs, Write] },
    Kernel { name: "upsample", stage: "upsample", lanes: 32, sources: wgsl!("network/upsample", "network/parts/between", "network/parts/image_layer", "shared/common"), choices: &[Choice::Values], storage: &[Costs, Write] },
    Kernel { name: "conv3d_volume", stage: "conv3d", lanes: 32, sources: wgsl!("network/conv3d_volume", "network/parts/convolution", "network/parts/layer", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv3d", stage: "conv3d", lanes: 32, sources: wgsl!("network/conv3d", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv3d_half", stage: "conv3d", lanes: 32, sources: wgsl!("network/conv3d_half", "network/parts/convolution", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: LAYER, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "conv3d_transposed", stage: "conv3d_transposed", lanes: 32, sources: wgsl!("network/conv3d_transposed", "network/parts/layer", "network/parts/line_own", "shared/common"), choices: TRANSPOSED, storage: &[Costs, Costs, Costs, Write] },
    Kernel { name: "disparity_regression", stage: "disparity_regression", lanes: 32, sources: wgsl!("network/disparity_regression", "network/parts/between", "network/parts/image_layer", "shared/common"), choices: &[Choice::Values], storage: &[Costs, Write] },
    Kernel { name: "round_disparities", stage: "round_disparities", lanes: 32, sources: wgsl!("network/round_disparities", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "texture_columns", stage: "texture", lanes: 32, sources: wgsl!("filters/texture_columns", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "texture", stage: "texture", lanes: 64, sources: wgsl!("filters/texture", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "mirror", stage: "mirror", lanes: 32, sources: wgsl!("winner/mirror", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "validity", stage: "validity", lanes: 32, sources: wgsl!("filters/validity", "filters/parts/check_octet", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "lr_check", stage: "lr_check", lanes: 32, sources: wgsl!("filters/lr_check", "filters/parts/check_octet", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "speckle_rows", stage: "speckle", lanes: 8, sources: wgsl!("filters/speckle/speckle_rows", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "speckle_link", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle_link", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees] },
    Kernel { name: "speckle_flatten", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle_flatten", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees] },
    Kernel { name: "speckle_count", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle_count", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees] },
    Kernel { name: "speckle", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees, Write] },
    Kernel { name: "fill_rows", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_rows", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, Write] },
    Kernel { name: "fill_lines", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_lines", "filters/fill/parts/line_octet", "filters/fill/parts/line_slots", "shared/bytes", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, Write] },
    Kernel { name: "fill_rows_medians", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_rows_medians", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, Write] },
    Kernel { name: "fill_rows_gray", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_rows_gray", "filters/fill/parts/keys", "filters/parts/gray_octet", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, QUAD] },
    Kernel { name: "fill_lines_gray", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_lines_gray", "filters/fill/parts/keys", "filters/fill/parts/line_octet", "filters/fill/parts/line_slots", "filters/parts/gray_octet", "shared/bytes", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, QUAD, Write] },
    Kernel { name: "fill_rays_weighted", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_rays_weighted", "filters/parts/gray_weight", "filters/fill/parts/line_slots", "filters/parts/gray_octet", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, QUAD, Read, Read, Read, Read] },
    Kernel { name: "fill_seen", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_seen", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "fill_between", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_between", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Read, Read, Write] },
    Kernel { name: "fill_rays", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_rays", "filters/fill/parts/line_slots", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Read, Read, Read, Read, Read, Write] },
    Kernel { name: "confidence", stage: "confidence", lanes: 64, sources: wgsl!("filters/confidence", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "depth", stage: "depth", lanes: 64, sources: wgsl!("filters/depth", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "median", stage: "median", lanes: 64, sources: wgsl!("filters/median", "filters/parts/map_octet", "filters/parts/invalidate_outside", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "median_five", stage: "median", lanes: 64, sources: wgsl!("filters/median_five", "filters/parts/median_of_25", "filters/parts/map_octet", "filters/parts/invalidate_outside", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "median_five_parallel", stage: "median", lanes: 64, sources: wgsl!("filters/median_five_parallel", "filters/parts/median_of_25", "filters/parts/map_octet", "filters/parts/invalidate_outside", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "weighted_median", stage: "weighted_median", lanes: 64, sources: wgsl!("filters/weighted_median", "filters/parts/weighted_keys", "filters/parts/gray_weight", "filters/parts/gray_octet", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, QUAD] },
    Kernel { name: "weighted_median_parallel", stage: "weighted_median", lanes: 64, sources: wgsl!("filters/weighted_median_parallel", "filters/parts/weighted_keys", "filters/parts/gray_weight", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, QUAD] },
    Kernel { name: "wls_start", stage: "wls", lanes: 64, sources: wgsl!("filters/wls/wls_start", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "wls_forward", stage: "wls", lanes: 8, sources: wgsl!("filters/wls/wls_forward", "filters/wls/parts/wls_line", "shared/common"), choices: &[], storage: &[Write, Write, Write, QUAD, Read] },
    Kernel { name: "wls_backward", stage: "wls", lanes: 8, sources: wgsl!("filters/wls/wls_backward", "filters/wls/parts/wls_line", "shared/common"), choices: &[], storage: &[Write, Write, Write] },
    Kernel { name: "wls", stage: "wls", lanes: 64, sources: wgsl!("filters/wls/wls", "shared/common"), choices: &[], storage: &[Read, Write] },
];

/// The name of a constant, and its value.
type Constant = (&'static str, fn(&Params) -> u32);

/// Constants that follow from the settings of a filter. A kernel that names one gets it.
pub(super) const SETTINGS: &[Constant] = &[
    ("SPACING", |params| median_spacing(params.weighted_median.unwrap_or(1))),
    ("DECAY", |params| median_decay(params.weighted_median_sigma)),
    ("SIXTEENTH_BITS", |params| wls_bits(params.disparities)),
];

impl Kernel {
    /// Invocations a workgroup. On a GPU those that walk a line each stay few: what a wave of them loads lies in as many rows.
    pub(crate) fn lanes(&self, plan: &Plan) -> u32 {
        match plan.per_subgroup {
            true if self.choices.contains(&Choice::SharedPath) => GROUP_LANES,
            true if self.lanes >= 32 => self.lanes.max(GROUP_LANES),
            _ => self.lanes,
        }
    }

    /// Invocations that work on one line of the kernel.
    pub(crate) fn members(&self, plan: &Plan) -> u32 {
        if self.choices.contains(&Choice::SharedPath) { plan.members } else { 1 }
    }

    pub(crate) fn storage(&self, params: &Params, plan: &Plan) -> Vec<Access> {
        let bound = |&access: &Access| match access {
            Costs => vec![if plan.per_subgroup { Read } else { QUAD }],
            Table if params.has_table() => vec![WORD],
            Penalties if plan.adaptive => vec![Read],
            Edges if params.smoothness_edge.is_some() => vec![QUAD],
            Planes if params.mixes_features() => vec![Read, Read],
            Table | Penalties | Edges | Planes => vec![],
            Trees => vec![Trees; plan.parts() as usize],
            access => vec![access],
        };
        self.storage.iter().flat_map(bound).collect()
    }

    /// All its WGSL but the constants.
    pub(super) fn fragments(&self, params: &Params, plan: &Plan) -> Vec<&'static str> {
        let pixel_costs = params.cost.row().fragments;
        let mut fragments = self.sources.to_vec();
        for choice in self.choices {
            let chosen: &[&str] = match choice {
                Choice::SharedPath => match plan.exchange {
                    Exchange::Alone => wgsl!("paths/parts/shared_path_alone", "paths/parts/shared_path"),
                    Exchange::Subgroup => wgsl!("paths/parts/shared_path_subgroup", "paths/parts/shared_path"),
                    Exchange::Workgroup => wgsl!("paths/parts/shared_path_workgroup", "paths/parts/shared_path"),
                },
                Choice::Volumes if plan.width == 1 => wgsl!("paths/parts/volume16"),
                Choice::Volumes => wgsl!("paths/parts/volume32"),
                Choice::Cost if plan.per_subgroup => wgsl!("paths/parts/cost_buffer"),
                Choice::Cost => wgsl!("paths/parts/cost_texels"),
                Choice::Penalty if plan.adaptive && params.adaptive_p1 => wgsl!("paths/parts/penalty_pairs"),
                Choice::Penalty if plan.adaptive => wgsl!("paths/parts/penalty_lines"),
                Choice::Penalty => wgsl!("paths/parts/penalty_fixed"),
                Choice::Smoothness => match params.smoothness {
                    Smoothness::Linear => wgsl!("beliefs/parts/smoothness_linear"),
                    Smoothness::Quadratic => wgsl!("beliefs/parts/smoothness_quadratic"),
                    Smoothness::Potts => wgsl!("beliefs/parts/smoothness_potts"),
                },
                Choice::Edges if params.smoothness_edge.is_some() => wgsl!("beliefs/parts/edges_lowered"),
                Choice::Edges => wgsl!("beliefs/parts/edges_fixed"),
                Choice::PixelCosts => pixel_costs,
                Choice::PixelPairs => {
                    fragments.extend(pixel_costs);
                    if params.pixel_max() <= 255 && !params.multiplies() {
                        wgsl!("cost/parts/pixel_pairs")
                    } else {
                        &[]
                    }
                }
                Choice::Sums if params.wide_sums() => wgsl!("cost/parts/sums32"),
                Choice::Sums => wgsl!("cost/parts/sums16"),
                Choice::BlockCosts if params.correlates() => wgsl!("winner/parts/block_costs_ncc"),
                Choice::BlockCosts => wgsl!("winner/parts/block_costs_sum"),
                Choice::Values if plan.per_subgroup => wgsl!("network/parts/values_buffer"),
                Choice::Values => wgsl!("network/parts/values_texels"),
                Choice::Weights if plan.per_subgroup => wgsl!("network/parts/weights_buffer"),
                Choice::Weights => wgsl!("network/parts/weights_texels"),
                // A GPU loads what all need once.
                Choice::Taps if !plan.per_subgroup && plan.subgroup >= TAP_LANES => {
                    wgsl!("network/parts/taps_subgroup")
                }
                Choice::Taps => wgsl!("network/parts/taps_alone"),
                // GPUs have an instruction for four products of bytes.
                Choice::Products if plan.per_subgroup => wgsl!("features/parts/products_packed"),
                Choice::Products => wgsl!("features/parts/products_float"),
                Choice::EightTexels if !plan.per_subgroup && plan.subgroup >= TAP_LANES => {
                    wgsl!("features/parts/texels_subgroup")
                }
                Choice::EightTexels => wgsl!("features/parts/texels_alone"),
                Choice::Beside if params.mixes_features() => {
                    fragments.extend(pixel_costs);
                    wgsl!("cost/parts/beside_census")
                }
                Choice::Beside => wgsl!("cost/parts/beside_nothing"),
                Choice::Trees if plan.part_bits.is_some() => wgsl!("filters/speckle/parts/speckle_parts"),
                Choice::Trees => wgsl!("filters/speckle/parts/speckle_trees"),
            };
            fragments.extend(chosen);
        }
        fragments
    }
}
