//! Every row of the table: valid WGSL, the folder's files, the Rust twins' layouts, WebGPU's limits; and the proof that
//! a wrong shader is found.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use super::*;
use crate::gpu::edits::with_mutant;
use crate::gpu::interop::{SHADERS, are_made};
use crate::params::Named;
use crate::{Fill, Median, Paths, RightView, Schedule, StereoMatcher, Wls};
use wgpu::naga;

mod grammar;
mod portable;
pub(crate) mod rounds;
#[path = "../../../tests/support/mod.rs"]
pub(crate) mod support;
mod unrolling;

/// Plans for devices with and without subgroups and 64-bit integers.
fn plans(params: &Params) -> BTreeSet<Plan> {
    let devices =
        [(false, 1, false), (false, 1, true), (false, 8, true), (true, 1, false), (true, 4, true), (true, 32, true)];
    let adaptive = params.adaptive_p2;
    let of = |&(per_subgroup, subgroup, int64)| {
        let part_bits = (subgroup == 8).then_some(20);
        Plan { adaptive, part_bits, ..Plan::of(params.quads(), per_subgroup, subgroup, int64) }
    };
    devices.iter().map(of).collect()
}

/// Settings that between them give every constant of [`constants`] every kind of value.
fn specialisations() -> Vec<(Params, PixelFormat, Plan)> {
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
                        let params = Params { paths, prefilter, subpixel, confidence, adaptive_p2, ..base.clone() };
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
    for &cost in Cost::VALUES {
        for (block, census, color_cost) in [
            (1, Census::NineBySeven, false),
            (5, Census::CentreSymmetric, true),
            (5, Census::Five, false),
            (21, Census::Seven, false),
        ] {
            let base = if cost == Cost::Ncc { Params::bm(40) } else { Params::sgm(40) };
            let block = if cost == Cost::Ncc { block.clamp(3, 19) } else { block };
            let base = Params { cost, block, census, prefilter: Prefilter::None, ..base };
            for prefilter in [Prefilter::Normalized, Prefilter::None] {
                let takes_colour = matches!(cost, Cost::Sad | Cost::BirchfieldTomasi);
                let params = Params { prefilter, color_cost: color_cost && takes_colour, ..base.clone() };
                all.extend(plans(&params).into_iter().map(|plan| (params.clone(), formats[1], plan)));
            }
        }
    }
    all
}

/// The [`specialisations`] that a kernel is for.
fn specialisations_of(kernel: &Kernel) -> impl Iterator<Item = (Params, PixelFormat, Plan)> {
    let name = kernel.name;
    specialisations().into_iter().filter(move |(params, ..)| match name {
        "block_match_small" => params.block <= Params::SMALL_BLOCK && params.cost == Cost::Sad,
        "matching_cost_pixels" => params.sums_small_blocks() && params.block == 1,
        "matching_cost_small" | "matching_cost_parallel" => params.sums_small_blocks(),
        _ => true,
    })
}

/// The different texts of each kernel over all of them.
static TEXTS: LazyLock<BTreeMap<&str, BTreeSet<String>>> = LazyLock::new(|| {
    let texts = |kernel: &Kernel| {
        specialisations_of(kernel).map(|(params, format, plan)| source(kernel, &params, format, &plan)).collect()
    };
    KERNELS.iter().map(|kernel| (kernel.name, texts(kernel))).collect()
});

/// The different texts of a kernel.
fn texts(kernel: &Kernel) -> &'static BTreeSet<String> {
    &TEXTS[kernel.name]
}

/// The text of every specialised kernel and of what is not in the table, with its name.
fn every_text() -> impl Iterator<Item = (&'static str, &'static str)> {
    static OTHERS: LazyLock<Vec<(&str, String)>> = LazyLock::new(|| crate::gpu::interop::texts().collect());
    let kernels = KERNELS.iter().flat_map(|kernel| texts(kernel).iter().map(|text| (kernel.name, text.as_str())));
    kernels.chain(OTHERS.iter().map(|(name, text)| (*name, text.as_str())))
}

fn parse(kernel: &Kernel, text: &str) -> naga::Module {
    match naga::front::wgsl::parse_str(text) {
        Ok(module) => module,
        Err(error) => panic!("{}.wgsl: {}", kernel.name, error.emit_to_string(text)),
    }
}

fn folder(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A file of the project.
struct SourceFile {
    /// Its name without extension.
    name: String,
    /// Its path from the project's root.
    path: String,
    text: String,
}

/// The files with `extension` in a folder of the project and in those below it.
fn files(path: &str, extension: &str) -> Vec<SourceFile> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder(path)).unwrap().map(|entry| entry.unwrap()) {
        let name = entry.file_name().into_string().unwrap();
        let inner = format!("{path}/{name}");
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(&inner, extension));
        } else if let Some((stem, _)) = name.rsplit_once('.').filter(|(_, e)| *e == extension) {
            let text = std::fs::read_to_string(entry.path()).unwrap();
            found.push(SourceFile { name: stem.into(), path: inner, text });
        }
    }
    found
}

/// What the kernels may use beyond WebGPU, where a device has it.
const CAPABILITIES: naga::valid::Capabilities =
    naga::valid::Capabilities::SUBGROUP.union(naga::valid::Capabilities::SHADER_INT64);

#[test]
fn every_kernel_is_valid_wgsl() {
    assert!(!KERNELS.is_empty(), "the table of kernels is empty");
    for kernel in KERNELS {
        let texts = texts(kernel);
        assert!(!texts.is_empty(), "{} has no text", kernel.name);
        for text in texts {
            let module = parse(kernel, text);
            let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), CAPABILITIES);
            validator.subgroup_stages(naga::valid::ShaderStages::COMPUTE);
            validator.subgroup_operations(naga::valid::SubgroupOperationSet::all());
            if let Err(error) = validator.validate(&module) {
                panic!("{}.wgsl: {}", kernel.name, error.emit_to_string(text));
            }
        }
    }
}

