//! `gpu-stereo batch` as a user meets it: lists, shares of them, several processes at once, what failed.
//!
//! On the CPU, so that no adapter is needed, but for one test of mixed pairs.

use crate::support::{
    SHIFT, command, contents, is_one_line_error, not_tested, refuses, run, stderr, stdout, succeeds, texture,
};
use image::{DynamicImage, GrayImage, Luma};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::thread;
use std::time::Duration;
use tempfile::TempDir;

/// Saves a pair that no other one is equal to, as `convert` makes of gray images.
fn save(folder: &Path, number: u32, [width, height]: [u32; 2], convert: impl Fn(GrayImage) -> DynamicImage) {
    for (side, shift) in [("l", 0), ("r", SHIFT)] {
        let image = GrayImage::from_fn(width, height, |x, y| Luma([texture(x + shift + 97 * number, y)]));
        convert(image).save(folder.join(format!("{side}{number}.png"))).unwrap();
    }
}

/// The pairs l0.png and r0.png, l1.png and r1.png and so on, and the list pairs.csv with the names p/0, p/1 and so on.
fn pairs(count: u32, size: [u32; 2]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut list = String::from("left,right,name\n");
    for number in 0..count {
        save(folder.path(), number, size, Into::into);
        list += &format!("l{number}.png,r{number}.png,p/{number}\n");
    }
    fs::write(folder.path().join("pairs.csv"), list).unwrap();
    folder
}

/// `batch pairs.csv -o maps --disp 16 --backend cpu` and more.
fn batch<'a>(more: &[&'a str]) -> Vec<&'a str> {
    of(&["pairs.csv"], more)
}

fn of<'a>(given: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [&["batch"], given, &["-o", "maps", "--disp", "16", "--backend", "cpu"], more].concat()
}

/// The files of an output folder, the record and the logs apart.
fn maps(folder: &TempDir) -> BTreeMap<PathBuf, Vec<u8>> {
    let maps = folder.path().join("maps");
    let all = contents(&maps).into_iter().map(|(path, bytes)| (path.strip_prefix(&maps).unwrap().to_owned(), bytes));
    all.filter(|(path, _)| !path.to_string_lossy().ends_with(".json") && !path.to_string_lossy().ends_with(".jsonl"))
        .filter(|(path, _)| !path.to_string_lossy().starts_with(".gpu-stereo-begun-"))
        .collect()
}

fn names(folder: &TempDir) -> BTreeSet<String> {
    maps(folder).into_keys().map(|path| path.to_string_lossy().into_owned()).collect()
}

fn set<S: ToString>(names: impl IntoIterator<Item = S>) -> BTreeSet<String> {
    names.into_iter().map(|name| name.to_string()).collect()
}

