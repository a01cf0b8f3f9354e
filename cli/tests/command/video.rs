//! `gpu-stereo video` as a user meets it: many frames, their files, what is told of those that fail.
//!
//! On the CPU, so that no adapter is needed, but for one test of the stream.

use crate::support::{
    SHIFT, command, contents, is_one_line_error, not_tested, refuses, run, stderr, stdout, succeeds, texture,
};
use image::{GrayImage, Luma};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A pair that no other frame is equal to.
fn frame(number: u32, width: u32, height: u32) -> [GrayImage; 2] {
    let sample = |x: u32, y: u32| Luma([texture(x + 97 * number, y)]);
    [0, SHIFT].map(|shift| GrayImage::from_fn(width, height, |x, y| sample(x + shift, y)))
}

/// Pairs left/LEFT.png and right/RIGHT.png with these names.
fn frames(names: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("left")).unwrap();
    fs::create_dir(folder.path().join("right")).unwrap();
    for (number, (left, right)) in (0..).zip(names) {
        let [l, r] = frame(number, 49, 31);
        l.save(folder.path().join(format!("left/{left}.png"))).unwrap();
        r.save(folder.path().join(format!("right/{right}.png"))).unwrap();
    }
    folder
}

/// `video left right -o OUT --disp 16 --backend cpu` and more.
fn video<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    of("left", "right", out, more)
}

fn of<'a>(left: &'a str, right: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["video", left, right, "-o", out, "--disp", "16", "--backend", "cpu"], more].concat()
}

/// The names in a folder.
fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The files are what single runs on these pairs give.
#[track_caller]
fn are_single_runs(folder: &TempDir, pairs: &[(&str, &str)], outs: &[&str], option: &str, ending: &str) {
    let single = format!("single.{ending}");
    for ((left, right), out) in pairs.iter().zip(outs) {
        let (left, right) = (format!("left/{left}.png"), format!("right/{right}.png"));
        succeeds(folder.path(), &[&left, &right, "--disp", "16", "--backend", "cpu", "-q", option, &single]);
        let [single, out] = [&single, *out].map(|name| fs::read(folder.path().join(name)).unwrap());
        assert!(single == out, "{left}");
    }
}

