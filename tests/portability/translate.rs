//! Translates WGSL as wgpu's backends do, with naga: `gpu-stereo-portability FOLDER` writes beside each NAME.wgsl of a folder
//!
//! - NAME.trusted.spv, for Vulkan 1.3, without naga's checks, and NAME.checked.spv, for Vulkan 1.1, with all of them and without
//!   integer dot products;
//! - NAME.metal, for Metal 3.0;
//! - NAME.es.STAGE (GLSL ES 310) and NAME.core.STAGE (GLSL 450), STAGE as glslangValidator names it, an entry point a file, where the
//!   text needs neither subgroups nor integers of 64 bits: no device of OpenGL gets one that does;
//! - NAME.hlsl, for shader model 6.0 where the text needs one of the two, else 5.1.
//!
//! Prints how many files of each kind were written. What naga refuses is on stderr, and the exit code is 1.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use naga::back::{glsl, hlsl, msl, spv};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, SubgroupOperationSet, ValidationFlags, Validator};
use naga::{AddressSpace, ImageClass, Module, ResourceBinding, ShaderStage, StorageAccess, TypeInner};

/// A text that naga takes.
struct Kernel {
    module: Module,
    info: ModuleInfo,
    /// Whether it needs subgroups or integers of 64 bits.
    advanced: bool,
}

impl Kernel {
    fn new(text: &str) -> Result<Self, String> {
        let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
        let validate = |capabilities| {
            let mut validator = Validator::new(ValidationFlags::all(), capabilities);
            validator.subgroup_stages(naga::valid::ShaderStages::COMPUTE);
            validator.subgroup_operations(SubgroupOperationSet::all());
            validator.validate(&module).map_err(Box::new)
        };
        let advanced = validate(Capabilities::empty()).is_err();
        let info = validate(Capabilities::SUBGROUP | Capabilities::SHADER_INT64);
        let info = info.map_err(|error| error.emit_to_string(text))?;
        Ok(Self { module, info, advanced })
    }

    /// What is bound, each with its kind.
    fn bindings(&self) -> impl Iterator<Item = (ResourceBinding, Bound)> {
        self.module.global_variables.iter().filter_map(|(_, variable)| {
            let kind = match (variable.space, &self.module.types[variable.ty].inner) {
                (AddressSpace::Uniform, _) => Bound::Uniform,
                (AddressSpace::Storage { access }, _) => Bound::Storage(access),
                (_, TypeInner::Image { class: ImageClass::Storage { access, .. }, .. }) => Bound::Image(*access),
                _ => Bound::Texture,
            };
            Some((variable.binding?, kind))
        })
    }
}

/// A kind of resource.
#[derive(Clone, Copy)]
enum Bound {
    Uniform,
    Storage(StorageAccess),
    Image(StorageAccess),
    Texture,
}

/// The same policy for all that may be out of range.
fn policies(policy: BoundsCheckPolicy) -> BoundsCheckPolicies {
    BoundsCheckPolicies {
        index: policy,
        buffer: policy,
        image_load: policy,
        binding_array: BoundsCheckPolicy::Unchecked,
    }
}

/// SPIR-V as wgpu's Vulkan backend makes it, with or without naga's checks.
fn spirv(kernel: &Kernel, checked: bool) -> Result<Vec<u32>, String> {
    use spv::Capability::{
        DotProduct, DotProductInput4x8Bit, DotProductInput4x8BitPacked, DotProductInputAll, GroupNonUniform,
        GroupNonUniformArithmetic, GroupNonUniformBallot, GroupNonUniformShuffle, GroupNonUniformShuffleRelative,
        GroupNonUniformVote, ImageQuery, Int8, Int64, Shader, StorageImageExtendedFormats,
    };
    let mut capabilities = vec![Shader, ImageQuery, StorageImageExtendedFormats, Int64];
    capabilities.extend([GroupNonUniform, GroupNonUniformVote, GroupNonUniformArithmetic, GroupNonUniformBallot]);
    capabilities.extend([GroupNonUniformShuffle, GroupNonUniformShuffleRelative]);
    if !checked {
        capabilities.extend([DotProduct, DotProductInputAll, DotProductInput4x8Bit]);
        capabilities.extend([DotProductInput4x8BitPacked, Int8]);
    }
    let options = spv::Options {
        lang_version: if checked { (1, 3) } else { (1, 6) },
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::FORCE_POINT_SIZE,
        fake_missing_bindings: true, // the numbers of the text
        capabilities: Some(capabilities.into_iter().collect()),
        bounds_check_policies: policies(if checked {
            BoundsCheckPolicy::Restrict
        } else {
            BoundsCheckPolicy::Unchecked
        }),
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: checked,
        ..spv::Options::default()
    };
    spv::write_vec(&kernel.module, &kernel.info, &options, None).map_err(|error| format!("SPIR-V: {error}"))
}

