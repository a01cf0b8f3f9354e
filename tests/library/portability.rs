//! What tests/portability/run has each driver do; the environment chooses the driver.
//!
//!     GPU_STEREO_SECONDS=60 GPU_STEREO_SEED=7 cargo test --test library portability -- --ignored --nocapture
//!
//! What was run is told on stderr, in lines that begin with `==`.

use std::io::Write as _;
use std::time::{Duration, Instant};

use crate::covering::{self, Factor, RealPairs, Row};
use crate::support;
use gpu_stereo::{Image, Params, Pixels, Preset, Schedule, StereoMatcher, reference};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Past libtest's capture.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "\n== {text}");
}

/// A number of the environment, or else a default.
fn number(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is {text}, but must be a whole number")),
        Err(_) => default,
    }
}

/// A device, or a panic: these tests are asked for by name.
fn device() -> (gpu_stereo::wgpu::Adapter, gpu_stereo::wgpu::Device, gpu_stereo::wgpu::Queue) {
    let (adapter, device, queue) = support::device().expect("an adapter");
    let info = adapter.get_info();
    let features =
        [("subgroups", gpu_stereo::wgpu::Features::SUBGROUP), ("int64", gpu_stereo::wgpu::Features::SHADER_INT64)];
    let there = features.iter().filter(|(_, feature)| device.features().contains(*feature)).map(|(name, _)| *name);
    let there = there.collect::<Vec<_>>().join(" ");
    say(&format!("adapter {} | {} | {} | {:?} | {there}", info.name, info.driver, info.driver_info, info.backend));
    (adapter, device, queue)
}

/// Each preset and block matching, on both schedules, with subgroups where the device has them and without: every stage, and the whole
/// chain.
#[test]
#[ignore = "asked for by tests/portability/run"]
fn presets_are_exact() {
    let full = device();
    let bare = support::bare_device().expect("an adapter");
    let size = (131, 57);
    let (left, right) = RealPairs::new().piece(0, size, &mut ChaCha8Rng::seed_from_u64(number("GPU_STEREO_SEED", 1)));
    let presets = [Preset::Classic, Preset::Fast, Preset::Balanced, Preset::Strict, Preset::Dense, Preset::Accurate];
    let presets = presets.into_iter().map(|preset| Params::preset(preset, 50));
    let all: Vec<_> = presets.chain([Params::bm(50), Params::bp(21)]).collect();
    let mut checked = 0;
    for params in &all {
        let expected = reference::compute_all(&left, &right, params).unwrap();
        for schedule in [Schedule::PerThread, Schedule::PerSubgroup] {
            let mut params = params.clone();
            params.schedule = schedule;
            for (adapter, device, queue) in [&full, &bare] {
                let matcher = StereoMatcher::new(device, queue, size.0, size.1, left.format(), &params).unwrap();
                support::assert_equal(&matcher.check_blocking(&left, &right).unwrap(), adapter, &params);
                assert!(matcher.compute_blocking(&left, &right).unwrap() == expected, "the map differs, {params:?}");
                checked += 1;
            }
        }
    }
    say(&format!("{checked} of {} settings are exact", all.len() * 4));
}

/// The settings of a covering set, in an order in which the first hold most pairs of values.
fn cases(factors: &[Factor], seed: u64) -> Vec<(usize, Row, Params)> {
    let refused = covering::refused_pairs(factors);
    let rows = covering::covering(factors, &refused, &mut ChaCha8Rng::seed_from_u64(seed));
    let case = |(nth, row): (usize, Row)| {
        let params = covering::params(factors, &row).unwrap();
        (nth, row, params)
    };
    rows.into_iter().enumerate().map(case).collect()
}