#[track_caller]
fn ends_with_1(output: &Output) {
    assert_eq!(output.status.code(), Some(1), "{}", stderr(output));
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

// What it writes.

const NATURAL: [(&str, &str); 4] = [("f1", "a_1"), ("f2", "a_2"), ("f3", "a_3"), ("f10", "a_10")];

#[test]
fn folders_give_what_single_runs_give() {
    let folder = frames(&NATURAL);
    let at = |name: &str| folder.path().join(name);
    fs::write(at("left/notes.txt"), "no image").unwrap();
    fs::write(at("right/.hidden.png"), "no image").unwrap();
    fs::create_dir(at("left/f4.png")).unwrap();
    let formats = [
        ("-o", "png", "png", ""),
        ("-o", "pfm", "pfm", ""),
        ("-o", "npy", "npy", ""),
        ("-o", "tif", "tif", ""),
        ("--color", "color", "png", "_color"),
        ("--mask", "mask", "png", "_mask"),
        ("--confidence", "confidence", "png", "_confidence"),
    ];
    let all = formats.map(|(_, name, ..)| name).join(",");
    let output = succeeds(folder.path(), &video("maps", &["--format", &all]));
    for (option, _, ending, suffix) in formats {
        let outs = NATURAL.map(|(left, _)| format!("maps/{left}{suffix}.{ending}"));
        are_single_runs(&folder, &NATURAL, &outs.each_ref().map(String::as_str), option, ending);
    }
    assert_eq!(names(&at("maps")).len(), 4 * formats.len() + 2);
    let told = stdout(&output);
    for words in ["CPU with ", "size     49 x 31", "4 done, 0 failed, 0 there already", "written  maps"] {
        assert!(told.contains(words), "{told}");
    }
    assert!(stderr(&output).contains("4/4") && stderr(&output).contains("frames a second"), "{}", stderr(&output));

    // The map alone, without a word, over what is there.
    fs::write(at("maps/f2.png"), "old").unwrap();
    let output = succeeds(folder.path(), &video("maps", &["-q"]));
    assert_eq!((stdout(&output), stderr(&output)), (String::new(), String::new()));
    are_single_runs(&folder, &NATURAL, &["maps/f1.png", "maps/f2.png", "maps/f3.png", "maps/f10.png"], "-o", "png");
}

#[test]
fn a_stream_on_an_adapter_gives_the_same_bits_in_the_same_order() {
    if std::env::var_os("GPU_STEREO_NO_ADAPTER").is_some() {
        not_tested("there is no adapter, and GPU_STEREO_NO_ADAPTER is set");
        return;
    }
    let numbers: Vec<String> = (0..9).map(|number| format!("{number:03}")).collect();
    let folder = frames(&numbers.iter().map(|name| (name.as_str(), name.as_str())).collect::<Vec<_>>());
    succeeds(folder.path(), &video("cpu", &[]));
    for in_flight in ["1", "3", "16"] {
        let options = ["--disp", "16", "--backend", "gpu", "--in-flight", in_flight, "--json"];
        let output = succeeds(folder.path(), &[&["video", "left", "right", "-o", in_flight], &options[..]].concat());
        let told = json(&output);
        assert!(
            told["done"] == 9 && told["backend"] != "cpu" && told["peak_device_bytes"].as_u64() > Some(0),
            "{told}"
        );
        for name in &numbers {
            let [cpu, gpu] = ["cpu", in_flight].map(|out| fs::read(folder.path().join(format!("{out}/{name}.png"))));
            assert!(cpu.unwrap() == gpu.unwrap(), "{in_flight} in flight, frame {name}");
        }
    }
}

#[test]
fn patterns_number_the_files_up_to_a_gap() {
    let pairs = [("l_003", "r3"), ("l_004", "r4"), ("l_006", "r6"), ("l_1007", "r1007")];
    let folder = frames(&pairs);
    let output = succeeds(folder.path(), &of("left/l_%03d.png", "right/r%d.png", "m_%02d.pfm", &[]));
    are_single_runs(&folder, &pairs, &["m_03.pfm", "m_04.pfm"], "-o", "pfm");
    assert_eq!(names(folder.path()), set(&["left", "right", "m_03.pfm", "m_04.pfm", "single.pfm"]));
    for words in ["there is no \"left/l_005.png\", so the 2 frames", "there is no \"right/r5.png\""] {
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    // Into a folder that is made, by the left names; a picture has the pattern's name.
    succeeds(folder.path(), &of("left/l_%03d.png", "right/r%d.png", "new", &[]));
    assert_eq!(names(&folder.path().join("new")), set(&["l_003.png", "l_004.png", "gpu-stereo.json", "done.jsonl"]));
    succeeds(folder.path(), &of("left/l_%03d.png", "right/r%d.png", "c%d.png", &["--format", "color"]));
    are_single_runs(&folder, &pairs, &["c3.png", "c4.png"], "--color", "png");
    // With gaps on one side only, frames have no partner.
    fs::remove_file(folder.path().join("right/r4.png")).unwrap();
    let words = ["2 frames", "RIGHT \"right/r%d.png\" 1", "\"left/l_004.png\""];
    refuses(folder.path(), &of("left/l_%03d.png", "right/r%d.png", "none", &[]), &words);
}

#[test]
fn globs_are_in_natural_order_and_counted() {
    let folder = frames(&NATURAL);
    succeeds(folder.path(), &of("left/f*.png", "right/a_*.png", "m%d.npy", &[]));
    are_single_runs(&folder, &NATURAL, &["m0.npy", "m1.npy", "m2.npy", "m3.npy"], "-o", "npy");
}

#[test]
fn a_range_beyond_a_png_is_written_as_floats() {
    let folder = frames(&NATURAL[..1]);
    let output = succeeds(folder.path(), &video("maps", &["--min-disp", "-3"]));
    assert!(stderr(&output).contains("do not fit a 16-bit PNG (0 to 255); writing NAME.tif"), "{}", stderr(&output));
    assert_eq!(names(&folder.path().join("maps")), set(&["f1.tif", "gpu-stereo.json", "done.jsonl"]));
}

#[test]
fn json_has_exactly_the_promised_fields() {
    let folder = frames(&NATURAL);
    fs::write(folder.path().join("right/a_2.png"), "no image").unwrap();
    let output = run(folder.path(), &video("maps", &["--json"]));
    ends_with_1(&output);
    let mut told = json(&output);
    for time in ["seconds", "frames_per_second"] {
        assert!(told[time].as_f64().unwrap() > 0.0, "{told}");
        told[time] = 0.into();
    }
    let error = told["failures"][0]["error"].take();
    assert!(error.as_str().unwrap().contains("right/a_2.png"), "{error}");
    let expected = serde_json::json!({
        "adapter": crate::support::cpu(), "backend": "cpu", "driver": concat!("gpu-stereo ", env!("CARGO_PKG_VERSION")),
        "width": 49, "height": 31, "min_disparity": 0, "disparities": 16,
        "frames": 4, "done": 3, "failed": 1, "skipped": 0, "seconds": 0, "frames_per_second": 0,
        "peak_device_bytes": 0, "failures": [{"frame": "left/f2.png", "error": null}], "warnings": [], "output": "maps",
    });
    assert_eq!(told, expected);
}

// Frames that fail.

#[test]
fn bad_frames_are_told_and_the_rest_goes_on() {
    let numbers = ["0", "1", "2", "3", "4", "5", "6"];
    let folder = frames(&numbers.map(|name| (name, name)));
    let at = |name: &str| folder.path().join(name);
    let whole = fs::read(at("left/1.png")).unwrap();
    fs::write(at("left/1.png"), &whole[..whole.len() / 2]).unwrap();
    frame(2, 48, 31)[1].save(at("right/2.png")).unwrap(); // another size than the left one
    for (side, image) in ["left", "right"].into_iter().zip(frame(3, 20, 20)) {
        image.save(at(&format!("{side}/3.png"))).unwrap(); // another size than the other frames
    }
    for side in ["left", "right"] {
        image::open(at(&format!("{side}/4.png"))).unwrap().to_rgb8().save(at(&format!("{side}/4.png"))).unwrap();
    }
    fs::write(at("right/5.png"), "no image").unwrap();
    let output = run(folder.path(), &video("maps", &[]));
    ends_with_1(&output);
    let told = stderr(&output);
    let failed: Vec<_> = told.lines().filter(|line| line.starts_with("failed: ")).collect();
    let expected = [
        ("left/1.png", "cut short"),
        ("left/2.png", "both must have one size"),
        ("left/3.png", "it is 20x20 in Gray8, but the first frame is 49x31 in Gray8"),
        ("left/4.png", "it is 49x31 in Rgba8, but the first frame is 49x31 in Gray8"),
        ("left/5.png", "not an image in a known format"),
    ];
    assert_eq!(failed.len(), expected.len(), "{told}");
    for (frame, words) in expected {
        assert!(failed.iter().any(|line| line.contains(frame) && line.contains(words)), "{frame}: {told}");
    }
    assert!(stdout(&output).contains("2 done, 5 failed"), "{}", stdout(&output));
    assert_eq!(names(&at("maps")), set(&["0.png", "6.png", "gpu-stereo.json", "done.jsonl"]));
    are_single_runs(&folder, &[("0", "0"), ("6", "6")], &["maps/0.png", "maps/6.png"], "-o", "png");

    // The size is that of the first good one. All bad: nothing is written.
    for number in numbers {
        fs::write(at(&format!("left/{number}.png")), "no image").unwrap();
    }
    let output = run(folder.path(), &video("none", &[]));
    ends_with_1(&output);
    assert!(stdout(&output).contains("0 done, 7 failed") && stdout(&output).contains("nothing"), "{}", stdout(&output));
    assert_eq!(names(&at("none")), set(&[]));
}

#[test]
fn without_a_device_that_computes_nothing_is_changed() {
    let folder = frames(&NATURAL);
    succeeds(folder.path(), &video("maps", &[]));
    let before = contents(folder.path());
    let args = ["video", "left", "right", "-o", "maps", "--disp", "9", "--adapter", "none such"];
    is_one_line_error(&run(folder.path(), &args), &["--adapter is \"none such\"", "0 of 4 frames"]);
    assert!(contents(folder.path()) == before, "maps of other settings were removed");
}

// Resuming.

#[test]
fn what_is_there_is_kept_only_if_it_was_made_with_the_same_settings() {
    let folder = frames(&NATURAL);
    let at = |name: &str| folder.path().join(name);
    let told =
        |more: &[&str]| json(&succeeds(folder.path(), &video("maps", &[&["--resume", "--json"], more].concat())));
    let counts = |told: &Value| ["frames", "done", "skipped"].map(|field| told[field].as_u64().unwrap());

    assert_eq!(counts(&told(&[])), [4, 4, 0]); // nothing to resume
    let all = contents(&at("maps"));
    fs::remove_file(at("maps/f2.png")).unwrap();
    fs::write(at("maps/f3.png"), "").unwrap();
    fs::write(at("maps/f10.png"), "another").unwrap();
    assert_eq!(counts(&told(&["--schedule", "per-subgroup", "--shader-checks", "on"])), [4, 3, 1]); // those change no bit
    fs::copy(at("maps/f1.png"), at("f1.png")).unwrap();
    let nothing = told(&[]);
    assert_eq!((counts(&nothing), &nothing["adapter"]), ([4, 0, 4], &Value::Null));
    // Every format of a frame must be there.
    assert_eq!(counts(&told(&["--format", "npy,png"])), [4, 4, 0]);
    assert_eq!(counts(&told(&["--format", "npy,png"])), [4, 0, 4]);
    let mut maps = all.iter().filter(|(path, _)| path.extension().is_some_and(|ending| ending == "png"));
    assert!(maps.all(|(path, bytes)| fs::read(path).unwrap() == *bytes), "f10 is computed again");

    // Other settings.
    let resume = |more: &[&'static str]| video("maps", &[&["--resume"], more].concat());
    let words = ["p1 18 there and 9 now", "uniqueness 10 there and 7 now", "gpu-stereo.json"];
    refuses(folder.path(), &resume(&["--p1", "9", "--uniqueness", "7"]), &words);
    refuses(folder.path(), &of("right", "left", "maps", &["--resume"]), &["/left there and ", "right "]);
    // An interrupted run with other settings would leave both kinds, so the old maps go when the first new one comes.
    fs::write(at("left/f2.png"), "no image").unwrap();
    ends_with_1(&run(folder.path(), &video("maps", &["--p1", "9"])));
    let expected = ["f1.png", "f3.png", "f10.png", "gpu-stereo.json", "done.jsonl"];
    assert_eq!(names(&at("maps")), set(&expected), "maps of other settings in a format that was not asked for");
    refuses(folder.path(), &resume(&[]), &["p1 9 there and 18 now"]);

    // What vouches for maps is a line of its own, not that they are there.
    for record in [Some("{"), None] {
        fs::remove_file(at("maps/gpu-stereo.json")).unwrap();
        record.iter().for_each(|text| fs::write(at("maps/gpu-stereo.json"), text).unwrap());
        fs::remove_file(at("maps/done.jsonl")).unwrap();
        fs::write(at("maps/f1.png"), "of unknown settings").unwrap();
        let output = run(folder.path(), &resume(&["--json"]));
        assert_eq!((output.status.code(), counts(&json(&output))), (Some(1), [4, 3, 0]));
        assert!(fs::read(at("maps/f1.png")).unwrap() == fs::read(at("f1.png")).unwrap());
    }
}

/// Frames of another source that lack in the present one are not taken for its own later.
#[test]
fn maps_of_another_source_go_too() {
    let folder = frames(&NATURAL);
    let at = |name: &str| folder.path().join(name);
    for (side, name) in [("left", "f1.png"), ("right", "a_1.png")] {
        fs::create_dir(at(&format!("other_{side}"))).unwrap();
        fs::copy(at(side).join(name), at(&format!("other_{side}")).join(name)).unwrap();
    }
    succeeds(folder.path(), &video("maps", &[]));
    succeeds(folder.path(), &of("other_left", "other_right", "maps", &[]));
    assert_eq!(names(&at("maps")), set(&["f1.png", "gpu-stereo.json", "done.jsonl"]));
    // Lines that somebody else wrote remove nothing outside the folder.
    fs::write(at("maps/kept"), "").unwrap();
    let line = r#"{"name": "f9", "files": ["../left/f1.png", "..", ".", "/f1.png", "f9.png"]}"#;
    fs::write(at("maps/done.jsonl"), format!("{line}\n")).unwrap();
    fs::write(at("maps/f9.png"), "").unwrap();
    succeeds(folder.path(), &video("maps", &[]));
    assert!(at("left/f1.png").exists() && at("maps/kept").exists() && !at("maps/f9.png").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_whole_files_and_can_be_resumed() {
    use std::process::{Command, Stdio};
    let numbers: Vec<String> = (0..60).map(|number| number.to_string()).collect();
    let folder = frames(&[]);
    for (number, name) in (0..).zip(&numbers) {
        for (side, image) in ["left", "right"].into_iter().zip(frame(number, 300, 200)) {
            image.save(folder.path().join(format!("{side}/{name}.png"))).unwrap();
        }
    }
    let maps = folder.path().join("maps");
    for signal in ["INT", "TERM"] {
        let mut child = command(folder.path());
        let child =
            child.args(video("maps", &["--resume"])).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let before = maps.read_dir().map_or(0, |files| files.count());
        while !maps.read_dir().is_ok_and(|files| files.count() > before + 2) {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.lines().last().unwrap().starts_with("error: interrupted; "), "{told}");
        assert!(told.contains("--resume computes the rest"), "{told}");
        let there = names(&maps);
        assert!(there.len() < numbers.len() && there.iter().all(|name| !name.starts_with('.')), "{there:?}");
    }
    let told = json(&succeeds(folder.path(), &video("maps", &["--resume", "--json"])));
    assert!(told["skipped"].as_u64() >= Some(4) && told["frames"] == 60, "{told}");
    succeeds(folder.path(), &video("again", &["-q"]));
    for name in &numbers {
        let [maps, again] = ["maps", "again"].map(|out| fs::read(folder.path().join(format!("{out}/{name}.png"))));
        assert!(maps.unwrap() == again.unwrap(), "{name}");
    }
}

// Videos.

/// A folder whose `ffmpeg` is this shell script.
#[cfg(unix)]
fn stand_in(script: &str) -> TempDir {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ffmpeg");
    fs::write(&path, format!("#!/bin/sh\n[ \"$1\" = -version ] && exit 0\n{script}\n")).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    folder
}

#[cfg(unix)]
fn with_path(folder: &TempDir, path: &str, args: &[&str]) -> Output {
    command(folder.path()).args(args).env("PATH", path).output().unwrap()
}

#[cfg(unix)]
#[test]
fn a_video_shows_the_left_image_beside_the_colours() {
    let folder = frames(&NATURAL);
    fs::write(folder.path().join("left/f2.png"), "no image").unwrap();
    // Its last argument is the file; it keeps the arguments and the frames.
    let ffmpeg = stand_in("for file; do :; done\necho \"$@\" > args\ncat > \"$file\"");
    let path = format!("{}:/usr/bin:/bin", ffmpeg.path().display());
    let output = with_path(&folder, &path, &video("film.mkv", &["--fps", "29.97"]));
    ends_with_1(&output);
    assert!(stdout(&output).contains("3 done, 1 failed"), "{}", stdout(&output));
    let args = fs::read_to_string(folder.path().join("args")).unwrap();
    let expected = "-f rawvideo -pix_fmt rgb24 -s 98x31 -r 29.97 -i - ";
    assert!(args.contains(expected) && args.ends_with(".mkv\n") && !args.contains("film.mkv"), "{args}");
    let mut expected = Vec::new();
    for (left, right) in NATURAL.into_iter().filter(|(left, _)| *left != "f2") {
        let (left, right) = (format!("left/{left}.png"), format!("right/{right}.png"));
        succeeds(folder.path(), &[&left, &right, "--disp", "16", "--backend", "cpu", "-q", "--color", "color.png"]);
        let [left, color] = [&*left, "color.png"].map(|name| image::open(folder.path().join(name)).unwrap().to_rgb8());
        let rows = left.rows().zip(color.rows());
        expected.extend(rows.flat_map(|(left, color)| left.chain(color).flat_map(|pixel| pixel.0)));
    }
    assert!(fs::read(folder.path().join("film.mkv")).unwrap() == expected, "the frames are others");
    assert_eq!(names(folder.path()), set(&["args", "color.png", "film.mkv", "left", "right"]));
}

#[cfg(unix)]
#[test]
fn a_video_that_fails_leaves_nothing() {
    let folder = frames(&NATURAL);
    fs::write(folder.path().join("film.mp4"), "old").unwrap();
    let before = contents(folder.path());
    let scripts = [
        // It fails at the end, at the start, and before it has read a frame.
        ("cat > /dev/null\necho 'no room' >&2\necho 'left' >&2\nexit 3", "no room left"),
        ("echo 'no encoder' >&2\nexit 1", "no encoder"),
        ("exec 0<&-\nsleep 0.2\necho 'bad input' >&2\nexit 1", "bad input"),
    ];
    for (script, words) in scripts {
        let ffmpeg = stand_in(script);
        let path = format!("{}:/usr/bin:/bin", ffmpeg.path().display());
        is_one_line_error(&with_path(&folder, &path, &video("film.mp4", &["-q"])), &["ffmpeg", words]);
        assert!(contents(folder.path()) == before, "{words}");
    }
    let words = ["\"film.mp4\" is a video", "no working ffmpeg is on the PATH", "install ffmpeg, or give a folder"];
    is_one_line_error(&with_path(&folder, "/nonexistent", &video("film.mp4", &[])), &words);
    let ffmpeg = stand_in("cat > /dev/null");
    let path = format!("{}:/usr/bin:/bin", ffmpeg.path().display());
    let cases: [(&str, &[&str], &[&str]); 6] = [
        ("film.mp4", &["--resume"], &["--resume", "is a video"]),
        ("film.mp4", &["--format", "npy"], &["--format", "is a video"]),
        ("film.mp4", &["--fps", "0"], &["--fps is \"0\"", "above 0"]),
        ("film.mp4", &["--fps", "nan"], &["--fps is \"nan\""]),
        ("film.mp4", &["--fps", "-3"], &["--fps is \"-3\""]),
        ("none/film.mp4", &[], &["\"none\"", "does not exist"]),
    ];
    for (out, more, words) in cases {
        is_one_line_error(&with_path(&folder, &path, &video(out, more)), words);
        assert!(contents(folder.path()) == before, "{out}");
    }
}

// What cannot be.

#[test]
fn what_cannot_be_is_one_line() {
    let folder = frames(&NATURAL);
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("empty")).unwrap();
    fs::create_dir(at("few")).unwrap();
    fs::copy(at("right/a_1.png"), at("few/f1.png")).unwrap();
    fs::copy(at("right/a_3.png"), at("few/f3.png")).unwrap();
    fs::write(at("file"), "").unwrap();
    let sides: [(&str, &str, &[&str]); 12] = [
        ("none", "right", &["LEFT is \"none\"", "neither such a folder", "printf pattern", "glob"]),
        ("left", "none/*.png", &["RIGHT is \"none/*.png\"", "neither"]),
        ("left", "empty", &["RIGHT is \"empty\"", "without images"]),
        ("left", "few", &["LEFT \"left\" has 4 frames and RIGHT \"few\" 2", "\"left/f2.png\""]),
        ("few", "left", &["LEFT \"few\" has 2 frames and RIGHT \"left\" 4", "\"left/f2.png\""]),
        ("left/f[13].png", "left/f[12].png", &["\"left/f3.png\" would be paired with \"left/f2.png\""]),
        ("left/%d.png", "right/%d.png", &["LEFT is \"left/%d.png\"", "no file", "\"left/0.png\""]),
        ("none/%d.png", "right/%d.png", &["LEFT is \"none/%d.png\"", "folder \"none\" cannot be read"]),
        ("left/f%s.png", "right", &["LEFT is \"left/f%s.png\"", "%06d"]),
        ("left/f%d_%d.png", "right", &["LEFT is \"left/f%d_%d.png\"", "one number"]),
        ("left%d/f.png", "right", &["LEFT is \"left%d/f.png\"", "in the file's name"]),
        ("left/[", "right", &["LEFT is \"left/[\"", "not a glob"]),
    ];
    for (left, right, words) in sides {
        refuses(folder.path(), &of(left, right, "maps", &[]), words);
    }
    let outs: [(&str, &[&str], &[&str]); 18] = [
        ("no/maps", &[], &["\"no/maps\"", "does not exist"]),
        ("no/no/%d.png", &[], &["\"no/no/%d.png\"", "does not exist"]),
        ("file", &[], &["\"file\" is a file"]),
        ("left", &[], &["\"left/f1.png\" is an input, too"]),
        ("%d", &[], &["has no ending"]),
        ("%d.jpg", &[], &[".jpg", ".png"]),
        ("%d.png", &["--format", "npy"], &["--format must fit its ending"]),
        ("%d.png", &["--format", "png,color"], &["one file a frame"]),
        ("%d.png", &["--resume"], &["--resume needs a folder"]),
        ("m%x.png", &[], &["output is \"m%x.png\"", "%06d"]),
        ("maps", &["--fps", "25"], &["--fps is for a video"]),
        ("maps", &["--format", "png,png"], &["twice"]),
        ("maps", &["--format", "exr"], &["exr", "--format"]),
        ("maps", &["--in-flight", "0"], &["--in-flight is 0", "1 to 16"]),
        ("maps", &["--in-flight", "17"], &["--in-flight is 17", "1 to 16"]),
        ("maps", &["--adapter", "0"], &["--adapter is \"0\"", "--backend cpu"]),
        ("maps", &["--block", "4"], &["--block is 4"]),
        ("maps", &["third"], &["3 names", "in quotes"]),
    ];
    for (out, more, words) in outs {
        refuses(folder.path(), &video(out, more), words);
    }
    refuses(folder.path(), &["video", "left", "right", "-o", "maps"], &["--disp"]);
    refuses(folder.path(), &["video", "left", "right", "--disp", "16"], &["--output"]);
    refuses(
        folder.path(),
        &["video", "left", "-o", "maps", "--disp", "16"],
        &["left/f1.png", "given alone", "--split sbs"],
    );

    // Two frames of one name.
    fs::create_dir(at("left/sub")).unwrap();
    fs::rename(at("left/f2.png"), at("left/sub/f1.png")).unwrap();
    let args = of("left/**/f1.png", "right/a_[12].png", "maps", &[]);
    refuses(folder.path(), &args, &["left/sub/f1.png", "would both become \"maps/f1.png\"", "maps/%06d.png"]);
}

#[test]
fn the_help_ends_with_examples() {
    let help = succeeds(Path::new("."), &["video", "--help"]);
    let help = stdout(&help);
    let examples = help.split_once("\nExamples:\n").unwrap().1;
    for words in ["gpu-stereo video left right -o maps --disp 64", "--resume", "both.mp4", "Exit codes:"] {
        assert!(examples.contains(words), "{help}");
    }
    for option in ["--format", "--fps", "--in-flight", "--resume", "--json", "--schedule", "--preset", "natural order"]
    {
        assert!(help.contains(option), "{option}");
    }
}
