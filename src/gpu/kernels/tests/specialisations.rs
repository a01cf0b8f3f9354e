//! The settings and plans that between them make every text of every kernel.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use wgpu::naga;

use crate::gpu::kernels::table::Kernel;
use crate::gpu::kernels::{KERNELS, source};
use crate::gpu::plan::{Exchange, Plan};
use crate::params::Named;
use crate::{Census, Cost, Median, Method, Params, Paths, PixelFormat, Prefilter, Smoothness, Subpixel, Wls};

/// Plans for devices with and without subgroups and 64-bit integers.
pub(crate) fn plans(params: &Params) -> BTreeSet<Plan> {
    let devices =
        [(false, 1, false), (false, 1, true), (false, 8, true), (true, 1, false), (true, 4, true), (true, 32, true)];
    let adaptive = params.adapts_penalties();
    let of = |&(per_subgroup, subgroup, int64)| {
        let part_bits = (subgroup == 8).then_some(20);
        Plan { adaptive, part_bits, ..Plan::of(params.quads(), per_subgroup, subgroup, int64) }
    };
    devices.iter().map(of).collect()
}

/// Settings that between them give every constant of [`constants`] every kind of value.
pub(crate) fn specialisations() -> Vec<(Params, PixelFormat, Plan)> {
    let formats = [PixelFormat::Gray8, PixelFormat::Gray16, PixelFormat::Rgba8, PixelFormat::Rgba16];
    let mut all = Vec::new();
    for disparities in [1, 16, 17, 64, 65, 256] {
        for paths in [Paths::Three, Paths::Five, Paths::Eight, Paths::Sixteen] {
            for prefilter in [Prefilter::XSobel, Prefilter::Sobel, Prefilter::None] {
                for base in [Params::sgm(disparities), Params::bm(disparities)] {
                    for subpixel in [Subpixel::Off, Subpixel::Parabola, Subpixel::Equiangular] {
                        if subpixel == Subpixel::Equiangular && paths != Paths::Three {
                            continue; // one function differs, whatever the paths
                        }
                        let confidence = subpixel == Subpixel::Equiangular;
                        let adaptive_p2 = prefilter == Prefilter::None && base.method == crate::Method::Sgm;
                        let labels = subpixel == Subpixel::Off;
                        let adaptive_p1 = adaptive_p2 && subpixel == Subpixel::Parabola;
                        let params = Params { paths, prefilter, subpixel, confidence, labels, ..base.clone() };
                        let params = Params { adaptive_p1, adaptive_p2, ..params };
                        let params = Params { block: if subpixel == Subpixel::Off { 21 } else { 5 }, ..params };
                        // A filter of each kind, and every spacing of the weighted median.
                        let params = Params {
                            median: if subpixel == Subpixel::Off { Median::Five } else { Median::Three },
                            weighted_median: Some(disparities % 15 + 1),
                            wls: Some(Wls { lambda: 8000.0, sigma: 1.5 }),
                            ..params
                        };
                        for (i, plan) in plans(&params).into_iter().enumerate() {
                            let formats = formats.iter().take(if i == 0 { 4 } else { 1 });
                            all.extend(formats.map(|&format| (params.clone(), format, plan)));
                        }
                    }
                }
            }
        }
    }
    for disparities in [1, 17, 64, 65, 256] {
        for (i, &smoothness) in Smoothness::VALUES.iter().enumerate() {
            for (smoothness_edge, subpixel) in [(None, Subpixel::Off), (Some(10), Subpixel::Parabola)] {
                let confidence = i == 1;
                let params = Params { smoothness, smoothness_edge, subpixel, confidence, ..Params::bp(disparities) };
                all.extend(plans(&params).into_iter().map(|plan| (params.clone(), formats[0], plan)));
            }
        }
    }
    for &cost in Cost::VALUES {
        for (block, census, color_cost) in [
            (1, Census::NineBySeven, false),
            (5, Census::CentreSymmetric, true),
            (5, Census::Five, false),
            (21, Census::Seven, false),
        ] {
            let row = cost.row();
            let base = if row.methods.contains(&Method::Sgm) { Params::sgm(40) } else { Params::bm(40) };
            let block = block.clamp(*row.blocks.start(), *row.blocks.end());
            let base = Params { cost, block, census, prefilter: Prefilter::None, ..base };
            for prefilter in [Prefilter::Normalized, Prefilter::None] {
                let params = Params { prefilter, color_cost: color_cost && row.color, ..base.clone() };
                all.extend(plans(&params).into_iter().map(|plan| (params.clone(), formats[1], plan)));
            }
        }
    }
    all
}

