//! The table of kernels: everything that turns a WGSL file into a pipeline.

use std::collections::HashSet;

use crate::gpu::layout::{Frame, Pass, TEXELS};
use crate::gpu::plan::{Exchange, GROUP_LANES, Plan, STRIP_LANES, paired, parts_and_strip, segment, span, vectors};
use crate::params::{Census, Cost, Params, Prefilter, Subpixel};
use crate::reference::{median_decay, median_spacing, wls_bits};
use crate::{Error, PixelFormat};

/// What a kernel does with a storage resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
    /// A texture of this format, read as a storage texture.
    Texels(wgpu::TextureFormat),
    /// The cost, read as the plan has it: from a texture or from its buffer.
    Costs,
    /// What pairs of values cost: there only for [`Cost::MutualInformation`].
    Table,
    /// The penalties of the pixels, where the plan has them.
    Penalties,
    /// The trees of the speckle filter, written: one binding, or its parts.
    Trees,
}
use Access::{Costs, Penalties, Read, Table, Texels, Trees, Write};

/// Fragments of which the plan or the settings choose some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// How invocations share the disparities of a pixel.
    SharedPath,
    /// How many disparities a load or store moves, and where the cost is read.
    Volumes,
    /// Where P2 comes from.
    Penalty,
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
}

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
    lanes: u32,
    /// The storage resources from binding 2 on; 0 and 1 are the uniform blocks.
    pub(crate) storage: &'static [Access],
}

macro_rules! wgsl {
    ($($file:literal),+) => { &[$(include_str!(concat!("../../../shaders/", $file, ".wgsl"))),+] };
}

const PATHS: &[Choice] = &[Choice::SharedPath, Choice::Volumes, Choice::Penalty];

