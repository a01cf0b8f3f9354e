//! docs/ALGORITHMS.md is enough to write the chain again: tests/algorithms.py follows the page alone, and
//! every stage of it equals the reference, for the cases below and for docs/vectors.json.

use crate::support;
use gpu_stereo::{
    Cost, DisparityMap, Distortion, Image, Median, Method, Params, Paths, PixelFormat, Pixels, Prefilter, Preset,
    Rectification, RightView, reference,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const PAGE: &str = include_str!("../../docs/ALGORITHMS.md");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/algorithms.py");

/// Runs the script; `None` where there is no Python, and then says so.
fn python(arguments: &[&str]) -> Option<String> {
    let probe = Command::new("python3").args(["-c", "import sys; sys.exit(sys.version_info < (3, 8))"]).status();
    let missing = match probe {
        Ok(status) if status.success() => None,
        Ok(_) => Some("python3 does not run or is older than 3.8".to_string()),
        Err(error) => Some(format!("python3 does not start: {error}")),
    };
    if let Some(why) = missing {
        // Not eprintln!, which the test harness holds back when a test passes.
        let mut console = std::io::stderr();
        writeln!(console, "NOT TESTED: docs/ALGORITHMS.md against the reference, {why}").unwrap();
        return None;
    }
    let output = Command::new("python3").arg(SCRIPT).args(arguments).output().unwrap();
    assert!(output.status.success(), "tests/algorithms.py failed:\n{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

fn median_side(params: &Params) -> Option<usize> {
    match params.median {
        Median::Off => None,
        Median::Three => Some(3),
        Median::Five => Some(5),
        other => panic!("no side of {other:?}"),
    }
}

/// The settings by the page's names.
fn settings(params: &Params) -> Vec<(&'static str, String)> {
    let number = |n: u32| n.to_string();
    let mut settings = vec![
        ("min_disparity", params.min_disparity.to_string()),
        ("disparities", number(params.disparities)),
        ("method", params.get("method").unwrap()),
        ("cost", params.get("cost").unwrap()),
        ("census", params.get("census").unwrap()),
        ("ad_weight", number(params.ad_weight)),
        ("census_weight", number(params.census_weight)),
        ("learned_weight", number(params.learned_weight)),
        ("color_cost", params.get("color-cost").unwrap()),
        ("paths", number(params.paths.count())),
        ("block", number(params.block)),
        ("prefilter", params.get("prefilter").unwrap()),
        ("prefilter_cap", number(params.prefilter_cap)),
        ("prefilter_window", number(params.prefilter_window)),
        ("p1", number(params.p1)),
        ("p2", number(params.p2)),
        ("adaptive_p1", params.get("adaptive-p1").unwrap()),
        ("adaptive_p2", params.get("adaptive-p2").unwrap()),
        ("p2_step", number(params.p2_step)),
        ("passes", number(params.passes)),
        ("smoothness", params.get("smoothness").unwrap()),
        ("smoothness_weight", number(params.smoothness_weight)),
        ("smoothness_truncation", number(params.smoothness_truncation)),
        ("smoothness_edge", params.smoothness_edge.map_or("off".into(), number)),
        ("bp_levels", number(params.bp_levels)),
        ("bp_iterations", number(params.bp_iterations)),
        ("bp_reweighting", number(params.bp_reweighting)),
        ("texture", number(params.texture)),
        ("uniqueness", number(params.uniqueness)),
        ("lr_check", params.lr_check.map_or("off".into(), number)),
        ("right_view", format!("{:?}", params.right_view).to_lowercase()),
        ("speckle_window", number(params.speckle_window)),
        ("speckle_range", number(params.speckle_range)),
        ("median", median_side(params).map_or("off".into(), |side| side.to_string())),
        ("fill", params.get("fill").unwrap()),
        ("subpixel", format!("{:?}", params.subpixel).to_lowercase()),
        ("weighted_median", params.weighted_median.map_or("off".into(), number)),
        ("weighted_median_sigma", number(params.weighted_median_sigma)),
        ("wls", params.wls.map_or("off".into(), |wls| format!("{},{}", f64::from(wls.lambda), f64::from(wls.sigma)))),
    ];
    // All other options by their own names.
    let written = ["disp", "min-disp", "wls-lambda", "wls-sigma", "schedule", "shader-checks", "memory-check"];
    let written = [&written[..], &["align-corners"]].concat(); // of networks, which docs/NETWORKS.md defines
    for option in Params::OPTIONS.iter().filter(|option| !written.contains(&option.name)) {
        let name = option.name.replace('-', "_");
        if settings.iter().all(|(known, _)| *known != name) {
            settings.push((name.leak(), option.get(params)));
        }
    }
    settings
}

/// A layer of a network of features: for each output its weights, bias, multiplier and shift.
fn layer(layer: &gpu_stereo::features::Layer) -> String {
    let each = layer.kind.weights(layer.inputs);
    let output = |o: usize| {
        let weights = &layer.weights[o * each..][..each];
        format!("[{weights:?}, {}, {}, {}]", layer.bias[o], layer.multiplier[o], layer.shift[o])
    };
    let outputs: Vec<String> = (0..layer.outputs).map(output).collect();
    format!("{{\"kind\": \"{}\", \"relu\": {}, \"outputs\": [{}]}}", layer.kind, layer.relu, outputs.join(", "))
}

fn json(Case { left, right, params }: &Case) -> String {
    let format = |image: &Image| match image.format() {
        PixelFormat::Gray8 => "gray8",
        PixelFormat::Gray16 => "gray16",
        PixelFormat::Rgba8 => "rgba8",
        PixelFormat::Rgba16 => "rgba16",
        other => panic!("no name for {other:?}"),
    };
    let mut fields = vec![
        format!("\"width\": {}", left.width()),
        format!("\"height\": {}", left.height()),
        format!("\"formats\": {:?}", [left, right].map(format)),
    ];
    let camera = |c: gpu_stereo::Camera| format!("{},{},{}", c.focal, c.baseline, c.doffs);
    let switch = |on| if on { "on" } else { "off" }.to_string();
    let outputs = [
        ("right_map", switch(params.right_map)),
        ("confidence", switch(params.confidence)),
        ("labels", switch(params.labels)),
        ("depth", params.depth.map_or("off".into(), camera)),
    ];
    for (name, value) in settings(params).into_iter().chain(outputs) {
        let value = if value.parse::<i64>().is_ok() { value } else { format!("\"{value}\"") };
        fields.push(format!("\"{name}\": {value}"));
    }
    if let Some(network) = params.features.as_ref().filter(|_| params.cost.to_string().starts_with("learned")) {
        let layers: Vec<String> = network.layers().iter().map(layer).collect();
        fields.push(format!("\"features\": [{}]", layers.join(", ")));
    }
    if let Some(rectification) = &params.rectify {
        let lens = |lens: &gpu_stereo::Lens| {
            let gpu_stereo::Lens { matrix, distortion, rotation, projection, .. } = lens;
            let model = match distortion {
                Distortion::Fisheye(_) => "fisheye",
                Distortion::DoubleSphere(_) => "double_sphere",
                Distortion::ExtendedUnified(_) => "extended_unified",
                _ => "pinhole",
            };
            format!(
                "{{\"matrix\": {matrix:?}, \"{model}\": {:?}, \"rotation\": {rotation:?}, \
                 \"projection\": {projection:?}}}",
                distortion.numbers()
            )
        };
        let lenses = rectification.lenses().each_ref().map(lens).join(", ");
        fields.push(format!("\"rectify\": [{lenses}]"));
    }
    if let Some(masks) = &params.masks {
        let side = |side| masks.side(side).map_or("null".into(), |mask: &[u8]| format!("{mask:?}"));
        fields.push(format!("\"masks\": [{}, {}]", side(0), side(1)));
    }
    format!("{{{}}}\n", fields.join(", "))
}

fn samples(image: &Image) -> Vec<u8> {
    match image.pixels() {
        Pixels::Gray8(s) | Pixels::Rgba8(s) => s.clone(),
        Pixels::Gray16(s) | Pixels::Rgba16(s) => s.iter().flat_map(|v| v.to_le_bytes()).collect(),
        other => panic!("no bytes of {other:?}"),
    }
}

struct Case {
    left: Image,
    right: Image,
    params: Params,
}

/// Few gray levels in large steps: many equal costs, and the extremes of every sum.
fn few_levels(width: u32, height: u32, format: u32, random: &mut ChaCha8Rng) -> Image {
    let levels = [0, 0, 0, u16::MAX, u16::MAX, 0x4000];
    let samples: Vec<u16> =
        (0..width * height * if format < 2 { 1 } else { 4 }).map(|_| levels[random.random_range(0..6)]).collect();
    let narrow = |samples: Vec<u16>| samples.into_iter().map(|v| (v >> 8) as u8).collect();
    let pixels = match format {
        0 => Pixels::Gray8(narrow(samples)),
        1 => Pixels::Gray16(samples),
        2 => Pixels::Rgba8(narrow(samples)),
        _ => Pixels::Rgba16(samples),
    };
    Image::new(width, height, pixels).unwrap()
}

/// Uniform noise over all samples, for the rounding of `gray`.
fn noise(width: u32, height: u32, format: u32, random: &mut ChaCha8Rng) -> Image {
    let count = width * height;
    let pixels = match format {
        0 => Pixels::Gray8((0..count).map(|_| random.random()).collect()),
        1 => Pixels::Gray16((0..count).map(|_| random.random()).collect()),
        2 => Pixels::Rgba8((0..4 * count).map(|_| random.random()).collect()),
        _ => Pixels::Rgba16((0..4 * count).map(|_| random.random()).collect()),
    };
    Image::new(width, height, pixels).unwrap()
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    // Pairs with a truth, in every pair of formats, with random parameters.
    for seed in 0..48 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let params = support::random_params(&mut random);
        let (width, height) = (random.random_range(1..40), random.random_range(1..10));
        let (left, right) = support::pair(width, height, seed);
        let (left_format, right_format) = (seed as u32 % 4, seed as u32 / 4 % 4);
        let (left, right) = (support::as_format(&left, left_format), support::as_format(&right, right_format));
        cases.push(Case { left, right, params });
    }
    // Ties, and noise; small ranges so that a winner often has neighbours of equal cost.
    for seed in 100..148 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = support::random_params(&mut random);
        params.disparities = random.random_range(1..9);
        params.block = 2 * random.random_range(0..3) + if params.cost == Cost::Ncc { 3 } else { 1 };
        params.min_disparity = random.random_range(-5..5);
        if random.random() {
            params.p2 = random.random_range(0..12);
            params.p1 = random.random_range(0..=params.p2);
        }
        let (width, height) = (random.random_range(1..24), random.random_range(1..9));
        let format = seed as u32 % 4;
        let image = if seed % 8 < 4 { few_levels } else { noise };
        let left = image(width, height, format, &mut random);
        let right = image(width, height, format, &mut random);
        cases.push(Case { left, right, params });
    }
    // The ends of the ranges.
    let mut edge = |width, height, seed: u64, change: &dyn Fn(&mut Params)| {
        for mut params in [Params::sgm(7), Params::bm(7)] {
            change(&mut params);
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let left = few_levels(width, height, 0, &mut random);
            let right = few_levels(width, height, 0, &mut random);
            cases.push(Case { left, right, params });
        }
    };
    edge(1, 1, 200, &|_| ());
    edge(1, 5, 201, &|_| ());
    edge(13, 1, 202, &|_| ());
    edge(6, 3, 203, &|params| {
        params.min_disparity = -Params::MAX_ABS_DISPARITY;
        params.disparities = 2 * Params::MAX_ABS_DISPARITY as u32 + 1;
        params.lr_check = Some(4095);
        params.block = 1;
    });
    edge(9, 4, 204, &|params| params.min_disparity = Params::MAX_ABS_DISPARITY - 6);
    edge(9, 4, 205, &|params| params.min_disparity = -Params::MAX_ABS_DISPARITY);
    edge(9, 4, 206, &|params| {
        params.block = Params::MAX_BLOCK;
        params.prefilter = Prefilter::None;
        params.paths = Paths::Eight;
        params.p1 = Params::MAX_P2;
        params.p2 = Params::MAX_P2;
    });
    edge(17, 5, 207, &|params| {
        params.block = 1;
        params.prefilter_cap = Params::MAX_CAP;
        params.prefilter = Prefilter::Sobel;
        params.paths = Paths::Eight;
        params.p1 = 0;
        params.p2 = Params::MAX_P2;
    });
    edge(17, 5, 208, &|params| {
        params.prefilter_cap = 1;
        params.p1 = 0;
        params.p2 = 0;
        params.uniqueness = 99;
    });
    // Every cost on samples of 16 bits, colour and gray: small blocks, then the largest block, cap and weights.
    for (seed, option) in (300..).zip(support::costs().into_iter().chain(["learned", "learned-census"])) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for (format, census) in ["5x5", "7x7", "9x7", "cs9x7"].into_iter().enumerate() {
            let mut params = if format % 2 == 0 { Params::sgm(6) } else { Params::bm(6) };
            params.min_disparity = -2;
            params.block = 2 * random.random_range(0..4) + 1;
            let mut set = |name: &str, value: &str| params.set(name, value).unwrap();
            set("cost", option);
            set("census", census);
            params.features = Some(support::feature_network(&mut random));
            let mut set = |name: &str, value: &str| params.set(name, value).unwrap();
            set("prefilter", ["none", "xsobel", "normalized", "none"][format]);
            if matches!(option, "sad" | "bt") && format >= 2 {
                set("color-cost", "on");
            }
            let left = noise(14, 9, format as u32, &mut random);
            let right = noise(14, 9, format as u32, &mut random);
            cases.push(Case { left, right, params });
        }
        for mut params in [Params::sgm(4), Params::bm(4)] {
            params.block = Params::MAX_BLOCK;
            params.prefilter = Prefilter::None;
            params.set("cost", option).unwrap();
            params.prefilter_cap = match option {
                "sad-xy" => 63,
                "census-sobel" | "learned-census" => 32,
                "bt-gray" => 96,
                _ => Params::MAX_CAP,
            };
            (params.ad_weight, params.census_weight, params.learned_weight) = (64, 64, 64);
            params.features = Some(support::feature_network(&mut random));
            let left = few_levels(11, 6, 1, &mut random);
            let right = few_levels(11, 6, 1, &mut random);
            cases.push(Case { left, right, params });
        }
    }
    // The network of the library; sides shorter than it reaches.
    for (i, (width, height)) in [(7, 3), (2, 2), (1, 1)].into_iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(390 + i as u64);
        let mut params = Params::sgm(3);
        params.min_disparity = -1;
        params.set("cost", if i == 1 { "learned-census" } else { "learned" }).unwrap();
        params.block = 1;
        let [left, right] = [0, 1].map(|_| noise(width, height, i as u32, &mut random));
        cases.push(Case { left, right, params });
    }
    // Windows and blocks at their largest, on 16 bits: the largest sums. Weights that leave no cost at all.
    for (window, cost) in [(51, "zsad"), (3, "zsad"), (51, "ad-census")] {
        let mut random = ChaCha8Rng::seed_from_u64(400 + window);
        let mut params = Params::sgm(5);
        params.set("cost", cost).unwrap();
        params.prefilter = Prefilter::Normalized;
        params.prefilter_window = window as u32;
        params.prefilter_cap = if cost == "zsad" { Params::MAX_CAP } else { 1 };
        params.block = if cost == "zsad" { Params::MAX_BLOCK } else { 1 };
        (params.ad_weight, params.census_weight) = (1, 0);
        let left = few_levels(15, 7, 3, &mut random);
        let right = few_levels(15, 7, 3, &mut random);
        cases.push(Case { left, right, params });
    }
    // One step of gray in a flat pair: all ties.
    for params in [Params::sgm(5), Params::bm(5)] {
        let image = |at: usize| {
            let samples = (0..60).map(|i| if i % 12 < at { 90 } else { 91 }).collect();
            Image::new(12, 5, Pixels::Gray8(samples)).unwrap()
        };
        cases.push(Case { left: image(6), right: image(4), params });
    }
    // Mutual information of images that are halved once.
    for (seed, mut params) in (300..).zip([Params::sgm(6), Params::bm(5)]) {
        (params.cost, params.prefilter, params.min_disparity) = (Cost::MutualInformation, Prefilter::None, -1);
        params.block = 2 * (seed as u32 - 300) + 1;
        let (left, right) = support::pair(35, 33, seed);
        cases.push(Case { left, right, params });
    }
    // Pairs that are rectified first, in every format; lenses that look away; every model of a lens.
    for seed in 0..9 {
        let mut random = ChaCha8Rng::seed_from_u64(500 + seed);
        let mut params = Params::sgm(6);
        let mut lenses = support::lenses(31, 14);
        if seed == 4 {
            lenses[1].rotation = [-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
        }
        if seed > 4 {
            // Half of the rays of the left lens come from behind it.
            lenses[0].distortion = Distortion::Fisheye([0.0158, -0.0197, 0.0204, -0.0072]);
            lenses[0].projection[0] /= 9.0;
            lenses[0].rotation = [0.2, 0.0, 0.98, 0.0, 1.0, 0.0, -0.98, 0.0, 0.2];
            let prism = [-0.28, 0.09, 0.0011, -0.0004, 0.01, 0.3, 0.1, 0.02, 0.01, -0.02, 0.015, 0.003, 0.12, -0.2];
            lenses[1].distortion = Distortion::pinhole(&prism[..[12, 14][seed as usize % 2]]).unwrap();
        }
        if seed > 6 {
            lenses[0].distortion = Distortion::DoubleSphere([-0.24, 0.56]);
            lenses[1].distortion = Distortion::ExtendedUnified([0.6, 1.1]);
        }
        params.rectify = Some(Rectification::new(31, 14, lenses).unwrap());
        let image = if seed % 2 == 0 { noise } else { few_levels };
        let [left, right] = [0, 1].map(|_| image(31, 14, seed as u32 % 4, &mut random));
        cases.push(Case { left, right, params });
    }
    // Pairs of which parts are masked, one side or both, also before they are rectified and with rounds that are halved.
    for seed in 600..624 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = support::random_params(&mut random);
        (params.disparities, params.min_disparity) = (random.random_range(2..9), random.random_range(-4..3));
        params.uniqueness = 0;
        let (mut width, mut height) = (random.random_range(1..40), random.random_range(1..12));
        if seed % 6 == 5 {
            (params.cost, params.color_cost, params.block) = (Cost::MutualInformation, false, 1);
            (width, height) = (37, 33);
        }
        if seed % 3 == 1 {
            params.rectify = Some(Rectification::new(width, height, support::lenses(width, height)).unwrap());
        }
        params.masks = Some(support::masks(width, height, seed));
        let (left, right) = support::pair(width, height, seed);
        let [left, right] = [left, right].map(|image| support::as_format(&image, seed as u32 % 4));
        cases.push(Case { left, right, params });
    }
    // Belief propagation: every smoothness, edges, levels down to a single pixel, ties, the ends of the ranges.
    for seed in 700..724 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = Params::bp(random.random_range(1..12));
        params.set("smoothness", ["linear", "quadratic", "potts"][seed as usize % 3]).unwrap();
        params.smoothness_truncation = *[0, 40, 127, 20].get(random.random_range(0..4)).unwrap();
        params.smoothness_weight = *[0, 1, 8, 127].get(random.random_range(0..4)).unwrap();
        params.smoothness_edge = if random.random() { None } else { Some(random.random_range(1..=255)) };
        (params.bp_levels, params.bp_iterations) = (random.random_range(1..=10), random.random_range(1..=7));
        params.bp_reweighting = random.random_range(4..=16);
        params.block = 2 * random.random_range(0..2) + 1;
        params.min_disparity = random.random_range(-4..3);
        if seed % 4 == 0 {
            params.right_view = RightView::Match;
        }
        let (width, height) = (random.random_range(1..24), random.random_range(1..12));
        let (left, right) = match seed % 2 {
            0 => support::pair(width, height, seed),
            _ => (few_levels(width, height, 0, &mut random), few_levels(width, height, 0, &mut random)),
        };
        cases.push(Case { left, right, params });
    }
    // Luma exactly half way between two levels.
    let half = |&(r, g, b): &(u32, u32, u32)| (9798 * r + 19235 * g + 3735 * b) % 32768 == 16384;
    let colours = (0..256).flat_map(|r| (0..256).flat_map(move |g| (0..256).map(move |b| (r, g, b))));
    let halves: Vec<u8> =
        colours.filter(half).take(120).flat_map(|(r, g, b)| [r as u8, g as u8, b as u8, 255]).collect();
    let image = |samples: &[u8]| Image::new(12, 5, Pixels::Rgba8(samples.to_vec())).unwrap();
    cases.push(Case { left: image(&halves[..240]), right: image(&halves[240..]), params: Params::sgm(5) });
    // The energy of labels, whatever method finds them, with every smoothness.
    for (i, Case { params, .. }) in (0..).zip(&mut cases) {
        params.labels = i % 4 > 0;
        if params.method != Method::Bp {
            params.set("smoothness", ["linear", "quadratic", "potts"][i as usize % 3]).unwrap();
            (params.smoothness_weight, params.smoothness_truncation) = (i * 37 % 128, i * 53 % 128);
            params.smoothness_edge = (i % 2 > 0).then_some(1 + i * 29 % 255);
        }
    }
    cases
}

