//! Settings that show what a changed kernel breaks.

use super::support;
use crate::{Cost, Fill, Median, Params, Paths, Prefilter, RightView, Schedule, Smoothness, Subpixel, Wls};

/// An adapter, its device and its queue.
pub(crate) type Setup = (wgpu::Adapter, wgpu::Device, wgpu::Queue);

pub(crate) fn bm(params: &mut Params) {
    *params = Params { min_disparity: params.min_disparity, ..Params::bm(params.disparities) };
}

/// Belief propagation on three levels.
pub(crate) fn bp(params: &mut Params) {
    let Params { min_disparity, disparities, schedule, .. } = *params;
    *params = Params { min_disparity, schedule, bp_levels: 3, bp_iterations: 5, ..Params::bp(disparities) };
    // Large messages, in which every rounding shows.
    (params.smoothness_weight, params.smoothness_truncation) = (8, 40);
}

/// A network of every kind of operation, and no filter.
pub(crate) fn network(params: &mut Params) {
    *params = Params::psmnet(32, crate::network::tiny::tiny(3));
}

/// A cost by the features of a network that has every kind of layer.
pub(crate) fn learned(params: &mut Params) {
    (params.cost, params.prefilter, params.block) = (Cost::Learned, Prefilter::None, 1);
    params.features = Some(crate::features::tiny());
}

/// The same beside a census.
pub(crate) fn learned_census(params: &mut Params) {
    learned(params);
    (params.cost, params.learned_weight) = (Cost::LearnedCensus, 33);
}

/// The same by invocations that sum products of packed bytes.
pub(crate) fn learned_packed(params: &mut Params) {
    per_subgroup(params);
    learned(params);
}

/// The same over blocks.
pub(crate) fn learned_blocks(params: &mut Params) {
    learned(params);
    params.block = 3;
}

/// The same, where interpolation lays the outer corners of pixels on each other.
pub(crate) fn network_pixels(params: &mut Params) {
    network(params);
    params.align_corners = false;
}

/// The same, where the gray image has edges.
pub(crate) fn bp_edges(params: &mut Params) {
    bp(params);
    params.smoothness_edge = Some(9);
}

/// The same with the square of the differences.
pub(crate) fn bp_quadratic(params: &mut Params) {
    bp(params);
    (params.smoothness, params.smoothness_weight, params.smoothness_truncation) = (Smoothness::Quadratic, 3, 60);
}

/// The same for invocations that share a pixel's disparities.
pub(crate) fn bp_shared(params: &mut Params) {
    per_subgroup(params);
    bp(params);
    (params.smoothness_weight, params.smoothness_truncation) = (1, 127);
}

/// Block matching with the column sums kept in memory.
pub(crate) fn bm_columns(params: &mut Params) {
    bm(params);
    params.shader_checks = true;
}

/// Block matching by normalised cross correlation.
pub(crate) fn ncc(params: &mut Params) {
    bm(params);
    (params.cost, params.block) = (Cost::Ncc, 7);
}

/// A range whose last disparities win, and those beyond it would.
pub(crate) fn bm_far(params: &mut Params) {
    bm(params);
    params.min_disparity = -14;
}

/// Blocks of one pixel, whose sums are often equal.
pub(crate) fn bm_pixel(params: &mut Params) {
    bm(params);
    (params.block, params.prefilter_cap, params.uniqueness) = (1, 4, 50);
}

/// A block for which the column sums are kept in memory.
pub(crate) fn stereo_bm(params: &mut Params) {
    bm(params);
    params.opencv_rules = true;
}

/// Blocks of a pixel and few values: many equal costs.
pub(crate) fn stereo_bm_ties(params: &mut Params) {
    bm_pixel(params);
    (params.opencv_rules, params.uniqueness, params.min_disparity) = (true, 0, -14);
}

pub(crate) fn stereo_bm_texture(params: &mut Params) {
    texture(params);
    (params.opencv_rules, params.median) = (true, Median::Off);
}

pub(crate) fn stereo_bm_columns(params: &mut Params) {
    stereo_bm_ties(params);
    params.shader_checks = true;
}

pub(crate) fn wide(params: &mut Params) {
    params.block = 17;
}

pub(crate) fn rectify(params: &mut Params) {
    params.rectify = Some(crate::Rectification::new(93, 41, support::lenses(93, 41)).unwrap());
}

