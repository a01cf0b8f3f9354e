//! Streams of frames: videos that ffmpeg decodes, and frames on stdin.
//!
//! On the CPU, so that no adapter is needed.

use crate::support::{
    SHIFT, command, contents, is_one_line_error, not_tested, refuses, stderr, stdout, succeeds, texture,
};
use image::{GrayImage, Luma};
use serde_json::Value;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use tempfile::TempDir;

const SIZE: [u32; 2] = [48, 30];

/// A pair that no other frame is equal to.
fn frame(number: u32) -> [GrayImage; 2] {
    let sample = |x: u32, y: u32| Luma([texture(x + 97 * number, y)]);
    [0, SHIFT].map(|shift| GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| sample(x + shift, y)))
}

/// Both views of a frame side by side, row by row.
fn beside(number: u32) -> Vec<u8> {
    let [left, right] = frame(number);
    let rows = left.as_raw().chunks(SIZE[0] as usize).zip(right.as_raw().chunks(SIZE[0] as usize));
    rows.flat_map(|(left, right)| [left, right].concat()).collect()
}

/// Folders left and right with so many frames.
fn folders(frames: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for side in ["left", "right"] {
        fs::create_dir(folder.path().join(side)).unwrap();
    }
    for number in 0..frames {
        for (side, image) in ["left", "right"].into_iter().zip(frame(number)) {
            image.save(folder.path().join(format!("{side}/{number:06}.png"))).unwrap();
        }
    }
    folder
}

const SETTINGS: [&str; 7] = ["--disp", "16", "--backend", "cpu", "-q", "--format", "npy"];

/// A run whose stdin has these bytes.
fn with_stdin(folder: &Path, args: &[&str], bytes: &[u8]) -> Output {
    let mut child = started(folder, args);
    let _ = child.stdin.take().unwrap().write_all(bytes); // a run that refuses them does not read them
    child.wait_with_output().unwrap()
}

fn started(folder: &Path, args: &[&str]) -> Child {
    let mut command = command(folder);
    command.args(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn has_ffmpeg() -> bool {
    let there = Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).status().is_ok_and(|s| s.success());
    if !there {
        not_tested("videos, since ffmpeg is missing");
    }
    there
}

fn ffmpeg(folder: &Path, args: &[&str]) {
    let status = Command::new("ffmpeg").args(["-v", "error", "-nostdin"]).args(args).current_dir(folder).status();
    assert!(status.unwrap().success(), "{args:?}");
}

#[track_caller]
fn same_maps(folder: &TempDir, one: &str, other: &str, frames: usize) {
    let [one, other] = [one, other].map(|name| contents(&folder.path().join(name)));
    let maps = |all: &std::collections::BTreeMap<std::path::PathBuf, Vec<u8>>| -> Vec<Vec<u8>> {
        all.iter().filter(|(path, _)| path.extension().is_some_and(|e| e == "npy")).map(|(_, b)| b.clone()).collect()
    };
    assert_eq!(maps(&one).len(), frames);
    assert!(maps(&one) == maps(&other));
}

// Stdin.

#[test]
fn frames_on_stdin_give_the_maps_of_files() {
    let folder = folders(7);
    succeeds(folder.path(), &[&["video", "left", "right", "-o", "files"], &SETTINGS[..]].concat());
    let frames: Vec<_> = (0..7).map(beside).collect();
    let y4m = frames.iter().map(|frame| [b"FRAME\n", &frame[..]].concat());
    let y4m = [b"YUV4MPEG2 W96 H30 F25:1 Ip Cmono\n".to_vec(), y4m.collect::<Vec<_>>().concat()].concat();
    let pam = b"P7\nWIDTH 96\nHEIGHT 30\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n";
    let pam = frames.iter().map(|frame| [pam, &frame[..]].concat()).collect::<Vec<_>>().concat();
    let rgb: Vec<u8> = frames.concat().into_iter().flat_map(|v| [v; 3]).collect();
    let yuyv: Vec<u8> = frames.concat().into_iter().flat_map(|v| [v, 128]).collect();
    let raw = |what| ["--raw-frames", what];
    let streams: [(&str, &[u8], &[&str]); 6] = [
        ("y4m", &y4m, &[]),
        ("pam", &pam, &[]),
        ("gray", &frames.concat(), &raw("96x30:gray")),
        ("rgb", &rgb, &raw("96x30:rgb24")),
        ("bgr", &rgb, &raw("96x30:bgr24")),
        ("yuyv", &yuyv, &raw("96x30:yuyv")),
    ];
    for (out, bytes, more) in streams {
        let args = [&["video", "-", "--split", "sbs", "-o", out], &SETTINGS[..], more].concat();
        let output = with_stdin(folder.path(), &args, bytes);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()), "{out}");
        if out == "yuyv" {
            // Luma from 16 to 235 is stretched, which is another picture.
            assert_eq!(fs::read_dir(folder.path().join(out)).unwrap().count(), 7);
        } else {
            same_maps(&folder, "files", out, 7);
        }
    }
    // A printf pattern, exchanged views, JSON.
    let args = [
        "video",
        "-",
        "--split",
        "sbs-swapped",
        "--swap",
        "-o",
        "m%03d.npy",
        "--disp",
        "16",
        "--backend",
        "cpu",
        "--json",
    ];
    let output = with_stdin(folder.path(), &args, &y4m);
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&told["done"], &told["width"], &told["frames"]),
        (&7.into(), &48.into(), &7.into()),
        "{}",
        stderr(&output)
    );
    let [one, other] = ["m006.npy", "files/000006.npy"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(one == other);
}

