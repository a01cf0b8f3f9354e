//! Records of ROS 2: pairs from two topics of an MCAP file, and what is written into another.
//!
//! On the CPU, so that no adapter is needed.

use crate::support::{SHIFT, contents, is_one_line_error, not_tested, pair, refuses, run, stderr, succeeds, texture};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{DynamicImage, ExtendedColorType, GrayImage, ImageEncoder as _, Luma};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A message in CDR, the lowest byte first.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new(nanoseconds: i64) -> Self {
        let cdr = Self(vec![0, 1, 0, 0]);
        let (seconds, rest) = (nanoseconds.div_euclid(1_000_000_000), nanoseconds.rem_euclid(1_000_000_000));
        cdr.number((seconds as i32).to_le_bytes()).number((rest as u32).to_le_bytes()).text("camera")
    }

    fn number<const N: usize>(mut self, digits: [u8; N]) -> Self {
        while !(self.0.len() - 4).is_multiple_of(N) {
            self.0.push(0);
        }
        self.0.extend(digits);
        self
    }

    fn u32(self, value: u32) -> Self {
        self.number(value.to_le_bytes())
    }

    fn text(self, text: &str) -> Self {
        self.blob(&[text.as_bytes(), &[0]].concat())
    }

    fn blob(self, bytes: &[u8]) -> Self {
        let mut cdr = self.u32(bytes.len() as u32);
        cdr.0.extend(bytes);
        cdr
    }
}

fn image(time: i64, encoding: &str, [width, height]: [u32; 2], bytes: &[u8]) -> Vec<u8> {
    let step = bytes.len() as u32 / height;
    Cdr::new(time).u32(height).u32(width).text(encoding).number([0]).u32(step).blob(bytes).0
}

fn compressed(time: i64, format: &str, bytes: &[u8]) -> Vec<u8> {
    Cdr::new(time).text(format).blob(bytes).0
}

