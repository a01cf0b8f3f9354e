//! The table and the folders of the shaders and of the reference name the same, and each shader begins with its header.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::specialisations::specialisations;
use crate::gpu::interop::SHADERS;
use crate::gpu::kernels::KERNELS;
use crate::gpu::kernels::table::Kernel;

fn folder(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Where the stages of a network are defined.
const NETWORK: &str = "src/reference/network/";

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

    // A stage's reference stands in the folder of that room: src/reference/winner/lr_check.rs; those of a network in files together.
    let references = files("src/reference", "rs");
    let in_rooms = references.iter().filter(|file| {
        file.path.matches('/').count() == 3
            && !["mod", "tests"].contains(&file.name.as_str())
            && !file.path.starts_with(NETWORK)
    });
    let references: BTreeSet<&str> = in_rooms.map(|file| file.name.as_str()).collect();
    let of_costs = |kernel: &&Kernel| !kernel.sources[0].contains(NETWORK);
    let stages: BTreeSet<&str> = KERNELS.iter().filter(of_costs).map(|kernel| kernel.stage).collect();
    assert_eq!(references, stages, "src/reference (left) and the table (right) name different stages");
}

#[test]
fn every_shader_starts_with_its_header() {
    let references = files("src/reference", "rs");
    for SourceFile { name: file, path: shader, text } in files("shaders", "wgsl") {
        let header: Vec<&str> = text.lines().take_while(|line| line.starts_with("//")).collect();
        assert!(!header.is_empty(), "{shader} has no header");
        assert!(header.len() <= 10, "{shader}: the header has {} lines, at most 10 are read", header.len());
        let named = header.iter().find_map(|line| line.strip_prefix("// Reference: "));
        if let Some(kernel) = KERNELS.iter().find(|kernel| kernel.name == file) {
            assert!(header[0].starts_with(&format!("// {file}: ")), "{shader}: its first line names it");
            let last = header[header.len() - 1];
            assert!(last.starts_with("// Reference: "), "{shader}: the header ends with {last:?}");
            let of_stage = |file: &&SourceFile| match file.path.starts_with(NETWORK) {
                true => file.text.contains("/// Stage") && file.text.contains(&format!("`{}`", kernel.stage)),
                false => file.name == kernel.stage,
            };
            let own = &references.iter().find(of_stage).unwrap().path;
            assert!(named.is_some_and(|n| n.split(", ").any(|n| n == own)), "{shader} does not name {own}");
        }
        for path in named.into_iter().flat_map(|named| named.split(", ")) {
            assert!(folder(path).is_file(), "{shader} names {path}, which does not exist");
        }
    }
}

/// The names after `label` in the header of a shader.
fn named<'a>(text: &'a str, label: &str) -> Vec<&'a str> {
    let header = text.lines().take_while(|line| line.starts_with("//"));
    header.filter_map(|line| line.strip_prefix(label)).flat_map(|names| names.split(", ")).collect()
}

/// What is wrong with the names of fragments in a header: `fixed` are those appended always, `chosen` all of which some are.
fn wrong_names(text: &str, fixed: &[&str], chosen: &BTreeSet<&str>) -> Option<String> {
    let (with, patterns) = (named(text, "// With: "), named(text, "// Chosen: "));
    let fits = |pattern: &str, name: &str| match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == pattern,
    };
    let unnamed = chosen.iter().find(|name| !patterns.iter().any(|pattern| fits(pattern, name)));
    let unused = patterns.iter().find(|pattern| !chosen.iter().any(|name| fits(pattern, name)));
    match (unnamed, unused) {
        _ if with != fixed => Some(format!("is with {with:?}, but its row says {fixed:?}")),
        (Some(name), _) => Some(format!("has no {name} among its chosen fragments")),
        (_, Some(pattern)) => Some(format!("names {pattern}, which is never chosen")),
        _ => None,
    }
}

/// `With` has the fragments that are always appended, in their order, `Chosen` those of which the settings choose some.
#[test]
fn headers_name_the_fragments() {
    let shaders = files("shaders", "wgsl");
    let name = |text: &str| shaders.iter().find(|file| file.text == text).unwrap().name.as_str();
    let all = specialisations();
    for kernel in KERNELS {
        let fixed: Vec<&str> = kernel.sources[1..].iter().map(|text| name(text)).collect();
        let texts: BTreeSet<&str> = all.iter().flat_map(|(params, _, plan)| kernel.fragments(params, plan)).collect();
        let chosen = texts.into_iter().filter(|text| !kernel.sources.contains(text)).map(name).collect();
        let wrong = wrong_names(kernel.sources[0], &fixed, &chosen);
        assert!(wrong.is_none(), "{}.wgsl {}", kernel.name, wrong.unwrap());
    }
    for (file, text) in SHADERS.iter().filter(|(_, text)| text.contains("fn main(")) {
        let kind = file.split('_').next().unwrap();
        let parts = SHADERS.iter().filter(|(part, text)| part.starts_with(kind) && !text.contains("fn main("));
        let chosen = parts.map(|(part, _)| *part).collect();
        let wrong = wrong_names(text, &["common"], &chosen);
        assert!(wrong.is_none(), "{file}.wgsl {}", wrong.unwrap());
    }
}

/// The test of the test above.
#[test]
fn wrong_names_of_fragments_are_found() {
    let text = "// a: b\n// With: bytes, common\n// Chosen: sums*, costs\n\n// With: another\n";
    let chosen = BTreeSet::from(["sums16", "sums32", "costs"]);
    assert_eq!(wrong_names(text, &["bytes", "common"], &chosen), None);
    let wrong =
        |fixed: &[&str], chosen: &[&'static str]| wrong_names(text, fixed, &chosen.iter().copied().collect()).unwrap();
    assert!(wrong(&["common", "bytes"], &["sums16", "sums32", "costs"]).contains("its row says"));
    assert!(wrong(&["bytes", "common"], &["sums16", "costs", "root"]).contains("no root"));
    assert!(wrong(&["bytes", "common"], &["sums16"]).contains("names costs"));
}