/// The lines of a log.
fn log(folder: &TempDir, name: &str) -> Vec<Value> {
    let text = fs::read_to_string(folder.path().join("maps").join(name)).unwrap_or_default();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// What a single run on a pair gives.
fn single(folder: &TempDir, number: u32) -> Vec<u8> {
    let (left, right) = (format!("l{number}.png"), format!("r{number}.png"));
    succeeds(folder.path(), &[&left, &right, "--disp", "16", "--backend", "cpu", "-q", "-o", "single.png"]);
    let path = folder.path().join("single.png");
    let bytes = fs::read(&path).unwrap();
    fs::remove_file(path).unwrap();
    bytes
}

#[track_caller]
fn told(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", stderr(output)))
}

fn counts(told: &Value) -> [u64; 4] {
    ["pairs", "done", "failed", "skipped"].map(|field| told[field].as_u64().unwrap())
}

// What it writes.

#[test]
fn a_list_gives_what_single_runs_give() {
    let folder = pairs(4, [49, 31]);
    let at = |name: &str| folder.path().join(name);
    let expected: Vec<_> = (0..4).map(|number| single(&folder, number)).collect();
    fs::create_dir(at("sub")).unwrap();
    fs::rename(at("l3.png"), at("sub/l3.png")).unwrap();
    let csv = "# two with a name, two without\nl0.png, r0.png, a/b/zero\n\n\"l1.png\",\"r1.png\",\"one, \"\"1\"\"\"\n\
               l2.png,r2.png,\nsub/l3.png,./r3.png,\n";
    let json = "{\"left\": \"l0.png\", \"right\": \"r0.png\", \"name\": \"a/b/zero\"}\n\n\
                {\"name\": \"one, \\\"1\\\"\", \"right\": \"r1.png\", \"left\": \"l1.png\"}\n\
                {\"left\": \"l2.png\", \"right\": \"r2.png\"}\n{\"left\": \"sub/l3.png\", \"right\": \"r3.png\"}\n";
    let names = ["a/b/zero.png", "one, \"1\".png", "l2.png", "sub/l3.png"];
    let expected: BTreeMap<_, _> = names.map(PathBuf::from).into_iter().zip(expected).collect();
    for (list, text) in [("list.csv", csv), ("list.jsonl", json), ("list.NDJSON", json), ("bom.csv", csv)] {
        let text = if list == "bom.csv" { format!("\u{feff}{text}").replace('\n', "\r\n") } else { text.to_owned() };
        fs::write(at(list), text).unwrap();
        let output = succeeds(folder.path(), &of(&[list], &["-j", "3"]));
        assert!(maps(&folder) == expected, "{list}");
        for words in ["CPU with ", "4 done, 0 failed, 0 there already", "written  maps"] {
            assert!(stdout(&output).contains(words), "{}", stdout(&output));
        }
        assert!(stderr(&output).contains("4/4") && stderr(&output).contains("pairs a second"), "{}", stderr(&output));
        fs::remove_dir_all(at("maps")).unwrap();
    }
    // Paths are relative to the list, but those of stdin to the folder one is in.
    succeeds(
        at("sub").as_path(),
        &["batch", "../list.csv", "--out", "../maps", "--disp", "16", "--backend", "cpu", "-q"],
    );
    assert!(maps(&folder) == expected);
    for text in [csv, json] {
        fs::remove_dir_all(at("maps")).unwrap();
        let mut command = command(folder.path());
        command.args(of(&["-"], &["-q"])).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()));
        assert!(maps(&folder) == expected);
    }
}

#[test]
fn globs_give_names_below_the_common_folder() {
    let folder = pairs(3, [49, 31]);
    let at = |name: &str| folder.path().join(name);
    for (number, scene) in ["b", "a", "c"].into_iter().enumerate() {
        for side in ["left", "right"] {
            fs::create_dir_all(at(&format!("data/{scene}/{side}"))).unwrap();
            let from = at(&format!("{}{number}.png", &side[..1]));
            fs::rename(from, at(&format!("data/{scene}/{side}/im.0.png"))).unwrap();
        }
    }
    succeeds(folder.path(), &of(&["data/*/left/*.png", "data/*/right/*.png"], &["--format", "npy,color"]));
    let expected = ["a", "b", "c"].map(|scene| [".npy", "_color.png"].map(|end| format!("{scene}/left/im.0{end}")));
    assert_eq!(names(&folder), set(expected.as_flattened()));
    fs::remove_dir_all(at("maps")).unwrap();
    succeeds(folder.path(), &of(&["data/a/left", "data/a/right"], &[]));
    assert_eq!(names(&folder), set(["im.0.png"]));
}