/// The Metal Shading Language, without naga's checks.
fn metal(kernel: &Kernel) -> Result<String, String> {
    let mut resources = msl::EntryPointResources::default();
    let (mut buffers, mut textures) = (0, 0);
    for (binding, kind) in kernel.bindings() {
        let count = if matches!(kind, Bound::Image(_) | Bound::Texture) { &mut textures } else { &mut buffers };
        let slot = Some(*count);
        *count += 1;
        let writes = |access: StorageAccess| access.contains(StorageAccess::STORE);
        let target = match kind {
            Bound::Uniform => msl::BindTarget { buffer: slot, ..Default::default() },
            Bound::Storage(access) => msl::BindTarget { buffer: slot, mutable: writes(access), ..Default::default() },
            Bound::Image(access) => msl::BindTarget { texture: slot, mutable: writes(access), ..Default::default() },
            Bound::Texture => msl::BindTarget { texture: slot, ..Default::default() },
        };
        resources.resources.insert(binding, target);
    }
    resources.sizes_buffer = Some(buffers);
    let entry_points = kernel.module.entry_points.iter();
    let options = msl::Options {
        lang_version: (3, 0),
        per_entry_point_map: entry_points.map(|entry| (entry.name.clone(), resources.clone())).collect(),
        fake_missing_bindings: false,
        bounds_check_policies: policies(BoundsCheckPolicy::Unchecked),
        zero_initialize_workgroup_memory: false,
        force_loop_bounding: false,
        ..msl::Options::default()
    };
    let written = msl::write_string(&kernel.module, &kernel.info, &options, &msl::PipelineOptions::default());
    let (text, translated) = written.map_err(|error| format!("MSL: {error}"))?;
    match translated.entry_point_names.into_iter().find_map(Result::err) {
        Some(error) => Err(format!("MSL: {error}")),
        None => Ok(text),
    }
}

/// GLSL for each entry point, with its stage.
fn open_gl(kernel: &Kernel, version: glsl::Version) -> Result<Vec<(ShaderStage, String)>, String> {
    let mut binding_map = glsl::BindingMap::default();
    let mut counts = [0; 4];
    for (binding, kind) in kernel.bindings() {
        let count = &mut counts[match kind {
            Bound::Uniform => 0,
            Bound::Storage(_) => 1,
            Bound::Image(_) => 2,
            Bound::Texture => 3,
        }];
        binding_map.insert(binding, *count);
        *count += 1;
    }
    let image_load = match version {
        glsl::Version::Desktop(_) => BoundsCheckPolicy::ReadZeroSkipWrite,
        glsl::Version::Embedded { .. } => BoundsCheckPolicy::Unchecked,
    };
    let policies = BoundsCheckPolicies { image_load, ..policies(BoundsCheckPolicy::Unchecked) };
    let options = glsl::Options {
        version,
        writer_flags: glsl::WriterFlags::ADJUST_COORDINATE_SPACE | glsl::WriterFlags::FORCE_POINT_SIZE,
        binding_map,
        zero_initialize_workgroup_memory: false,
    };
    let text_of = |entry: &naga::EntryPoint| {
        let (shader_stage, entry_point) = (entry.stage, entry.name.clone());
        let pipeline = glsl::PipelineOptions { shader_stage, entry_point, multiview: None };
        let mut text = String::new();
        let writer = glsl::Writer::new(&mut text, &kernel.module, &kernel.info, &options, &pipeline, policies);
        let written = writer.and_then(|mut writer| writer.write());
        written.map(|_| (shader_stage, text)).map_err(|error| format!("GLSL {version}: {error}"))
    };
    kernel.module.entry_points.iter().map(text_of).collect()
}