#[test]
fn a_second_implementation_from_the_page_gives_the_same_bits() {
    let cases = cases();
    let root = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("algorithms");
    if root.exists() {
        std::fs::remove_dir_all(&root).unwrap(); // what an earlier run wrote must not be taken for this one's
    }
    let folder = |i: usize| root.join(format!("{i:03}"));
    for (i, case) in cases.iter().enumerate() {
        std::fs::create_dir_all(folder(i)).unwrap();
        std::fs::write(folder(i).join("case.json"), json(case)).unwrap();
        std::fs::write(folder(i).join("left.raw"), samples(&case.left)).unwrap();
        std::fs::write(folder(i).join("right.raw"), samples(&case.right)).unwrap();
    }
    let Some(said) = python(&[root.to_str().unwrap()]) else { return };
    assert_eq!(said.trim(), format!("{} cases", cases.len()));

    let (mut valid, mut invalid, mut refined) = (0, 0, 0);
    for (i, case) in cases.iter().enumerate() {
        let mut stages = Vec::new();
        let mut compare = |stage: &str, expected: &[u8]| {
            let name = format!("{:03}_{stage}.raw", stages.len());
            compare(&folder(i).join(&name), expected, &json(case));
            stages.push(name);
        };
        let matched = reference::compute_traced(&case.left, &case.right, &case.params, &mut compare).unwrap();
        let written = std::fs::read_dir(folder(i)).unwrap().count();
        assert_eq!(written, stages.len() + 3, "the page has other stages than {stages:?}, case {}", json(case));
        let map = matched.map.data;
        valid += map.iter().filter(|&&v| v != DisparityMap::INVALID).count();
        invalid += map.iter().filter(|&&v| v == DisparityMap::INVALID).count();
        refined += map.iter().filter(|&&v| v % 16 != 0).count();
    }
    // The cases say something: maps are neither empty nor full, and not of whole pixels only.
    assert!(valid > 2000 && invalid > 2000 && refined > 300, "{valid} valid, {invalid} invalid, {refined} refined");
}