const MATRIX: [f64; 9] = [50.0, 0.0, 24.0, 0.0, 50.0, 15.0, 0.0, 0.0, 1.0];
const ROTATION: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// A camera of this baseline, in a sensor_msgs/CameraInfo.
fn camera_info(baseline: f64, distortion: f64) -> Vec<u8> {
    let mut cdr = Cdr::new(0).u32(30).u32(48).text("plumb_bob").u32(5);
    let projection = [50.0, 0.0, 24.0, -50.0 * baseline, 0.0, 50.0, 15.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let all = [[distortion; 5].to_vec(), MATRIX.to_vec(), ROTATION.to_vec(), projection.to_vec()].concat();
    for value in all {
        cdr = cdr.number(value.to_le_bytes());
    }
    cdr.u32(0).u32(0).0
}

const IMAGE: &str = "sensor_msgs/msg/Image";
const COMPRESSED: &str = "sensor_msgs/msg/CompressedImage";
const INFO: &str = "sensor_msgs/msg/CameraInfo";

/// A record of messages: topic, type, when it was recorded, and its bytes.
fn record(path: &Path, compression: Option<Compression>, messages: &[(&str, &str, i64, Vec<u8>)]) {
    let options = WriteOptions::new().compression(compression).chunk_size(Some(5000)).profile("ros2");
    let mut writer: Writer<_> = options.create(File::create(path).unwrap()).unwrap();
    for (sequence, (topic, of, time, data)) in (0..).zip(messages) {
        let schema = writer.add_schema(of, "ros2msg", b"").unwrap();
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        let time = *time as u64;
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
}

/// A pair that no other frame is equal to.
fn frame(number: u32) -> [GrayImage; 2] {
    let sample = |x: u32, y: u32| Luma([texture(x + 97 * number, y)]);
    [0, SHIFT].map(|shift| GrayImage::from_fn(48, 30, |x, y| sample(x + shift, y)))
}

/// Milliseconds between two frames.
const PERIOD: i64 = 100;

fn at(number: u32) -> i64 {
    (1_700_000_000_000 + PERIOD * i64::from(number)) * 1_000_000
}

const LEFT: &str = "/stereo/left/image_rect";
const RIGHT: &str = "/stereo/right/image_rect";

/// So many frames with the cameras, the right images before the left ones.
fn drive(frames: u32) -> Vec<(&'static str, &'static str, i64, Vec<u8>)> {
    let mut all = vec![
        ("/stereo/left/camera_info", INFO, at(0), camera_info(0.0, 0.0)),
        ("/stereo/right/camera_info", INFO, at(0), camera_info(0.2, 0.0)),
    ];
    for number in 0..frames {
        let [left, right] = frame(number).map(GrayImage::into_raw);
        all.push((RIGHT, IMAGE, at(number), image(at(number), "mono8", [48, 30], &right)));
        all.push(("/other", "std_msgs/msg/String", at(number), vec![1; 2000]));
        all.push((LEFT, IMAGE, at(number) + 5, image(at(number), "mono8", [48, 30], &left)));
    }
    all
}

const SETTINGS: [&str; 5] = ["--disp", "16", "--backend", "cpu", "-q"];

fn video<'a>(name: &'a str, topics: [&'a str; 2], out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["video", name, "--left", topics[0], "--right", topics[1], "-o", out], &SETTINGS[..], more].concat()
}

/// The disparities of a single run on a frame, in pixels.
fn expected(folder: &TempDir, [left, right]: &[GrayImage; 2], more: &[&str]) -> Vec<u8> {
    left.save(folder.path().join("l.png")).unwrap();
    right.save(folder.path().join("r.png")).unwrap();
    succeeds(folder.path(), &[&["l.png", "r.png", "-o", "m.npy"], &SETTINGS[..], more].concat());
    fs::read(folder.path().join("m.npy")).unwrap()
}

/// Messages by topic: when they were recorded, and their bytes.
fn read(path: &Path) -> BTreeMap<String, Vec<(u64, Vec<u8>)>> {
    let bytes = fs::read(path).unwrap();
    let mut all: BTreeMap<String, Vec<_>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert_eq!(message.channel.message_encoding, "cdr");
        assert!(message.channel.schema.as_ref().unwrap().encoding == "ros2msg");
        all.entry(message.channel.topic.clone()).or_default().push((message.log_time, message.data.into_owned()));
    }
    all
}

#[test]
fn a_record_becomes_a_record_of_disparities_depths_and_points() {
    let folder = tempfile::tempdir().unwrap();
    record(&folder.path().join("in.mcap"), Some(Compression::Zstd), &drive(5));
    succeeds(folder.path(), &video("in.mcap", [LEFT, RIGHT], "out.mcap", &[]));
    let all = read(&folder.path().join("out.mcap"));
    assert_eq!(all.keys().collect::<Vec<_>>(), ["/stereo/depth", "/stereo/disparity", "/stereo/points2"]);
    for number in 0..5 {
        let npy = expected(&folder, &frame(number), &["--depth", "d.npy", "--focal", "50", "--baseline", "0.2"]);
        let (time, message) = &all["/stereo/disparity"][number as usize];
        assert_eq!(*time, at(number) as u64 + 5);
        let header = Cdr::new(at(number)).0;
        assert!(message.starts_with(&header), "the header is not that of the left image");
        // The pixels of the image within, whose header is padded by 1 byte: 8 + 4 + 7, 1, 8 + 4 + 7, 1, 4 + 4 + 4 + 6 + 1, 1, 4, 4.
        let pixels = &message[4 + 68..][..4 * 48 * 30];
        let floats =
            |bytes: &[u8]| bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect::<Vec<_>>();
        let map = floats(&npy[npy.len() - 4 * 48 * 30..]);
        for (got, expected) in floats(pixels).into_iter().zip(map) {
            assert!(got == expected || (got == -1.0 && expected.is_nan()), "{got} {expected}");
        }
        let tail = floats(&message[4 + 68 + 4 * 48 * 30..][..8]);
        assert_eq!(tail, [50.0, 0.2]);
        let depth = fs::read(folder.path().join("d.npy")).unwrap();
        let (depth, message) = (&depth[depth.len() - 4 * 48 * 30..], &all["/stereo/depth"][number as usize].1);
        let [got, expected] = [&message[message.len() - 4 * 48 * 30..], depth].map(floats);
        assert!(got.iter().zip(&expected).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
        let valid = expected.iter().filter(|v| !v.is_nan()).count();
        assert!(valid > 500 && all["/stereo/points2"][number as usize].1.len() > 16 * valid);
    }
    // Without cameras there are disparities alone; they may be given.
    let mut without = drive(2);
    without.drain(..2);
    record(&folder.path().join("bare.mcap"), None, &without);
    let output = succeeds(folder.path(), &video("bare.mcap", [LEFT, RIGHT], "bare_out.mcap", &[]));
    assert!(stderr(&output).contains("only disparities are written"), "{}", stderr(&output));
    assert_eq!(read(&folder.path().join("bare_out.mcap")).keys().collect::<Vec<_>>(), ["/stereo/disparity"]);
    let focal = ["--focal", "50", "--baseline", "0.2"];
    succeeds(folder.path(), &video("bare.mcap", [LEFT, RIGHT], "given.mcap", &focal));
    assert_eq!(read(&folder.path().join("given.mcap"))["/stereo/depth"], all["/stereo/depth"][..2]);
}

/// The points of a message are those of a PLY: x, y and z, and the colours.
#[track_caller]
fn are_points(message: &[u8], ply: &[u8]) {
    let end = ply.windows(11).position(|bytes| bytes == b"end_header\n").unwrap() + 11;
    let points = &ply[end..];
    let count = points.len() / 15;
    assert!(count > 100, "{count}");
    // What follows the points is is_dense.
    let data = &message[message.len() - 1 - 16 * count..message.len() - 1];
    assert_eq!(message[message.len() - 1 - 16 * count - 4..][..4], (16 * count as u32).to_le_bytes());
    for (got, expected) in data.chunks(16).zip(points.chunks(15)) {
        assert_eq!(got[..12], expected[..12]);
        assert_eq!([got[14], got[13], got[12]], expected[12..]);
    }
}

/// A record is written with the part, the farthest depth and the range that a single run has.
#[test]
fn points_of_a_record_are_those_of_a_single_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    record(&path.join("in.mcap"), None, &drive(2));
    let [left, right] = frame(1);
    left.save(path.join("l.png")).unwrap();
    right.save(path.join("r.png")).unwrap();
    let cameras = ["--focal", "50", "--baseline", "0.2", "--cx", "24", "--cy", "15"];
    let options: [&[&str]; 4] = [
        &["--disp", "16", "--crop", "6,4,40,22"],
        &["--disp", "16", "--max-depth", "2"],
        &["--disp", "auto"],
        &["--disp", "auto", "--crop", "6,4,40,22", "--max-depth", "5", "--swap"],
    ];
    for more in options {
        let swaps = more.contains(&"--swap");
        let (topics, pair) =
            if swaps { ([RIGHT, LEFT], ["r.png", "l.png"]) } else { ([LEFT, RIGHT], ["l.png", "r.png"]) };
        let record =
            ["video", "in.mcap", "--left", topics[0], "--right", topics[1], "-o", "out.mcap", "--backend", "cpu", "-q"];
        let output = run(path, &[&record[..], &cameras, more].concat());
        let alone = ["--points", "p.ply", "--depth", "d.npy", "--backend", "cpu", "-q"];
        let expected = run(path, &[&pair[..], &alone, &cameras, more].concat());
        assert_eq!((output.status.code(), expected.status.code()), (Some(0), Some(0)), "{more:?}: {}", stderr(&output));
        let all = read(&path.join("out.mcap"));
        let (_, points) = &all.iter().find(|(topic, _)| topic.ends_with("points2")).unwrap().1[1];
        are_points(points, &fs::read(path.join("p.ply")).unwrap());
        let (_, depth) = &all.iter().find(|(topic, _)| topic.ends_with("depth")).unwrap().1[1];
        let floats = |bytes: &[u8]| -> Vec<f32> {
            bytes.chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
        };
        let npy = fs::read(path.join("d.npy")).unwrap();
        let pixels = if more.contains(&"--crop") { 40 * 22 } else { 48 * 30 };
        let [got, expected] = [depth, &npy].map(|bytes| floats(&bytes[bytes.len() - 4 * pixels..]));
        assert!(got.iter().zip(&expected).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())), "{more:?}");
    }
}

