//! How many rounds of loops an invocation of a kernel takes.
//!
//! lavapipe counts the rounds of all loops of an invocation together, those of inner loops for each round of the outer one, and
//! after [`MOST`] of them it leaves every loop, without a word. Loops that Mesa unrolls do not count: those to a constant of
//! at most [`MOST_TRIPS`](crate::gpu::plan::MOST_TRIPS), as long as naga puts no checks into them. So every kernel stays below that at
//! every size that is taken, on all devices alike: src/gpu/kernels/tests/rounds.rs compares what is counted here with what the
//! driver counts.

use crate::Params;
use crate::gpu::plan::{self, Plan};

/// The rounds after which lavapipe leaves all loops of an invocation.
pub(crate) const MOST: u32 = 65_535;

/// The longest side that is taken: a row and the smallest disparity take a round a pixel ([`rounds`]).
pub(crate) const MOST_SIDE: u32 = 60_000;

/// Groups of eight columns that are joined across a border of two bands at a time, so that no path to a root is long ([`rounds`]).
pub(crate) const SEGMENT_GROUPS: u32 = 128;

/// The side of the largest squares that a network averages.
const LARGEST_SQUARE: u32 = 64;

/// Blocks of four channels that a convolution reads at most: of an image, and of a volume.
const MOST_BLOCKS: u32 = 80;
const VOLUME_BLOCKS: u32 = 16;

/// Rounds of the loops over what an invocation of a convolution holds of a line, where checks keep them from being unrolled:
/// twelve weights, up to thirteen values, six sums for each of three taps, and more.
const LINE_ROUNDS: u32 = 64;

/// A loop of `count` rounds that take `inner` rounds of other loops each; the last one only finds that it is over.
fn repeated(count: u32, inner: u32) -> u32 {
    count * (1 + inner) + 1
}

/// Rounds of the loops over the state of a path, in each of its steps: naga's checks keep some of them from being unrolled. As
/// measured, and rounded up; the same of a row whose winners are chosen, if it `walks` a path as well.
fn over_path(params: &Params, plan: &Plan) -> u32 {
    if params.shader_checks && plan.own_quads > 4 { 2 * plan.own_quads + 4 } else { 0 }
}

fn over_row(params: &Params, plan: &Plan, walks: bool) -> u32 {
    if !params.shader_checks {
        return 0;
    }
    let own = plan.own_quads;
    let loops = match own {
        1 => 0,
        2 | 3 => 4,
        4 if walks => 11,
        4 => 4,
        5 | 6 => 5 * own - 2,
        _ => 7 * own + 6,
    };
    let margins = if params.confidence && own > 1 { 8 } else { 0 };
    let correlations = if params.correlates() { 2 * own } else { 0 };
    loops + margins + correlations
}

