//! `gpu-stereo batch` and `video` after everything that can go wrong with a folder: changed images, killed processes, other
//! runs at the same time, full disks, names and files that are in the way.
//!
//! On the CPU, so that no adapter is needed.

use crate::support::{
    SHIFT, command, contents, is_one_line_error, not_tested, refuses, run, stderr, succeeds, texture,
};
use image::{GrayImage, Luma};
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, SystemTime};
use tempfile::TempDir;

/// The pair left/NUMBER.png and right/NUMBER.png, of which no other one with another seed is a copy.
fn save(folder: &Path, number: u32, seed: u32, [width, height]: [u32; 2]) {
    for (side, shift) in [("left", 0), ("right", SHIFT)] {
        let sample = |x, y| Luma([texture(x + shift + 997 * seed, y)]);
        let path = folder.join(side).join(format!("{number}.png"));
        GrayImage::from_fn(width, height, sample).save(path).unwrap();
    }
}

/// So many pairs, all of one seed each.
fn pairs(count: u32, size: [u32; 2]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("left")).unwrap();
    fs::create_dir(folder.path().join("right")).unwrap();
    (0..count).for_each(|number| save(folder.path(), number, number, size));
    folder
}

/// `VERB left right -o OUT --disp 16 --backend cpu` and more.
fn args<'a>(verb: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[verb, "left", "right", "-o", out, "--disp", "16", "--backend", "cpu"], more].concat()
}

/// The maps of a folder.
fn maps(folder: &TempDir, out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let out = folder.path().join(out);
    let there = if out.exists() { contents(&out) } else { BTreeMap::new() };
    let all = there.into_iter().map(|(path, bytes)| (path.strip_prefix(&out).unwrap().to_owned(), bytes));
    let is_map = |path: &Path| {
        let name = path.to_string_lossy();
        !name.ends_with(".json") && !name.ends_with(".jsonl") && !name.contains(".gpu-stereo-")
    };
    all.filter(|(path, _)| is_map(path)).collect()
}

/// The maps that a run into a new folder gives.
fn fresh(folder: &TempDir, verb: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let _ = fs::remove_dir_all(folder.path().join("fresh"));
    succeeds(folder.path(), &args(verb, "fresh", &["-q"]));
    maps(folder, "fresh")
}