/// Parts of both images are masked, the last column of the left one in every other row among them.
pub(crate) fn masked(params: &mut Params) {
    let masks = support::masks(93, 41, 3);
    let [mut left, right] = [0, 1].map(|side| masks.side(side).map_or(vec![1; 93 * 41], <[u8]>::to_vec));
    left.chunks_exact_mut(93).step_by(2).for_each(|row| row[92] = 0);
    params.masks = Some(crate::Masks::new(93, 41, [Some(left), Some(right)]).unwrap());
    (params.uniqueness, params.right_map) = (0, true);
}

pub(crate) fn depth(params: &mut Params) {
    params.depth = Some(crate::Camera { doffs: 3.3, ..crate::Camera::new(994.978, 0.193) });
}

/// Settings that leave wrong winners in the map: those that point outside the right image by a fraction among them.
pub(crate) fn any(params: &mut Params) {
    (params.p1, params.p2, params.uniqueness) = (12, 72, 0);
}

pub(crate) fn five(params: &mut Params) {
    params.median = Median::Five;
}

pub(crate) fn weighted(params: &mut Params) {
    (params.weighted_median, params.uniqueness) = (Some(5), 0);
}

pub(crate) fn five_parallel(params: &mut Params) {
    five(params);
    params.schedule = Schedule::PerSubgroup;
}

pub(crate) fn weighted_parallel(params: &mut Params) {
    weighted(params);
    params.schedule = Schedule::PerSubgroup;
}

pub(crate) fn wls(params: &mut Params) {
    params.wls = Some(Wls { lambda: 50.0, sigma: 20.0 });
}

pub(crate) fn eight_paths(params: &mut Params) {
    params.paths = Paths::Eight;
}

pub(crate) fn adaptive(params: &mut Params) {
    (params.adaptive_p2, params.p1, params.p2) = (true, 9, 100);
}

/// Small penalties that depend on the image, too.
pub(crate) fn adaptive_both(params: &mut Params) {
    adaptive(params);
    (params.adaptive_p1, params.p1, params.p2_step) = (true, 40, 6);
}

pub(crate) fn two_passes(params: &mut Params) {
    params.passes = 2;
}

pub(crate) fn twice(params: &mut Params) {
    params.right_view = RightView::Match;
}

pub(crate) fn sixteen(params: &mut Params) {
    adaptive(params);
    params.paths = Paths::Sixteen;
}

pub(crate) fn equiangular(params: &mut Params) {
    params.subpixel = Subpixel::Equiangular;
}

/// A threshold about which many sums lie, and are equal to.
pub(crate) fn texture(params: &mut Params) {
    (params.texture, params.prefilter_cap, params.uniqueness) = (60, 3, 0);
}

pub(crate) fn confidence(params: &mut Params) {
    params.confidence = true;
}

pub(crate) fn labels(params: &mut Params) {
    params.labels = true;
}

/// Holes of many sizes, most of them mismatches.
pub(crate) fn rays(params: &mut Params) {
    (params.p1, params.p2, params.fill) = (2, 9, Fill::Rays);
}

/// The same, with grays that differ by a few sigma.
pub(crate) fn weighted_rays(params: &mut Params) {
    rays(params);
    (params.fill, params.weighted_median_sigma) = (Fill::WeightedRays, 9);
}

/// The same with strips at both ends of rows.
pub(crate) fn weighted_strips(params: &mut Params) {
    weighted_rays(params);
    params.min_disparity = -20;
}

/// Weights of 1 wherever grays differ by a few levels, and so many ties.
pub(crate) fn counted_rays(params: &mut Params) {
    weighted_rays(params);
    params.weighted_median_sigma = 1;
}

/// Small regions of many sizes.
pub(crate) fn speckle(params: &mut Params) {
    (params.p1, params.p2, params.lr_check) = (0, 3, None);
    (params.speckle_window, params.speckle_range) = (6, 1);
}

/// Invocations that share a pixel's disparities.
pub(crate) fn per_subgroup(params: &mut Params) {
    (params.schedule, params.disparities) = (Schedule::PerSubgroup, 50);
}

/// A cost that is looked up in a table, on images that are halved once.
pub(crate) fn mutual(params: &mut Params) {
    (params.cost, params.prefilter, params.block) = (Cost::MutualInformation, Prefilter::None, 1);
}