/// Cameras one above the other, as their CameraInfo says.
#[test]
fn an_upper_and_a_lower_camera_are_known_by_their_projections() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let [upper, lower] = frame(0).map(|image| image::imageops::rotate90(&image));
    // P's eighth number, -f B; what follows P are binning and roi.
    let mut below = Cdr::new(0).u32(48).u32(30).text("plumb_bob").u32(5);
    let mut above = Cdr::new(0).u32(48).u32(30).text("plumb_bob").u32(5);
    let matrix = [50.0, 0.0, 15.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0];
    for (info, shift) in [(&mut above, 0.0), (&mut below, -10.0)] {
        let projection = [50.0, 0.0, 15.0, 0.0, 0.0, 50.0, 24.0, shift, 0.0, 0.0, 1.0, 0.0];
        for value in [&[0.0; 5][..], &matrix, &ROTATION, &projection].concat() {
            *info = std::mem::replace(info, Cdr(Vec::new())).number(value.to_le_bytes());
        }
    }
    let infos = [above, below].map(|info| info.u32(0).u32(0).0);
    let mut all = drive(0);
    (all[0].3, all[1].3) = (infos[0].clone(), infos[1].clone());
    for (topic, picture) in [LEFT, RIGHT].into_iter().zip([&upper, &lower]) {
        all.push((topic, IMAGE, at(0), image(at(0), "mono8", [30, 48], picture.as_raw())));
    }
    record(&path.join("in.mcap"), None, &all);
    let output = succeeds(path, &video("in.mcap", [LEFT, RIGHT], "out.mcap", &[]));
    assert!(stderr(&output).contains("one above the other"), "{}", stderr(&output));
    upper.save(path.join("l.png")).unwrap();
    lower.save(path.join("r.png")).unwrap();
    let cameras = ["--vertical", "--focal", "50", "--baseline", "0.2", "--cx", "15", "--cy", "24"];
    succeeds(path, &[&["l.png", "r.png", "--points", "p.ply"], &SETTINGS[..], &cameras].concat());
    let all = read(&path.join("out.mcap"));
    are_points(&all["/stereo/points2"][0].1, &fs::read(path.join("p.ply")).unwrap());
}