#[test]
fn the_table_and_the_folders_name_the_same_kernels() {
    let names: BTreeSet<&str> = KERNELS.iter().map(|kernel| kernel.name).collect();
    assert_eq!(names.len(), KERNELS.len(), "two kernels have one name");

    let shaders = files("shaders", "wgsl");
    let all = specialisations();
    for SourceFile { name, path, text } in &shaders {
        let is_entry = !path.contains("/parts/") && !path.starts_with("shaders/shared/");
        let has_entry = text.contains("@compute") || text.contains("@fragment");
        assert_eq!(
            has_entry, is_entry,
            "{path}: entry points stand in a stage's folder, fragments in parts/ or shared/"
        );
        if SHADERS.iter().any(|(file, of_surfaces)| name == file && of_surfaces == text) {
            continue;
        }
        let used = all.iter().any(|(p, _, plan)| KERNELS.iter().any(|k| k.fragments(p, plan).contains(&text.as_str())));
        assert!(used, "{path} is in no row of the table");
        assert_eq!(has_entry, names.contains(name.as_str()), "{path}: entry points and rows differ");
    }
    for kernel in KERNELS {
        let own = shaders.iter().find(|file| file.name == kernel.name);
        let own = own.unwrap_or_else(|| panic!("there is no {}.wgsl in shaders", kernel.name));
        assert_eq!(kernel.sources[0], own.text, "{}: its own file must come first in its row", kernel.name);
        assert_eq!(kernel.sources.iter().filter(|source| source.contains("@compute")).count(), 1, "{}", kernel.name);
    }

    // A stage's reference stands in the folder of that room: src/reference/winner/lr_check.rs.
    let references = files("src/reference", "rs");
    let in_rooms = references.iter().filter(|file| file.path.matches('/').count() == 3 && file.name != "mod");
    let references: BTreeSet<&str> = in_rooms.map(|file| file.name.as_str()).collect();
    let stages: BTreeSet<&str> = KERNELS.iter().map(|kernel| kernel.stage).collect();
    assert_eq!(references, stages, "src/reference (left) and the table (right) name different stages");
}

#[test]
fn every_shader_starts_with_its_header() {
    let references = files("src/reference", "rs");
    for SourceFile { name: file, path: shader, text } in files("shaders", "wgsl") {
        let header: Vec<&str> = text.lines().take_while(|line| line.starts_with("//")).collect();
        assert!(!header.is_empty(), "{shader} has no header");
        assert!(header.len() <= 9, "{shader}: the header has {} lines, at most 9 are read", header.len());
        let named = header.iter().find_map(|line| line.strip_prefix("// Reference: "));
        if let Some(kernel) = KERNELS.iter().find(|kernel| kernel.name == file) {
            assert!(header[0].starts_with(&format!("// {file}: ")), "{shader}: its first line names it");
            let last = header[header.len() - 1];
            assert!(last.starts_with("// Reference: "), "{shader}: the header ends with {last:?}");
            let own = &references.iter().find(|file| file.name == kernel.stage).unwrap().path;
            assert!(named.is_some_and(|n| n.split(", ").any(|n| n == own)), "{shader} does not name {own}");
        }
        for path in named.into_iter().flat_map(|named| named.split(", ")) {
            assert!(folder(path).is_file(), "{shader} names {path}, which does not exist");
        }
    }
}

/// Name, offset and kind of each member, and the size: of a Rust struct. A member left out does not compile.
macro_rules! layout {
    ($type:ident { $($field:ident),+ $(,)? }) => {{
        let $type { $($field),+ } = $type::default();
        let members = vec![$((
            stringify!($field).to_string(),
            offset_of!($type, $field) as u32,
            std::any::type_name_of_val(&$field).to_string(),
        )),+];
        (members, size_of::<$type>() as u32)
    }};
}

/// The same of a WGSL struct.
fn reflected(module: &naga::Module, name: &str) -> (Vec<(String, u32, String)>, u32) {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
        panic!("there is no struct {name}");
    };
    let kind = |member: &naga::StructMember| match module.types[member.ty].inner {
        naga::TypeInner::Scalar(naga::Scalar::U32) => "u32".to_string(),
        naga::TypeInner::Scalar(naga::Scalar::I32) => "i32".to_string(),
        ref other => format!("{other:?}"),
    };
    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset, kind(m))).collect();
    (members, *span)
}