#[test]
fn sizes_and_samples_are_mixed() {
    let folder = pairs(14, [61, 40]);
    let sizes = [[61, 40], [40, 61], [33, 21], [90, 70]];
    let wide = |image: &GrayImage| DynamicImage::from(image.clone()).into_luma16();
    for number in 0..14 {
        // Neighbours differ in either, or in both. Buffers for the width of 12 and the height of 13 are very large.
        let size = match number {
            12 => [20_000, 1],
            13 => [1, 20_000],
            _ => sizes[number as usize / 2 % 4],
        };
        save(folder.path(), number, size, |image| match number / 3 {
            0 => image.into(),
            1 => DynamicImage::from(image).into_rgb8().into(),
            2 => wide(&image).into(),
            _ => DynamicImage::from(wide(&image)).into_rgb16().into(),
        });
    }
    fs::write(folder.path().join("r5.png"), "no image").unwrap();
    save(folder.path(), 20, [61, 40], Into::into);
    fs::rename(folder.path().join("r20.png"), folder.path().join("r6.png")).unwrap(); // its left one is smaller
    let expected = || (0..14).filter(|number| ![5, 6].contains(number)).map(|number| (number, single(&folder, number)));
    let expected: BTreeMap<_, _> = expected().map(|(n, bytes)| (PathBuf::from(format!("p/{n}.png")), bytes)).collect();
    // Once in the list's order, once so that samples and sizes come and go.
    let list = fs::read_to_string(folder.path().join("pairs.csv")).unwrap();
    let mut rows: Vec<_> = list.lines().skip(1).collect();
    rows.sort_by_key(|row| row.bytes().map(u32::from).map(|b| b * 7 % 11).sum::<u32>());
    fs::write(folder.path().join("other.csv"), rows.join("\n")).unwrap();
    let adapter = std::env::var_os("GPU_STEREO_NO_ADAPTER").is_none();
    if !adapter {
        not_tested("there is no adapter, and GPU_STEREO_NO_ADAPTER is set");
    }
    for backend in if adapter { &["cpu", "gpu"][..] } else { &["cpu"] } {
        for list in ["pairs.csv", "other.csv"] {
            let args = ["batch", list, "-o", "maps", "--disp", "16", "--backend", backend, "--json"];
            let output = run(folder.path(), &args);
            assert_eq!(
                (output.status.code(), counts(&told(&output))),
                (Some(1), [14, 12, 2, 0]),
                "{}",
                stderr(&output)
            );
            assert!(maps(&folder) == expected, "{backend} {list}");
            assert_eq!(told(&output)["backend"] == "cpu", *backend == "cpu");
            fs::remove_dir_all(folder.path().join("maps")).unwrap();
        }
    }
}

// Shares.

#[test]
fn shards_are_all_pairs_once_each() {
    let folder = pairs(11, [49, 31]);
    succeeds(folder.path(), &batch(&["-q"]));
    let expected = maps(&folder);
    assert_eq!(expected.len(), 11);
    for count in [1, 3, 4, 13] {
        fs::remove_dir_all(folder.path().join("maps")).unwrap();
        let mut sum = 0;
        for index in 1..=count {
            let shard = format!("{index}/{count}");
            let told = told(&succeeds(folder.path(), &batch(&["--json", "--shard", &shard])));
            assert_eq!((&told["shard"], counts(&told)[2..].to_vec()), (&json!(shard), vec![0, 0]));
            assert_eq!(told["pairs"].as_u64(), Some((11 + count - index) / count));
            sum += counts(&told)[1];
            assert_eq!(maps(&folder).len() as u64, sum, "{shard} has pairs of another one");
        }
        assert!(maps(&folder) == expected);
        let mut done: Vec<_> = log(&folder, "done.jsonl").iter().map(|line| line["name"].to_string()).collect();
        done.sort();
        assert_eq!(done.len(), 11);
        done.dedup();
        assert_eq!(done.len(), 11);
    }
}