/// The [`specialisations`] that a kernel is for.
pub(crate) fn specialisations_of(kernel: &Kernel) -> impl Iterator<Item = (Params, PixelFormat, Plan)> {
    let name = kernel.name;
    specialisations().into_iter().filter(move |(params, ..)| match name {
        // What compares pixels by other means than features.
        "descriptors" => params.compared_planes() > 0,
        "cost_columns" if params.feature_planes() > 0 => false,
        "cost_columns_features" => params.feature_planes() > 0,
        "matching_cost_features" => params.feature_planes() > 0 && params.sums_small_blocks(),
        _ if kernel.stage.starts_with("feature") => params.feature_planes() > 0,
        "matching_cost_pixels" | "matching_cost_small" | "matching_cost_parallel" if params.feature_planes() > 0 => {
            false
        }
        "block_match_small" => params.block <= Params::SMALL_BLOCK && params.cost.row().small_match,
        "matching_cost_pixels" => params.sums_small_blocks() && params.block == 1,
        "matching_cost_small" | "matching_cost_parallel" => params.sums_small_blocks(),
        "coarse_cost" | "coarse_cost_sums" | "messages_start" | "messages" | "messages_coarse" | "winner_beliefs" => {
            params.method == Method::Bp
        }
        "network_input" => params.disparities == 16,
        _ if kernel.sources[0].contains("// Reference: src/reference/network/") => {
            params.method == Method::Sgm && [16, 64].contains(&params.disparities)
        }
        _ => true,
    })
}

/// The different texts of a kernel; of each the specialisations that differ in what they bind, at least one.
type Texts = BTreeMap<String, Vec<(Params, PixelFormat, Plan)>>;

/// Made once: most specialisations give a text that another one has given.
static TEXTS: LazyLock<BTreeMap<&str, Texts>> = LazyLock::new(|| {
    let texts = |kernel: &Kernel| {
        let mut texts = Texts::new();
        for (params, format, plan) in specialisations_of(kernel) {
            let of_text = texts.entry(source(kernel, &params, format, &plan)).or_default();
            let bound = kernel.storage(&params, &plan);
            if of_text.iter().all(|(params, _, plan)| kernel.storage(params, plan) != bound) {
                of_text.push((params, format, plan));
            }
        }
        texts
    };
    KERNELS.iter().map(|kernel| (kernel.name, texts(kernel))).collect()
});

/// The different texts of a kernel with specialisations that give them.
pub(crate) fn specialised(kernel: &Kernel) -> &'static Texts {
    &TEXTS[kernel.name]
}

/// The different texts of a kernel.
pub(crate) fn texts(kernel: &Kernel) -> impl ExactSizeIterator<Item = &'static str> {
    specialised(kernel).keys().map(String::as_str)
}

/// The text of every specialised kernel and of what is not in the table, with its name.
pub(crate) fn every_text() -> impl Iterator<Item = (&'static str, &'static str)> {
    static OTHERS: LazyLock<Vec<(&str, String)>> = LazyLock::new(|| crate::gpu::interop::texts().collect());
    let kernels = KERNELS.iter().flat_map(|kernel| texts(kernel).map(|text| (kernel.name, text)));
    kernels.chain(OTHERS.iter().map(|(name, text)| (*name, text.as_str())))
}

pub(crate) fn parse(kernel: &Kernel, text: &str) -> naga::Module {
    match naga::front::wgsl::parse_str(text) {
        Ok(module) => module,
        Err(error) => panic!("{}.wgsl: {}", kernel.name, error.emit_to_string(text)),
    }
}

/// What the kernels may use beyond WebGPU, where a device has it.
pub(crate) const CAPABILITIES: naga::valid::Capabilities =
    naga::valid::Capabilities::SUBGROUP.union(naga::valid::Capabilities::SHADER_INT64);

/// A plan for 64 disparities.
pub(crate) const PLAN: Plan = Plan {
    per_subgroup: false,
    members: 1,
    exchange: Exchange::Alone,
    own_quads: 4,
    subgroup: 1,
    threads: None,
    width: 1,
    adaptive: false,
    part_bits: None,
};
