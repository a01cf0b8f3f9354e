//! docs/ALGORITHMS.md is enough to write the chain again: tests/algorithms.py follows the page alone, and
//! every stage of it equals the reference.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use gpu_stereo::{
    Cost, DisparityMap, Distortion, Fill, Image, Masks, Median, Method, Params, Paths, PixelFormat, Pixels, Prefilter,
    Rectification, RightView, Subpixel, reference,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const PAGE: &str = include_str!("../docs/ALGORITHMS.md");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/algorithms.py");

/// Runs the script; `None` where there is no Python, and then says so.
fn python(argument: &str) -> Option<String> {
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
    let output = Command::new("python3").args([SCRIPT, argument]).output().unwrap();
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
    vec![
        ("min_disparity", params.min_disparity.to_string()),
        ("disparities", number(params.disparities)),
        ("method", if params.method == Method::Sgm { "sgm" } else { "bm" }.into()),
        ("cost", params.get("cost")),
        ("census", params.get("census")),
        ("ad_weight", number(params.ad_weight)),
        ("census_weight", number(params.census_weight)),
        ("color_cost", params.get("color-cost")),
        ("paths", number(params.paths.count())),
        ("block", number(params.block)),
        ("prefilter", params.get("prefilter")),
        ("prefilter_cap", number(params.prefilter_cap)),
        ("prefilter_window", number(params.prefilter_window)),
        ("p1", number(params.p1)),
        ("p2", number(params.p2)),
        ("adaptive_p2", if params.adaptive_p2 { "on" } else { "off" }.into()),
        ("texture", number(params.texture)),
        ("uniqueness", number(params.uniqueness)),
        ("lr_check", params.lr_check.map_or("off".into(), number)),
        ("right_view", format!("{:?}", params.right_view).to_lowercase()),
        ("speckle_window", number(params.speckle_window)),
        ("speckle_range", number(params.speckle_range)),
        ("median", median_side(params).map_or("off".into(), |side| side.to_string())),
        ("fill", format!("{:?}", params.fill).to_lowercase()),
        ("subpixel", format!("{:?}", params.subpixel).to_lowercase()),
        ("weighted_median", params.weighted_median.map_or("off".into(), number)),
        ("weighted_median_sigma", number(params.weighted_median_sigma)),
        ("wls", params.wls.map_or("off".into(), |wls| format!("{},{}", f64::from(wls.lambda), f64::from(wls.sigma)))),
    ]
}