/// Samples of 10 bits in two bytes, whose colours are four times those of 8 bits.
#[test]
fn frames_of_more_bits_give_the_maps_of_gray() {
    let folder = folders(2);
    let luma: Vec<Vec<u16>> =
        (0..2).map(|n| beside(n).into_iter().map(|v| 4 * (16 + u16::from(v) * 219 / 255)).collect()).collect();
    let words = |samples: &[u16]| samples.iter().flat_map(|sample| sample.to_le_bytes()).collect::<Vec<u8>>();
    for (form, chroma) in [("420p10 XYSCSS=420P10", 2 * 48 * 15), ("422p10", 2 * 48 * 30), ("444p10", 2 * 96 * 30)] {
        let frames = luma.iter().map(|luma| [b"FRAME\n".to_vec(), words(luma), words(&vec![512; chroma])].concat());
        let y4m =
            [format!("YUV4MPEG2 W96 H30 F25:1 C{form}\n").into_bytes(), frames.collect::<Vec<_>>().concat()].concat();
        let args = [&["video", "-", "--split", "sbs", "-o", "deep"], &SETTINGS[..]].concat();
        let output = with_stdin(folder.path(), &args, &y4m);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()), "{form}");
        let map = fs::read(folder.path().join("deep/000001.npy")).unwrap();
        // The same, as a picture of 16 bits whose samples have 10.
        let colour = |luma: &u16| ((298 * (i32::from(*luma) - 64) + 128) >> 8).clamp(0, 1023) as u16;
        let picture = image::ImageBuffer::<image::Rgb<u16>, Vec<u16>>::from_raw(
            96,
            30,
            luma[1].iter().flat_map(|l| [colour(l); 3]).collect(),
        );
        picture.unwrap().save(folder.path().join("deep.png")).unwrap();
        let alone = ["deep.png", "--split", "sbs", "-o", "deep.npy", "--disp", "16", "--backend", "cpu", "-q"];
        succeeds(folder.path(), &alone);
        assert!(fs::read(folder.path().join("deep.npy")).unwrap() == map, "{form}");
    }
}

/// Cameras one above the other in a stream, of whose images a part is matched over the range that it needs.
#[test]
fn options_of_cameras_do_the_same_to_a_stream() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let upright: Vec<_> = (0..3).map(|number| frame(number).map(|image| image::imageops::rotate90(&image))).collect();
    let bytes: Vec<u8> =
        upright.iter().flat_map(|[upper, lower]| [upper.as_raw().clone(), lower.as_raw().clone()].concat()).collect();
    let [upper, lower] = &upright[2];
    upper.save(path.join("l.png")).unwrap();
    lower.save(path.join("r.png")).unwrap();
    let cameras = ["--vertical", "--focal", "50", "--baseline", "0.2", "--cx", "15", "--cy", "24", "--max-depth", "3"];
    for range in [&["--disp", "16"][..], &["--disp", "auto"]] {
        let options = [&["--crop", "3,6,24,40", "--backend", "cpu", "-q"], &cameras[..], range].concat();
        let stream = [
            "video",
            "-",
            "--split",
            "tb",
            "--raw-frames",
            "30x96:gray",
            "-o",
            "m",
            "--format",
            "npy,depth-npy,points",
        ];
        let output = with_stdin(path, &[&stream[..], &options].concat(), &bytes);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()), "{range:?}");
        succeeds(
            path,
            &[&["l.png", "r.png", "-o", "o.npy", "--depth", "d.npy", "--points", "p.ply"], &options[..]].concat(),
        );
        for (one, other) in
            [("o.npy", "m/000002.npy"), ("d.npy", "m/000002_depth.npy"), ("p.ply", "m/000002_points.ply")]
        {
            let [one, other] = [one, other].map(|name| fs::read(path.join(name)).unwrap());
            assert!(one == other, "{range:?}");
        }
    }
}

