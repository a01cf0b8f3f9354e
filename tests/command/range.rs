//! `--disp auto` as a user meets it: the range that it finds, on small pairs and on real ones with a truth.

use crate::support::{SHIFT, is_one_line_error, pair, run, shared, stderr, succeeds};
use serde_json::Value;
use std::path::Path;

fn scene(size: (u32, u32)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (image, name) in pair(size.0, size.1).iter().zip(["left.png", "right.png"]) {
        image.save(folder.path().join(name)).unwrap();
    }
    folder
}

/// The first and the last disparity that were searched, and what was told besides.
fn range(folder: &Path, args: &[&str]) -> (i64, i64, String) {
    let output = succeeds(folder, &[args, &["--disp", "auto", "--backend", "cpu", "--json", "-o", "map.npy"]].concat());
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let (first, count) = (told["min_disparity"].as_i64().unwrap(), told["disparities"].as_i64().unwrap());
    (first, first + count - 1, told["warnings"].to_string())
}

#[test]
fn the_range_lies_round_the_disparities() {
    let folder = scene((96, 64));
    let shift = i64::from(SHIFT);
    let (first, last, warnings) = range(folder.path(), &["left.png", "right.png"]);
    assert!((shift - 3..=shift).contains(&first) && (shift..=shift + 3).contains(&last), "{first} to {last}");
    assert!(!warnings.contains("negative"), "{warnings}");
    let (first, last, _) = range(folder.path(), &["left.png", "right.png", "--min-disp", "-2"]);
    assert!(first == -2 && (shift..=shift + 3).contains(&last), "{first} to {last}");
    let (first, last, warnings) = range(folder.path(), &["right.png", "left.png"]);
    assert!(first <= -shift && last < 0, "{first} to {last}");
    assert!(warnings.contains("exchange them"), "{warnings}");
    // The same range by the definition: what is found depends on no backend.
    let by = |backend| {
        let args = ["left.png", "right.png", "--disp", "auto", "--json", "-o", "map.npy", "--backend", backend];
        let told: Value = serde_json::from_slice(&succeeds(folder.path(), &args).stdout).unwrap();
        [told["min_disparity"].clone(), told["disparities"].clone()]
    };
    assert_eq!(by("cpu"), by("reference"));
}

#[test]
fn what_has_no_range_is_refused() {
    let folder = scene((96, 64));
    let run = |args: &[&str]| run(folder.path(), args);
    is_one_line_error(&run(&["left.png", "right.png", "--disp", "auto", "--min-disp", "40"]), &["--min-disp is 40"]);
    let all = ["video", "left.png", "right.png", "--disp", "auto", "-o", "maps"];
    is_one_line_error(&run(&all), &["--disp is auto", "a single pair"]);
    image::GrayImage::new(96, 64).save(folder.path().join("black.png")).unwrap();
    let output = run(&["black.png", "black.png", "--disp", "auto", "--backend", "cpu"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("too few to find the range"), "{}", stderr(&output));
}

/// At least 99.5 % of the true disparities, in a range that is at most 1.5 times as wide as theirs.
#[test]
fn the_range_of_real_pairs_is_theirs() {
    let Some(data) = shared("data", "the range of real pairs") else { return };
    let of = [
        ("middlebury2001/tsukuba", 16),
        ("middlebury2001/venus", 8),
        ("middlebury2003/teddy", 4),
        ("middlebury2003/cones", 4),
    ];
    for (scene, scale) in of {
        let folder = data.join(scene);
        let truth = image::open(folder.join("disp_left.png")).unwrap().into_luma8();
        let truth: Vec<f64> = truth.iter().filter(|&&v| v > 0).map(|&v| f64::from(v) / f64::from(scale)).collect();
        let (least, most) = truth.iter().fold((f64::MAX, f64::MIN), |(least, most), &v| (least.min(v), most.max(v)));
        let target = tempfile::tempdir().unwrap();
        let paths = ["left.png", "right.png"].map(|name| folder.join(name).display().to_string());
        let (first, last, _) = range(target.path(), &[&paths[0], &paths[1]]);
        let within = truth.iter().filter(|&&v| (first as f64..=last as f64).contains(&v)).count();
        assert!(within as f64 >= 0.995 * truth.len() as f64, "{scene}: {first} to {last}, {within} of {}", truth.len());
        assert!((last - first) as f64 <= 1.5 * (most - least), "{scene}: {first} to {last}, {least} to {most}");
    }
}