/// The most rounds of an invocation of a kernel for images of `width` x `height` pixels; `None` for kernels that only have
/// loops to constants, all of them together to fewer than [`MOST`].
pub(crate) fn rounds(kernel: &str, params: &Params, [width, height]: [u32; 2], plan: &Plan) -> Option<u32> {
    let (radius, shift) = (params.radius(), params.min_disparity.unsigned_abs());
    let (block, reach) = (2 * radius + 1, 2 * radius);
    let segment = plan::segment(plan);
    let eights = width.div_ceil(8);
    let checks = u32::from(params.shader_checks);
    let state = over_row(params, plan, kernel == "winner" || kernel == "second_cost");
    Some(match kernel {
        "window_columns" | "window_sums" => {
            repeated(block.max(params.prefilter_window), 0) + repeated(segment, repeated(4, 0))
        }
        "cost_columns" => {
            let (vectors, planes) = (plan::vectors(params.quads(), plan), params.planes());
            let row = repeated(planes, repeated(vectors + 1, 0)) + repeated(vectors, repeated(planes.max(8), 0));
            let added = repeated(vectors, repeated(4, 0));
            repeated(block, checks * (row + added)) + repeated(segment, checks * (2 * row + added))
        }
        "block_statistics" => {
            let row = repeated(params.block.div_ceil(4) + 2, repeated(4, 0));
            repeated(block, row) + repeated(segment, 2 * row + repeated(4, 0))
        }
        "texture_columns" => repeated(reach, 0) + repeated(segment, 0),
        "matching_cost" => repeated(reach, 0) + repeated(plan::span(plan).min(width), 0),
        "matching_cost_pixels" => repeated(width.div_ceil(4), checks * 8 * repeated(params.planes().max(8), 0)),
        // The four columns of a step are not unrolled.
        "matching_cost_small" => {
            let planes = params.planes();
            let (rows, column) = match planes {
                1 => (0, block + 4),
                _ => {
                    let rows = repeated(block + 1, repeated(planes, 0));
                    (rows, rows + (block + 1) * repeated(planes.max(8), 0) + repeated(4, repeated(block, 0)))
                }
            };
            repeated((width + reach).div_ceil(4), checks * rows + repeated(4, checks * column))
        }
        "matching_cost_parallel" => {
            let planes = repeated(params.planes().max(8), 0);
            let row = planes + repeated(block, 3 * planes);
            repeated(segment + reach, checks * (row + repeated(2, repeated(block, 0))))
        }
        "sgm_aggregate" => repeated(width.max(height), over_path(params, plan)),
        "second_cost" => repeated(width, state),
        "winner" => repeated(width + shift, state),
        "winner_beliefs" => repeated(width + shift, over_row(params, plan, true) + checks * (8 * plan.own_quads + 4)),
        "block_match" => repeated(reach, state) + repeated(width + shift, state),
        // Not with checks. Before the walk all of the first block's columns enter; then pixels of the right view are written that
        // no left one sees.
        "block_match_small" => {
            let (parts, strip) = plan::parts_and_strip(params.disparities);
            let slice = 4 * params.disparities.div_ceil(4 * parts);
            let unseen = if params.min_disparity > 0 {
                repeated(shift.min(width) / 2 + 2, repeated(strip / parts, 0))
            } else {
                0
            };
            let steps = (width + slice + block + shift).div_ceil(4) + 4;
            unseen + 2 + repeated(steps, repeated(4, 0))
        }
        "speckle_rows" => repeated(eights, repeated(2, 0)),
        // src/gpu/chain/filters/speckle.rs joins the runs of `SEGMENT_GROUPS` eights of all borders at a time. Only roots get other parents, and only
        // roots of the upper band become them. So a way to a root has at most 8 * SEGMENT_GROUPS of those, and what it had before
        // in each band: one pixel for each segment of each border so far. `speckle_flatten` walks eight times a way from above, to
        // look for the root, and one from above and one from below; `speckle_link` goes up the ways to two roots.
        "speckle_link" | "speckle_flatten" | "speckle_count" => {
            let groups = eights.min(SEGMENT_GROUPS);
            let flat = eights.div_ceil(SEGMENT_GROUPS) * (height.next_power_of_two().ilog2());
            8 * (3 * (8 * groups + flat) + flat + 4)
        }
        "speckle" => repeated(8, 0),
        "wls_forward" | "wls_backward" => repeated(width.max(height), 0),
        name if name.starts_with("fill_") => return fill_rounds(kernel, params, [width, height]),
        name if name.contains("feature") => return feature_rounds(kernel, params),
        _ => return network_rounds(kernel, params),
    })
}

/// The same of the kernels that fill holes.
fn fill_rounds(kernel: &str, params: &Params, [width, height]: [u32; 2]) -> Option<u32> {
    let eights = width.div_ceil(8);
    Some(match kernel {
        "fill_rays" | "fill_rays_weighted" => repeated(8, repeated(8, 0)),
        "fill_rows" | "fill_rows_gray" => repeated(eights, 0),
        // The row, eight times three eights of five rows for the slope, and the strip.
        "fill_rows_medians" => 2 * repeated(eights, 0) + repeated(8, repeated(5, repeated(3, 0))),
        "fill_lines" | "fill_lines_gray" => repeated(height, 0),
        // The columns that eight right pixels lead to lie within all disparities, and each is marked in words of 32.
        "fill_seen" => repeated(8, 0) + 9 * repeated(params.disparities.min(width) / 32 + 3, 0),
        _ => return None,
    })
}

/// The same of the kernels that make features and compare them.
fn feature_rounds(kernel: &str, params: &Params) -> Option<u32> {
    let checks = u32::from(params.shader_checks);
    // Of loops over 16 channels of four columns, which compilers unroll or not.
    let sums = 512;
    Some(match kernel {
        // A step is sixteen inputs, or three columns of a row of four, of at most 128.
        "feature_point" => repeated(8, sums) + sums,
        "feature_convolution" => repeated(3 * 32, sums) + sums,
        "cost_columns_features" => {
            let row = repeated(32, checks * 18) + checks * 64;
            repeated(2 * params.radius() + 1, row) + repeated(plan::FEATURE_SEGMENT, 2 * row + checks * 64)
        }
        _ => return None,
    })
}

/// The same of the kernels of a network.
fn network_rounds(kernel: &str, params: &Params) -> Option<u32> {
    let line = if params.shader_checks { LINE_ROUNDS } else { 0 };
    Some(match kernel {
        "average_pool" => repeated(LARGEST_SQUARE, repeated(LARGEST_SQUARE, 0)),
        "disparity_regression" => repeated(2, repeated(params.disparities, 0)),
        name if name.starts_with("conv2d") => repeated(MOST_BLOCKS, repeated(1, repeated(3, line))) + line,
        name if name.starts_with("conv3d") => repeated(VOLUME_BLOCKS, repeated(3, repeated(3, line))) + line,
        _ => return None,
    })
}