#[test]
fn a_stream_that_is_cut_or_none_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let of = |more: &[&'static str]| [&["video", "-", "-o", "maps"], &SETTINGS[..], more].concat();
    let told = |args: &[&str], bytes: &[u8], words: &[&str]| {
        is_one_line_error(&with_stdin(folder.path(), args, bytes), words);
        assert!(fs::read_dir(folder.path()).unwrap().count() == 0, "files were left behind");
    };
    let split = ["--split", "sbs"];
    told(&of(&[]), b"", &["- is given alone", "--split sbs"]);
    told(&of(&split), b"", &["no byte"]);
    told(&of(&split), b"GIF89a", &["neither Y4M nor PAM", "--raw-frames"]);
    told(&of(&split), b"YUV4MPEG2 W96 H30 C420p11\n", &["C420p11", "-pix_fmt"]);
    told(&of(&[&split[..], &["--resume"]].concat()), b"YUV4MPEG2 W96 H30 Cmono\n", &["--resume is for files"]);
    told(&of(&[&split[..], &["--raw-frames", "96:gray"]].concat()), b"", &["1280x480:yuyv"]);
    told(&of(&[&split[..], &["--raw-frames", "96x30:grey"]].concat()), b"", &["gray16le"]);
    refuses(
        folder.path(),
        &["video", "a", "b", "-o", "m", "--disp", "16", "--raw-frames", "9x9:gray"],
        &["--raw-frames"],
    );
    refuses(folder.path(), &["video", "-", "b", "-o", "m", "--disp", "16"], &["stdin goes with nothing"]);
    // An odd width, and a stream without a frame.
    let output = with_stdin(folder.path(), &of(&[&split[..], &["--raw-frames", "95x30:gray"]].concat()), &[0; 95 * 30]);
    is_one_line_error(&output, &["a frame of stdin is 95x30", "even number of columns"]);
    let output = with_stdin(folder.path(), &of(&split), b"YUV4MPEG2 W96 H30 Cmono\n");
    is_one_line_error(&output, &["stdin has no frame"]);
    // The frames before a cut are there, and the rest of the stream is one failed frame.
    let args = [&["video", "-", "--split", "sbs", "--raw-frames", "96x30:gray", "-o", "cut"], &SETTINGS[..]].concat();
    let bytes = [beside(0), beside(1), beside(2)].concat();
    let output = with_stdin(folder.path(), &args, &bytes[..bytes.len() - 9]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let words = "failed: stdin#2: frame 2: it is cut short: the stream ended after 2871 of its 2880 bytes";
    assert!(stderr(&output).contains(words), "{}", stderr(&output));
    assert_eq!(fs::read_dir(folder.path().join("cut")).unwrap().count(), 2);
    // Maps of files are not mixed with those of a stream.
    fs::write(folder.path().join("cut/gpu-stereo.json"), "{}").unwrap();
    is_one_line_error(&with_stdin(folder.path(), &args, &bytes), &["--resume may keep"]);
}

/// What a process has of memory, in KiB.
#[cfg(target_os = "linux")]
fn resident(child: &Child) -> u64 {
    let told = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let line = told.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap_or("0 kB");
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// 300 frames of 150 KB: were they kept, or their maps, they would be 44 MiB.
#[cfg(target_os = "linux")]
#[test]
fn a_long_stream_takes_no_more_memory_than_a_short_one() {
    let folder = tempfile::tempdir().unwrap();
    let frame: Vec<u8> =
        (0..240).flat_map(|y| (0..640).map(move |x| texture(x % 320 + if x < 320 { 0 } else { 5 }, y))).collect();
    let args = [
        "video",
        "-",
        "--split",
        "sbs",
        "--raw-frames",
        "640x240:gray",
        "-o",
        "m%d.pfm",
        "--disp",
        "8",
        "--method",
        "bm",
        "--backend",
        "cpu",
        "-q",
        "--no-sync",
    ];
    let mut child = started(folder.path(), &args);
    let mut stdin = child.stdin.take().unwrap();
    let mut early = 0;
    for number in 0..300 {
        stdin.write_all(&frame).unwrap();
        let written = folder.path().join(format!("m{}.pfm", number - 20));
        if number >= 20 {
            let _ = fs::remove_file(&written); // memory that the files take is not the process's, but may be a small disk's
        }
        if number == 60 {
            early = resident(&child);
        }
    }
    let late = resident(&child);
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(late < early + 12 * 1024, "{early} KiB after 60 frames, {late} KiB after 300");
}

#[test]
fn an_interrupted_stream_ends_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let args =
        ["video", "-", "--split", "sbs", "--raw-frames", "96x30:gray", "-o", "m", "--disp", "16", "--backend", "cpu"];
    let mut child = started(folder.path(), &args);
    let mut stdin = child.stdin.take().unwrap();
    (0..4).for_each(|number| stdin.write_all(&beside(number)).unwrap());
    while !folder.path().join("m/000001.png").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(50));
    // A camera goes on; the run ends at the next frames.
    for number in 4..1000 {
        if stdin.write_all(&beside(number)).is_err() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let done = fs::read_dir(folder.path().join("m")).unwrap().count();
    assert!(
        (2..900).contains(&done) && stdout(&output).contains(&format!("{done} done, 0 failed")),
        "{}",
        stdout(&output)
    );
}

// Videos.

#[test]
fn videos_give_the_maps_of_their_frames() {
    if !has_ffmpeg() {
        return;
    }
    let folder = folders(9);
    let at = |name: &str| folder.path().join(name);
    for side in ["left", "right"] {
        let frames = format!("{side}/%06d.png");
        let lossless = ["-c:v", "libx264", "-qp", "0", "-pix_fmt", "yuv444p"];
        ffmpeg(
            folder.path(),
            &[&["-r", "25", "-start_number", "0", "-i", &frames], &lossless[..], &[&format!("{side}.mp4")]].concat(),
        );
        fs::create_dir(at(&format!("{side}2"))).unwrap();
        ffmpeg(folder.path(), &["-i", &format!("{side}.mp4"), &format!("{side}2/%06d.png")]);
    }
    let both = ["-i", "left.mp4", "-i", "right.mp4", "-filter_complex", "hstack", "-c:v", "ffv1", "both.mkv"];
    ffmpeg(folder.path(), &both);
    for (names, out) in [(&["left2", "right2"][..], "files"), (&["left.mp4", "right.mp4"], "two")] {
        succeeds(folder.path(), &[&["video"], names, &["-o", out], &SETTINGS[..]].concat());
    }
    same_maps(&folder, "files", "two", 9);
    succeeds(folder.path(), &[&["video", "both.mkv", "--split", "sbs", "-o", "both"], &SETTINGS[..]].concat());
    same_maps(&folder, "files", "both", 9);
    // A film has the rate of the video that it is of.
    let more = ["--disp", "16", "--backend", "cpu", "-q"];
    succeeds(folder.path(), &[&["video", "both.mkv", "--split", "sbs", "-o", "film.mp4"], &more[..]].concat());
    let probe = ["-v", "error", "-show_entries", "stream=width,avg_frame_rate,nb_frames", "-of", "csv=p=0", "film.mp4"];
    let told = Command::new("ffprobe").args(probe).current_dir(folder.path()).output().unwrap();
    assert_eq!(stdout(&told).trim(), "96,25/1,9");

    // One that is shorter ends the run, and that is said.
    ffmpeg(folder.path(), &["-i", "left.mp4", "-frames:v", "4", "-c", "copy", "short.mkv"]);
    let output =
        succeeds(folder.path(), &[&["video", "short.mkv", "right.mp4", "-o", "short"], &SETTINGS[..]].concat());
    assert!(stderr(&output).contains("short.mkv has fewer frames than right.mp4"), "{}", stderr(&output));
    assert_eq!(fs::read_dir(at("short")).unwrap().count(), 4);

    let of = |names: &[&'static str]| [&["video"], names, &["-o", "none"], &SETTINGS[..]].concat();
    refuses(folder.path(), &of(&["left.mp4"]), &["\"left.mp4\" is given alone", "--split sbs", "two videos"]);
    refuses(folder.path(), &of(&["left.mp4", "right2"]), &["nothing of another kind"]);
    refuses(folder.path(), &of(&["left.mp4", "right.mp4", "--split", "sbs"]), &["--split is for one video"]);
    refuses(folder.path(), &of(&["left.mp4", "right.mp4", "--resume"]), &["--resume is for files"]);
    let onto = ["video", "left.mp4", "right.mp4", "-o", "right.mp4", "--disp", "16", "--backend", "cpu"];
    refuses(folder.path(), &onto, &["\"right.mp4\" is an input"]);
    let start = fs::read(at("left.mp4")).unwrap();
    fs::write(at("cut.mp4"), &start[..start.len() / 2]).unwrap();
    refuses(folder.path(), &of(&["cut.mp4", "right.mp4"]), &["\"cut.mp4\" cannot be decoded", "moov atom"]);
    let output = command(folder.path()).args(of(&["left.mp4", "right.mp4"])).env("PATH", "/none").output().unwrap();
    is_one_line_error(&output, &["\"left.mp4\" is a video", "install ffmpeg"]);
}
