//! `--disp auto` as a user meets it: the range that it finds, on small pairs and on real ones with a truth.

use crate::support::{
    SHIFT, command, is_one_line_error, pair, refuses, run, shared, stderr, stdout, succeeds, texture,
};
use image::{GrayImage, Luma};
use serde_json::Value;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;

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

const SIZE: [u32; 2] = [96, 64];
const AUTO: [&str; 4] = ["--disp", "auto", "--backend", "cpu"];

/// A pair with one disparity.
fn shifted(shift: u32) -> [GrayImage; 2] {
    [0, shift].map(|shift| GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| Luma([texture(x + shift, y)])))
}

/// Folders left and right with a pair of each disparity, named by their number.
fn folders(shifts: &[u32]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for side in ["left", "right"] {
        fs::create_dir(folder.path().join(side)).unwrap();
    }
    for (number, shift) in shifts.iter().enumerate() {
        for (side, image) in ["left", "right"].into_iter().zip(shifted(*shift)) {
            image.save(folder.path().join(format!("{side}/{number}.png"))).unwrap();
        }
    }
    folder
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_slice(&succeeds(folder, &[args, &AUTO, &["--json"]].concat()).stdout).unwrap()
}

/// The first and the last disparity that a single run of a pair searches.
fn alone(folder: &Path, number: usize) -> [i64; 2] {
    let [left, right] = ["left", "right"].map(|side| format!("{side}/{number}.png"));
    let (first, last, _) = range(folder, &[&left, &right]);
    [first, last]
}

