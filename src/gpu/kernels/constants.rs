//! The constants that specialise a kernel, a table for each subject.

use std::collections::HashSet;

use super::table::{Access, Kernel, SETTINGS};
use crate::PixelFormat;
use crate::gpu::layout::{NO_OWN, TEXELS};
use crate::gpu::plan::{FEATURE_SEGMENT, Plan, groups, paired, parts_and_strip, penalty_bytes, segment, span, vectors};
use crate::params::{Census, Descriptor, Params, Prefilter, Subpixel};
use crate::reference::LARGEST_TERM;

/// A constant: its name, its type and its value.
type Constant = (&'static str, &'static str, String);

fn number(name: &'static str, value: impl Into<u32>) -> Constant {
    (name, "u32", format!("{}u", value.into()))
}

/// How the work is spread over invocations.
fn schedule(kernel: &Kernel, params: &Params, plan: &Plan) -> Vec<Constant> {
    let (parts, strip) = parts_and_strip(params.disparities);
    vec![
        number("LANES", kernel.lanes(plan)),
        number("MEMBERS", plan.members),
        number("MEMBER_BITS", plan.members.ilog2()),
        number("OWN_QUADS", plan.own_quads),
        number("SLICES", plan.own_quads / plan.width),
        number("WIDTH", plan.width),
        number("SEGMENT", segment(plan)),
        number("COLUMN_ROWS", FEATURE_SEGMENT),
        number("VECTORS", vectors(params.quads(), plan)),
        number("SPAN", span(plan)),
        number("PARTS", parts),
        number("STRIP", strip),
    ]
}

/// The disparities and where they lie.
fn disparities(params: &Params) -> Vec<Constant> {
    let quads = params.quads();
    let padding = |word: u32| {
        let first = (quads - 1) * 16 + word * 4;
        let mask = (0..4).filter(|byte| first + byte >= params.disparities).map(|byte| 0xffu32 << (8 * byte));
        format!("{}u", mask.sum::<u32>())
    };
    let beyond: Vec<String> = (0..4).map(padding).collect();
    vec![
        number("DISPARITIES", params.disparities),
        number("QUADS", quads),
        number("TEXELS", TEXELS),
        ("BEYOND", "vec4<u32>", format!("vec4({})", beyond.join(", "))),
        number("SHIFTED", params.min_disparity != 0),
    ]
}

/// Images, and what becomes of them before the cost.
fn images(params: &Params, format: PixelFormat) -> Vec<Constant> {
    let [eighth, scale] = params.normalized_scales();
    vec![
        number("FORMAT", format as u32),
        number("DEEP", format.is_deep()),
        number("GRAY8", PixelFormat::Gray8 as u32),
        number("GRAY16", PixelFormat::Gray16 as u32),
        number("RGBA8", PixelFormat::Rgba8 as u32),
        number("PREFILTER", params.prefilter as u32),
        number("PREFILTER_XSOBEL", Prefilter::XSobel as u32),
        number("PREFILTER_NORMALIZED", Prefilter::Normalized as u32),
        number("PREFILTER_NONE", Prefilter::None as u32),
        number("PREFILTER_WINDOW", params.prefilter_window),
        number("OPENCV_RULES", params.opencv_rules),
        number("NORMALIZED_EIGHTH", eighth),
        number("NORMALIZED_SCALE", scale),
    ]
}

/// Blocks, and what is compared in them.
fn cost(params: &Params) -> Vec<Constant> {
    let names = Descriptor::IN_SHADERS.iter().map(|&(name, descriptor)| number(name, descriptor as u32));
    let values = [
        number("BLOCK", params.block),
        number("BLOCK_WORDS", (params.block + 6) / 4),
        number("SMALL_VALUES", params.descriptor_max() < 128),
        number("SUMMABLE", (255 / params.pixel_max()).max(1)),
        number("NARROWING", params.narrowing()),
        number("SCALE_SHIFT", params.scale_shift()),
        number("PLANES", params.compared_planes().max(1)),
        number("IMAGE_PLANES", (params.compared_planes() / params.described()).max(1)),
        number("DESCRIBED", params.described()),
        number("DESCRIPTOR", params.numeric_descriptor() as u32),
        number("AD_WEIGHT", params.ad_weight),
        number("CENSUS_WEIGHT", params.census_weight),
    ];
    values.into_iter().chain(names).collect()
}