fn json(image: &Image, params: &Params) -> String {
    let format = match image.format() {
        PixelFormat::Gray8 => "gray8",
        PixelFormat::Gray16 => "gray16",
        PixelFormat::Rgba8 => "rgba8",
        PixelFormat::Rgba16 => "rgba16",
        other => panic!("no name for {other:?}"),
    };
    let mut fields = vec![
        format!("\"width\": {}", image.width()),
        format!("\"height\": {}", image.height()),
        format!("\"format\": \"{format}\""),
    ];
    let camera = |c: gpu_stereo::Camera| format!("{},{},{}", c.focal, c.baseline, c.doffs);
    for (name, value) in settings(params).into_iter().chain([("depth", params.depth.map_or("off".into(), camera))]) {
        let value = if value.parse::<i64>().is_ok() { value } else { format!("\"{value}\"") };
        fields.push(format!("\"{name}\": {value}"));
    }
    if let Some(rectification) = &params.rectify {
        let lens = |lens: &gpu_stereo::Lens| {
            let gpu_stereo::Lens { matrix, distortion, rotation, projection } = lens;
            let model = if matches!(distortion, Distortion::Fisheye(_)) { "fisheye" } else { "pinhole" };
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

fn bytes16(samples: &[u16]) -> Vec<u8> {
    samples.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn map_bytes(map: &DisparityMap) -> Vec<u8> {
    map.data.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn samples(image: &Image) -> Vec<u8> {
    match image.pixels() {
        Pixels::Gray8(s) | Pixels::Rgba8(s) => s.clone(),
        Pixels::Gray16(s) | Pixels::Rgba16(s) => bytes16(s),
        other => panic!("no bytes of {other:?}"),
    }
}

/// Every stage of the reference by the name of its file, the last one being the map.
fn stages(left: &Image, right: &Image, params: &Params) -> Vec<(&'static str, usize, Vec<u8>)> {
    let rectified = params.rectify.as_ref().map(|rectification| {
        [(left, 0), (right, 1)].map(|(image, side)| reference::rectify(image, rectification, side).unwrap())
    });
    let [left, right] = rectified.as_ref().map_or([left, right], |pair| pair.each_ref());
    let content = reference::Content::new(params, left.width(), left.height());
    // The masks of the rectified pair.
    let masks_of = |content: &reference::Content| {
        let sides = content.sides.each_ref().map(|side| Some(side.data.iter().map(|&has| u8::from(has)).collect()));
        Masks::new(left.width(), left.height(), sides).unwrap()
    };
    let params = &{
        let mut params = params.clone();
        (params.rectify, params.masks) = (None, content.as_ref().map(masks_of));
        params
    };
    let valid = |map: DisparityMap, side| match &content {
        Some(content) => reference::validity(&map, content, side),
        None => map,
    };
    let gray = [left, right].map(|image| reference::gray(image, reference::Channel::Luma));
    let deep = [left, right].map(|image| reference::images(image, params));
    let prefiltered = [0, 1].map(|side: usize| deep[side].prefiltered(params));
    let descriptors = [0, 1].map(|side: usize| prefiltered[side].descriptors(params));
    let table = reference::cost_table(&descriptors, content.as_ref(), params);
    let columns = reference::cost_columns(&descriptors[0], &descriptors[1], &table, params);
    let rows = 0..columns.height;
    let sums = rows.flat_map(|y| reference::block_sums(&columns, y, params)).flat_map(u32::to_le_bytes).collect();
    let bytes16s = |images: &reference::Images| images.channels.iter().flat_map(|c| bytes16(&c.data)).collect();
    let mut stages = Vec::new();
    if let Some(content) = &content {
        let bytes = content.sides.iter().flat_map(|side| &side.data).map(|&has| u8::from(has));
        stages.push(("content", 1, bytes.collect()));
    }
    if let Some([left, right]) = &rectified {
        let size = left.format().bytes_per_pixel() as usize;
        stages.extend([("rectify_left", size, samples(left)), ("rectify_right", size, samples(right))]);
    }
    stages.extend([
        ("gray_left", 1, gray[0].data.clone()),
        ("gray_right", 1, gray[1].data.clone()),
        ("deep_gray_left", 2, bytes16s(&deep[0])),
        ("deep_gray_right", 2, bytes16s(&deep[1])),
        ("prefilter_left", 2, bytes16s(&prefiltered[0])),
        ("prefilter_right", 2, bytes16s(&prefiltered[1])),
        ("descriptors_left", 1, descriptors[0].data.clone()),
        ("descriptors_right", 1, descriptors[1].data.clone()),
        ("cost_columns", 4, columns.data.iter().flat_map(|v| v.to_le_bytes()).collect()),
        ("block_sums", 4, sums),
    ]);
    if !table.is_empty() {
        stages.push(("mi_table", 1, table));
    }
    let views = if params.method == Method::Sgm {
        let cost = reference::matching_cost(&columns, params);
        let luma = reference::gray(left, reference::Channel::Luma);
        let penalties = params.adaptive_p2.then(|| reference::penalties(&luma, params));
        let aggregate = reference::sgm_aggregate(&cost, penalties.as_ref(), params);
        if let Some(penalties) = penalties {
            stages.push(("penalties", 1, penalties.data));
        }
        stages.push(("matching_cost_scale", 4, reference::matching_cost_scale(params).to_le_bytes().to_vec()));
        stages.push(("matching_cost", 1, cost.data));
        stages.push(("sgm_aggregate", 2, bytes16(&aggregate.data)));
        reference::winner(&aggregate, params)
    } else {
        let statistics = (params.cost == Cost::Ncc).then(|| {
            let statistics = reference::block_statistics(&descriptors[0], &descriptors[1], params);
            for (name, side) in [("block_statistics_left", &statistics[0]), ("block_statistics_right", &statistics[1])]
            {
                stages.push((name, 4, side.data.iter().flatten().flat_map(|v| v.to_le_bytes()).collect()));
            }
            statistics
        });
        reference::block_match(&columns, statistics.as_ref(), params)
    };
    stages.push(("winner_left", 2, map_bytes(&views.left)));
    stages.push(("winner_right", 2, map_bytes(&views.right)));
    let mut right_view = views.right;
    if params.right_view == RightView::Match
        && (params.lr_check.is_some() || matches!(params.fill, Fill::Rays | Fill::Hirschmuller))
    {
        let mut second = params.clone();
        (second.subpixel, second.uniqueness, second.texture) = (Subpixel::Off, 0, 0);
        // So the map is the left view.
        (second.lr_check, second.median) = (None, Median::Off);
        (second.weighted_median, second.wls) = (None, None);
        (second.fill, second.speckle_window) = (Fill::None, 0);
        second.masks = content.as_ref().map(|content| masks_of(&content.mirrored()));
        let (left, right) = (reference::mirrored(left).unwrap(), reference::mirrored(right).unwrap());
        right_view = reference::mirror(&reference::compute(&right, &left, &second).unwrap());
        if content.is_none() {
            stages.push(("mirror", 2, map_bytes(&right_view))); // else only what is left of it is known here
        }
    }
    let right_view = valid(right_view, 1);
    stages.push(("validity_right", 2, map_bytes(&right_view)));
    let mut map = valid(views.left, 0);
    stages.push(("validity", 2, map_bytes(&map)));
    if params.texture > 0 {
        map = reference::texture(&map, &gray[0], params);
    }
    stages.push(("texture", 2, map_bytes(&map)));
    if let Some(px) = params.lr_check {
        map = reference::lr_check(&map, &right_view, px);
    }
    stages.push(("lr_check", 2, map_bytes(&map)));
    if params.speckle_window > 0 {
        map = reference::speckle(&map, params.speckle_window, params.speckle_range);
    }
    stages.push(("speckle", 2, map_bytes(&map)));
    if let Some(side) = median_side(params) {
        map = reference::median(&map, side);
    }
    stages.push(("median", 2, map_bytes(&map)));
    map = valid(map, 0);
    if params.fill != gpu_stereo::Fill::None {
        map = reference::fill(&map, &right_view, params);
    }
    stages.push(("fill", 2, map_bytes(&map)));
    map = valid(map, 0);
    if let Some(radius) = params.weighted_median {
        map = reference::weighted_median(&map, &gray[0], radius, params);
    }
    stages.push(("weighted_median", 2, map_bytes(&map)));
    map = valid(map, 0);
    let mut with_confidence = params.clone();
    with_confidence.confidence = true;
    let matched = reference::compute_all(left, right, &with_confidence).unwrap();
    if let Some(settings) = &params.wls {
        map = reference::wls(&map, &gray[0], settings, params);
    }
    stages.push(("wls", 2, map_bytes(&map)));
    map = valid(map, 0);
    assert!(map == matched.map);
    stages.push(("map", 2, map_bytes(&map)));
    stages.push(("margins", 1, views.margins.data));
    stages.push(("confidence", 1, matched.confidence.unwrap().data));
    if let Some(depth) = matched.depth {
        stages.push(("depth", 4, depth.data.iter().flat_map(|v| v.to_le_bytes()).collect()));
    }
    stages
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

/// Every cost of the page, by name.
const COSTS: [&str; 8] = ["sad", "ssd", "zsad", "bt", "sad-xy", "census", "census-sobel", "ad-census"];

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    // Pairs with a truth, in every format, with random parameters.
    for seed in 0..48 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let params = support::random_params(&mut random);
        let (width, height) = (random.random_range(1..40), random.random_range(1..10));
        let (left, right) = support::pair(width, height, seed);
        let format = seed as u32 % 4;
        cases.push(Case { left: support::as_format(&left, format), right: support::as_format(&right, format), params });
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
    for (seed, option) in (300..).zip(COSTS) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for (format, census) in ["5x5", "7x7", "9x7", "cs9x7"].into_iter().enumerate() {
            let mut params = if format % 2 == 0 { Params::sgm(6) } else { Params::bm(6) };
            params.min_disparity = -2;
            params.block = 2 * random.random_range(0..4) + 1;
            let mut set = |name: &str, value: &str| params.set(name, value).unwrap();
            set("cost", option);
            set("census", census);
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
                "census-sobel" => 32,
                _ => Params::MAX_CAP,
            };
            (params.ad_weight, params.census_weight) = (64, 64);
            let left = few_levels(11, 6, 1, &mut random);
            let right = few_levels(11, 6, 1, &mut random);
            cases.push(Case { left, right, params });
        }
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
    for seed in 0..7 {
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
    // Luma exactly half way between two levels.
    let half = |&(r, g, b): &(u32, u32, u32)| (9798 * r + 19235 * g + 3735 * b) % 32768 == 16384;
    let colours = (0..256).flat_map(|r| (0..256).flat_map(move |g| (0..256).map(move |b| (r, g, b))));
    let halves: Vec<u8> =
        colours.filter(half).take(120).flat_map(|(r, g, b)| [r as u8, g as u8, b as u8, 255]).collect();
    let image = |samples: &[u8]| Image::new(12, 5, Pixels::Rgba8(samples.to_vec())).unwrap();
    cases.push(Case { left: image(&halves[..240]), right: image(&halves[240..]), params: Params::sgm(5) });
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
    for (i, Case { left, right, params }) in cases.iter().enumerate() {
        std::fs::create_dir_all(folder(i)).unwrap();
        std::fs::write(folder(i).join("case.json"), json(left, params)).unwrap();
        std::fs::write(folder(i).join("left.raw"), samples(left)).unwrap();
        std::fs::write(folder(i).join("right.raw"), samples(right)).unwrap();
    }
    let Some(said) = python(root.to_str().unwrap()) else { return };
    assert_eq!(said.trim(), format!("{} cases", cases.len()));

    let (mut valid, mut invalid, mut refined) = (0, 0, 0);
    for (i, Case { left, right, params }) in cases.iter().enumerate() {
        for (stage, size, expected) in stages(left, right, params) {
            compare(&folder(i), stage, size, &expected, &json(left, params));
        }
        let map = reference::compute(left, right, params).unwrap();
        valid += map.data.iter().filter(|&&v| v != DisparityMap::INVALID).count();
        invalid += map.data.iter().filter(|&&v| v == DisparityMap::INVALID).count();
        refined += map.data.iter().filter(|&&v| v % 16 != 0).count();
    }
    // The cases say something: maps are neither empty nor full, and not of whole pixels only.
    assert!(valid > 2000 && invalid > 2000 && refined > 300, "{valid} valid, {invalid} invalid, {refined} refined");
}

fn compare(folder: &Path, stage: &str, size: usize, expected: &[u8], case: &str) {
    let found = std::fs::read(folder.join(stage).with_extension("raw")).unwrap();
    assert!(!expected.is_empty() && found.len() == expected.len(), "{stage}: {} bytes, case {case}", found.len());
    let first = found.iter().zip(expected).position(|(a, b)| a != b).map(|byte| byte / size);
    let element = |bytes: &[u8], i: usize| bytes[i * size..][..size].to_vec();
    if let Some(i) = first {
        panic!(
            "{stage}: element {i} is {:?} by the page and {:?} by the reference (little endian), {}, case {case}",
            element(&found, i),
            element(expected, i),
            folder.display()
        );
    }
}

#[test]
fn the_worked_example_is_what_the_formulas_give() {
    let Some(example) = python("--example") else { return };
    let on_page: Vec<&str> = PAGE.lines().map(str::trim_end).collect();
    let lines: Vec<String> = example.lines().map(|line| format!("    {line}").trim_end().to_string()).collect();
    assert!(lines.len() > 30);
    assert!(
        on_page.windows(lines.len()).any(|window| window == lines),
        "the page does not hold what python3 tests/algorithms.py --example prints"
    );
}

#[test]
fn the_table_of_parameters_has_the_defaults() {
    let rows: Vec<Vec<&str>> = PAGE
        .lines()
        .filter(|line| line.contains("| `--"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let (sgm, bm) = (settings(&Params::sgm(64)), settings(&Params::bm(64)));
    assert_eq!(rows.len(), sgm.len());
    for ((row, (name, sgm)), (_, bm)) in rows.iter().zip(&sgm).zip(&bm) {
        assert!(row[0].starts_with(&format!("`{name}`")), "{row:?} where {name} was expected");
        let given = |value: &str| if *name == "disparities" { "must be given".into() } else { value.to_string() };
        assert_eq!((row[4], row[5]), (given(sgm).as_str(), given(bm).as_str()), "the defaults of {name}");
    }
}