#[test]
fn raw_topics_are_rectified_by_what_the_cameras_say() {
    let folder = tempfile::tempdir().unwrap();
    let [left, right] = frame(0);
    let raw = ["/stereo/left/image_raw", "/stereo/right/image_raw"];
    let of = |distortion: f64| {
        let mut all = drive(0);
        (all[0].3, all[1].3) = (camera_info(0.0, distortion), camera_info(0.2, distortion));
        for (topic, picture) in raw.into_iter().zip([&left, &right]) {
            all.push((topic, IMAGE, at(0), image(at(0), "mono8", [48, 30], picture.as_raw())));
        }
        all
    };
    record(&folder.path().join("in.mcap"), None, &of(0.002));
    let args = video("in.mcap", raw, "m%d.npy", &[]);
    let output = succeeds(folder.path(), &args);
    assert!(stderr(&output).contains("rectified by what camera_info says"), "{}", stderr(&output));
    // The same numbers in files.
    for (name, baseline) in [("left.yaml", 0.0), ("right.yaml", 0.2)] {
        let matrix = |name: &str, columns: usize, values: &[f64]| {
            format!("{name}:\n  rows: {}\n  cols: {columns}\n  data: {values:?}\n", values.len() / columns)
        };
        let text = [
            "image_width: 48\nimage_height: 30\ncamera_name: c\ndistortion_model: plumb_bob\n".to_owned(),
            matrix("camera_matrix", 3, &MATRIX),
            matrix("distortion_coefficients", 5, &[0.002; 5]),
            matrix("rectification_matrix", 3, &ROTATION),
            matrix(
                "projection_matrix",
                4,
                &[50.0, 0.0, 24.0, -50.0 * baseline, 0.0, 50.0, 15.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            ),
        ];
        fs::write(folder.path().join(name), text.concat()).unwrap();
    }
    let npy =
        expected(&folder, &[left.clone(), right.clone()], &["--rectify", "left.yaml", "--calib-right", "right.yaml"]);
    let found = fs::read(folder.path().join("m0.npy")).unwrap();
    assert!(found == npy && found != expected(&folder, &[left.clone(), right.clone()], &[]));
    // Lenses that change nothing, as those of simulators.
    record(&folder.path().join("in.mcap"), None, &of(0.0));
    assert_eq!(stderr(&succeeds(folder.path(), &args)), "");
}

/// The name of a case, how its record is compressed, and the type and the bytes of both messages.
type Case = (&'static str, Option<Compression>, [(&'static str, Vec<u8>); 2]);