fn start(folder: &TempDir, args: &[&str]) -> Child {
    command(folder.path()).args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn counts(output: &Output) -> [u64; 3] {
    let told: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", stderr(output)));
    ["done", "failed", "skipped"].map(|field| told[field].as_u64().unwrap())
}

fn resume(folder: &TempDir, verb: &str, more: &[&str]) -> [u64; 3] {
    counts(&run(folder.path(), &args(verb, "maps", &[&["--resume", "--json"], more].concat())))
}

/// Through the shell, after `limit`.
fn limited(folder: &Path, limit: &str, args: &[&str]) -> Output {
    let mut sh = Command::new("sh");
    sh.current_dir(folder).args(["-c", &format!("{limit}; exec \"$@\""), "sh", env!("CARGO_BIN_EXE_gpu-stereo")]);
    sh.args(args).output().unwrap()
}

// Changed images.

#[test]
fn maps_of_images_that_changed_are_computed_again() {
    for verb in ["batch", "video"] {
        let folder = pairs(4, [49, 31]);
        succeeds(folder.path(), &args(verb, "maps", &["-q"]));
        assert_eq!(resume(&folder, verb, &[]), [0, 0, 4]);
        // Other contents; other contents of the same length and time; the same contents with another time.
        save(folder.path(), 0, 90, [49, 31]);
        let path = folder.path().join("right/1.png");
        let (before, time) = (fs::read(&path).unwrap(), fs::metadata(&path).unwrap().modified().unwrap());
        let image = GrayImage::from_pixel(49, 31, Luma([7]));
        image.save(&path).unwrap();
        let mut after = fs::read(&path).unwrap();
        after.resize(before.len(), 0); // decoders stop at the end of the image
        fs::write(&path, after).unwrap();
        File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        let touched = File::options().write(true).open(folder.path().join("left/2.png")).unwrap();
        touched.set_modified(SystemTime::now() - Duration::from_secs(1000)).unwrap();
        assert_eq!(resume(&folder, verb, &[]), [2, 0, 2], "{verb}");
        assert!(maps(&folder, "maps") == fresh(&folder, verb), "{verb}");
    }
}

#[test]
fn maps_that_are_not_as_they_were_written_are_computed_again() {
    for verb in ["batch", "video"] {
        let folder = pairs(5, [49, 31]);
        succeeds(folder.path(), &args(verb, "maps", &["-q", "--no-sync"]));
        let expected = maps(&folder, "maps");
        let at = |name: &str| folder.path().join("maps").join(name);
        // Empty, as after a power cut; cut short; zeros of the same length; another file by a link.
        fs::write(at("0.png"), "").unwrap();
        fs::write(at("1.png"), &expected[Path::new("1.png")][..100]).unwrap();
        fs::write(at("2.png"), vec![0; expected[Path::new("2.png")].len()]).unwrap();
        fs::rename(at("3.png"), folder.path().join("elsewhere")).unwrap();
        symlink("../elsewhere", at("3.png")).unwrap();
        assert_eq!(resume(&folder, verb, &[]), [4, 0, 1], "{verb}");
        assert!(maps(&folder, "maps") == expected, "{verb}");
        assert!(!at("3.png").is_symlink());
        assert_eq!(resume(&folder, verb, &[]), [0, 0, 5], "{verb}");
        // A copy of the folder, with times of its own, is as good.
        let status = Command::new("cp").arg("-r").args([at(""), folder.path().join("copy")]).status().unwrap();
        assert!(status.success());
        assert_eq!(counts(&succeeds(folder.path(), &args(verb, "copy", &["--resume", "--json"]))), [0, 0, 5], "{verb}");
    }
}

/// A run that begins anew vouches for no old map from its first own one on.
#[test]
fn what_a_finished_folder_held_is_not_resumed_after_an_interrupted_run() {
    for verb in ["batch", "video"] {
        let folder = pairs(30, [160, 120]);
        succeeds(folder.path(), &args(verb, "maps", &["-q"]));
        let old = maps(&folder, "maps");
        // As an editor or rsync leaves them: lengths and times may be the same, so only the contents tell.
        (0..30).for_each(|number| save(folder.path(), number, 100 + number, [160, 120]));
        let mut child =
            start(&folder, &args(verb, "maps", &["-q", if verb == "batch" { "-j1" } else { "--in-flight=1" }]));
        while maps(&folder, "maps").iter().filter(|(path, bytes)| old[*path] != **bytes).count() < 3 {
            assert!(child.try_wait().unwrap().is_none(), "it ended before its time");
            thread::sleep(Duration::from_millis(2));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let [done, failed, skipped] = resume(&folder, verb, &[]);
        assert!(failed == 0 && done + skipped == 30 && skipped >= 1, "{verb}: {done} {failed} {skipped}");
        assert!(maps(&folder, "maps") == fresh(&folder, verb), "{verb}");
        // Settings of old maps are refused.
        let output = run(folder.path(), &args(verb, "maps", &["--resume", "--p1", "9"]));
        is_one_line_error(&output, &["p1 18 there and 9 now", "gpu-stereo.json"]);
    }
}

/// Killed at any time, with images that change in between, it ends with the maps of the images as they are.
#[test]
fn killed_at_any_time_it_resumes_to_the_maps_of_the_present_images() {
    let seed: u64 = std::env::var("SEED").map_or(1, |seed| seed.parse().unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for verb in ["batch", "video"] {
        let folder = pairs(12, [90, 60]);
        let mut version = 100;
        for round in 0..4 {
            for kill in 0..3 {
                let anew = rng.random_range(0..4) == 0;
                let more: &[&str] = if anew { &["-q"] } else { &["-q", "--resume"] };
                let mut child = start(&folder, &args(verb, "maps", more));
                thread::sleep(Duration::from_millis(rng.random_range(0..120)));
                let _ = child.kill(); // it may have ended
                child.wait().unwrap();
                if kill < 2 {
                    version += 1;
                    save(folder.path(), rng.random_range(0..12), version, [90, 60]);
                }
            }
            let [done, failed, skipped] = resume(&folder, verb, &[]);
            assert_eq!((done + skipped, failed), (12, 0), "{verb}, round {round} of seed {seed}");
            assert!(maps(&folder, "maps") == fresh(&folder, verb), "{verb}, round {round} of seed {seed}");
            assert_eq!(resume(&folder, verb, &[]), [0, 0, 12], "{verb}, round {round} of seed {seed}");
        }
        let left: Vec<_> = contents(&folder.path().join("maps")).into_keys().collect();
        assert!(!left.iter().any(|path| path.to_string_lossy().contains("begun")), "{left:?}");
    }
}

#[test]
fn a_frame_of_another_size_is_refused_by_a_resumed_video_too() {
    let folder = pairs(3, [49, 31]);
    save(folder.path(), 1, 1, [40, 31]);
    let first = run(folder.path(), &args("video", "maps", &["--json"]));
    assert_eq!(counts(&first), [2, 1, 0]);
    let again = run(folder.path(), &args("video", "maps", &["--json", "--resume"]));
    assert_eq!((again.status.code(), counts(&again)), (Some(1), [0, 1, 2]));
    assert!(stderr(&again).contains("it is 40x31 in Gray8, but the first frame is 49x31"), "{}", stderr(&again));
    assert!(!folder.path().join("maps/1.png").exists());
}

// Pairs that end the process.

#[test]
fn a_pair_that_ends_the_process_is_reported_and_passed_over() {
    let folder = pairs(6, [49, 31]);
    let heavy = |name: &str| {
        // More than a second of processor time.
        let image = GrayImage::from_fn(1600, 1200, |x, y| Luma([texture(x, y)]));
        image.save(folder.path().join(name)).unwrap();
    };
    for side in ["left", "right"] {
        fs::remove_file(folder.path().join(side).join("3.png")).unwrap();
        heavy(&format!("{side}/3.pgm"));
    }
    let limited = |more: &[&str]| limited(folder.path(), "ulimit -t 1", &args("batch", "maps", more));
    let died = limited(&["--json"]);
    if died.status.code().is_some() {
        not_tested("this system does not limit the time of a process, or is very fast");
        return;
    }
    let resumed = limited(&["--resume", "--json"]);
    assert_eq!((resumed.status.code(), counts(&resumed)[1]), (Some(1), 1), "{}", stderr(&resumed));
    let [done, _, skipped] = counts(&resumed);
    assert_eq!(done + skipped, 5);
    for words in
        ["note: an earlier run died", "failed: left/3.pgm: it ended the process that computed it alone", "--retry"]
    {
        assert!(stderr(&resumed).contains(words), "{words:?} is not in {}", stderr(&resumed));
    }
    let failures = fs::read_to_string(folder.path().join("maps/failures.jsonl")).unwrap();
    assert!(failures.lines().count() == 1 && failures.contains("3.pgm"), "{failures}");
    // It is not tried again, with a limit or without, until that is asked for.
    let again = run(folder.path(), &args("batch", "maps", &["--resume", "--json"]));
    assert_eq!((again.status.code(), counts(&again)), (Some(1), [0, 1, 5]), "{}", stderr(&again));
    assert!(stderr(&again).contains("not tried again"), "{}", stderr(&again));
    let retried = succeeds(folder.path(), &args("batch", "maps", &["--resume", "--retry", "--json"]));
    assert_eq!(counts(&retried), [1, 0, 5]);
    assert_eq!(resume(&folder, "batch", &[]), [0, 0, 6]);
    assert!(maps(&folder, "maps") == fresh(&folder, "batch"));
    // Other images under the same names are tried without being asked for.
    let died = limited(&["--json"]);
    assert_eq!((died.status.code(), limited(&["--resume", "-q"]).status.code()), (None, Some(1)));
    save(folder.path(), 3, 3, [49, 31]);
    for side in ["left", "right"] {
        let (from, to) = (format!("{side}/3.png"), format!("{side}/3.pgm"));
        fs::rename(folder.path().join(from), folder.path().join(to)).unwrap();
    }
    assert_eq!(resume(&folder, "batch", &[]), [1, 0, 5]);
}

#[test]
fn a_process_that_lives_is_no_crashed_one() {
    let folder = pairs(40, [160, 120]);
    let first = start(&folder, &args("batch", "maps", &["-q", "-j", "1", "--shard", "1/2"]));
    while maps(&folder, "maps").is_empty() {
        thread::sleep(Duration::from_millis(2));
    }
    let second = succeeds(folder.path(), &args("batch", "maps", &["--resume", "--json"]));
    let first = first.wait_with_output().unwrap();
    assert_eq!(first.status.code(), Some(0), "{}", stderr(&first));
    assert!(!stderr(&second).contains("died"), "{}", stderr(&second));
    assert!(maps(&folder, "maps") == fresh(&folder, "batch"));
}

// Two runs in one folder.

#[test]
fn videos_of_two_settings_at_once_never_mix() {
    let folder = pairs(20, [120, 80]);
    let expected = ["5", "9"].map(|p1| {
        succeeds(folder.path(), &args("video", p1, &["-q", "--p1", p1]));
        maps(&folder, p1)
    });
    for _ in 0..4 {
        let children = ["5", "9"].map(|p1| start(&folder, &args("video", "maps", &["-q", "--p1", p1])));
        let outputs = children.map(|child| child.wait_with_output().unwrap());
        for (output, other) in outputs.iter().zip(["9 there and 5 now", "5 there and 9 now"]) {
            if output.status.code() != Some(0) {
                let told = stderr(output);
                assert_eq!(output.status.code(), Some(2), "{told}");
                assert!(told.contains("another process writes maps") && told.contains(other), "{told}");
            }
        }
        assert!(outputs.iter().any(|output| output.status.success()));
        let both = maps(&folder, "maps");
        assert!(expected.contains(&both), "maps of both settings");
        fs::remove_dir_all(folder.path().join("maps")).unwrap();
    }
}

#[test]
fn a_folder_is_of_one_verb() {
    for (first, second) in [("batch", "video"), ("video", "batch")] {
        let folder = pairs(3, [49, 31]);
        succeeds(folder.path(), &args(first, "maps", &["-q"]));
        for more in [&[][..], &["--resume"], &["--p1", "9"]] {
            let words = ["maps of gpu-stereo", first, "gpu-stereo.json", "another folder"];
            refuses(folder.path(), &args(second, "maps", more), &words);
        }
        assert_eq!(resume(&folder, first, &[]), [0, 0, 3]);
    }
}

#[test]
fn a_lock_that_is_waited_for_is_reported() {
    let folder = pairs(2, [49, 31]);
    fs::create_dir(folder.path().join("maps")).unwrap();
    let hold = Command::new("flock").current_dir(folder.path()).args(["maps/gpu-stereo.json", "sleep", "3"]).spawn();
    let Ok(mut hold) = hold else { return not_tested("there is no flock") };
    thread::sleep(Duration::from_millis(300));
    let output = succeeds(folder.path(), &args("batch", "maps", &["-q"]));
    hold.wait().unwrap();
    let expected = "note: waiting for \"maps/gpu-stereo.json\", which another process has locked\n";
    assert_eq!(stderr(&output), expected);
    assert_eq!(maps(&folder, "maps").len(), 2);
}

// Names.

#[test]
fn names_that_are_no_unicode_are_told_apart() {
    let folder = pairs(2, [49, 31]);
    let bytes = |name: &[u8]| OsStr::from_bytes(name).to_owned();
    let [one, other] = [bytes(b"a\xff"), bytes(b"a\xfe")];
    for side in ["left", "right"] {
        for (number, name) in [&one, &other].into_iter().enumerate() {
            let to = folder.path().join(side).join(name).with_extension("png");
            if fs::rename(folder.path().join(side).join(format!("{number}.png")), to).is_err() {
                return not_tested("this file system has names in Unicode alone");
            }
        }
    }
    for verb in ["batch", "video"] {
        let out = bytes(
            format!("{verb}\u{1}")
                .as_bytes()
                .iter()
                .map(|&b| if b == 1 { 0xff } else { b })
                .collect::<Vec<_>>()
                .as_slice(),
        );
        let run = |more: &[&str]| {
            let fixed = ["--disp", "16", "--backend", "cpu", "--json"].map(OsString::from);
            let mut all = [verb, "left", "right", "-o"].map(OsString::from).to_vec();
            all.push(out.clone());
            all.extend(fixed.into_iter().chain(more.iter().map(OsString::from)));
            run(folder.path(), &all)
        };
        assert_eq!(counts(&run(&[])), [2, 0, 0], "{verb}");
        let read = |name: &OsStr| fs::read(folder.path().join(&out).join(name).with_extension("png")).unwrap();
        let maps = [read(&one), read(&other)];
        assert!(maps[0] != maps[1]);
        assert_eq!(counts(&run(&["--resume"])), [0, 0, 2], "{verb}");
        fs::remove_file(folder.path().join(&out).join(&one).with_extension("png")).unwrap();
        assert_eq!(counts(&run(&["--resume"])), [1, 0, 1], "{verb}");
        assert!([read(&one), read(&other)] == maps);
        // Maps of other settings go, these names too.
        if verb == "video" {
            fs::write(folder.path().join("left").join(&one).with_extension("png"), "no image").unwrap();
            assert_eq!(counts(&run(&["--p1", "9"])), [1, 1, 0]);
            assert!(!folder.path().join(&out).join(&one).with_extension("png").exists());
        } else {
            // The log of failures is a list without loss.
            let image = folder.path().join("left").join(&other).with_extension("png");
            let whole = fs::read(&image).unwrap();
            fs::write(&image, "no image").unwrap();
            assert_eq!(counts(&run(&["--resume"])), [0, 1, 1]);
            fs::write(&image, &whole).unwrap();
            fs::copy(folder.path().join(&out).join("failures.jsonl"), folder.path().join("list.jsonl")).unwrap();
            let args = ["batch", "list.jsonl", "-o", "again", "--disp", "16", "--backend", "cpu", "-q"];
            succeeds(folder.path(), &args);
            let again = folder.path().join("again").join(&other).with_extension("png");
            assert!(fs::read(again).unwrap() == maps[1]);
        }
    }
}

#[test]
fn names_in_each_others_way_are_refused_before_any_work() {
    let folder = pairs(2, [49, 31]);
    let list = |text: &str| fs::write(folder.path().join("list.csv"), text).unwrap();
    let batch = ["batch", "list.csv", "-o", "maps", "--disp", "16", "--backend", "cpu"];
    fs::create_dir(folder.path().join("maps")).unwrap();
    for (names, words) in [
        (["a", "a.png/b"], ["\"left/0.png\" (line 1)", "\"left/1.png\" (line 2)", "\"maps/a.png\""]),
        (["a.png/b/c", "a"], ["(line 2)", "(line 1)", "\"maps/a.png\""]),
        (["a", "done.jsonl/b"], ["\"maps/done.jsonl\"", "a file of gpu-stereo itself", "a list"]),
        (["a", "gpu-stereo.json/b"], ["\"maps/gpu-stereo.json\"", "a file of gpu-stereo itself", "a list"]),
    ] {
        list(&format!("left/0.png,right/0.png,{}\nleft/1.png,right/1.png,{}\n", names[0], names[1]));
        refuses(folder.path(), &batch, &words);
    }
}

// Files in the way.

#[test]
fn nothing_is_written_through_links() {
    let folder = pairs(2, [49, 31]);
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("outside")).unwrap();
    fs::create_dir(at("maps")).unwrap();
    symlink("../outside", at("maps/link")).unwrap();
    fs::write(at("list.csv"), "left/0.png,right/0.png,link/x\nleft/1.png,right/1.png,y\n").unwrap();
    let batch = ["batch", "list.csv", "-o", "maps", "--disp", "16", "--backend", "cpu"];
    refuses(folder.path(), &batch, &["\"maps/link\" is a link", "lead out of the output folder"]);
    fs::remove_file(at("maps/link")).unwrap();
    // A map takes the place of a link, and of nothing behind it.
    fs::write(at("outside/file"), "kept").unwrap();
    symlink("../outside/file", at("maps/y.png")).unwrap();
    fs::create_dir(at("maps/link")).unwrap();
    succeeds(folder.path(), &batch);
    assert_eq!(fs::read(at("outside/file")).unwrap(), b"kept");
    assert!(!at("maps/y.png").is_symlink() && at("maps/link/x.png").exists());
    // The output folder itself may be a link.
    symlink("outside", at("other")).unwrap();
    succeeds(folder.path(), &args("batch", "other", &["-q"]));
    assert!(at("outside/1.png").exists());
    for own in ["gpu-stereo.json", "done.jsonl", "failures.jsonl"] {
        let _ = fs::remove_dir_all(at("maps"));
        fs::create_dir(at("maps")).unwrap();
        symlink("../outside/file", at("maps").join(own)).unwrap();
        refuses(folder.path(), &batch, &[own, "is a link"]);
    }
}

#[test]
fn fifos_are_refused_and_nothing_hangs() {
    let folder = pairs(2, [49, 31]);
    let at = |name: &str| folder.path().join(name);
    let fifo = |name: &str| Command::new("mkfifo").arg(at(name)).status().is_ok_and(|status| status.success());
    fs::create_dir(at("maps")).unwrap();
    for verb in ["batch", "video"] {
        for own in ["gpu-stereo.json", "done.jsonl", "failures.jsonl"] {
            let name = format!("maps/{own}");
            if !fifo(&name) {
                return not_tested("there is no mkfifo");
            }
            for more in [&[][..], &["--resume"]] {
                let mut timeout = Command::new("timeout");
                timeout.current_dir(folder.path()).arg("20").arg(env!("CARGO_BIN_EXE_gpu-stereo"));
                let output = timeout.args(args(verb, "maps", more)).output().unwrap();
                is_one_line_error(&output, &[own, "is a FIFO"]);
            }
            fs::remove_file(at(&name)).unwrap();
        }
        assert!(fifo("maps/1.png"));
        is_one_line_error(&run(folder.path(), &args(verb, "maps", &[])), &["\"maps/1.png\"", "not a regular file"]);
        fs::remove_dir_all(at("maps")).unwrap();
        fs::create_dir(at("maps")).unwrap();
    }
}

// Disks.

/// It stops at once, says why, and leaves no file half written.
#[track_caller]
fn stops(folder: &Path, output: &Output, words: &[&str]) {
    let told = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    let last = told.lines().last().unwrap();
    assert!(last.starts_with("error: ") && !told.contains("failed: "), "{told}");
    for word in words {
        assert!(last.contains(word), "{word:?} is not in {told}");
    }
    let left: Vec<_> =
        contents(folder).into_keys().filter(|path| path.to_string_lossy().contains(".gpu-stereo-")).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_limit_of_file_sizes_stops_a_run() {
    let folder = pairs(30, [120, 80]);
    for verb in ["batch", "video"] {
        let output = limited(folder.path(), "ulimit -f 2", &args(verb, "maps", &["-q"]));
        let words = ["cannot be written", "ulimit -f", "0 of 30", "--resume computes the rest"];
        stops(&folder.path().join("maps"), &output, &words);
        assert!(maps(&folder, "maps").is_empty());
        assert_eq!(resume(&folder, verb, &[]), [30, 0, 0]);
        fs::remove_dir_all(folder.path().join("maps")).unwrap();
    }
    let single = ["left/0.png", "right/0.png", "--disp", "16", "--backend", "cpu", "-o", "single.npy"];
    is_one_line_error(
        &limited(folder.path(), "ulimit -f 2", &single),
        &["\"single.npy\" cannot be written", "ulimit -f"],
    );
    assert!(!folder.path().join("single.npy").exists());
}

#[test]
fn a_full_disk_stops_a_run() {
    let folder = pairs(30, [120, 80]);
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=128k", "tmpfs"]).arg(&disk).output();
    if !mount.is_ok_and(|mounted| mounted.status.success()) {
        return not_tested("no small disk can be mounted");
    }
    let check = || {
        for verb in ["batch", "video"] {
            let output = run(folder.path(), &args(verb, "disk/maps", &["-q"]));
            stops(&disk, &output, &["cannot be written", "free some space", " of 30", "--resume computes the rest"]);
            for (path, bytes) in maps(&folder, "disk/maps") {
                assert!(image::load_from_memory(&bytes).is_ok(), "{path:?}");
            }
            let _ = fs::remove_dir_all(disk.join("maps"));
        }
    };
    let checked = std::panic::catch_unwind(check);
    Command::new("umount").arg(&disk).status().unwrap();
    if let Err(why) = checked {
        std::panic::resume_unwind(why);
    }
}

// Bench.

/// A data set of scenes as in KITTI 2015.
fn data_set(scenes: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for side in ["image_2", "image_3", "disp_occ_0"] {
        fs::create_dir_all(folder.path().join("set/training").join(side)).unwrap();
    }
    for number in 0..scenes {
        let at = |side: &str| folder.path().join(format!("set/training/{side}/{number:06}_10.png"));
        for (side, shift) in [("image_2", 0), ("image_3", SHIFT)] {
            let sample = |x, y| Luma([texture(x + shift + 997 * number, y)]);
            GrayImage::from_fn(160, 120, sample).save(at(side)).unwrap();
        }
        let truth = |x: u32, _| Luma([if x < SHIFT { 0 } else { 256 * SHIFT as u16 }]);
        image::ImageBuffer::<Luma<u16>, Vec<u16>>::from_fn(160, 120, truth).save(at("disp_occ_0")).unwrap();
    }
    folder
}

/// The files of a report, without times.
fn report(folder: &TempDir, name: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = maps(folder, name);
    files.remove(Path::new("report.md")).unwrap();
    let text = fs::read_to_string(folder.path().join(name).join("report.md")).unwrap();
    let text: String =
        text.split("## Scenes").nth(1).unwrap().split_inclusive('\n').filter(|line| line.contains("](")).collect();
    let without_times: Vec<_> =
        text.split(" ms |").map(|part| part.rsplit_once(", ").map_or(part, |(rest, _)| rest)).collect();
    files.insert("report".into(), without_times.join("\n").into_bytes());
    let results = fs::read(folder.path().join(name).join("results.json")).unwrap();
    let mut results: Value = serde_json::from_slice(&results).unwrap();
    for of in ["scenes", "sets"] {
        results[of].as_array_mut().unwrap().iter_mut().for_each(|found| found["frame_ms"] = Value::Null);
    }
    files.insert("results".into(), results.to_string().into_bytes());
    files
}

#[test]
fn a_bench_that_was_killed_goes_on_to_the_same_report() {
    let folder = data_set(8);
    let bench = |report: &'static str, more: &[&'static str]| {
        let args = [
            "bench",
            "set",
            "--layout",
            "kitti2015",
            "--backend",
            "cpu",
            "--disp",
            "16",
            "--variants",
            "sad",
            "census",
        ];
        [&args[..], &["--report", report, "--submission", "upload"], more].concat()
    };
    succeeds(folder.path(), &bench("whole", &["-q"]));
    let expected = report(&folder, "whole");
    let log = folder.path().join("killed/done.jsonl");
    let lines = || fs::read_to_string(&log).map_or(0, |text| text.lines().count());
    let mut more: &[&str] = &["-q"];
    for _ in 0..3 {
        let before = if more.len() == 1 { 0 } else { lines() };
        let mut child = start(&folder, &bench("killed", more));
        while lines() < before + 3 {
            assert!(child.try_wait().unwrap().is_none(), "it ended before its time");
            thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        more = &["-q", "--resume"];
    }
    // A picture that is damaged and an image that changes and is changed back.
    let picture = folder.path().join("killed/pictures/0001_training_000000_10_estimate1.png");
    fs::write(&picture, "damaged").unwrap();
    let before = lines();
    succeeds(folder.path(), &bench("killed", &["--resume", "-q"]));
    assert!(report(&folder, "killed") == expected);
    assert!(lines() < 16 + 3, "{before} {}: what was kept is computed again", lines());
    let after = lines();
    succeeds(folder.path(), &bench("killed", &["--resume", "-q"]));
    assert_eq!(lines(), after);
    assert!(report(&folder, "killed") == expected);
    save_scene(&folder, 3);
    succeeds(folder.path(), &bench("killed", &["--resume", "-q"]));
    assert_eq!(lines(), after + 2);
    succeeds(folder.path(), &bench("whole", &["-q"]));
    assert!(report(&folder, "killed") == report(&folder, "whole"));
    // Other settings keep nothing.
    succeeds(folder.path(), &bench("killed", &["--resume", "-q", "--p1", "9"]));
    assert_eq!(lines(), after + 2 + 16);
    let no_report = ["bench", "set", "--layout", "kitti2015", "--backend", "cpu", "--resume"];
    refuses(folder.path(), &no_report, &["--resume needs", "--report"]);
}

/// Other images of a scene.
fn save_scene(folder: &TempDir, number: u32) {
    for (side, shift) in [("image_2", 0), ("image_3", SHIFT)] {
        let path = folder.path().join(format!("set/training/{side}/{number:06}_10.png"));
        GrayImage::from_fn(160, 120, |x, y| Luma([texture(x + shift + 31, y + 500)])).save(path).unwrap();
    }
}

#[test]
fn a_limit_of_file_sizes_stops_a_bench() {
    let folder = data_set(6);
    let args =
        ["bench", "set", "--layout", "kitti2015", "--backend", "cpu", "--disp", "16", "-q", "--report", "report"];
    let output = limited(folder.path(), "ulimit -f 2", &args);
    stops(
        &folder.path().join("report"),
        &output,
        &["cannot be written", "ulimit -f", "0 of 6", "--resume computes the rest"],
    );
    succeeds(folder.path(), &[&args[..], &["--resume"]].concat());
    succeeds(folder.path(), &[&args[..9], &["--report", "other"]].concat());
    assert!(report(&folder, "report") == report(&folder, "other"));
}