/// A plan for 64 disparities.
const PLAN: Plan = Plan {
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

fn frame_layout() -> (Vec<(String, u32, String)>, u32) {
    layout!(Frame {
        width,
        height,
        min_disparity,
        block_radius,
        prefilter_cap,
        cost_scale,
        p1,
        p2,
        lr_max_difference,
        gray_stride,
        left_stride,
        right_stride,
        map_stride,
        volume_stride,
        map_words,
        texture,
        speckle_window,
        speckle_range,
        fill_max_difference,
        depth_high,
        depth_low,
        depth_offset,
        source_shift,
    })
}

fn pass_layout() -> (Vec<(String, u32, String)>, u32) {
    layout!(Pass {
        first_row,
        rows,
        volume_row,
        first_line,
        lines,
        shift,
        dx,
        dy,
        carried,
        accumulate,
        channel,
        mirrored,
        lead,
        stride,
        first_plane,
        window,
        row_step,
        occlusions,
        reversed,
        entry,
        carry_from,
        carry_to,
        slot,
        penalties_from,
        penalties_line,
        penalties_step,
        place,
        halvings,
        narrowing,
        prior,
        logarithms,
        side,
        map_row,
        planes_row,
        planes_rows,
    })
}

#[test]
fn uniform_blocks_are_laid_out_as_their_rust_twins() {
    for kernel in KERNELS {
        let module = parse(kernel, &source(kernel, &Params::sgm(64), PixelFormat::Gray8, &PLAN));
        assert_eq!(reflected(&module, "Frame"), frame_layout(), "Frame in WGSL (left) and Rust (right)");
        assert_eq!(reflected(&module, "Dispatch"), pass_layout(), "Dispatch in WGSL (left) and Rust (right)");
    }
}

/// The test of the test above: members that change places, and one of another kind.
#[test]
fn a_changed_uniform_block_is_noticed() {
    let kernel = &KERNELS[0];
    let text = source(kernel, &Params::sgm(64), PixelFormat::Gray8, &PLAN);
    for (from, to) in [
        ("    p1: u32,\n    p2: u32,\n", "    p2: u32,\n    p1: u32,\n"),
        ("    min_disparity: i32,\n", "    min_disparity: u32,\n"),
        ("    height: u32,\n", "    @align(16) height: u32,\n"),
    ] {
        let changed = text.replace(from, to);
        assert_ne!(changed, text, "{from:?} is no longer in the text");
        assert_ne!(reflected(&parse(kernel, &changed), "Frame"), frame_layout(), "{to:?} went unnoticed");
    }
}

#[test]
fn bindings_agree_with_the_table() {
    for kernel in KERNELS {
        for (params, format, plan) in specialisations_of(kernel).step_by(5) {
            let module = parse(kernel, &source(kernel, &params, format, &plan));
            let mut bindings: Vec<(u32, String)> = Vec::new();
            for (_, variable) in module.global_variables.iter() {
                let Some(at) = &variable.binding else { continue };
                assert_eq!(at.group, 0, "{}: {:?}", kernel.name, variable.name);
                let kind = match variable.space {
                    naga::AddressSpace::Uniform => module.types[variable.ty].name.clone().unwrap_or_default(),
                    naga::AddressSpace::Storage { access } if access == naga::StorageAccess::LOAD => "Read".into(),
                    naga::AddressSpace::Storage { .. } => "Write".into(),
                    naga::AddressSpace::Handle => match module.types[variable.ty].inner {
                        naga::TypeInner::Image {
                            class: naga::ImageClass::Storage { format: naga::StorageFormat::R32Uint, access },
                            ..
                        } if access == naga::StorageAccess::LOAD => "Texels(R32Uint)".into(),
                        naga::TypeInner::Image {
                            class: naga::ImageClass::Storage { format: naga::StorageFormat::Rgba32Uint, access },
                            ..
                        } if access == naga::StorageAccess::LOAD => "Texels(Rgba32Uint)".into(),
                        ref other => format!("{other:?}"),
                    },
                    other => format!("{other:?}"),
                };
                bindings.push((at.binding, kind));
            }
            bindings.sort();
            let written = |access| if access == Access::Trees { Access::Write } else { access };
            let storage = kernel.storage(&params, &plan).into_iter().map(|access| format!("{:?}", written(access)));
            let expected = ["Frame".to_string(), "Dispatch".to_string()].into_iter().chain(storage);
            let expected: Vec<(u32, String)> = (0..).zip(expected).collect();
            assert_eq!(bindings, expected, "{}: bindings in WGSL (left) and in the table (right)", kernel.name);
        }
    }
}

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
    least.max_uniform_buffer_binding_size = size_of::<Pass>().max(size_of::<Frame>()) as u64;
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
            crate::gpu::scopes::guarded(&device, || compile(&device, kernel, text, params, plan)).is_ok()
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

/// A device without a driver, with the features that some plans need.
fn noop_device() -> (wgpu::Device, wgpu::Queue) {
    wgpu::Device::noop(&wgpu::DeviceDescriptor {
        required_features: wgpu::Features::SUBGROUP | wgpu::Features::SHADER_INT64,
        ..Default::default()
    })
}

/// wgpu itself accepts every pipeline with the table's layout, and every bind group of a matcher. The backend `noop`
/// has no driver, so this also holds where there is no adapter.
#[test]
fn pipelines_and_matchers_are_made_without_a_driver() {
    let (device, queue) = noop_device();
    for kernel in KERNELS {
        let mut seen = BTreeSet::new();
        for (params, format, plan) in specialisations_of(kernel) {
            if seen.insert(source(kernel, &params, format, &plan)) {
                let made = crate::gpu::scopes::guarded(&device, || {
                    compile(&device, kernel, &source(kernel, &params, format, &plan), &params, &plan)
                });
                assert!(made.is_ok(), "{} with {params:?}, {format:?}: {}", kernel.name, made.unwrap_err());
            }
        }
    }
    for (params, format, plan) in specialisations().into_iter().step_by(7) {
        for (width, height) in [(1, 1), (2, 3), (301, 45)] {
            let schedule = if plan.per_subgroup { Schedule::PerSubgroup } else { Schedule::PerThread };
            let params = Params { schedule, ..params.clone() };
            let matcher = StereoMatcher::new(&device, &queue, width, height, format, &params);
            assert!(matcher.is_ok(), "{width}x{height} in {format:?}, {params:?}: {}", matcher.unwrap_err());
        }
    }
}

/// A kernel that lacks a binding is refused where the pipeline is made: the test of the test above.
#[test]
fn a_wrong_row_of_the_table_is_refused() {
    let (device, _queue) = noop_device();
    for kernel in KERNELS {
        let row = Kernel { storage: &kernel.storage[1..], ..*kernel };
        let params = Params::sgm(64);
        let text = source(&row, &params, PixelFormat::Gray8, &PLAN);
        let made = crate::gpu::scopes::guarded(&device, || compile(&device, &row, &text, &params, &PLAN));
        assert!(made.is_err(), "{} was accepted with a binding too few", kernel.name);
    }
}

/// A change to a shader, and settings that show it.
struct Mutant {
    kernel: &'static str,
    from: &'static str,
    to: &'static str,
    change: fn(&mut Params),
}

const fn mutant(kernel: &'static str, from: &'static str, to: &'static str, change: fn(&mut Params)) -> Mutant {
    Mutant { kernel, from, to, change }
}

fn bm(params: &mut Params) {
    *params = Params { min_disparity: params.min_disparity, ..Params::bm(params.disparities) };
}

/// Block matching with the column sums kept in memory.
fn bm_columns(params: &mut Params) {
    bm(params);
    params.shader_checks = true;
}

/// Block matching by normalised cross correlation.
fn ncc(params: &mut Params) {
    bm(params);
    (params.cost, params.block) = (Cost::Ncc, 7);
}

/// A range whose last disparities win, and those beyond it would.
fn bm_far(params: &mut Params) {
    bm(params);
    params.min_disparity = -14;
}

/// Blocks of one pixel, whose sums are often equal.
fn bm_pixel(params: &mut Params) {
    bm(params);
    (params.block, params.prefilter_cap, params.uniqueness) = (1, 4, 50);
}

/// A block for which the column sums are kept in memory.
fn wide(params: &mut Params) {
    params.block = 17;
}

fn rectify(params: &mut Params) {
    params.rectify = Some(crate::Rectification::new(93, 41, support::lenses(93, 41)).unwrap());
}

/// Parts of both images are masked, the last column of the left one in every other row among them.
fn masked(params: &mut Params) {
    let masks = support::masks(93, 41, 3);
    let [mut left, right] = [0, 1].map(|side| masks.side(side).map_or(vec![1; 93 * 41], <[u8]>::to_vec));
    left.chunks_exact_mut(93).step_by(2).for_each(|row| row[92] = 0);
    params.masks = Some(crate::Masks::new(93, 41, [Some(left), Some(right)]).unwrap());
    (params.uniqueness, params.right_map) = (0, true);
}

fn depth(params: &mut Params) {
    params.depth = Some(crate::Camera { doffs: 3.3, ..crate::Camera::new(994.978, 0.193) });
}

/// Settings that leave wrong winners in the map: those that point outside the right image by a fraction among them.
fn any(params: &mut Params) {
    (params.p1, params.p2, params.uniqueness) = (12, 72, 0);
}

fn five(params: &mut Params) {
    params.median = Median::Five;
}

fn weighted(params: &mut Params) {
    (params.weighted_median, params.uniqueness) = (Some(5), 0);
}

fn wls(params: &mut Params) {
    params.wls = Some(Wls { lambda: 50.0, sigma: 20.0 });
}

fn eight_paths(params: &mut Params) {
    params.paths = Paths::Eight;
}

fn adaptive(params: &mut Params) {
    (params.adaptive_p2, params.p1, params.p2) = (true, 9, 100);
}

fn twice(params: &mut Params) {
    params.right_view = RightView::Match;
}

fn sixteen(params: &mut Params) {
    adaptive(params);
    params.paths = Paths::Sixteen;
}

fn equiangular(params: &mut Params) {
    params.subpixel = Subpixel::Equiangular;
}

/// A threshold about which many sums lie, and are equal to.
fn texture(params: &mut Params) {
    (params.texture, params.prefilter_cap, params.uniqueness) = (60, 3, 0);
}

fn confidence(params: &mut Params) {
    params.confidence = true;
}

/// Holes of many sizes, most of them mismatches.
fn rays(params: &mut Params) {
    (params.p1, params.p2, params.fill) = (2, 9, Fill::Rays);
}

/// Small regions of many sizes.
fn speckle(params: &mut Params) {
    (params.p1, params.p2, params.lr_check) = (0, 3, None);
    (params.speckle_window, params.speckle_range) = (6, 1);
}

/// Invocations that share a pixel's disparities.
fn per_subgroup(params: &mut Params) {
    (params.schedule, params.disparities) = (Schedule::PerSubgroup, 50);
}

/// A cost that is looked up in a table, on images that are halved once.
fn mutual(params: &mut Params) {
    (params.cost, params.prefilter, params.block) = (Cost::MutualInformation, Prefilter::None, 1);
}

pub(crate) type Setup = (wgpu::Adapter, wgpu::Device, wgpu::Queue);

/// One rule a row: a weight, a rounding, a border, a tie, a penalty, a test of the winner.
const MUTANTS: &[Mutant] = &[
    mutant("gray", "16384u", "0u", |_| ()),
    mutant("gray", "3735u", "3734u", |_| ()),
    mutant("gray", "frame.width) - 1)", "frame.width) - 2)", |_| ()),
    mutant("prefilter", "low_bytes(-x)", "low_bytes(-x - 1)", |_| ()),
    mutant("prefilter", "low_bytes(last - x)", "low_bytes(last - x + 2)", |_| ()),
    mutant("prefilter", "frame.height) - 1)", "frame.height) - 2)", |_| ()),
    mutant("prefilter", "dispatch.lead", "(dispatch.lead + 1)", |_| ()),
    mutant("prefilter", "vec4(-128 * divisor)", "vec4(-12 * divisor)", |params| {
        params.prefilter = Prefilter::Normalized
    }),
    mutant("prefilter", "4 * centre", "3 * centre", |params| params.prefilter = Prefilter::Normalized),
    mutant("deep_gray", "vec4(x < 0)", "vec4(x < -8)", |_| ()),
    mutant("window_columns", "dy < radius", "dy < radius - 1", |params| params.prefilter = Prefilter::Normalized),
    mutant("window_columns", "frame.height) - 1)", "frame.height) - 2)", |params| {
        params.prefilter = Prefilter::Normalized
    }),
    mutant("window_sums", "frame.width) - 1)", "frame.width) - 2)", |params| params.prefilter = Prefilter::Normalized),
    mutant("descriptors", "~(a ^ b) & low_bits", "low_bits", |params| {
        (params.cost, params.prefilter) = (Cost::Census, Prefilter::None);
    }),
    mutant("descriptors", "moved(other, -towards)", "moved(other, towards)", |params| {
        params.cost = Cost::Census;
        params.census = Census::CentreSymmetric;
    }),
    mutant("descriptors", "low_bytes(last - x)", "low_bytes(last - x + 2)", |params| params.cost = Cost::CensusSobel),
    mutant("descriptors", "vec4(half)", "vec4(0)", |params| params.cost = Cost::ZeroMeanSad),
    mutant("descriptors", "min(before, after)", "before", |params| params.cost = Cost::BirchfieldTomasi),
    mutant("prefilter", "2 * cap", "2 * cap - 1", |params| params.prefilter = Prefilter::Sobel),
    mutant("prefilter", "return root;", "return root + 1u;", |params| params.prefilter = Prefilter::Sobel),
    mutant("halve", "+ 2u) >> 2u", "+ 1u) >> 2u", mutual),
    mutant("halve", "dispatch.lines - 1u", "dispatch.lines - 2u", mutual),
    mutant("mi_histogram", "+ 8) >> 4u", "+ 7) >> 4u", mutual),
    mutant("mi_histogram", "value * i32(1u << dispatch.halvings)", "value", mutual),
    mutant("mi_smooth", "6u * middle", "5u * middle", mutual),
    mutant("mi_smooth", "fraction) * 11u", "fraction) * 9u", mutual),
    mutant("mi_smooth", "vec4(values.x), four < 0", "values, four < 0", |params| {
        mutual(params);
        params.prefilter = Prefilter::XSobel;
    }),
    mutant("mi_marginals", "select(256u, 1u, id.x < 256u)", "select(255u, 1u, id.x < 256u)", mutual),
    mutant("mi_range", "max(found.y, ranges[l].y)", "ranges[l].y", mutual),
    mutant("mi_table", "vec4(span / 2u)", "vec4(0u)", mutual),
    mutant("mi_table", "vec4(span == 0u)", "vec4(false)", mutual),
    mutant("mi_table", "vec4(32u)", "vec4(0u)", mutual),
    mutant("cost_columns", "vec4(3u)) * 8u", "vec4(1u)) * 8u", |params| {
        mutual(params);
        wide(params);
    }),
    mutant("matching_cost_pixels", "vec4(3u)) * 8u", "vec4(1u)) * 8u", mutual),
    mutant("matching_cost_parallel", "vec2(columns.w, l)", "vec2(columns.w, 0u)", |params| {
        mutual(params);
        per_subgroup(params);
    }),
    mutant("cost_columns", "frame.height) - 1)", "frame.height))", wide),
    mutant("cost_columns", "here + r)", "here + r - 1)", wide),
    mutant("cost_columns", "low * low", "low * low + 1u", |params| params.cost = Cost::Ssd),
    mutant("matching_cost", "1u << 23u", "1u << 22u", wide),
    mutant("matching_cost", "frame.cost_scale", "(frame.cost_scale + 9000u)", wide),
    mutant("matching_cost", "c < begin + reach", "c < begin + reach - 1u", wide),
    mutant("matching_cost", "min(begin + SPAN,", "min(begin + SPAN - 1u,", |params| {
        wide(params);
        per_subgroup(params);
    }),
    mutant("matching_cost_small", "1u << 23u", "1u << 22u", |_| ()),
    mutant("matching_cost_small", "frame.height) - 1)", "frame.height) - 2)", |_| ()),
    mutant("matching_cost_small", "start - four,", "start - four + 1u,", |_| ()),
    mutant("matching_cost_small", "window(start + 1u,", "window(start,", |params| params.min_disparity = -12),
    mutant("matching_cost_small", "values[j][p] >>= 8u", "values[j][p] >>= 16u", |_| ()),
    mutant("matching_cost_small", "c < columns", "c + 1u < columns", |_| ()),
    mutant("matching_cost_small", "- kept[0]", "- kept[1]", |_| ()),
    mutant("matching_cost_pixels", "24u - 8u * k", "8u * k", |params| params.block = 1),
    mutant("matching_cost_pixels", "inside > 2u", "inside > 9u", |params| params.block = 1),
    mutant("matching_cost_pixels", "vec4(entering[p], seen[p].xyz)", "seen[p]", |params| params.block = 1),
    mutant("matching_cost_pixels", "0x01010101u <<", "0u <<", |params| {
        (params.block, params.cost, params.prefilter) = (1, Cost::CensusSobel, Prefilter::None);
    }),
    mutant("matching_cost_small", "(a ^ b) & c", "(a ^ b) | c", |params| params.cost = Cost::Census),
    mutant("matching_cost_small", "2u * bits", "bits", |params| params.cost = Cost::CensusSobel),
    mutant("matching_cost_small", "+ vec4(8u)", "+ vec4(7u)", |params| params.cost = Cost::AdCensus),
    mutant("matching_cost_small", "there - above(there, back)", "there", |params| params.cost = Cost::BirchfieldTomasi),
    mutant("matching_cost_small", "((a ^ b) >> vec4(1u))", "((a | b) >> vec4(1u))", |params| params.color_cost = true),
    mutant("matching_cost_small", "j % SUMMABLE == 0u", "j % (SUMMABLE + 3u) == 0u", |params| {
        params.prefilter_cap = 63
    }),
    mutant("matching_cost_parallel", "1u << 23u", "1u << 22u", per_subgroup),
    mutant("matching_cost_parallel", "frame.height) - 1)", "frame.height) - 2)", per_subgroup),
    mutant("matching_cost_parallel", "- kept[0]", "- kept[1]", per_subgroup),
    mutant("matching_cost_parallel", "values[p][c >> 2u], (c & 3u)", "values[p][c >> 2u], (i & 3u)", per_subgroup),
    mutant("matching_cost_parallel", "% SUMMABLE == 0u", "% (SUMMABLE + 3u) == 0u", |params| {
        per_subgroup(params);
        params.prefilter_cap = 63;
    }),
    mutant("matching_cost_parallel", "+ REACH;", "+ REACH - 1u;", per_subgroup),
    mutant("sgm_aggregate", "frame.p1", "frame.p2", |_| ()),
    mutant("sgm_aggregate", "frame.p2", "frame.p1", |_| ()),
    mutant("sgm_aggregate", "frame.p2", "frame.p1", eight_paths),
    mutant("sgm_aggregate", "x >= width", "x > width", eight_paths),
    mutant("sgm_aggregate", "select(below, NONE, member == 0u)", "below", per_subgroup),
    mutant("sgm_aggregate", "subgroupShuffleXor(least_of_all, 1u << bit)", "least", per_subgroup),
    mutant("sgm_aggregate", "places[start + member_of(member + 1u)].y", "NONE", per_subgroup),
    mutant("sgm_aggregate", "places[start + i].x", "places[start].x", per_subgroup),
    mutant("sgm_aggregate", "select(after, (*state)[s]", "select(0u, (*state)[s]", |params| params.disparities = 64),
    mutant("sgm_aggregate", "stored >> vec4(32u)", "stored >> vec4(31u)", |params| params.disparities = 64),
    mutant("sgm_aggregate", "i32(dispatch.first_line", "i32(0u * dispatch.first_line", |_| ()),
    mutant("sgm_aggregate", "var place = dispatch.place", "var place = 0", adaptive),
    mutant("sgm_aggregate", "select(15, 0, forward)", "15", adaptive),
    mutant("sgm_aggregate", "dispatch.penalties_from +", "0u +", sixteen),
    mutant("sgm_aggregate", "select(-width, width", "select(-width, width - 1", sixteen),
    mutant("sgm_aggregate", "dispatch.entry", "0", sixteen),
    mutant("penalties", "vec4(10.0))", "vec4(12.0))", adaptive),
    mutant("penalties", "frame.p1 / 2u", "frame.p1 / 4u", adaptive),
    mutant("penalties", "+ 0.5)", "- 0.5)", adaptive),
    mutant("penalties", "0xffffff00u) | frame.p2", "0xffffff00u) | frame.p1", adaptive),
    mutant("penalties_lines", "starts || leaves", "starts", sixteen),
    mutant("penalties_lines", "id.y / rows * 16u * rows + id.y % rows", "id.y * 16u", sixteen),
    mutant("winner", "known, x + 1", "known, x", adaptive),
    mutant("winner", "i / 3u * dispatch.slot", "0u", sixteen),
    mutant("winner", "dispatch.volume_row * frame.volume_stride", "0u", |_| ()),
    mutant("winner", "least_key(costs) + member * OWN", "least_key(costs)", per_subgroup),
    mutant("winner", "min(entering, COST_NONE << 12u)", "COST_NONE << 12u", per_subgroup),
    mutant("winner", "neighbours_and_rival(vec3(", "(vec3(", per_subgroup),
    mutant("winner", "255u * (rival - here)", "256u * (rival - here)", confidence),
    mutant("winner", "is_before | is_after", "is_before", confidence),
    mutant("winner", "frame.p1", "frame.p2", |_| ()),
    mutant("winner", "PATHS *", "(PATHS - 1u) *", |_| ()),
    mutant("winner", "k - 1u", "k", |_| ()),
    mutant("winner", "max(before, after)", "before", equiangular),
    mutant("winner", "known.z <= limit", "known.z < limit", |params| params.uniqueness = 1),
    mutant("winner", "(100u - UNIQUENESS)", "(99u - UNIQUENESS)", |params| params.uniqueness = 10),
    mutant("winner", "disparity + 8", "disparity + 7", any),
    mutant("winner", "seen < i32(frame.width)", "seen <= i32(frame.width)", |_| ()),
    mutant("block_match", "known.z <= limit", "known.z < limit", |params| {
        bm_pixel(params);
        params.shader_checks = true;
    }),
    mutant("block_match", "2u * frame.block_radius", "2u * frame.block_radius - 1u", bm_columns),
    mutant("block_statistics", "+ vec4(BLOCK)", "+ vec4(BLOCK - 1u)", ncc),
    mutant("block_statistics", "return root;", "return root + 1u;", ncc),
    mutant("block_statistics", "frame.height) - 1)", "frame.height))", ncc),
    mutant("block_statistics", "BLOCK * BLOCK * sums.squares", "(BLOCK * BLOCK - 1u) * sums.squares", ncc),
    mutant("block_match", "left.x * right_sums", "left.y * right_sums", ncc),
    mutant("block_match", "vec4(0.015625)", "vec4(1.5)", ncc),
    mutant("block_match", "vec4(4096u) + part", "vec4(4096u)", ncc),
    mutant("block_match", "frame.width - 1u - u32(x)", "frame.width - u32(x)", ncc),
    mutant("block_match", "max(place, 1u) - 1u", "place", ncc),
    mutant("block_match", "entering.y, last", "0u, last", ncc),
    mutant("block_match", "(*seen).roots[q] = r", "(*seen).roots[q] = s", ncc),
    mutant("block_match", "k - 1u", "k", bm_columns),
    mutant("block_match_small", "frame.height) - 1)", "frame.height) - 2)", bm),
    mutant("block_match_small", "best * 100u", "best * 110u", bm),
    mutant("block_match_small", "7u << u32(clamp", "6u << u32(clamp", bm),
    mutant("block_match_small", "if PADDED", "if !PADDED", bm_far),
    mutant("block_match_small", "BLOCK) - start", "BLOCK) - start - 1", bm),
    mutant("block_match_small", "1u) + SLICE", "1u)", bm_far),
    mutant("block_match_small", "x4 - frame.min_disparity", "x4", bm),
    mutant("block_match_small", "k - 1u", "k", bm),
    mutant("block_match_small", "max(before, after)", "after", |params| {
        bm(params);
        equiangular(params);
    }),
    mutant("block_match_small", "0x7f7f7f7fu", "0x7f7f7f7eu", bm),
    mutant("texture_columns", "weight * (here &", "(here &", texture),
    mutant("texture_columns", "let row = clamp(y, 0,", "let row = clamp(y, 1,", texture),
    mutant("texture_columns", "vec4(s.even.yzw, s.after)", "vec4(s.even.yzw, 0u)", texture),
    mutant("texture_columns", "y - r)", "y - r + 1)", texture),
    mutant("texture", ">= vec4(frame.texture)", "> vec4(frame.texture)", texture),
    mutant("texture", "select(values, vec4(left)", "select(values, vec4(0u)", |params| {
        texture(params);
        params.min_disparity = -20;
    }),
    mutant("texture", "(last & 4u) != 0u", "(last & 4u) == 0u", texture),
    mutant("validity", "place >> 4u, row", "(place + 8) >> 4u, row", masked),
    mutant("validity", "(place + 15) >> 4u", "place >> 4u", masked),
    mutant("validity", "has_content(dispatch.side, x, row)", "true", masked),
    mutant("validity", "select(-value, value, dispatch.side == 1u)", "-value", masked),
    mutant("validity", "1u - dispatch.side", "dispatch.side", masked),
    mutant("validity", "side * frame.height + row", "row", masked),
    mutant("validity", "column & 31u", "column & 30u", masked),
    mutant("validity", "i32(frame.width) - 1", "i32(frame.width) - 2", masked),
    mutant("validity", "words.z, x + 4", "words.z, x + 2", masked),
    mutant("lr_check", "frame.lr_max_difference", "(frame.lr_max_difference + 1u)", |_| ()),
    mutant("lr_check", "(value + 8)", "value", |_| ()),
    mutant("mirror", "frame.width - 1u - min", "frame.width - min", twice),
    mutant("gray", "16u - left", "17u - left", twice),
    mutant("gray", "unpack(word).wzyx", "unpack(word).wzxy", twice),
    mutant("confidence", "max(margins, vec4(1u))", "margins", |params| {
        bm_pixel(params);
        confidence(params);
        params.uniqueness = 0;
    }),
    mutant("confidence", "frame.map_words / 4u", "0u", confidence),
    mutant("confidence", "vec4(0u), values ==", "vec4(1u), values ==", confidence),
    mutant("rectify", "+ 32768u", "+ 32000u", rectify),
    mutant("rectify", "x < i32(frame.width)", "x < i32(frame.width) - 9", rectify),
    mutant("rectify", "at.x + 1, at.y + 1", "at.x, at.y + 1", rectify),
    mutant("rectify", "position & vec2(255)", "position & vec2(247)", rectify),
    mutant("depth", "depth_low >> (31u - i)", "depth_low >> i", depth),
    mutant("depth", "256 * values", "255 * values", depth),
    mutant("depth", "words.y, 1u)", "words.x, 1u)", depth),
    mutant("depth", "& (values != vec4(INVALID))", "", |params| {
        depth(params);
        params.depth.as_mut().unwrap().doffs = 4096.0;
    }),
    mutant("depth", "near & (divisors", "(divisors", |params| {
        depth(params);
        (params.depth.as_mut().unwrap().focal, params.depth.as_mut().unwrap().baseline) = (1e6, 1000.0);
    }),
    mutant("speckle_rows", "b, joined.z)", "b, joined.y)", speckle),
    mutant("speckle_rows", "vec4(p.before, p.odd.xyz)", "vec4(INVALID, p.odd.xyz)", speckle),
    mutant("speckle_link", "low = first + firstTrailingBit(rest)", "low = first", speckle),
    mutant("speckle_link", "vec4(frame.speckle_range)", "vec4(frame.speckle_range + 40)", speckle),
    mutant("speckle_flatten", "set_tree(at, root)", "set_tree(at, ROOT)", speckle),
    mutant("speckle_count", "1u + firstTrailingBit(~(along >> (start + 1u)))", "1u", speckle),
    mutant("speckle", "<= frame.speckle_window", "< frame.speckle_window", speckle),
    mutant(
        "speckle_flatten",
        "pixel + 2u * frame.map_stride, root",
        "pixel + 2u * frame.map_stride + 1u, root",
        speckle,
    ),
    mutant("speckle", "vec4(2u, 8u, 32u, 128u))", "vec4(2u, 8u, 32u, 64u))", speckle),
    mutant("fill_rows", "last = odd.w", "last = even.w", |params| params.fill = Fill::Background),
    mutant("fill_rows", "odd.y = after(even.z, odd.y)", "odd.y = after(odd.z, odd.y)", rays),
    mutant("fill_lines", "first + n, last - n", "first + n, first + n", rays),
    mutant("fill_lines", "-7 - 8 * group", "1 - 8 * group", rays),
    mutant("fill_lines", "8 * group + 7", "8 * group", rays),
    mutant("fill_lines", "u32(x & 7)", "u32(x & 6)", rays),
    mutant("fill_seen", "(value >> 4u) + frame.fill_max_difference", "(value >> 4u)", rays),
    mutant("fill_seen", "31u - to_bit", "32u - to_bit", rays),
    mutant("fill_between", "select(min(a, b), max(a, b)", "select(max(a, b), max(a, b)", |params| {
        params.fill = Fill::Background
    }),
    mutant("fill_between", "dispatch.occlusions == 1u", "false", rays),
    mutant("fill_rays", "(valid - 1u) / 2u", "valid / 2u", rays),
    mutant("fill_rays", "min(valid - 1u, 1u)", "min(valid - 1u, 2u)", |params| {
        rays(params);
        params.fill = Fill::Hirschmuller;
    }),
    mutant("fill_rays", "place(x, y, -1)", "place(x, y, 0)", rays),
    mutant("median", "7) == beyond", "7) == beyond + 9", |_| ()),
    mutant("median", "select(before, even.x, i == 0u)", "before", |params| params.min_disparity = -20),
    mutant("median", "min(y + 1u, frame.height - 1u)", "id.y", |_| ()),
    mutant("median", "(seen >= vec4(0)) & (seen < vec4(i32(frame.width)))", "seen == seen", any),
    mutant("median_five", "beyond + 1", "beyond", five),
    mutant("median_five", "y + 2", "y + 1", five),
    mutant("median_five", "middle.d, min(low[0], high[0])", "middle.c, min(low[0], high[0])", five),
    mutant(
        "median_five",
        "select(vec2(map_value(before, 0u), map_value(before, 1u)), vec2(even.x), i == 0u)",
        "vec2(map_value(before, 0u), map_value(before, 1u))",
        |params| {
            five(params);
            params.min_disparity = -20;
        },
    ),
    mutant("weighted_median", "2u * reached >= total", "3u * reached >= total", weighted),
    mutant("weighted_median", "512u - (halvings & 255u)", "512u", weighted),
    mutant("weighted_median", "select(i32(frame.width + 8u * AROUND), 0, y == i32(row))", "0", weighted),
    mutant("weighted_median", "0xffffu), (even >= vec4(0))", "0xffffu), (even >= vec4(-8))", weighted),
    mutant("weighted_median", "exchange(keys, 2u, 2u, 6u);", "", weighted),
    mutant("weighted_median", "(i & 1u) == 1u", "(i & 1u) == 0u", weighted),
    mutant("weighted_median", "middle(&keys), valid", "middle(&keys), true", weighted),
    mutant("wls_start", "16 * frame.min_disparity", "16 * frame.min_disparity - 1", wls),
    mutant("wls_start", "disparity == INVALID", "false", wls),
    mutant("wls_forward", "0u, i + 1u == end", "9u, i + 1u == end", wls),
    mutant("wls_forward", "- select(0u, 1u, rest < 0)", "- 1u", wls),
    mutant("wls_forward", "dispatch.shift +", "0u +", wls),
    mutant("wls_forward", "65536u - share", "65535u - share", wls),
    mutant("wls_forward", "+ 16u;", "+ 15u;", wls),
    mutant("wls_backward", "dispatch.rows - 1u - i", "i", wls),
    mutant("wls", "(bits + 1u)", "bits", wls),
];

/// The check finds each mutant, and in the stage that it is in: the stages before stay exact.
#[test]
fn a_mutated_shader_is_caught() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    let (width, height, seed) = (93, 41, 5);
    let (left, right) = support::pair(width, height, seed);
    let mut wrong = Vec::new();
    for Mutant { kernel, from, to, change } in MUTANTS {
        let case = format!("{kernel} with {to:?} for {from:?}, seed {seed}, on {}", full.0.get_info().name);
        let row = KERNELS.iter().find(|row| row.name == *kernel).unwrap_or_else(|| panic!("no kernel for {case}"));
        let mut params = Params { min_disparity: -2, ..Params::sgm(21) };
        change(&mut params);
        // A rule that only a device without features follows is broken there.
        let has_it = |(_, device, _): &&Setup| {
            source(row, &params, PixelFormat::Rgba8, &Plan::new(device, &params)).contains(from)
        };
        let setup = [&full, &bare].into_iter().find(has_it);
        let Some((_, device, queue)) = setup else {
            wrong.push(format!("{case}: that is no longer in the text, break the same rule in its new words"));
            continue;
        };

        let format = if *kernel == "deep_gray" { 3 } else { 2 };
        let (left, right) = (support::as_format(&left, format), support::as_format(&right, format));
        let make = || StereoMatcher::new(device, queue, width, height, left.format(), &params);
        let matcher = with_mutant([kernel, from, to], make);
        let stages = matcher.unwrap().check_blocking(&left, &right).unwrap();
        let at = stages.iter().position(|stage| stage.stage == row.stage);
        let Some(at) = at else {
            wrong.push(format!("{case}: not run"));
            continue;
        };
        let before: u64 = stages[..at].iter().map(|stage| stage.mismatches).sum();
        if stages[at].mismatches == 0 || before > 0 {
            wrong.push(format!("{case}: {} mismatches there, {before} in the stages before", stages[at].mismatches));
        }
    }
    assert!(wrong.is_empty(), "not caught, or blamed on another stage:\n{}", wrong.join("\n"));
    let without: Vec<_> = KERNELS.iter().filter(|row| MUTANTS.iter().all(|m| m.kernel != row.name)).collect();
    assert!(without.is_empty(), "no mutant of {without:?}");
}