#[test]
fn each_pair_of_a_batch_has_its_own_range() {
    let folder = folders(&[3, 20, 3]);
    let path = folder.path();
    let ranges = [0, 1, 2].map(|number| alone(path, number));
    assert!(ranges[0][1] < ranges[1][0], "{ranges:?}");
    let batch = ["batch", "left", "right", "-o", "maps"];
    let told = json(path, &batch);
    let count = ranges[1][1] - ranges[0][0] + 1;
    assert_eq!([&told["min_disparity"], &told["disparities"]], [ranges[0][0], count], "{told}");
    assert_eq!(told["disp"], "auto");
    let mut rows = fs::read_to_string(path.join("maps/done.jsonl")).unwrap();
    for (number, range) in ranges.iter().enumerate() {
        let row = rows.lines().map(|row| serde_json::from_str::<Value>(row).unwrap());
        let name = number.to_string();
        let row = row.into_iter().find(|row| row["name"] == name).unwrap();
        assert_eq!(row["searched"], serde_json::json!(range));
        let [left, right] = ["left", "right"].map(|side| format!("{side}/{number}.png"));
        succeeds(path, &[&[&left, &right, "-o", "alone.png", "-q"], &AUTO[..]].concat());
        assert_eq!(
            fs::read(path.join("alone.png")).unwrap(),
            fs::read(path.join(format!("maps/{number}.png"))).unwrap()
        );
    }
    // What is kept keeps its range, and what is gone is computed again with it.
    fs::remove_file(path.join("maps/1.png")).unwrap();
    let told = json(path, &[&batch[..], &["--resume"]].concat());
    assert_eq!((&told["done"], &told["skipped"], &told["min_disparity"]), (&1.into(), &2.into(), &ranges[1][0].into()));
    rows = fs::read_to_string(path.join("maps/done.jsonl")).unwrap();
    assert!(
        rows.lines().last().unwrap().contains(&format!("\"searched\":[{},{}]", ranges[1][0], ranges[1][1])),
        "{rows}"
    );
    let text = stdout(&succeeds(path, &[&batch[..], &AUTO, &["--resume"]].concat()));
    assert!(text.contains("what each pair needs\n"), "{text}");
    for other in [["--disp", "32"], ["--format", "npy"]] {
        let args = [&batch[..], &AUTO, &["--resume"], &other].concat();
        let args: Vec<_> = if other[0] == "--disp" { [&batch[..], &other].concat() } else { args };
        refuses(path, &args, &["disp auto, 0 to 255 there"]);
    }
    // A pair without a range fails alone.
    for side in ["left", "right"] {
        GrayImage::new(SIZE[0], SIZE[1]).save(path.join(format!("{side}/1.png"))).unwrap();
    }
    let output = run(path, &[&batch[..], &AUTO, &["--resume"]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("too few to find the range"), "{}", stderr(&output));
    assert!(stdout(&output).contains("0 done, 1 failed, 2 there already"), "{}", stdout(&output));
}

/// The margin of a range is no reason to refuse the usual format, which has no disparities below 0.
#[test]
fn the_margin_is_not_searched_where_no_file_can_hold_it() {
    let folder = folders(&[0, 1]);
    let path = folder.path();
    let (first, _, _) = range(path, &["left/0.png", "right/0.png"]);
    assert!(first < 0, "{first}");
    let png = json(path, &["left/0.png", "right/0.png", "-o", "map.png"]);
    assert_eq!(png["min_disparity"], 0);
    assert_eq!(json(path, &["video", "left", "right", "-o", "maps"])["min_disparity"], 0);
    assert!(path.join("maps/1.png").exists());
    // Disparities that are there are.
    let exchanged =
        run(path, &[&["right/1.png", "left/1.png", "-o", "map.png", "--min-disp", "-9"], &AUTO[..]].concat());
    is_one_line_error(&exchanged, &["16-bit PNG", "-9 to "]);
}

#[test]
fn a_video_keeps_the_range_of_its_first_frames() {
    let folder = folders(&[4, 6, 5, 4, 5, 20, 5]);
    let path = folder.path();
    let ranges: Vec<_> = (0..4).map(|number| alone(path, number)).collect();
    let ends = [ranges.iter().map(|r| r[0]).min().unwrap(), ranges.iter().map(|r| r[1]).max().unwrap()];
    let args = ["video", "left", "right", "--format", "npy", "-o"];
    let told = json(path, &[&args[..], &["found"]].concat());
    assert_eq!([&told["min_disparity"], &told["disparities"]], [ends[0], ends[1] - ends[0] + 1], "{told}");
    assert_eq!(told["disp"], "auto");
    let text = stdout(&succeeds(path, &[&args[..], &["found", "--resume"], &AUTO].concat()));
    let line =
        format!("{} disparities, {} to {} px, as the first 4 frames need\n", ends[1] - ends[0] + 1, ends[0], ends[1]);
    assert!(text.contains(&line) && text.contains("7 there already"), "{text}");
    // The maps are those of the same range, given.
    let [first, count] = [ends[0], ends[1] - ends[0] + 1].map(|number| number.to_string());
    let given = [&args[..], &["given", "--disp", &count, "--min-disp", &first, "--backend", "cpu", "-q"]].concat();
    succeeds(path, &given);
    for number in 0..7 {
        let map = |folder: &str| fs::read(path.join(format!("{folder}/{number}.npy"))).unwrap();
        assert_eq!(map("found"), map("given"), "{number}");
    }
    // Of a stream the same, from frames that are looked at ahead. Black ones at the beginning tell nothing.
    let black = [GrayImage::new(SIZE[0], SIZE[1]), GrayImage::new(SIZE[0], SIZE[1])];
    let frames = [4, 6, 5, 4, 5, 20, 5].map(shifted);
    let rows = |[left, right]: &[GrayImage; 2]| -> Vec<u8> {
        let rows = left.as_raw().chunks(SIZE[0] as usize).zip(right.as_raw().chunks(SIZE[0] as usize));
        rows.flat_map(|(left, right)| [left, right].concat()).collect()
    };
    let bytes: Vec<u8> = [&black].into_iter().chain(&frames).flat_map(rows).collect();
    let stream =
        ["video", "-", "--split", "sbs", "--raw-frames", "192x64:gray", "--format", "npy", "-o", "streamed", "--json"];
    let mut command = command(path);
    command.args([&stream[..], &AUTO].concat()).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!([&told["min_disparity"], &told["disparities"]], [ends[0], ends[1] - ends[0] + 1], "{told}");
    assert_eq!(told["done"], 8);
    for number in 0..7 {
        let map = |name: String| fs::read(path.join(name)).unwrap();
        assert_eq!(map(format!("streamed/{:06}.npy", number + 1)), map(format!("found/{number}.npy")), "{number}");
    }
}

/// A frame with things nearer than the range.
#[test]
fn a_frame_that_needs_more_than_the_first_ones_is_told() {
    let folder = folders(&[9; 6]);
    let path = folder.path();
    // The lower half of frame 4 comes nearer, by a little more than the range has.
    let last = alone(path, 0)[1] as u32;
    let [left, mut right] = shifted(9);
    for (x, y, pixel) in right.enumerate_pixels_mut().filter(|(_, y, _)| *y >= 32) {
        *pixel = Luma([texture(x + last, y)]);
    }
    left.save(path.join("left/4.png")).unwrap();
    right.save(path.join("right/4.png")).unwrap();
    let told = json(path, &["video", "left", "right", "--format", "npy", "-o", "maps"]);
    let notes: Vec<_> = told["warnings"].as_array().unwrap().iter().map(|note| note.as_str().unwrap()).collect();
    let [note] = notes[..] else { panic!("{notes:?}") };
    assert!(note.contains("left/4.png") && note.contains(&format!("lie at {last} px, where the range ends")), "{note}");
    // With a range that was given it is the user's.
    let given = ["video", "left", "right", "-o", "given", "--disp", "16", "--backend", "cpu", "--json"];
    let told: Value = serde_json::from_slice(&succeeds(path, &given).stdout).unwrap();
    assert_eq!(told["warnings"], serde_json::json!([]));
}

#[test]
fn variants_share_one_search() {
    let folder = folders(&[7]);
    let path = folder.path();
    let [first, last] = alone(path, 0);
    let range = [Value::from(first), Value::from(last - first + 1)];
    let ends = |of: &Value| [of["min_disparity"].clone(), of["disparities"].clone()];
    let pair = ["left/0.png", "right/0.png"];
    let told = json(
        path,
        &[&["compare"], &pair[..], &["--variants", "sad,census,bm+disp=32", "--maps", "maps", "-o", "c.png"]].concat(),
    );
    let of = |place: usize| ends(&told["variants"][place]);
    assert_eq!([of(0), of(1), of(2)], [range.clone(), range.clone(), [0.into(), 32.into()]]);
    succeeds(path, &[&pair[..], &["--cost", "census", "-o", "alone.png", "-q"], &AUTO].concat());
    let census = fs::read(path.join("maps/2_cost_census.png")).unwrap();
    assert_eq!(fs::read(path.join("alone.png")).unwrap(), census);
    let sweep = [&["sweep"], &pair[..], &["--disp", "auto,32", "--backend", "cpu", "-o", "s.png"]].concat();
    let text = stdout(&succeeds(path, &sweep));
    assert!(text.contains(&format!(" {first} to {last} px |")) && text.contains(" 0 to 31 px |"), "{text}");
}

#[test]
fn each_scene_of_a_bench_has_its_own_range() {
    let folder = folders(&[3, 20]);
    let path = folder.path();
    let ranges = [0, 1].map(|number| alone(path, number));
    let scene = |n: u32| format!(r#"{{"set":"s","scene":"{n}","left":"left/{n}.png","right":"right/{n}.png"}}"#);
    fs::write(path.join("MANIFEST.json"), format!("[{},{}]", scene(0), scene(1))).unwrap();
    let bench = ["bench", ".", "--layout", "manifest", "--variants", "classic,balanced,disp=24", "--report", "report"];
    let told = json(path, &bench);
    let again = json(path, &[&bench[..], &["--resume"]].concat());
    assert_eq!(told["scenes"], again["scenes"]);
    for (place, [first, last]) in [0, 3].into_iter().zip(ranges) {
        for variant in [0, 1] {
            let scene = &told["scenes"][place + variant];
            assert_eq!([&scene["min_disparity"], &scene["disparities"]], [first, last - first + 1], "{scene}");
        }
        let scene = &told["scenes"][place + 2];
        assert_eq!([&scene["min_disparity"], &scene["disparities"]], [0, 24], "{scene}");
    }
}