#[test]
fn every_encoding_and_compression_gives_the_same_maps() {
    let folder = tempfile::tempdir().unwrap();
    let images = pair(48, 30);
    let npy = expected(&folder, &images, &[]);
    let png = |image: &GrayImage| {
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes).write_image(image.as_raw(), 48, 30, ExtendedColorType::L8).unwrap();
        compressed(at(0), "mono8; png compressed ", &bytes)
    };
    let samples =
        |image: &GrayImage, each: fn(u8) -> Vec<u8>| image.as_raw().iter().flat_map(|v| each(*v)).collect::<Vec<u8>>();
    let raw = |encoding: &'static str, each: fn(u8) -> Vec<u8>| {
        images.each_ref().map(|i| (IMAGE, image(at(0), encoding, [48, 30], &samples(i, each))))
    };
    let cases: [Case; 6] = [
        ("mono8", None, raw("mono8", |v| vec![v])),
        ("mono16", Some(Compression::Lz4), raw("mono16", |v| vec![v, v])),
        ("rgb8", Some(Compression::Zstd), raw("rgb8", |v| vec![v; 3])),
        ("bgr8", Some(Compression::Lz4), raw("bgr8", |v| vec![v; 3])),
        ("bgra8", None, raw("bgra8", |v| vec![v, v, v, 7])),
        ("png", Some(Compression::Zstd), images.each_ref().map(|image| (COMPRESSED, png(image)))),
    ];
    for (name, compression, [left, right]) in cases {
        let path = folder.path().join("in.mcap");
        record(&path, compression, &[("l", left.0, 1, left.1), ("r", right.0, 2, right.1)]);
        succeeds(folder.path(), &video("in.mcap", ["l", "r"], name, &["--format", "npy"]));
        assert!(fs::read(folder.path().join(name).join("000000.npy")).unwrap() == npy, "{name}");
    }
    // JPEG is as its file, and yuv422 is read.
    let jpeg = images.each_ref().map(|image| {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, 90).encode_image(&DynamicImage::from(image.clone())).unwrap();
        bytes
    });
    let [l, r] = jpeg.each_ref().map(|bytes| compressed(at(0), "jpeg", bytes));
    record(&folder.path().join("in.mcap"), None, &[("l", COMPRESSED, 1, l), ("r", COMPRESSED, 2, r)]);
    succeeds(folder.path(), &video("in.mcap", ["l", "r"], "j%d.npy", &[]));
    for (name, bytes) in ["l.jpg", "r.jpg"].iter().zip(&jpeg) {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    succeeds(folder.path(), &[&["l.jpg", "r.jpg", "-o", "m.npy"], &SETTINGS[..]].concat());
    assert!(fs::read(folder.path().join("j0.npy")).unwrap() == fs::read(folder.path().join("m.npy")).unwrap());
    let [l, r] = images.each_ref().map(|i| image(at(0), "yuv422", [48, 30], &samples(i, |v| vec![128, v])));
    record(&folder.path().join("in.mcap"), None, &[("l", IMAGE, 1, l), ("r", IMAGE, 2, r)]);
    succeeds(folder.path(), &video("in.mcap", ["l", "r"], "y%d.npy", &[]));
}