fn compare(file: &Path, expected: &[u8], case: &str) {
    let Ok(found) = std::fs::read(file) else { panic!("the page does not give {}, case {case}", file.display()) };
    let name = file.display();
    assert!(!expected.is_empty() && found.len() == expected.len(), "{name}: {} bytes, case {case}", found.len());
    if let Some(i) = found.iter().zip(expected).position(|(a, b)| a != b) {
        panic!("{name}: byte {i} is {} by the page and {} by the reference, case {case}", found[i], expected[i]);
    }
}

#[test]
fn the_page_gives_the_test_vectors() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/vectors.json");
    let Some(said) = python(&["--vectors", file]) else { return };
    let known: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let vectors = known["vectors"].as_array().unwrap();
    let stages: usize = vectors.iter().map(|vector| vector["stages"].as_array().unwrap().len()).sum();
    assert!(vectors.len() >= 15 && stages >= 15 * vectors.len(), "{} vectors, {stages} stages", vectors.len());
    assert_eq!(said.trim(), format!("{} vectors, {stages} stages", vectors.len()));
}

#[test]
fn the_worked_example_is_what_the_formulas_give() {
    let Some(example) = python(&["--example"]) else { return };
    let on_page: Vec<&str> = PAGE.lines().map(str::trim_end).collect();
    let lines: Vec<String> = example.lines().map(|line| format!("    {line}").trim_end().to_string()).collect();
    assert!(lines.len() > 30);
    assert!(
        on_page.windows(lines.len()).any(|window| window == lines),
        "the page does not hold what python3 tests/algorithms.py --example prints"
    );
}