/// A batch that runs.
fn start(folder: &TempDir, more: &[&str]) -> Child {
    command(folder.path()).args(batch(more)).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn processes_at_once_lose_nothing() {
    let folder = pairs(24, [120, 80]);
    fs::write(folder.path().join("l7.png"), "no image").unwrap();
    succeeds(folder.path(), &of(&["l[0-6].png", "r[0-6].png"], &["-q"])); // a few to compare
    let expected = maps(&folder);
    fs::remove_dir_all(folder.path().join("maps")).unwrap();
    for shards in [["1/2", "2/2", "1/1", "1/1"], ["1/1", "1/1", "1/1", "1/1"]] {
        let children = shards.map(|shard| start(&folder, &["--resume", "--shard", shard, "--json"]));
        let mut failed = 0;
        for (child, shard) in children.into_iter().zip(shards) {
            let output = child.wait_with_output().unwrap();
            let told = told(&output);
            let [pairs, done, failures, skipped] = counts(&told);
            assert_eq!(output.status.code(), Some(i32::from(failures > 0)), "{}", stderr(&output));
            assert_eq!((pairs, done + failures + skipped), if shard == "1/1" { (24, 24) } else { (12, 12) });
            failed += failures;
        }
        assert_eq!(names(&folder), set((0..24).filter(|n| *n != 7).map(|n| format!("p/{n}.png"))));
        for (path, bytes) in &expected {
            let number = path.to_string_lossy()[1..].to_owned();
            assert!(fs::read(folder.path().join(format!("maps/p/{number}"))).unwrap() == *bytes, "{number}");
        }
        let lines = log(&folder, "failures.jsonl");
        assert_eq!(lines.len() as u64, failed);
        assert!(lines.iter().all(|line| line["name"] == "p/7"), "{lines:?}");
        let done: BTreeSet<_> = log(&folder, "done.jsonl").iter().map(|line| line["name"].to_string()).collect();
        assert_eq!(done.len(), 23);
        fs::remove_dir_all(folder.path().join("maps")).unwrap();
    }
}

#[test]
fn of_two_settings_at_once_one_is_refused() {
    let folder = pairs(12, [120, 80]);
    for _ in 0..3 {
        let children = ["5", "9"].map(|p1| start(&folder, &["--p1", p1, "-q"]));
        let outputs = children.map(|child| child.wait_with_output().unwrap());
        let codes = outputs.each_ref().map(|output| output.status.code().unwrap());
        assert!([[0, 2], [2, 0]].contains(&codes), "{codes:?}");
        let refused = stderr(&outputs[usize::from(codes[0] == 0)]);
        assert!(refused.contains("other settings: p1 ") && refused.lines().count() == 1, "{refused}");
        let record: Value =
            serde_json::from_slice(&fs::read(folder.path().join("maps/gpu-stereo.json")).unwrap()).unwrap();
        assert_eq!(record["p1"], if codes[0] == 0 { "5" } else { "9" });
        let both = maps(&folder);
        assert_eq!(both.len(), 12);
        fs::remove_dir_all(folder.path().join("maps")).unwrap();
        succeeds(folder.path(), &batch(&["-q", "--p1", record["p1"].as_str().unwrap()]));
        assert!(maps(&folder) == both, "maps of both settings");
        fs::remove_dir_all(folder.path().join("maps")).unwrap();
    }
}

// Resuming.

#[test]
fn what_is_there_is_kept_if_it_is_of_the_same_pair_and_settings() {
    let folder = pairs(4, [49, 31]);
    let at = |name: &str| folder.path().join(name);
    let resume =
        |more: &[&str]| counts(&told(&succeeds(folder.path(), &batch(&[&["--resume", "--json"], more].concat()))));
    assert_eq!(resume(&[]), [4, 4, 0, 0]);
    let all = maps(&folder);
    assert_eq!(resume(&["--schedule", "per-subgroup"]), [4, 0, 0, 4]); // this changes no bit
    fs::remove_file(at("maps/p/0.png")).unwrap();
    fs::write(at("maps/p/1.png"), "").unwrap();
    assert_eq!(resume(&[]), [4, 2, 0, 2]);
    assert_eq!(resume(&["--format", "png,npy"]), [4, 4, 0, 0]);
    assert_eq!(resume(&["--format", "npy"]), [4, 0, 0, 4]);
    assert!(all.iter().all(|(path, bytes)| fs::read(at("maps").join(path)).unwrap() == *bytes));

    // The list grows, and a name gets another pair.
    save(folder.path(), 4, [49, 31], Into::into);
    let list = fs::read_to_string(at("pairs.csv")).unwrap();
    fs::write(at("pairs.csv"), list.replace("l3.png,r3.png", "l4.png,r4.png") + "l3.png,r3.png,p/4\n").unwrap();
    assert_eq!(resume(&[]), [5, 2, 0, 3]);
    assert!(fs::read(at("maps/p/3.png")).unwrap() == single(&folder, 4));
    assert!(fs::read(at("maps/p/4.png")).unwrap() == single(&folder, 3));
    assert_eq!(resume(&[]), [5, 0, 0, 5]);
    // And has it back: the map is not that which was made of it first.
    fs::write(at("pairs.csv"), &list).unwrap();
    assert_eq!(resume(&[]), [4, 1, 0, 3]);
    assert!(maps(&folder)[Path::new("p/3.png")] == all[Path::new("p/3.png")]);

    // Without --resume all are computed again; other settings are refused either way.
    assert_eq!(counts(&told(&succeeds(folder.path(), &batch(&["--json"])))), [4, 4, 0, 0]);
    let words = ["made with other settings", "p1 18 there and 9 now", "gpu-stereo.json", "another folder"];
    for more in [&["--p1", "9"][..], &["--p1", "9", "--resume"]] {
        refuses(folder.path(), &batch(more), &words);
    }
    // Maps without a record are of unknown settings. One that was cut short is none.
    for record in [None, Some("{\"version\": ")] {
        fs::remove_file(at("maps/gpu-stereo.json")).unwrap();
        record.iter().for_each(|text| fs::write(at("maps/gpu-stereo.json"), text).unwrap());
        let told = told(&succeeds(folder.path(), &batch(&["--resume", "--json", "--p1", "9"])));
        assert_eq!(counts(&told), [4, 4, 0, 0]);
        fs::remove_file(at("maps/gpu-stereo.json")).unwrap();
        assert_eq!(resume(&[]), [4, 4, 0, 0]);
        assert_eq!(resume(&[]), [4, 0, 0, 4]);
    }
}

#[cfg(unix)]
#[test]
fn a_killed_run_leaves_whole_files_and_can_be_resumed() {
    use std::process::Command;
    let folder = pairs(60, [300, 200]);
    let is_temporary = |path: &Path| path.file_name().unwrap().to_string_lossy().starts_with(".gpu-stereo-");
    let maps_in = |files: fs::ReadDir| files.filter(|file| !is_temporary(&file.as_ref().unwrap().path())).count();
    let there = || fs::read_dir(folder.path().join("maps/p")).map_or(0, maps_in);
    for signal in ["KILL", "KILL", "TERM"] {
        let before = there();
        let mut child = start(&folder, &["--resume", "-j", "1"]);
        while there() < before + 3 {
            assert!(child.try_wait().unwrap().is_none(), "it ended before its time");
            thread::sleep(Duration::from_millis(2));
        }
        Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        if signal == "TERM" {
            assert_eq!(output.status.code(), Some(2));
            assert!(
                stderr(&output).lines().last().unwrap().contains("--resume computes the rest"),
                "{}",
                stderr(&output)
            );
        }
    }
    let killed = maps(&folder);
    let told = told(&succeeds(folder.path(), &batch(&["--resume", "--json"])));
    let [pairs, done, failed, skipped] = counts(&told);
    assert!(pairs == 60 && done + skipped == 60 && failed == 0 && skipped >= 6, "{told}");
    let resumed = maps(&folder);
    fs::remove_dir_all(folder.path().join("maps")).unwrap();
    succeeds(folder.path(), &batch(&["-q"]));
    let again = maps(&folder);
    for (path, bytes) in killed.iter().chain(&resumed).filter(|(path, _)| !is_temporary(path)) {
        assert!(again[path] == *bytes, "{path:?}");
    }
    assert!(again.keys().all(|path| resumed.contains_key(path)));
}

// Pairs that fail.

#[test]
fn failures_are_told_and_logged_and_the_log_is_a_list() {
    let folder = pairs(5, [49, 31]);
    let at = |name: &str| folder.path().join(name);
    let whole = fs::read(at("l1.png")).unwrap();
    fs::write(at("l1.png"), &whole[..whole.len() / 2]).unwrap();
    fs::remove_file(at("r2.png")).unwrap();
    let other = fs::read(at("r3.png")).unwrap();
    save(folder.path(), 9, [20, 20], Into::into);
    fs::rename(at("r9.png"), at("r3.png")).unwrap();
    let output = run(folder.path(), &batch(&["--json"]));
    assert_eq!(output.status.code(), Some(1));
    let mut told_of = told(&output);
    for time in ["seconds", "pairs_per_second"] {
        assert!(told_of[time].as_f64().unwrap() > 0.0, "{told_of}");
        told_of[time] = 0.into();
    }
    let failures = told_of["failures"].take();
    let expected = json!({
        "adapter": crate::support::cpu(), "backend": "cpu", "driver": concat!("gpu-stereo ", env!("CARGO_PKG_VERSION")),
        "min_disparity": 0, "disparities": 16, "shard": null, "pairs": 5, "done": 2, "failed": 3, "skipped": 0,
        "seconds": 0, "pairs_per_second": 0, "peak_device_bytes": 0, "failures": null, "warnings": [], "output": "maps",
    });
    assert_eq!(told_of, expected);
    let mut logged = log(&folder, "failures.jsonl");
    logged.sort_by_key(|line| line["name"].to_string());
    assert_eq!(json!(logged), failures);
    let words = [
        ("p/1", "l1.png", "cut short"),
        ("p/2", "l2.png", "does not exist"),
        ("p/3", "l3.png", "both must have one size"),
    ];
    for (line, (name, left, error)) in logged.iter().zip(words) {
        assert!(line["name"] == name && Path::new(line["left"].as_str().unwrap()).is_absolute(), "{line}");
        assert!(
            line["left"].as_str().unwrap().ends_with(left) && line["error"].as_str().unwrap().contains(error),
            "{line}"
        );
        assert!(stderr(&output).lines().any(|line| line.starts_with("failed: ") && line.contains(left)));
    }
    // What failed is computed again by itself, once the causes are gone.
    fs::write(at("l1.png"), &whole).unwrap();
    fs::write(at("r3.png"), &other).unwrap();
    let output = run(folder.path(), &of(&["maps/failures.jsonl"], &["--json"]));
    assert_eq!(counts(&told(&output)), [3, 2, 1, 0]);
    assert_eq!(log(&folder, "failures.jsonl").len(), 4);
    assert_eq!(names(&folder), set([0, 1, 3, 4].map(|n| format!("p/{n}.png"))));
    let output = run(folder.path(), &batch(&["--resume"]));
    assert!(stdout(&output).contains("0 done, 1 failed, 4 there already"), "{}", stdout(&output));
    assert!(stdout(&output).contains("failed   maps/failures.jsonl"), "{}", stdout(&output));
}

// What cannot be.

#[test]
fn what_cannot_be_is_one_line() {
    let folder = pairs(3, [20, 20]);
    let at = |name: &str| folder.path().join(name);
    let csv: [(&str, &[&str]); 14] = [
        ("", &["list \"x.csv\" has no pairs"]),
        ("# nothing\n\nleft,right\n", &["has no pairs"]),
        ("l0.png,r0.png\n\n# x\nl1.png\n", &["list \"x.csv\": line 4: it has 1 fields, but left,right or"]),
        ("right,left\nl0.png,r0.png,a\n", &["line 2: it has 3 fields, but 2, as in the first line"]),
        ("l0.png;r0.png\n", &["line 1: it has 1 fields"]),
        ("l0.png,r0.png,a,b\n", &["line 1: it has 4 fields"]),
        ("left,right,mask\nl0.png,r0.png,m\n", &["line 1: the header has \"mask\"", "left, right and name"]),
        ("left,right,left\n", &["line 1: the header has \"left\"", "each once"]),
        ("l0.png,r0.png\n,r1.png\n", &["line 2: left is empty"]),
        ("name,right,left\na,,l0.png\n", &["line 2: right is empty"]),
        ("l0.png,\"r0.png\nl1.png,r1.png\n", &["line 1: a quote is not closed"]),
        ("l0.png,r0.png,../a\n", &["line 1: name is \"../a\"", "within the output folder"]),
        ("l0.png,r0.png,/a\n", &["line 1: name is \"/a\""]),
        ("l0.png,r0.png,.\n", &["line 1: name is \".\""]),
    ];
    for (text, words) in csv {
        fs::write(at("x.csv"), text).unwrap();
        refuses(folder.path(), &of(&["x.csv"], &[]), words);
    }
    let json: [(&str, &[&str]); 9] = [
        ("\n", &["list \"x.jsonl\" has no pairs"]),
        (
            "{\"left\": \"l0.png\", \"right\": \"r0.png\"}\n{\"left\": \"l1.png\"}\n",
            &["line 2: right is missing here or"],
        ),
        ("{\"left\": \"l0.png\", \"right\": \"r0.png\"", &["line 1: EOF", "(column 36)"]),
        ("{\"left\": 1, \"right\": \"r0.png\"}", &["line 1: invalid type: integer"]),
        ("{\"left\": \"l\", \"right\": \"r\", \"disp\": 3}", &["line 1: unknown field `disp`"]),
        ("{\"left\": \"l\", \"right\": \"r\", \"left\": \"m\"}", &["line 1: duplicate field `left`"]),
        ("[{\"left\": \"l\", \"right\": \"r\"}]", &["line 1: "]),
        ("{\"left\": \"\", \"right\": \"r\"}", &["line 1: left is empty"]),
        ("{\"left\": \"l\", \"right\": \"r\", \"name\": \"a\\u0000\"}", &["line 1: name is \"a\\0\""]),
    ];
    for (text, words) in json {
        fs::write(at("x.jsonl"), text).unwrap();
        refuses(folder.path(), &of(&["x.jsonl"], &[]), words);
    }
    let names: [(&str, &[&str]); 5] = [
        (
            "l0.png,r0.png,a\nl1.png,r1.png,a\n",
            &["\"l0.png\" (line 1) and \"l1.png\" (line 2) would both become \"maps/a.png\""],
        ),
        ("l0.png,r0.png\nl0.png,r1.png\n", &["(line 1)", "(line 2)", "\"maps/l0.png\"", "a name of its own"]),
        ("l0.png,r0.png\nl0.jpg,r0.jpg\n", &["\"l0.png\" (line 1)", "\"l0.jpg\" (line 2)"]),
        ("l0.png,r0.png,\nl1.png,r1.png,./l0\n", &["both become \"maps/l0.png\""]),
        ("l0.png,r0.png\n../l1.png,r1.png\n", &["\"../l1.png\" yields no name for its map"]),
    ];
    for (text, words) in names {
        fs::write(at("x.csv"), text).unwrap();
        refuses(folder.path(), &of(&["x.csv"], &[]), words);
    }
    fs::write(at("x.csv"), "l0.png,r0.png,a\nl1.png,r1.png,a_color\n").unwrap();
    refuses(folder.path(), &of(&["x.csv"], &["--format", "png,color"]), &["both become \"maps/a_color.png\""]);
    fs::write(at("x.csv"), [0xff, b',', b'a']).unwrap();
    refuses(folder.path(), &of(&["x.csv"], &[]), &["list \"x.csv\" cannot be read", "UTF-8"]);
    fs::create_dir(at("d.csv")).unwrap();
    fs::write(at("file"), "").unwrap();
    let given: [(&[&str], &[&str]); 7] = [
        (&["none.csv"], &["list \"none.csv\" cannot be read"]),
        (&["d.csv"], &["list \"d.csv\" cannot be read"]),
        (&["pairs.txt"], &["LIST is \"pairs.txt\"", ".csv, .jsonl or .ndjson", "stdin"]),
        (&["."], &["LIST is \".\""]),
        (&["l0.png", "l1.png", "l2.png"], &["3 names", "in quotes"]),
        (&["l*.png", "r[01].png"], &["LEFT \"l*.png\" has 3 frames and RIGHT"]),
        (&["l*.png", "none/*.png"], &["RIGHT is \"none/*.png\""]),
    ];
    for (given, words) in given {
        refuses(folder.path(), &of(given, &[]), words);
    }
    let options: [(&[&str], &[&str]); 10] = [
        (&["--shard", "0/3"], &["'0/3'", "--shard", "I from 1 to N", "add 1 to a number that counts from 0"]),
        (&["--shard", "4/3"], &["'4/3'"]),
        (&["--shard", "3"], &["'3'"]),
        (&["-j", "0"], &["--threads is 0", "1 to 64"]),
        (&["-j", "-1"], &["--threads is -1"]),
        (&["--in-flight", "17"], &["--in-flight is 17"]),
        (&["--format", "png,png"], &["twice"]),
        (&["--block", "4"], &["--block is 4"]),
        (&["--adapter", "0"], &["--adapter is \"0\""]),
        (&["--fps", "3"], &["--fps"]),
    ];
    for (more, words) in options {
        refuses(folder.path(), &batch(more), words);
    }
    for (out, words) in [("no/maps", "does not exist"), ("file", "is a file")] {
        refuses(folder.path(), &["batch", "pairs.csv", "-o", out, "--disp", "16"], &[out, words]);
    }
    refuses(folder.path(), &["batch", "pairs.csv", "-o", "maps"], &["--disp"]);
    refuses(folder.path(), &["batch", "pairs.csv", "--disp", "16"], &["--output"]);
    // No map over an input of any pair, also of another shard's.
    fs::write(at("x.csv"), "l0.png,r0.png,a\nl1.png,r1.png,l0\n").unwrap();
    refuses(folder.path(), &["batch", "x.csv", "-o", ".", "--disp", "16", "--shard", "1/2"], &["is an input, too"]);
    // A device that cannot compute changes nothing.
    fs::create_dir_all(at("maps")).unwrap();
    let before = contents(folder.path());
    let args = ["batch", "pairs.csv", "-o", "maps", "--disp", "16", "--adapter", "none such"];
    is_one_line_error(&run(folder.path(), &args), &["--adapter is \"none such\"", "0 of 3 pairs"]);
    assert!(contents(folder.path()) == before);
}

#[test]
fn the_help_ends_with_examples() {
    let help = succeeds(Path::new("."), &["batch", "--help"]);
    let help = stdout(&help);
    let examples = help.split_once("\nExamples:\n").unwrap().1;
    for words in ["gpu-stereo batch pairs.csv -o maps --disp 128", "--resume --shard 3/8", "parallel ", "Exit codes:"] {
        assert!(examples.contains(words), "{help}");
    }
    for option in ["--format", "--shard", "--threads", "--in-flight", "--resume", "--json", "--out", "failures.jsonl"] {
        assert!(help.contains(option), "{option}");
    }
}