#[test]
fn pairs_are_found_by_their_stamps_and_the_others_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let of = |side: usize, number: u32, time: i64| {
        let bytes = frame(number)[side].clone().into_raw();
        ([LEFT, RIGHT][side], IMAGE, time, image(time, "mono8", [48, 30], &bytes))
    };
    // The right camera is 3 ms late, its second image is missing, and it has one more at the end.
    let late = 3_000_000;
    let right = [0, 2, 3].map(|number| of(1, number, at(number) + late));
    let left = [0, 1, 2, 3].map(|number| of(0, number, at(number)));
    let mut messages = [&left[..], &right[..]].concat();
    messages.push(of(1, 9, at(9)));
    record(&folder.path().join("in.mcap"), Some(Compression::Lz4), &messages);
    let output = run(folder.path(), &video("in.mcap", [LEFT, RIGHT], "m%d.npy", &["--json"]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["done"], 3);
    for words in ["1 left and 1 right images have no partner", "up to 3.000 ms apart"] {
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
    for (place, number) in [0, 2, 3].into_iter().enumerate() {
        let npy = expected(&folder, &frame(number), &[]);
        assert!(fs::read(folder.path().join(format!("m{place}.npy"))).unwrap() == npy, "{number}");
    }
    // One that cannot be decoded fails alone.
    let mut broken = drive(4);
    broken[5].3.truncate(900);
    let at_right = broken.iter().position(|(topic, _, time, _)| *topic == RIGHT && *time == at(1)).unwrap();
    broken[at_right].3.truncate(900);
    record(&folder.path().join("broken.mcap"), None, &broken);
    let output = run(folder.path(), &video("broken.mcap", [LEFT, RIGHT], "b.mcap", &["--json"]));
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("failed: broken.mcap#1: the right image: a message ends"), "{}", stderr(&output));
    let stamps: Vec<_> =
        read(&folder.path().join("b.mcap"))["/stereo/disparity"].iter().map(|(time, _)| *time).collect();
    assert_eq!(stamps, [0, 2, 3].map(|number| at(number) as u64 + 5));
    // A record that was not ended is read as far as it goes.
    let whole = fs::read(folder.path().join("in.mcap")).unwrap();
    fs::write(folder.path().join("cut.mcap"), &whole[..whole.len() * 3 / 4]).unwrap();
    let output = run(folder.path(), &video("cut.mcap", [LEFT, RIGHT], "c%d.npy", &[]));
    assert!(stderr(&output).contains("\"cut.mcap\" is cut short"), "{}", stderr(&output));
}