/// As many settings of a covering set as are done in some seconds; those come first that hold most pairs of values.
#[test]
#[ignore = "asked for by tests/portability/run"]
fn covering_settings_are_exact() {
    let (seconds, seed) = (number("GPU_STEREO_SECONDS", 60), number("GPU_STEREO_SEED", 1));
    device();
    let factors = covering::factors();
    let cases = cases(&factors, seed);
    let end = Instant::now() + Duration::from_secs(seconds);
    let checked = covering::check_all(&factors, &cases, Some(end), |_| ()).expect("an adapter");
    let refused = covering::refused_pairs(&factors);
    let pairs = covering::all_pairs(&factors).into_iter().filter(|pair| !refused.contains(pair));
    let held = |pair: &_| cases[..checked].iter().any(|(_, row, _)| covering::holds(row, pair));
    let (held, other): (Vec<_>, Vec<_>) = pairs.partition(held);
    let share = (1000.0 * held.len() as f64 / (held.len() + other.len()) as f64).floor() / 10.0;
    say(&format!("{checked} of {} settings are exact, {share:.1} % of all pairs of values, seed {seed}", cases.len()));
    assert!(checked >= 8, "only {checked} settings were checked in {seconds} s");
}

fn bytes(image: &Image) -> (&'static str, Vec<u8>) {
    let wide = |samples: &[u16]| samples.iter().flat_map(|sample| sample.to_le_bytes()).collect();
    match image.pixels() {
        Pixels::Gray8(samples) => ("gray8", samples.clone()),
        Pixels::Rgba8(samples) => ("rgba8", samples.clone()),
        Pixels::Gray16(samples) => ("gray16", wide(samples)),
        Pixels::Rgba16(samples) => ("rgba16", wide(samples)),
        other => panic!("no case has {other:?}"),
    }
}

/// Writes cases for the library in JavaScript into the folder `GPU_STEREO_CASES`: cases.json, and of each the two images and the map of the
/// reference as bytes. First the presets, then the settings of the covering set that JavaScript can ask for.
#[test]
#[ignore = "asked for by tests/portability/run"]
fn cases_are_written() {
    let folder =
        std::path::PathBuf::from(std::env::var_os("GPU_STEREO_CASES").expect("GPU_STEREO_CASES names the folder"));
    let (factors, pairs) = (covering::factors(), RealPairs::new());
    let seed = number("GPU_STEREO_SEED", 1);
    let mut told = Vec::new();
    let mut write = |options: &[(&str, &str)], disparities: u32, params: &Params, pair: (Image, Image)| {
        let nth = told.len();
        let expected = reference::compute_all(&pair.0, &pair.1, params).unwrap();
        let map: Vec<u8> = expected.map.data.iter().flat_map(|value| value.to_le_bytes()).collect();
        let [(format, left), (_, right)] = [&pair.0, &pair.1].map(bytes);
        for (name, bytes) in [("left", left), ("right", right), ("map", map)] {
            std::fs::write(folder.join(format!("{nth}-{name}")), bytes).unwrap();
        }
        let (width, height, confidence) = (pair.0.width(), pair.0.height(), params.confidence);
        let options: Vec<_> = options.iter().map(|(name, value)| format!("[\"{name}\", \"{value}\"]")).collect();
        told.push(format!(
            "{{\"width\": {width}, \"height\": {height}, \"format\": \"{format}\", \"disparities\": {disparities}, \
             \"confidence\": {confidence}, \"options\": [{}]}}",
            options.join(", ")
        ));
    };
    for preset in ["classic", "fast", "balanced", "strict", "dense", "accurate"] {
        for schedule in ["per-thread", "per-subgroup"] {
            let options = [("preset", preset), ("schedule", schedule)];
            let pair = pairs.piece(0, (131, 57), &mut ChaCha8Rng::seed_from_u64(seed));
            write(&options, 50, &Params::from_options(50, options).unwrap(), pair);
        }
    }
    for (nth, row, params) in cases(&factors, seed) {
        let off = |name| covering::value(&factors, &row, name) == "off";
        if off("masks") && off("labels") {
            let options: Vec<_> = covering::options(&factors, &row).collect();
            let disparities = covering::value(&factors, &row, "disp").parse().unwrap();
            write(&options, disparities, &params, covering::images(&factors, &pairs, nth, &row));
        }
    }
    std::fs::write(folder.join("cases.json"), format!("[{}]", told.join(",\n"))).unwrap();
    say(&format!("{} cases", told.len()));
}