/// Features, and how they are compared.
fn features(params: &Params, plan: &Plan) -> Vec<Constant> {
    vec![
        number("FEATURES", params.feature_planes()),
        number("FEATURE_OFFSET", (1 - params.min_disparity).rem_euclid(4) as u32),
        number("LEARNED_WEIGHT", params.learned_weight),
        number("GROUPS", groups(plan)),
    ]
}

/// The window of a census.
fn census(params: &Params) -> Vec<Constant> {
    let (columns, rows, above): (u32, u32, u32) = match params.census {
        Census::Five => (5, 5, 2),
        Census::Seven => (7, 7, 3),
        Census::NineBySeven => (9, 7, 3),
        Census::CentreSymmetric => (9, 3, 3),
    };
    vec![
        number("CENSUS", params.census as u32),
        number("CENSUS_SYMMETRIC", Census::CentreSymmetric as u32),
        number("CENSUS_PLANES", params.census_planes()),
        number("CENSUS_COLUMNS", columns),
        number("CENSUS_ROWS", rows),
        number("CENSUS_ABOVE", above),
    ]
}

/// Paths and the winner.
fn winner(kernel: &Kernel, params: &Params) -> Vec<Constant> {
    let before = kernel.storage.iter().position(|access| *access == Access::Penalties).unwrap_or(0);
    vec![
        number("PENALTIES", before as u32 + 2),
        number("PENALTY_BYTES", penalty_bytes(params)),
        number("P2_STEP", if params.adaptive_p2 { params.p2_step } else { 0 }),
        number("PATHS", params.paths.count()),
        number("PATH_BITS", params.paths.count().ilog2()),
        number("PAIRED", paired(params.paths)),
        number("SUBPIXEL", params.subpixel as u32),
        number("SUBPIXEL_OFF", Subpixel::Off as u32),
        number("SUBPIXEL_EQUIANGULAR", Subpixel::Equiangular as u32),
        number("UNIQUENESS", params.uniqueness),
        number("STEREO_BM", params.chooses_as_stereo_bm()),
        number("CONFIDENCE", params.confidence),
        number("LABELS", params.labels),
    ]
}

/// Belief propagation.
fn beliefs(params: &Params) -> Vec<Constant> {
    // No difference that costs less than the truncation takes more steps of one, not even where both are half.
    let [weight, truncation] = [params.smoothness_weight, params.smoothness_truncation];
    let steps = |shift: u32| ((truncation >> shift) / (weight >> shift).max(1)).isqrt();
    vec![
        number("LARGEST_TERM", LARGEST_TERM),
        number("SMOOTHNESS_WEIGHT", weight),
        number("SMOOTHNESS_TRUNCATION", truncation),
        ("SMOOTHNESS_EDGE", "i32", format!("{}", params.smoothness_edge.unwrap_or(0))),
        number("QUADRATIC_STEPS", steps(0).max(steps(1))),
    ]
}

/// The parts that the trees of the speckle filter lie in.
fn speckle_parts(plan: &Plan) -> Vec<Constant> {
    vec![number("PART_BITS", plan.part_bits.unwrap_or(0)), number("FILTERED", 3 + plan.parts())]
}

fn no_own(fragments: &[&str]) -> Option<&'static str> {
    fragments.iter().all(|text| !text.contains("struct Own {")).then_some(NO_OWN)
}

/// The constants of a kernel, as the WGSL line that is appended to `fragments`, its text: `override` constants cannot size the
/// arrays that hold a path's state. Only those that the text names are given, so that settings which do not concern a kernel do
/// not change its text, and the driver's cache finds it again.
pub(super) fn constants(
    kernel: &Kernel,
    fragments: &[&str],
    params: &Params,
    format: PixelFormat,
    plan: &Plan,
) -> String {
    let is_part_of_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: HashSet<&str> = fragments.iter().flat_map(|text| text.split(|c| !is_part_of_word(c))).collect();
    [
        schedule(kernel, params, plan),
        disparities(params),
        images(params, format),
        cost(params),
        census(params),
        features(params, plan),
        winner(kernel, params),
        beliefs(params),
        speckle_parts(plan),
        SETTINGS.iter().map(|&(name, value)| number(name, value(params))).collect(),
    ]
    .iter()
    .flatten()
    .filter(|(name, ..)| words.contains(name))
    .map(|(name, kind, value)| format!("const {name}: {kind} = {value}; "))
    .chain(no_own(fragments).map(str::to_string))
    .collect()
}
