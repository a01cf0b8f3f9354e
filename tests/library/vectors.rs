//! docs/vectors.json: checksums of every stage for a pair that a formula makes, so that another implementation finds its first
//! wrong stage. docs/VECTORS.md describes them. After a change of bits that is meant:
//!
//!     GPU_STEREO_UPDATE_VECTORS=1 cargo test --test library vectors

use crate::support::mixed;
use gpu_stereo::features::{Layer, LayerKind};
use gpu_stereo::{Camera, Distortion, FeatureNetwork, Image, Lens, Masks, Params, Pixels, Rectification, reference};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(ROOT).join(path)).unwrap()
}

/// Channel c of the left image: a rough surface, saturated in places, and one without texture.
fn left(x: u32, y: u32, c: u32) -> u32 {
    if y >= 27 && x < 24 {
        return 40_000;
    }
    let sum: u32 = [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|(i, j)| mixed(x + i, y + j, c)).sum();
    (2 * (sum >> 2)).saturating_sub(32_768).min(65_535)
}

/// Channel c of the right image: a rectangle at 11 px before a background at 5 px, a patch that matches nothing, noise.
fn right(x: u32, y: u32, c: u32) -> u32 {
    let near = (7..=20).contains(&y) && (9..=22).contains(&x);
    let foreign = (22..=26).contains(&y) && (30..=36).contains(&x);
    let v = match (near, foreign) {
        (true, _) => left(x + 11, y, c),
        (_, true) => mixed(x, y, c + 4),
        _ => left(x + 5, y, c),
    };
    (v + (mixed(x, y, c + 8) >> 7)).min(65_535)
}

fn image(case: &Value, side: usize) -> Image {
    let [width, height] = ["width", "height"].map(|name| case[name].as_u64().unwrap() as u32);
    let formula = [left, right][side];
    let samples = |channels: u32| -> Vec<u16> {
        let pixel = |i: u32| (0..channels).map(move |c| formula(i % width, i / width, c) as u16);
        (0..width * height).flat_map(pixel).collect()
    };
    let high = |samples: Vec<u16>| samples.into_iter().map(|v| (v >> 8) as u8).collect();
    let pixels = match case["formats"][side].as_str().unwrap() {
        "gray8" => Pixels::Gray8(high(samples(1))),
        "gray16" => Pixels::Gray16(samples(1)),
        "rgba8" => Pixels::Rgba8(high(samples(4))),
        "rgba16" => Pixels::Rgba16(samples(4)),
        other => panic!("there is no format {other}"),
    };
    Image::new(width, height, pixels).unwrap()
}

/// Both masks, if the case has them.
fn masks(case: &Value, width: u32, height: u32) -> Option<Masks> {
    let has = |side: usize, x: u32, y: u32| match side {
        0 => !((3..=9).contains(&x) && (13..=17).contains(&y)) && x + 2 < width,
        _ => x.abs_diff(28).pow(2) + y.abs_diff(9).pow(2) > 10,
    };
    let byte =
        |side: usize, i: u32| if has(side, i % width, i / width) { (1 + i % width + i / width) as u8 } else { 0 };
    let sides = [0, 1].map(|side| Some((0..width * height).map(|i| byte(side, i)).collect()));
    (case["masks"] == "on").then(|| Masks::new(width, height, sides).unwrap())
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect();
    numbers.try_into().unwrap()
}

fn lens(value: &Value) -> Lens {
    let distortion = match value.get("fisheye") {
        Some(fisheye) => Distortion::Fisheye(numbers(fisheye)),
        None => Distortion::Pinhole(numbers(&value["pinhole"])),
    };
    let [matrix, rotation, projection] = ["matrix", "rotation", "projection"].map(|name| numbers(&value[name]));
    Lens::new(matrix, distortion, rotation, projection)
}

/// The network of docs/VECTORS.md.
fn formula_network() -> FeatureNetwork {
    let kinds = [LayerKind::Convolution, LayerKind::Depthwise, LayerKind::Point, LayerKind::Point];
    let (mut layers, mut inputs) = (Vec::new(), 1);
    for ((n, kind), outputs) in (0..).zip(kinds).zip([8, 8, 12, 8]) {
        let each = kind.weights(inputs) as u32;
        let weights = |o: u32| (0..each).map(move |k| (mixed(k, o, 16 + n) % 255) as i16 - 127);
        let weights = (0..outputs).flat_map(weights).map(|weight| weight as i8).collect();
        let [bias, multiplier, shift] = [(0, 2001, -1000), (1, 300, 100), (2, 3, 14)]
            .map(|(i, many, first)| (0..outputs).map(|o| (mixed(o, i, 24 + n) % many) as i32 + first).collect());
        let outputs = outputs as usize;
        layers.push(Layer { kind, relu: n % 2 == 0, inputs, outputs, weights, bias, multiplier, shift });
        inputs = outputs;
    }
    FeatureNetwork::new(layers).unwrap()
}