#[test]
fn what_is_no_record_or_has_no_images_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    record(&at("in.mcap"), None, &drive(2));
    let of = |topics, more: &[&'static str]| video("in.mcap", topics, "m", more);
    let topics = "its topics of images are /stereo/left/image_rect (2 messages), /stereo/right/image_rect (2 messages)";
    refuses(
        folder.path(),
        &[&["video", "in.mcap", "-o", "m"], &SETTINGS[..]].concat(),
        &["--left TOPIC and --right TOPIC", topics],
    );
    refuses(folder.path(), &of(["/none", RIGHT], &[]), &["--left is \"/none\"", topics]);
    refuses(folder.path(), &of([LEFT, "/other"], &[]), &["\"std_msgs/msg/String\", but images are needed"]);
    refuses(folder.path(), &of([LEFT, LEFT], &[]), &["give the topics of two cameras"]);
    refuses(folder.path(), &of([LEFT, RIGHT], &["--split", "sbs"]), &["--split is for frames"]);
    refuses(folder.path(), &of([LEFT, RIGHT], &["--resume"]), &["--resume is for files"]);
    refuses(folder.path(), &video("in.mcap", [LEFT, RIGHT], "in.mcap", &[]), &["is an input"]);
    refuses(folder.path(), &video("in.mcap", [LEFT, RIGHT], "o.mcap", &["--format", "npy"]), &["not for a record"]);
    refuses(folder.path(), &["video", "a", "b", "--left", "x", "-o", "m", "--disp", "16"], &["topics of one record"]);
    let [l, r] = [1, 1].map(|time| image(time, "bayer_rggb8", [48, 30], &[7; 1440]));
    record(&at("bayer.mcap"), None, &[("l", IMAGE, 1, l), ("r", IMAGE, 2, r)]);
    is_one_line_error(
        &run(folder.path(), &video("bayer.mcap", ["l", "r"], "n%d.png", &[])),
        &["bayer_rggb8", "image_proc"],
    );
    fs::write(at("old.bag"), "#ROSBAG V2.0\n").unwrap();
    refuses(folder.path(), &video("old.bag", [LEFT, RIGHT], "m", &[]), &["ROS 1", "mcap convert old.bag out.mcap"]);
    fs::write(at("old.db3"), "SQLite format 3\0aaaa").unwrap();
    refuses(folder.path(), &video("old.db3", [LEFT, RIGHT], "m", &[]), &["SQLite", "mcap convert old.db3 out.mcap"]);
    fs::create_dir(at("bag")).unwrap();
    fs::write(at("bag/metadata.yaml"), "").unwrap();
    fs::copy(at("in.mcap"), at("bag/bag_0.mcap")).unwrap();
    refuses(
        folder.path(),
        &video("bag", [LEFT, RIGHT], "m", &[]),
        &["the folder of a ROS 2 bag", "give the .mcap file"],
    );
    let mut damaged = fs::read(at("in.mcap")).unwrap();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 0xff;
    fs::write(at("damaged.mcap"), damaged).unwrap();
    refuses(folder.path(), &video("damaged.mcap", [LEFT, RIGHT], "m", &[]), &["damaged.mcap", "mcap recover"]);
    assert!(contents(folder.path()).keys().all(|path| !path.ends_with("m")));
}

/// Readers that this program does not share a line with: the packages rosbags and mcap of PyPI, where Python has them.
#[test]
fn other_readers_read_the_same() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/sources/record.py");
    let python = std::env::var_os("GPU_STEREO_PYTHON").unwrap_or_else(|| "python3".into());
    let there = Command::new(&python).args(["-c", "import rosbags, mcap_ros2, numpy"]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        let why = "the packages rosbags, mcap-ros2-support and numpy are missing (GPU_STEREO_PYTHON names a Python that has them)";
        not_tested(&format!("other readers of records, since {why}"));
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    record(&folder.path().join("in.mcap"), Some(Compression::Zstd), &drive(3));
    succeeds(folder.path(), &video("in.mcap", [LEFT, RIGHT], "out.mcap", &[]));
    succeeds(folder.path(), &video("in.mcap", [LEFT, RIGHT], "map%d.npy", &[]));
    let output = Command::new(python).arg(script).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
}