#[test]
fn the_examples_of_borders_hold() {
    let row = |data: Vec<u16>| reference::Plane { width: data.len(), height: 1, data };
    let params = Params::sgm(16); // xsobel with a cap of 31
    let filtered = reference::prefilter(&row(vec![0, 1, 2, 3]), 1, &params).data;
    assert_eq!(filtered, [4 + 31, 8 + 31, 8 + 31, 4 + 31], "prefilter: a ramp");
    assert_eq!(reference::prefilter(&row(vec![9]), 1, &params).data, [31], "prefilter: one column");

    let map = |data: Vec<i16>| DisparityMap { width: 2, height: data.len() as u32 / 2, data };
    let corner = reference::median(&map(vec![48, 16, DisparityMap::INVALID, 80]), 3);
    assert_eq!(corner.data[1], 16, "median: the upper right corner");
    let border = reference::median(&map(vec![0, 16, 16, 16, 16, 16]), 3);
    assert_eq!(border.data[0], DisparityMap::INVALID, "median: what leads out of the image");

    let columns = reference::Plane { width: 2, height: 3, data: [0, 10].repeat(3) };
    for (least, kept) in [(279, 0), (280, DisparityMap::INVALID)] {
        let mut params = Params::sgm(16);
        (params.block, params.texture) = (3, least);
        assert_eq!(reference::texture(&map(vec![0; 6]), &columns, &params).data, [kept; 6], "texture: {least}");
    }
}