/// The settings of a case: every parameter of the page by its name.
fn params(case: &Value) -> Params {
    let mut params = Params::sgm(1);
    let [width, height] = ["width", "height"].map(|name| case[name].as_u64().unwrap() as u32);
    for (name, value) in case.as_object().unwrap() {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
        let parts: Vec<&str> = text.split(',').collect();
        let mut set = |option: &str, value: &str| params.set(option, value).unwrap();
        match name.as_str() {
            "width" | "height" | "formats" => {}
            "min_disparity" => set("min-disp", &text),
            "disparities" => set("disp", &text),
            "wls" if text == "off" => set("wls", "off"),
            "wls" => {
                set("wls-lambda", parts[0]);
                set("wls-sigma", parts[1]);
            }
            "confidence" => params.confidence = text == "on",
            "labels" => params.labels = text == "on",
            "right_map" => params.right_map = text == "on",
            "depth" if text == "off" => {}
            "depth" => {
                let [focal, baseline, doffs] = [0, 1, 2].map(|i| parts[i].parse().unwrap());
                params.depth = Some(Camera::new(focal, baseline).with_doffs(doffs));
            }
            "features" => params.features = Some(formula_network()),
            "masks" => params.masks = masks(case, width, height),
            "rectify" => {
                let lenses = [lens(&value[0]), lens(&value[1])];
                params.rectify = Some(Rectification::new(width, height, lenses).unwrap());
            }
            _ => set(&name.replace('_', "-"), &text),
        }
    }
    params
}

/// CRC-32 as zlib, PNG and Ethernet have it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}

/// A stage, the bytes of its result and their checksum.
type Stage = (String, usize, String);

fn stages(left: &Image, right: &Image, params: &Params) -> Vec<Stage> {
    let mut stages = Vec::new();
    let mut receive =
        |stage: &str, bytes: &[u8]| stages.push((stage.to_string(), bytes.len(), format!("{:08x}", crc32(bytes))));
    reference::compute_traced(left, right, params, &mut receive).unwrap();
    stages
}

fn known(vector: &Value) -> Vec<Stage> {
    let stage = |of: &Value| {
        let text = |i: usize| of[i].as_str().unwrap().to_string();
        (text(0), of[1].as_u64().unwrap() as usize, text(2))
    };
    vector["stages"].as_array().unwrap().iter().map(stage).collect()
}

/// The first stage that differs.
fn difference(found: &[Stage], known: &[Stage]) -> Option<String> {
    let first = (0..found.len().max(known.len())).find(|&i| found.get(i) != known.get(i))?;
    let [found, known] = [found.get(first), known.get(first)];
    let name = found.or(known).map(|stage| &stage.0)?;
    Some(format!("{name} (number {first}): {found:?} was found where {known:?} is known"))
}

fn vectors() -> Vec<Value> {
    let file: Value = serde_json::from_str(&text("docs/vectors.json")).unwrap();
    file["vectors"].as_array().unwrap().clone()
}

/// The file with other stages: the line after `"stages": [` to the one before the next `]`.
fn with_stages(text: &str, stages: &[Vec<Stage>]) -> String {
    let (mut stages, mut inside, mut written) = (stages.iter(), false, String::new());
    for line in text.lines() {
        inside &= line.trim() != "]";
        if !inside {
            writeln!(written, "{line}").unwrap();
        }
        if line.trim() == "\"stages\": [" {
            inside = true;
            let rows = stages.next().expect("as many lists of stages as vectors");
            let rows = rows.iter().map(|(name, bytes, crc)| format!("        [\"{name}\", {bytes}, \"{crc}\"]"));
            writeln!(written, "{}", rows.collect::<Vec<_>>().join(",\n")).unwrap();
        }
    }
    written
}

#[test]
fn every_stage_has_its_checksum() {
    let vectors = vectors();
    let found: Vec<_> = vectors
        .iter()
        .map(|vector| {
            let case = &vector["case"];
            stages(&image(case, 0), &image(case, 1), &params(case))
        })
        .collect();
    if std::env::var_os("GPU_STEREO_UPDATE_VECTORS").is_some() {
        let updated = with_stages(&text("docs/vectors.json"), &found);
        std::fs::write(Path::new(ROOT).join("docs/vectors.json"), updated).unwrap();
        return;
    }
    for (vector, found) in vectors.iter().zip(&found) {
        if let Some(difference) = difference(found, &known(vector)) {
            panic!("{}: stage {difference}", vector["name"]);
        }
    }
}