/// The High-Level Shader Language.
fn direct_x(kernel: &Kernel) -> Result<String, String> {
    let options = hlsl::Options {
        shader_model: if kernel.advanced { hlsl::ShaderModel::V6_0 } else { hlsl::ShaderModel::V5_1 },
        zero_initialize_workgroup_memory: false,
        restrict_indexing: false,
        force_loop_bounding: false,
        ..hlsl::Options::default()
    };
    let mut text = String::new();
    let pipeline = hlsl::PipelineOptions::default();
    let written = hlsl::Writer::new(&mut text, &options, &pipeline).write(&kernel.module, &kernel.info, None);
    let reflected = written.map_err(|error| format!("HLSL: {error}"))?;
    match reflected.entry_point_names.into_iter().find_map(Result::err) {
        Some(error) => Err(format!("HLSL: {error}")),
        None => Ok(text),
    }
}

/// All files of a text: what follows its name, and the bytes. What could not be written is an error in place of the file.
fn files(text: &str) -> Vec<Result<(String, Vec<u8>), String>> {
    let kernel = match Kernel::new(text) {
        Ok(kernel) => kernel,
        Err(error) => return vec![Err(error)],
    };
    let mut files = Vec::new();
    for (kind, checked) in [("trusted.spv", false), ("checked.spv", true)] {
        let bytes = |words: Vec<u32>| words.into_iter().flat_map(u32::to_le_bytes).collect();
        files.push(spirv(&kernel, checked).map(|words| (kind.to_string(), bytes(words))));
    }
    files.push(metal(&kernel).map(|text| ("metal".into(), text.into_bytes())));
    files.push(direct_x(&kernel).map(|text| ("hlsl".into(), text.into_bytes())));
    let versions = [("es", glsl::Version::new_gles(310)), ("core", glsl::Version::Desktop(450))];
    for (kind, version) in versions.into_iter().filter(|_| !kernel.advanced) {
        match open_gl(&kernel, version) {
            Ok(texts) => files.extend(texts.into_iter().map(|(stage, text)| {
                let stage = match stage {
                    ShaderStage::Vertex => "vert",
                    ShaderStage::Fragment => "frag",
                    _ => "comp",
                };
                Ok((format!("{kind}.{stage}"), text.into_bytes()))
            })),
            Err(error) => files.push(Err(error)),
        }
    }
    files
}

/// The texts of a folder, by name.
fn texts(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    let mut paths: Vec<_> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "wgsl"));
    paths.sort();
    Ok(paths)
}

/// Writes the files of some texts: how many of each kind, and what naga refused.
fn translate(paths: &[PathBuf]) -> Result<(BTreeMap<String, usize>, Vec<String>), String> {
    let (mut counts, mut faults) = (BTreeMap::new(), Vec::new());
    for path in paths {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        for file in files(&text) {
            match file {
                Ok((kind, bytes)) => {
                    let place = path.with_extension(&kind);
                    std::fs::write(&place, bytes).map_err(|error| format!("{}: {error}", place.display()))?;
                    *counts.entry(kind).or_insert(0) += 1;
                }
                Err(error) => {
                    let line: Vec<_> = error.split_whitespace().collect();
                    faults.push(format!("{}: {}", path.display(), line.join(" ")));
                }
            }
        }
    }
    Ok((counts, faults))
}

fn run(folder: &Path) -> Result<usize, String> {
    let paths = texts(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    if paths.is_empty() {
        return Err(format!("{} has no .wgsl", folder.display()));
    }
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    let parts: Vec<_> = paths.chunks(paths.len().div_ceil(cores)).collect();
    let done: Result<Vec<_>, String> = std::thread::scope(|scope| {
        let started: Vec<_> = parts.iter().map(|part| scope.spawn(|| translate(part))).collect();
        started.into_iter().map(|part| part.join().unwrap_or_else(|_| Err("naga panicked".into()))).collect()
    });
    let (mut counts, mut refused) = (BTreeMap::new(), 0);
    for (written, faults) in done? {
        written.into_iter().for_each(|(kind, count)| *counts.entry(kind).or_insert(0) += count);
        faults.iter().for_each(|fault| eprintln!("{fault}"));
        refused += faults.len();
    }
    println!("{} wgsl", paths.len());
    counts.iter().for_each(|(kind, count)| println!("{count} {kind}"));
    Ok(refused)
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(folder), None) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: gpu-stereo-portability FOLDER");
        return ExitCode::from(2);
    };
    match run(Path::new(&folder)) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