#[rustfmt::skip]
pub(crate) const KERNELS: &[Kernel] = &[
    Kernel { name: "rectify", stage: "rectify", lanes: 64, sources: wgsl!("images/rectify", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
    Kernel { name: "gray", stage: "gray", lanes: 64, sources: wgsl!("images/gray", "images/parts/samples", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "deep_gray", stage: "gray", lanes: 64, sources: wgsl!("images/deep_gray", "images/parts/samples", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "window_columns", stage: "window_sums", lanes: 64, sources: wgsl!("images/window_columns", "images/parts/gray_pixels", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "window_sums", stage: "window_sums", lanes: 64, sources: wgsl!("images/window_sums", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "prefilter", stage: "prefilter", lanes: 64, sources: wgsl!("images/prefilter", "shared/root", "images/parts/gray_pixels", "images/parts/plane_layout", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
    Kernel { name: "descriptors", stage: "descriptors", lanes: 64, sources: wgsl!("cost/descriptors", "images/parts/gray_pixels", "images/parts/plane_layout", "shared/bytes", "shared/common"), choices: &[], storage: &[QUAD, Read, Write] },
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
    Kernel { name: "sgm_aggregate", stage: "sgm_aggregate", lanes: STRIP_LANES, sources: wgsl!("paths/sgm_aggregate", "paths/parts/path_step", "shared/common"), choices: PATHS, storage: &[Costs, Write, Read, Write, Penalties] },
    Kernel { name: "winner", stage: "winner", lanes: STRIP_LANES, sources: wgsl!("winner/winner", "paths/parts/path_step", "winner/parts/winner_row", "winner/parts/refinement", "winner/parts/costs", "shared/common"), choices: PATHS, storage: &[Costs, Read, Read, Read, Read, Write, Write, Penalties] },
    Kernel { name: "block_statistics", stage: "block_statistics", lanes: 32, sources: wgsl!("winner/block_statistics", "shared/root", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "block_match", stage: "block_match", lanes: 32, sources: wgsl!("winner/block_match", "cost/parts/column_sums", "winner/parts/costs", "winner/parts/winner_row", "winner/parts/refinement", "shared/common"), choices: &[Choice::SharedPath, Choice::Sums, Choice::BlockCosts], storage: &[Read, Write, Write, Read] },
    Kernel { name: "block_match_small", stage: "block_match", lanes: 8, sources: wgsl!("winner/block_match_small", "winner/parts/refinement", "shared/common"), choices: &[], storage: &[WORD, WORD, Write, Write] },
    Kernel { name: "texture_columns", stage: "texture", lanes: 32, sources: wgsl!("filters/texture_columns", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "texture", stage: "texture", lanes: 64, sources: wgsl!("filters/texture", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "mirror", stage: "mirror", lanes: 32, sources: wgsl!("winner/mirror", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "validity", stage: "validity", lanes: 32, sources: wgsl!("filters/validity", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "lr_check", stage: "lr_check", lanes: 32, sources: wgsl!("filters/lr_check", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "speckle_rows", stage: "speckle", lanes: 8, sources: wgsl!("filters/speckle/speckle_rows", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "speckle_link", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle_link", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees] },
    Kernel { name: "speckle_flatten", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle_flatten", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees] },
    Kernel { name: "speckle_count", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle_count", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees] },
    Kernel { name: "speckle", stage: "speckle", lanes: 32, sources: wgsl!("filters/speckle/speckle", "filters/speckle/parts/speckle_root", "filters/speckle/parts/speckle_joins", "filters/parts/map_octet", "shared/common"), choices: &[Choice::Trees], storage: &[QUAD, Trees, Write] },
    Kernel { name: "fill_rows", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_rows", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, Write] },
    Kernel { name: "fill_lines", stage: "fill", lanes: 8, sources: wgsl!("filters/fill/fill_lines", "shared/bytes", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, Write] },
    Kernel { name: "fill_seen", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_seen", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "fill_between", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_between", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Read, Read, Write] },
    Kernel { name: "fill_rays", stage: "fill", lanes: 32, sources: wgsl!("filters/fill/fill_rays", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Read, Read, Read, Read, Read, Write] },
    Kernel { name: "confidence", stage: "confidence", lanes: 64, sources: wgsl!("filters/confidence", "shared/common"), choices: &[], storage: &[Read, Read, Write] },
    Kernel { name: "depth", stage: "depth", lanes: 64, sources: wgsl!("filters/depth", "shared/common"), choices: &[], storage: &[Read, Write] },
    Kernel { name: "median", stage: "median", lanes: 64, sources: wgsl!("filters/median", "filters/parts/map_octet", "filters/parts/invalidate_outside", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "median_five", stage: "median", lanes: 64, sources: wgsl!("filters/median_five", "filters/parts/map_octet", "filters/parts/invalidate_outside", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "weighted_median", stage: "weighted_median", lanes: 64, sources: wgsl!("filters/weighted_median", "filters/parts/map_octet", "shared/common"), choices: &[], storage: &[QUAD, Write, QUAD] },
    Kernel { name: "wls_start", stage: "wls", lanes: 64, sources: wgsl!("filters/wls/wls_start", "shared/common"), choices: &[], storage: &[QUAD, Write] },
    Kernel { name: "wls_forward", stage: "wls", lanes: 8, sources: wgsl!("filters/wls/wls_forward", "filters/wls/parts/wls_line", "shared/common"), choices: &[], storage: &[Write, Write, Write, QUAD, Read] },
    Kernel { name: "wls_backward", stage: "wls", lanes: 8, sources: wgsl!("filters/wls/wls_backward", "filters/wls/parts/wls_line", "shared/common"), choices: &[], storage: &[Write, Write, Write] },
    Kernel { name: "wls", stage: "wls", lanes: 64, sources: wgsl!("filters/wls/wls", "shared/common"), choices: &[], storage: &[Read, Write] },
];

impl Kernel {
    /// Invocations a workgroup.
    pub(crate) fn lanes(&self, plan: &Plan) -> u32 {
        if plan.per_subgroup && self.choices.contains(&Choice::SharedPath) { GROUP_LANES } else { self.lanes }
    }

    /// Invocations that work on one line of the kernel.
    pub(crate) fn members(&self, plan: &Plan) -> u32 {
        if self.choices.contains(&Choice::SharedPath) { plan.members } else { 1 }
    }

    pub(crate) fn storage(&self, params: &Params, plan: &Plan) -> Vec<Access> {
        let bound = |&access: &Access| match access {
            Costs => vec![if plan.per_subgroup { Read } else { QUAD }],
            Table if params.cost == Cost::MutualInformation => vec![WORD],
            Penalties if plan.adaptive => vec![Read],
            Table | Penalties => vec![],
            Trees => vec![Trees; plan.parts() as usize],
            access => vec![access],
        };
        self.storage.iter().flat_map(bound).collect()
    }

    /// All its WGSL but the constants.
    fn fragments(&self, params: &Params, plan: &Plan) -> Vec<&'static str> {
        let pixel_costs = match params.cost {
            Cost::Sad | Cost::ZeroMeanSad | Cost::SadXy => wgsl!("cost/parts/pixel_sad"),
            Cost::Ncc => wgsl!("cost/parts/pixel_ncc"),
            Cost::Ssd => wgsl!("cost/parts/pixel_ssd"),
            Cost::MutualInformation => wgsl!("cost/parts/pixel_mi"),
            Cost::BirchfieldTomasi => wgsl!("cost/parts/pixel_bt"),
            Cost::Census | Cost::CensusSobel | Cost::AdCensus => wgsl!("cost/parts/pixel_census"),
        };
        let mut fragments = self.sources.to_vec();
        for choice in self.choices {
            let chosen: &[&str] = match choice {
                Choice::SharedPath => match plan.exchange {
                    Exchange::Alone => wgsl!("paths/parts/shared_path_alone", "paths/parts/shared_path"),
                    Exchange::Subgroup => wgsl!("paths/parts/shared_path_subgroup", "paths/parts/shared_path"),
                    Exchange::Workgroup => wgsl!("paths/parts/shared_path_workgroup", "paths/parts/shared_path"),
                },
                Choice::Volumes => match (plan.per_subgroup, plan.width) {
                    (true, _) => wgsl!("paths/parts/volume16", "paths/parts/cost_buffer"),
                    (false, 1) => wgsl!("paths/parts/volume16", "paths/parts/cost_texels"),
                    (false, _) => wgsl!("paths/parts/volume32", "paths/parts/cost_texels"),
                },
                Choice::Penalty if plan.adaptive => wgsl!("paths/parts/penalty_lines"),
                Choice::Penalty => wgsl!("paths/parts/penalty_fixed"),
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
                Choice::BlockCosts if params.cost == Cost::Ncc => wgsl!("winner/parts/block_costs_ncc"),
                Choice::BlockCosts => wgsl!("winner/parts/block_costs_sum"),
                Choice::Trees if plan.part_bits.is_some() => wgsl!("filters/speckle/parts/speckle_parts"),
                Choice::Trees => wgsl!("filters/speckle/parts/speckle_trees"),
            };
            fragments.extend(chosen);
        }
        fragments
    }
}

/// The constants that specialise a kernel, as the WGSL line that is appended to it: `override` constants cannot size
/// the arrays that hold a path's state. Only those that the source names are given, so that settings which do not
/// concern a kernel do not change its text (and the driver's cache finds it again).
pub(crate) fn constants(kernel: &Kernel, params: &Params, format: PixelFormat, plan: &Plan) -> String {
    let quads = params.quads();
    let beyond: Vec<String> = (0..4)
        .map(|word| {
            let first = (quads - 1) * 16 + word * 4;
            let mask = (0..4).filter(|byte| first + byte >= params.disparities).map(|byte| 0xffu32 << (8 * byte));
            format!("{}u", mask.sum::<u32>())
        })
        .collect();
    let paired = paired(params.paths);
    let penalties = kernel.storage.iter().position(|access| *access == Penalties).unwrap_or(0) as u32 + 2;
    let (parts, strip) = parts_and_strip(params.disparities);
    let census_planes = match params.cost {
        Cost::Census | Cost::CensusSobel | Cost::AdCensus => params.census_planes(),
        _ => 0,
    };
    let (census_columns, census_rows, census_above) = match params.census {
        Census::Five => (5, 5, 2),
        Census::Seven => (7, 7, 3),
        Census::NineBySeven => (9, 7, 3),
        Census::CentreSymmetric => (9, 3, 3),
    };
    let number = |value: u32| ("u32", format!("{value}u"));
    let table = [
        ("LANES", number(kernel.lanes(plan))),
        ("MEMBERS", number(plan.members)),
        ("MEMBER_BITS", number(plan.members.ilog2())),
        ("OWN_QUADS", number(plan.own_quads)),
        ("SLICES", number(plan.own_quads / plan.width)),
        ("WIDTH", number(plan.width)),
        ("SEGMENT", number(segment(plan))),
        ("VECTORS", number(vectors(quads, plan))),
        ("SPAN", number(span(plan))),
        ("DISPARITIES", number(params.disparities)),
        ("QUADS", number(quads)),
        ("TEXELS", number(TEXELS)),
        ("PENALTIES", number(penalties)),
        ("PART_BITS", number(plan.part_bits.unwrap_or(0))),
        ("FILTERED", number(3 + plan.parts())),
        ("BEYOND", ("vec4<u32>", format!("vec4({})", beyond.join(", ")))),
        ("BLOCK", number(params.block)),
        ("BLOCK_WORDS", number((params.block + 6) / 4)),
        ("SMALL_VALUES", number((params.descriptor_max() < 128).into())),
        ("SUMMABLE", number((255 / params.pixel_max()).max(1))),
        ("NARROWING", number(params.narrowing())),
        ("SCALE_SHIFT", number(params.scale_shift())),
        ("PLANES", number(params.planes())),
        ("IMAGE_PLANES", number(params.planes() / params.channels())),
        ("CHANNELS", number(params.channels())),
        ("COST", number(params.cost as u32)),
        ("COST_ZSAD", number(Cost::ZeroMeanSad as u32)),
        ("COST_BT", number(Cost::BirchfieldTomasi as u32)),
        ("COST_SAD_XY", number(Cost::SadXy as u32)),
        ("COST_CENSUS_SOBEL", number(Cost::CensusSobel as u32)),
        ("COST_AD_CENSUS", number(Cost::AdCensus as u32)),
        ("CENSUS", number(params.census as u32)),
        ("CENSUS_SYMMETRIC", number(Census::CentreSymmetric as u32)),
        ("CENSUS_PLANES", number(census_planes)),
        ("CENSUS_COLUMNS", number(census_columns)),
        ("CENSUS_ROWS", number(census_rows)),
        ("CENSUS_ABOVE", number(census_above)),
        ("AD_WEIGHT", number(params.ad_weight)),
        ("CENSUS_WEIGHT", number(params.census_weight)),
        ("PREFILTER_WINDOW", number(params.prefilter_window)),
        ("PARTS", number(parts)),
        ("STRIP", number(strip)),
        ("PATHS", number(params.paths.count())),
        ("PAIRED", number(paired)),
        ("SUBPIXEL", number(params.subpixel as u32)),
        ("SUBPIXEL_OFF", number(Subpixel::Off as u32)),
        ("SUBPIXEL_EQUIANGULAR", number(Subpixel::Equiangular as u32)),
        ("SHIFTED", number((params.min_disparity != 0).into())),
        ("UNIQUENESS", number(params.uniqueness)),
        ("CONFIDENCE", number(params.confidence.into())),
        ("FORMAT", number(format as u32)),
        ("DEEP", number(format.is_deep().into())),
        ("GRAY8", number(PixelFormat::Gray8 as u32)),
        ("GRAY16", number(PixelFormat::Gray16 as u32)),
        ("RGBA8", number(PixelFormat::Rgba8 as u32)),
        ("PREFILTER", number(params.prefilter as u32)),
        ("PREFILTER_XSOBEL", number(Prefilter::XSobel as u32)),
        ("SIXTEENTH_BITS", number(wls_bits(params.disparities))),
        ("SPACING", number(median_spacing(params.weighted_median.unwrap_or(1)))),
        ("DECAY", number(median_decay(params.weighted_median_sigma))),
        ("PREFILTER_NORMALIZED", number(Prefilter::Normalized as u32)),
        ("PREFILTER_NONE", number(Prefilter::None as u32)),
    ];
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let fragments = kernel.fragments(params, plan);
    let named: HashSet<&str> = fragments.iter().flat_map(|source| source.split(|c| !word(c))).collect();
    let chosen = table.iter().filter(|(name, _)| named.contains(name));
    chosen.map(|(name, (kind, value))| format!("const {name}: {kind} = {value}; ")).collect()
}

/// How invocations without a line of their own leave a kernel that walks lines.
const EARLY_RETURN: &str = "    if !works {\n        return;\n    }\n";

/// The whole text of a specialised kernel.
pub(crate) fn source(kernel: &Kernel, params: &Params, format: PixelFormat, plan: &Plan) -> String {
    let text = format!("{}\n{}\n", kernel.fragments(params, plan).join("\n"), constants(kernel, params, format, plan));
    // A barrier is for all invocations of a workgroup: there they walk the last line once more, and write nothing.
    let barriers = plan.exchange == Exchange::Workgroup && kernel.choices.contains(&Choice::SharedPath);
    let text = if barriers { text.replacen(EARLY_RETURN, "", 1) } else { text };
    #[cfg(test)]
    let text = crate::gpu::edits::edited(kernel.name, text);
    text
}

/// A kernel compiled for a device.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) pipeline: wgpu::ComputePipeline,
}

/// Compiles `text`, a kernel's [`source`].
pub(crate) fn compile(device: &wgpu::Device, kernel: &Kernel, text: &str, params: &Params, plan: &Plan) -> Compiled {
    let label = format!("gpu-stereo.{}", kernel.name);
    let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    let storage = kernel.storage(params, plan);
    let storage = storage.iter().map(|access| match access {
        Read | Costs => buffer(wgpu::BufferBindingType::Storage { read_only: true }, false),
        Write | Trees => buffer(wgpu::BufferBindingType::Storage { read_only: false }, false),
        Table | Penalties => unreachable!("there is none, or it is bound as what holds it"),
        Texels(format) => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::ReadOnly,
            format: *format,
            view_dimension: wgpu::TextureViewDimension::D2,
        },
    });
    let uniform = wgpu::BufferBindingType::Uniform;
    let types = [buffer(uniform, false), buffer(uniform, true)].into_iter().chain(storage);
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let entries: Vec<_> = (0..).zip(types).map(entry).collect();
    let layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label), entries: &entries });
    let module = shader_module(
        device,
        wgpu::ShaderModuleDescriptor { label: Some(&label), source: wgpu::ShaderSource::Wgsl(text.into()) },
        params.shader_checks,
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
            // Every kernel writes what it reads before it reads it.
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    });
    Compiled { layout, pipeline }
}

/// The kernels run without naga's guards against endless loops and against indices out of range, unless
/// [`Params::shader_checks`] asks for them. Both keep Mesa from unrolling the loops over a path's state, which then stays
/// in memory: 2 to 5 times slower on lavapipe (docs/PERFORMANCE.md). The exactness tests run with and without them.
#[allow(unsafe_code)]
fn shader_module(
    device: &wgpu::Device,
    descriptor: wgpu::ShaderModuleDescriptor<'_>,
    shader_checks: bool,
) -> wgpu::ShaderModule {
    if shader_checks {
        return device.create_shader_module(descriptor);
    }
    let checks = wgpu::ShaderRuntimeChecks {
        force_loop_bounding: false,
        bounds_checks: false,
        ..wgpu::ShaderRuntimeChecks::checked()
    };
    // SAFETY: every loop of the kernels counts up to a constant or to a size from the uniform blocks, and every index is
    // made of such sizes; the matcher fills the blocks and sizes the buffers from one source (src/gpu/layout/mod.rs).
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}

/// Bytes of workgroup memory of `shared_path_workgroup` and of `mi_range`, which have most of it.
pub(crate) const SHARED_BYTES: u32 = 2048;

/// The limits that the kernels need, whatever the settings; all that the device lacks is named at once. The sizes of
/// buffers and textures, which depend on the pair, are checked where they are computed (src/gpu/layout/mod.rs).
pub(crate) fn check_limits(limits: &wgpu::Limits) -> Result<(), Error> {
    let most = |bound: fn(&Access) -> bool| {
        KERNELS.iter().map(|kernel| kernel.storage.iter().filter(|access| bound(access)).count()).max().unwrap_or(0)
    };
    let buffers = most(|access| matches!(access, Read | Write | Costs | Penalties | Trees));
    let textures = most(|access| matches!(access, Texels(_) | Costs | Table));
    let lanes = KERNELS.iter().map(|kernel| kernel.lanes).max().unwrap_or(0).max(GROUP_LANES);
    let uniform = size_of::<Frame>().max(size_of::<Pass>());
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
        max_sampled_textures_per_shader_stage 1;
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

#[cfg(test)]
pub(crate) mod tests;