#[test]
fn one_changed_bit_and_one_changed_setting_are_found() {
    let vectors = vectors();
    let vector = vectors.iter().find(|vector| vector["name"] == "sgm").unwrap();
    let (case, known) = (&vector["case"], known(vector));
    let (left, right, mut params) = (image(case, 0), image(case, 1), params(case));
    assert_eq!(difference(&stages(&left, &right, &params), &known), None);

    let Pixels::Gray8(samples) = left.pixels() else { panic!("not in gray") };
    let mut samples = samples.clone();
    samples[45 * 12 + 30] ^= 1;
    let changed = Image::new(left.width(), left.height(), Pixels::Gray8(samples)).unwrap();
    let found = difference(&stages(&changed, &right, &params), &known).unwrap();
    assert!(found.starts_with("gray (number 0)"), "{found}");

    params.p2 += 1;
    let found = difference(&stages(&left, &right, &params), &known).unwrap();
    assert!(found.starts_with("sgm_aggregate"), "{found}");
    assert!(difference(&known[1..], &known).is_some() && difference(&known[..known.len() - 1], &known).is_some());
}

/// All files of a folder and of those in it.
fn files(folder: PathBuf) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(path) } else { vec![path] }).collect()
}

#[test]
fn every_stage_and_every_choice_is_covered() {
    let vectors = vectors();
    let covered: BTreeSet<String> =
        vectors.iter().flat_map(|vector| known(vector).into_iter().map(|stage| stage.0)).collect();

    // The stages of the definition say so: "Stage `name`". Those of networks have golden tensors of their own.
    let mut stages = BTreeSet::new();
    let of_networks = Path::new(ROOT).join("src/reference/network");
    for file in files(Path::new(ROOT).join("src/reference")).into_iter().filter(|file| !file.starts_with(&of_networks))
    {
        let code = std::fs::read_to_string(file).unwrap();
        let names = code.lines().filter_map(|line| line.trim().strip_prefix("/// Stage `")?.split('`').next());
        stages.extend(names.filter(|name| *name != "deep_gray").map(String::from)); // a part of `gray`
    }
    assert!(stages.len() > 24, "only {stages:?}");
    assert_eq!(stages.difference(&covered).collect::<Vec<_>>(), [""; 0], "stages without a vector");

    // So do the stages of the page: sections of one word that say what goes in.
    let page = text("docs/ALGORITHMS.md");
    let sections = page.split("\n## ").filter(|section| section.contains("\nIn: "));
    let names: BTreeSet<String> = sections.filter_map(|section| section.lines().next().map(String::from)).collect();
    assert!(names.len() > 24, "only {names:?}");
    assert_eq!(names.difference(&covered).collect::<Vec<_>>(), [""; 0], "stages of the page without a vector");

    // The description has every stage but those that give one map.
    let described = text("docs/VECTORS.md");
    assert!(described.contains("\n| any other, "), "docs/VECTORS.md does not describe the other stages");
    let rows: Vec<&str> = described.lines().filter(|line| line.starts_with("| `")).collect();
    let gives_one_map = |name: &str| {
        vectors.iter().any(|vector| {
            let pixels = ["width", "height"].map(|side| vector["case"][side].as_u64().unwrap() as usize);
            known(vector).iter().any(|(stage, bytes, _)| stage == name && *bytes == 2 * pixels[0] * pixels[1])
        })
    };
    for stage in &covered {
        let has_row = rows.iter().any(|row| row.contains(&format!("`{stage}`")));
        assert!(has_row || gives_one_map(stage), "docs/VECTORS.md does not describe the bytes of {stage}");
    }

    // Every value of every setting that takes words.
    let cases: Vec<Params> = vectors.iter().map(|vector| params(&vector["case"])).collect();
    for option in
        Params::OPTIONS.iter().filter(|option| !matches!(option.name, "schedule" | "shader-checks" | "memory-check"))
    {
        // Networks have golden tensors of their own, with a tolerance: docs/NETWORKS.md.
        let of_networks = |value: &str| option.name == "align-corners" || value == "psmnet";
        for (value, _) in option.values.iter().filter(|(value, _)| !of_networks(value)) {
            assert!(cases.iter().any(|case| option.get(case) == *value), "no vector has --{} {value}", option.name);
        }
    }
}