/// The rows of the table whose head begins with `head`, without those two lines.
fn table(head: &str) -> Vec<Vec<&'static str>> {
    let rows = PAGE.lines().skip_while(|line| !line.starts_with(head)).take_while(|line| line.starts_with('|'));
    rows.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

#[test]
fn the_tables_of_parameters_have_every_name_and_value() {
    let presets = ["classic", "fast", "balanced", "strict", "dense", "accurate"];
    let columns: Vec<Params> = [Params::sgm(64), Params::bm(64)]
        .into_iter()
        .chain(presets.map(|name| Params::from_options(64, [("preset", name)]).unwrap()))
        .collect();
    assert_eq!(Params::from_options(64, []).unwrap(), Params::preset(Preset::Balanced, 64), "the command's own");
    let (ranges, values) = (table("| parameter | option"), table("| parameter | `sgm`"));
    let head: Vec<String> = ["sgm", "bm"].into_iter().chain(presets).map(|name| format!("`{name}`")).collect();
    assert_eq!(values[0][1..], head);
    let (ranges, values) = (&ranges[2..], &values[2..]);
    let names: Vec<_> = settings(&columns[0]).into_iter().map(|(name, _)| name).collect();
    assert_eq!((ranges.len(), values.len()), (names.len(), names.len()));
    for (i, name) in names.iter().enumerate() {
        assert!(ranges[i][0].starts_with(&format!("`{name}`")), "{:?} where {name} was expected", ranges[i]);
        assert_eq!(values[i][0], format!("`{name}`"));
        let of = |params: &Params| if *name == "disparities" { "given".into() } else { settings(params)[i].1.clone() };
        assert_eq!(values[i][1..], columns.iter().map(of).collect::<Vec<_>>(), "the values of {name}");
    }
}
