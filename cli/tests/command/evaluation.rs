//! Figures against a truth: cli/tests/command/evaluation.py, which follows docs/EVALUATION.md alone, finds the same; every file
//! format is read, and what is no map is refused.

use crate::support::{contents, not_tested, refuses, run, shared, stderr, stdout, succeeds};
use image::{DynamicImage, GrayImage, ImageBuffer, Luma};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/command/evaluation.py");
const NAN: f32 = f32::NAN;

/// What the script finds for each case; `None` where there is no Python, and then says so.
fn python(folder: &Path, cases: &[Vec<String>]) -> Option<Vec<Value>> {
    let probe = Command::new("python3").args(["-c", "import sys; sys.exit(sys.version_info < (3, 8))"]).status();
    if !probe.is_ok_and(|status| status.success()) {
        not_tested("the figures against docs/EVALUATION.md, since python3 is missing or older than 3.8");
        return None;
    }
    let quoted = |case: &Vec<String>| case.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" ");
    fs::write(folder.join("cases"), cases.iter().map(quoted).collect::<Vec<_>>().join("\n")).unwrap();
    let output = Command::new("python3").current_dir(folder).args([SCRIPT, "--each", "cases"]).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let found: Vec<_> = stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(found.len(), cases.len());
    Some(found)
}

fn eval(folder: &Path, case: &[String]) -> Value {
    let args: Vec<_> = ["eval", "--json"].into_iter().chain(case.iter().map(String::as_str)).collect();
    let found: Value = serde_json::from_str(&stdout(&succeeds(folder, &args))).unwrap();
    found["evaluation"].clone()
}

/// The same fields with the same values to 1e-6.
#[track_caller]
fn assert_equal(found: &Value, expected: &Value, case: &[String]) {
    let (found, expected) = (found.as_object().unwrap(), expected.as_object().unwrap());
    assert_eq!(found.len(), 18);
    assert_eq!(expected.len(), 18);
    for (name, expected) in expected {
        let equal = match (found[name].as_f64(), expected.as_f64()) {
            (Some(a), Some(b)) => (a - b).abs() <= 1e-6 * b.abs().max(1.0),
            (a, b) => a == b && found[name].is_null(),
        };
        assert!(equal, "{name} is {}, but the page says {expected}: {case:?}", found[name]);
    }
}

// Writers of our own, byte for byte.

fn pfm(width: usize, values: &[f32], big_endian: bool, header_end: &str) -> Vec<u8> {
    let scale = if big_endian { "0.00392" } else { "-1.0" };
    let mut bytes = format!("Pf\n{width} {}\n{scale}{header_end}", values.len() / width).into_bytes();
    for value in values.chunks(width).rev().flatten() {
        bytes.extend(if big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
    }
    bytes
}

fn npy(descr: &str, fortran: bool, (width, height): (usize, usize), samples: &[u8]) -> Vec<u8> {
    let fortran = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': ({height}, {width}), }}");
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{header:<0$}\n", length - 1).bytes());
    bytes.extend(samples);
    bytes
}

fn by_columns<T: Copy>(width: usize, values: &[T]) -> Vec<T> {
    let height = values.len() / width;
    (0..values.len()).map(|i| values[i % height * width + i / height]).collect()
}

fn png16(path: &Path, width: usize, values: &[f32], scale: f32) {
    let sample = |v: &f32| if v.is_finite() { (v * scale).round().clamp(1.0, 65535.0) as u16 } else { 0 };
    let height = (values.len() / width) as u32;
    let image = ImageBuffer::<Luma<u16>, Vec<u16>>::from_raw(width as u32, height, values.iter().map(sample).collect());
    image.unwrap().save(path).unwrap();
}

fn png8(path: &Path, width: usize, values: Vec<u8>) {
    GrayImage::from_raw(width as u32, (values.len() / width) as u32, values).unwrap().save(path).unwrap();
}

/// A map in a random format of those that the script reads; the scale that it needs.
fn write_somehow(path: &Path, width: usize, values: &[f32], random: &mut ChaCha8Rng) -> Option<u32> {
    let size = (width, values.len() / width);
    let bytes = match random.random_range(0..8) {
        0 => pfm(width, values, false, "\n"),
        1 => pfm(width, values, true, "\n"),
        2 => npy("<f4", false, size, &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>()),
        3 => npy(">f8", false, size, &values.iter().flat_map(|&v| f64::from(v).to_be_bytes()).collect::<Vec<_>>()),
        4 => {
            let samples: Vec<u8> = by_columns(width, values).iter().flat_map(|v| v.to_le_bytes()).collect();
            npy("<f4", true, size, &samples)
        }
        5 => {
            png16(path, width, values, 256.0);
            return None;
        }
        6 => {
            let sample = |v: &f32| if v.is_finite() { (v * 2.0).clamp(1.0, 255.0) as u8 } else { 0 };
            png8(path, width, values.iter().map(sample).collect());
            return Some(2);
        }
        _ => {
            let sample = |v: &f32| if v.is_finite() { (v * 8.0).clamp(1.0, 65535.0) as u16 } else { 0 };
            let samples: Vec<u8> = values.iter().flat_map(|v| sample(v).to_le_bytes()).collect();
            fs::write(path, npy("<u2", false, size, &samples)).unwrap();
            return Some(8);
        }
    };
    fs::write(path, bytes).unwrap();
    None
}

/// A value as maps have them, or one that no map should have.
fn value(random: &mut ChaCha8Rng, holes: f64) -> f32 {
    if random.random_bool(holes) {
        return [f32::INFINITY, NAN, f32::NEG_INFINITY][random.random_range(0..3)];
    }
    match random.random_range(0..20) {
        0 => 0.0,
        1 => -f32::from(random.random::<u8>()),
        2 => [f32::MAX, f32::MIN, 1e-30, 3e9][random.random_range(0..4)],
        _ => random.random_range(0..2000) as f32 / 16.0,
    }
}

#[test]
fn figures_equal_those_of_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let mut cases = Vec::new();
    for number in 0..60 {
        let (width, height) = match number {
            0 => (1, 1),
            1 => (1, 19),
            2 => (31, 1),
            _ => (random.random_range(1..25), random.random_range(1..12)),
        };
        let holes = [0.0, 0.1, 0.5, 0.95, 1.0][number % 5];
        let mut truth: Vec<f32> = (0..width * height).map(|_| value(&mut random, 0.2)).collect();
        truth[0] = 60.0; // something is known, and may be off by 3 px and 5 % to the point
        let close = |&g: &f32, random: &mut ChaCha8Rng| match random.random_range(0..3) {
            0 => value(random, holes),
            _ if random.random_bool(holes) => NAN,
            _ => g + [0.0, 0.5, -1.0, 2.0, 3.0, -4.0, 5.0, 0.0625][random.random_range(0..8)],
        };
        let estimate: Vec<f32> = truth.iter().map(|g| close(g, &mut random)).collect();
        let (map, gt, mask) = (format!("{number}.map"), format!("{number}.gt"), format!("{number}.mask.png"));
        // The content tells the format.
        let scale = {
            let path = folder.path().join(format!("{number}.map.png"));
            let scale = write_somehow(&path, width, &estimate, &mut random);
            fs::rename(path, folder.path().join(&map)).unwrap();
            scale
        };
        let path = folder.path().join(format!("{number}.gt.png"));
        let gt_scale = write_somehow(&path, width, &truth, &mut random);
        fs::rename(path, folder.path().join(&gt)).unwrap();
        let mut case = vec![map, gt];
        if let Some(scale) = scale {
            case.extend(["--scale".to_owned(), scale.to_string()]);
        }
        if let Some(scale) = gt_scale {
            case.extend(["--gt-scale".to_owned(), scale.to_string()]);
        }
        if number % 2 == 0 {
            let mut values: Vec<u8> =
                (0..width * height).map(|_| [255, 255, 128, 254, 0][random.random_range(0..5)]).collect();
            values[0] = 255;
            png8(&folder.path().join(&mask), width, values);
            case.extend(["--gt-mask".to_owned(), mask]);
        }
        cases.push(case);
    }
    let with_picture = |(number, case): (usize, &Vec<String>)| {
        [case.clone(), vec!["--picture".into(), format!("{number}.ppm")]].concat()
    };
    let Some(expected) = python(folder.path(), &cases.iter().enumerate().map(with_picture).collect::<Vec<_>>()) else {
        return;
    };
    let mut empty = 0;
    for (number, (case, expected)) in cases.iter().zip(&expected).enumerate() {
        let mut args = case.clone();
        args.extend(["--error-map".to_owned(), "errors.png".to_owned()]);
        assert_equal(&eval(folder.path(), &args), expected, case);
        empty += usize::from(expected["a50"].is_null());
        let [found, picture] = [folder.path().join("errors.png"), folder.path().join(format!("{number}.ppm"))];
        assert!(image::open(found).unwrap().into_rgb8() == image::open(picture).unwrap().into_rgb8(), "{case:?}");
    }
    assert!((5..30).contains(&empty), "{empty} maps are empty");
}

/// The collection beside the checkout, if there is one.
fn collection() -> Option<PathBuf> {
    shared("data", "real maps against docs/EVALUATION.md")
}

#[test]
fn figures_of_real_maps_equal_those_of_the_page() {
    let Some(data) = collection() else { return };
    let folder = tempfile::tempdir().unwrap();
    let manifest: Value = serde_json::from_slice(&fs::read(data.join("MANIFEST.json")).unwrap()).unwrap();
    let file = |value: &Value| data.join(value.as_str().unwrap()).to_str().unwrap().to_owned();
    let mut cases = Vec::new();
    for (number, entry) in manifest.as_array().unwrap().iter().enumerate() {
        // Art takes a minute in the reference and in Python.
        if !entry["gt"].is_string() || entry["scene"] == "art" {
            continue;
        }
        let map = format!("{number}.{}", ["png", "pfm", "npy"][number % 3]);
        let (left, right) = (file(&entry["left"]), file(&entry["right"]));
        let settings = ["--disp", "64", "--method", "bm", "--block", "9", "--backend", "cpu", "-o", &map];
        succeeds(folder.path(), &[&[left.as_str(), &right], &settings[..]].concat());
        let mut case = vec![map, file(&entry["gt"]), "--gt-scale".into(), entry["gt_scale"].to_string()];
        cases.push(case.clone());
        if entry["mask"]["nonocc"].is_string() {
            case.extend(["--gt-mask".into(), file(&entry["mask"]["nonocc"])]);
            cases.push(case);
        }
    }
    assert!(cases.len() > 12);
    let Some(expected) = python(folder.path(), &cases) else { return };
    for (case, expected) in cases.iter().zip(&expected) {
        assert!(expected["density"].as_f64().unwrap() > 0.2, "{case:?}: {expected}");
        assert_equal(&eval(folder.path(), case), expected, case);
    }
}

/// A 3x2 map in which every value differs, and holes.
const MAP: [f32; 6] = [4.0, NAN, 1.5, 20.0, 7.0, 255.0];

fn folder_with_truth() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("truth.pfm"), pfm(3, &[4.0, 6.0, 2.5, 10.0, 7.0, 250.0], false, "\n")).unwrap();
    folder
}

#[test]
fn every_format_is_read() {
    let folder = folder_with_truth();
    let at = |name: &str| folder.path().join(name);
    let bytes = |map: &dyn Fn(f32) -> Vec<u8>| MAP.iter().flat_map(|&v| map(v)).collect::<Vec<_>>();
    let sixteenth = |v: f32| if v.is_finite() { (16.0 * v) as u16 } else { 0 };
    fs::write(at("crlf.pfm"), pfm(3, &MAP, true, "\r\n")).unwrap();
    let commented = pfm(3, &MAP, false, "\n");
    fs::write(at("comment.pfm"), [b"Pf\n# made by hand\n", &commented[3..]].concat()).unwrap();
    fs::write(at("f4.npy"), npy("<f4", false, (3, 2), &bytes(&|v| v.to_le_bytes().into()))).unwrap();
    fs::write(at("f8.npy"), npy(">f8", false, (3, 2), &bytes(&|v| f64::from(v).to_be_bytes().into()))).unwrap();
    fs::write(at("u2.npy"), npy("<u2", false, (3, 2), &bytes(&|v| sixteenth(v).to_le_bytes().into()))).unwrap();
    fs::write(at("i8.npy"), npy("<i8", false, (3, 2), &bytes(&|v| i64::from(sixteenth(v)).to_le_bytes().into())))
        .unwrap();
    let columns: Vec<u8> = by_columns(3, &MAP).into_iter().flat_map(|v| sixteenth(v).to_be_bytes()).collect();
    fs::write(at("fortran.npy"), npy(">u2", true, (3, 2), &columns)).unwrap();
    png16(&at("kitti.png"), 3, &MAP, 256.0);
    png16(&at("sixteenth.png"), 3, &MAP, 16.0);
    let samples: Vec<u16> = MAP.iter().map(|&v| sixteenth(v)).collect();
    let pgm: Vec<u8> = samples.iter().flat_map(|v| v.to_be_bytes()).collect();
    fs::write(at("16.pgm"), [b"P5\n3 2\n65535\n", &pgm[..]].concat()).unwrap();
    let text: Vec<_> = samples.iter().map(u16::to_string).collect();
    fs::write(at("text.pgm"), format!("P2\n3 2\n65535\n{}\n", text.join(" "))).unwrap();
    let color =
        ImageBuffer::<image::Rgb<u16>, Vec<u16>>::from_raw(3, 2, samples.iter().flat_map(|&v| [v; 3]).collect());
    color.unwrap().save(at("equal_channels.png")).unwrap();
    let mut tiff = tiff::encoder::TiffEncoder::new(fs::File::create(at("f32.tif")).unwrap()).unwrap();
    tiff.write_image::<tiff::encoder::colortype::Gray32Float>(3, 2, &MAP).unwrap();
    let mut tiff = tiff::encoder::TiffEncoder::new(fs::File::create(at("f64.tif")).unwrap()).unwrap();
    tiff.write_image::<tiff::encoder::colortype::Gray64Float>(3, 2, &MAP.map(f64::from)).unwrap();
    let mut tiff = tiff::encoder::TiffEncoder::new(fs::File::create(at("u16.tif")).unwrap()).unwrap();
    tiff.write_image::<tiff::encoder::colortype::Gray16>(3, 2, &samples).unwrap();

    fs::write(at("plain.pfm"), pfm(3, &MAP, false, "\n")).unwrap();
    let expected = eval(folder.path(), &["plain.pfm".into(), "truth.pfm".into()]);
    assert_eq!((&expected["pixels"], &expected["density"]), (&6.into(), &(5.0 / 6.0).into()));
    assert_eq!(expected["average_error"], (1.0 + 10.0 + 5.0) / 5.0);
    assert_eq!(expected["bad_2"], 3.0 / 6.0);
    for name in ["crlf.pfm", "comment.pfm", "f4.npy", "f8.npy", "kitti.png", "f32.tif", "f64.tif"] {
        assert_eq!(eval(folder.path(), &[name.into(), "truth.pfm".into()]), expected, "{name}");
    }
    for name in ["u2.npy", "i8.npy", "fortran.npy", "sixteenth.png", "16.pgm", "text.pgm", "u16.tif"]
        .into_iter()
        .chain(["equal_channels.png"])
    {
        let case = [name.into(), "truth.pfm".into(), "--scale".into(), "16".into()];
        assert_eq!(eval(folder.path(), &case), expected, "{name}");
    }
}

#[test]
fn depth_of_virtual_kitti_becomes_disparity() {
    let folder = tempfile::tempdir().unwrap();
    let depths = [1000, 2000, 0, 65535, 65534, 1];
    let image = ImageBuffer::<Luma<u16>, Vec<u16>>::from_raw(3, 2, depths.to_vec()).unwrap();
    image.save(folder.path().join("depth.png")).unwrap();
    let disparity =
        |z: u16| if z == 0 || z == 65535 { NAN } else { (725.0087 * 0.532725 * 100.0 / f64::from(z)) as f32 };
    fs::write(folder.path().join("map.pfm"), pfm(3, &depths.map(disparity), false, "\n")).unwrap();
    let case =
        |more: &str| ["map.pfm", "depth.png"].into_iter().chain(more.split(' ')).map(String::from).collect::<Vec<_>>();
    let found = eval(folder.path(), &case("--gt-depth --focal 725.0087 --baseline 0.532725"));
    assert_eq!((&found["pixels"], &found["density"], &found["rms_error"]), (&4.into(), &1.0.into(), &0.0.into()));
    for (options, words) in [
        ("--gt-depth", ["--focal", "--baseline"]),
        ("--gt-depth --focal 700", ["--focal", "--baseline"]),
        ("--focal 700 --baseline 1", ["--gt-depth", "--focal"]),
        ("--gt-depth --baseline 1 --focal -700", ["-700", "above 0"]),
        ("--gt-depth --baseline nan --focal 700", ["NaN", "above 0"]),
    ] {
        let args = case(options);
        refuses(
            folder.path(),
            &["eval"].into_iter().chain(args.iter().map(String::as_str)).collect::<Vec<_>>(),
            &words,
        );
    }
}

#[test]
fn malformed_maps_are_one_line() {
    let folder = folder_with_truth();
    let at = |name: &str| folder.path().join(name);
    let good = pfm(3, &MAP, false, "\n");
    let header = |text: &str| [text.as_bytes(), &good[good.len() - 24..]].concat();
    let npy_with = |text: &str| {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.bytes());
        bytes.extend([0; 24]);
        bytes
    };
    let floats: Vec<u8> = MAP.iter().flat_map(|v| v.to_le_bytes()).collect();
    let good_npy = npy("<f4", false, (3, 2), &floats);
    let mut endless = good_npy.clone();
    endless[6..12].copy_from_slice(&[3, 0, 0xff, 0xff, 0xff, 0xff]);
    let cases: Vec<(&str, Vec<u8>, &[&str])> = vec![
        ("empty", vec![], &["empty"]),
        ("short.pfm", good[..good.len() - 1].to_vec(), &["3x2", "23 bytes", "cut short"]),
        ("long.pfm", [&good[..], b"x"].concat(), &["25 bytes"]),
        ("only.pfm", b"Pf\n3 2\n-1.0".to_vec(), &["no end"]),
        ("two.pfm", b"Pf\n3 2\n".to_vec(), &["no end"]),
        ("wide.pfm", header("Pf\n4294967295 4294967295\n-1\n"), &["4294967295x4294967295", "24 bytes"]),
        ("wider.pfm", header("Pf\n4294967296 2\n-1\n"), &["width", "4294967296"]),
        ("negative.pfm", header("Pf\n3 -2\n-1\n"), &["height", "\"-2\""]),
        ("zero.pfm", header("Pf\n0 2\n-1\n"), &["width", "\"0\""]),
        ("word.pfm", header("Pf\nthree 2\n-1\n"), &["width", "three"]),
        ("nan.pfm", header("Pf\n3 2\nnan\n"), &["scale", "nan"]),
        ("flat.pfm", header("Pf\n3 2\n0.0\n"), &["scale", "0.0"]),
        ("inf.pfm", header("Pf\n3 2\n-inf\n"), &["scale", "-inf"]),
        ("color.pfm", header("PF\n3 2\n-1\n"), &["three channels"]),
        ("joined.pfm", header("Pf4\n3 2\n-1\n"), &["header"]),
        ("size.pfm", pfm(2, &MAP, false, "\n"), &["2x3", "3x2"]),
        ("unknown.bin", b"no map at all".to_vec(), &["known format", "PFM"]),
        ("short.npy", good_npy[..good_npy.len() - 1].to_vec(), &["3x2", "23 bytes"]),
        ("head.npy", good_npy[..40].to_vec(), &["header"]),
        ("nine.npy", good_npy[..9].to_vec(), &["header"]),
        ("endless.npy", endless, &["4294967307"]),
        (
            "cube.npy",
            npy_with("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 1, 2)}\n"),
            &["its shape is [3, 1, 2]"],
        ),
        ("row.npy", npy_with("{'descr': '<f4', 'fortran_order': False, 'shape': (6,)}\n"), &["its shape is [6]"]),
        (
            "huge.npy",
            npy_with("{'descr': '<f4', 'fortran_order': False, 'shape': (9999999999, 9999999999)}\n"),
            &["21 digits"],
        ),
        (
            "wide.npy",
            npy_with("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 99999999999)}\n"),
            &["99999999999x2"],
        ),
        ("none.npy", npy_with("{'descr': '<f4', 'fortran_order': False, 'shape': (0, 3)}\n"), &["3x0"]),
        ("complex.npy", npy_with("{'descr': '<c8', 'fortran_order': False, 'shape': (1, 3)}\n"), &["<c8", "f4"]),
        ("object.npy", npy_with("{'descr': '|O', 'fortran_order': False, 'shape': (4, 3)}\n"), &["object.npy"]),
        ("fields.npy", npy_with("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2, 3)}\n"), &["records"]),
        ("python.npy", npy_with("import os\n"), &["header"]),
        ("cut.tif", b"II*\0\x08\0\0\0".to_vec(), &["cut.tif", "save it again"]),
        ("cut.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec(), &["cut short"]),
        ("most.pgm", b"P5\n3 2\n63\n\x01\x02\x03\x04\x05\x06".to_vec(), &["maximum of 63", "255 or 65535"]),
        ("short.pgm", b"P5\n3 2\n255\n\x01\x02".to_vec(), &["cut short"]),
        ("scale.npy", npy("|u1", false, (3, 2), &[1; 6]), &["--scale S", "Middlebury"]),
    ];
    for (name, bytes, words) in &cases {
        fs::write(at(name), bytes).unwrap();
        refuses(folder.path(), &["eval", name, "truth.pfm"], &[&[*name], *words].concat());
    }

    DynamicImage::new_rgb8(3, 2).save(at("black.png")).unwrap(); // equal channels, no disparity
    refuses(folder.path(), &["eval", "black.png", "truth.pfm"], &["--scale S"]);
    let mut picture = image::RgbImage::new(3, 2);
    picture.put_pixel(1, 1, image::Rgb([1, 2, 3]));
    picture.save(at("picture.png")).unwrap();
    refuses(folder.path(), &["eval", "picture.png", "truth.pfm", "--scale", "1"], &["colours", "not a picture"]);
    picture.save(at("picture.jpg")).unwrap();
    refuses(folder.path(), &["eval", "picture.jpg", "truth.pfm", "--scale", "1"], &["Jpeg", "PNG, PGM"]);
    refuses(folder.path(), &["eval", "truth.pfm", "missing.pfm"], &["missing.pfm", "does not exist"]);
    refuses(folder.path(), &["eval", "truth.pfm", "."], &["folder"]);
    for scale in ["0", "-1", "nan", "inf", "x", ""] {
        refuses(folder.path(), &["eval", "truth.pfm", "truth.pfm", "--gt-scale", scale], &["--gt-scale", "above 0"]);
    }

    // Truths and masks that do not fit.
    fs::write(at("unknown.pfm"), pfm(3, &[NAN; 6], false, "\n")).unwrap();
    refuses(folder.path(), &["eval", "truth.pfm", "unknown.pfm"], &["no known pixel"]);
    png8(&at("mask.png"), 3, vec![128; 6]);
    refuses(folder.path(), &["eval", "truth.pfm", "truth.pfm", "--gt-mask", "mask.png"], &["within the mask"]);
    png8(&at("wide.png"), 6, vec![255; 6]);
    refuses(folder.path(), &["eval", "truth.pfm", "truth.pfm", "--gt-mask", "wide.png"], &["6x1", "3x2"]);
    png16(&at("deep.png"), 3, &MAP, 256.0);
    refuses(folder.path(), &["eval", "truth.pfm", "truth.pfm", "--gt-mask", "deep.png"], &["16 bits"]);
    let errors = ["eval", "truth.pfm", "truth.pfm", "--error-map"];
    refuses(folder.path(), &[&errors[..], &["e.jpg"]].concat(), &["--error-map", ".png"]);
    let onto = ["eval", "truth.pfm", "truth.pfm", "--gt-mask", "mask.png", "--error-map", "mask.png"];
    refuses(folder.path(), &onto, &["input"]);
}

/// A folder with a pair that is 5 px apart and its truth.
fn pair_with_truth() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    put_pair(folder.path(), ["left.png", "right.png"], 48);
    fs::write(folder.path().join("truth.pfm"), pfm(48, &[5.0; 48 * 30], false, "\n")).unwrap();
    folder
}

#[test]
fn a_run_scores_its_map() {
    let folder = pair_with_truth();
    let args = ["left.png", "right.png", "--disp", "16", "--backend", "cpu", "--gt", "truth.pfm"];
    let files = ["-o", "map.pfm", "--error-map", "run.png"];
    let told = stdout(&succeeds(folder.path(), &[&args[..], &files].concat()));
    for word in ["of 1440 pixels", "bad-0.5", "D1", "A99", "map.pfm, run.png"] {
        assert!(told.contains(word), "{told}");
    }
    let output = succeeds(folder.path(), &["eval", "map.pfm", "truth.pfm", "--error-map", "eval.png"]);
    assert!(told.ends_with(&stdout(&output)), "{told}");
    let files = contents(folder.path());
    assert!(files[&folder.path().join("run.png")] == files[&folder.path().join("eval.png")]);
    let found = succeeds(folder.path(), &[&args[..], &["--json", "-o", "again.pfm"]].concat());
    let found: Value = serde_json::from_str(&stdout(&found)).unwrap();
    let expected = eval(folder.path(), &["map.pfm".into(), "truth.pfm".into()]);
    assert_eq!(found["evaluation"], expected);
    assert!(found["evaluation"]["bad_1_of_valid"].as_f64().unwrap() < 0.01, "{found}");

    // What does not fit is told before anything is written.
    png8(&folder.path().join("small.png"), 3, vec![1; 6]);
    let with = |gt| [&args[..7], &[gt], &["--gt-scale", "2", "-o", "never.png"]].concat();
    refuses(folder.path(), &with("small.png"), &["3x2", "48x30"]);
    refuses(folder.path(), &with("gone.png"), &["gone.png", "does not exist"]);
    let without = [&args[..6], &["--gt-scale", "2"]].concat();
    refuses(folder.path(), &without, &["--gt-scale", "add --gt FILE"]);
    refuses(folder.path(), &[&args[..6], &["--error-map", "e.png"]].concat(), &["--error-map", "--gt FILE"]);
    refuses(folder.path(), &[&args[..], &["-o", "truth.pfm"]].concat(), &["truth.pfm", "input"]);
    let help = stdout(&run(folder.path(), &["eval", "--help"]));
    assert!(help.contains("--gt-mask") && help.contains("Examples:"), "{help}");
}

// Whole data sets, made small in their official layouts.

/// Puts files below a folder; what `contents` writes is at the path that it is given.
fn put(folder: &Path, name: &str, contents: impl FnOnce(&Path)) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    contents(&path);
}

/// A pair of `width` x 30 that is 5 px apart.
fn put_pair(folder: &Path, [left, right]: [&str; 2], width: u32) {
    for (image, name) in crate::support::pair(width, 30).iter().zip([left, right]) {
        put(folder, name, |path| image.save(path).unwrap());
    }
}

/// 5 px, unknown in the first rows; the occluded part is off by 10.
fn put_kitti_truth(folder: &Path, all: &str, noc: &str, width: usize) {
    let truth = |occluded: f32| {
        let value = |i: usize| match (i / width, i % width) {
            (0..4, _) => NAN,
            (_, 0..8) => occluded,
            _ => 5.0,
        };
        (0..width * 30).map(value).collect::<Vec<_>>()
    };
    put(folder, all, |path| png16(path, width, &truth(15.0), 256.0));
    put(folder, noc, |path| png16(path, width, &truth(NAN), 256.0));
}

fn bench(folder: &Path, layout: &str, more: &[&str]) -> Value {
    let args = ["bench", "set", "--layout", layout, "--backend", "cpu", "--json", "-q"];
    serde_json::from_str(&stdout(&succeeds(folder, &[&args[..], more].concat()))).unwrap()
}

fn files_below(folder: &Path) -> Vec<String> {
    let name = |path: &PathBuf| path.strip_prefix(folder).unwrap().to_str().unwrap().replace('\\', "/");
    contents(folder).keys().map(name).collect()
}

#[test]
fn kitti_in_its_layout() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    for (number, width) in [(0, 48), (1, 45)] {
        let file = |kind: &str| format!("training/{kind}/{number:06}_10.png");
        put_pair(&set, [&file("image_2"), &file("image_3")], width);
        put_kitti_truth(&set, &file("disp_occ_0"), &file("disp_noc_0"), width as usize);
        // The second frame of a scene has no truth and is no scene.
        put_pair(&set, ["training/image_2/000000_11.png", "training/image_3/000000_11.png"], width);
    }
    put_pair(&set, ["testing/image_2/000000_10.png", "testing/image_3/000000_10.png"], 48);
    let found = bench(folder.path(), "kitti2015", &["--disp", "16", "--report", "report", "--submission", "submit"]);
    let scenes = found["scenes"].as_array().unwrap();
    let names: Vec<_> = scenes.iter().map(|s| format!("{}/{}", s["set"], s["scene"]).replace('"', "")).collect();
    assert_eq!(names, ["training/000000_10", "training/000001_10", "testing/000000_10"]);
    assert!(found["failures"].as_array().unwrap().is_empty());
    assert!(scenes[2]["evaluation"].is_null() && scenes[2]["valid"].as_f64().unwrap() > 0.5);

    // The scene's figures are those of eval; the set's are means, and all pixels together.
    succeeds(
        folder.path(),
        &["set/training/image_2/000000_10.png", "set/training/image_3/000000_10.png", "--disp", "16"]
            .into_iter()
            .chain(["--backend", "cpu", "-o", "map.png"])
            .collect::<Vec<_>>(),
    );
    let of = |truth: &str| eval(folder.path(), &["map.png".into(), format!("set/training/{truth}/000000_10.png")]);
    let (all, noc) = (of("disp_occ_0"), of("disp_noc_0"));
    assert_eq!((&scenes[0]["evaluation"], &scenes[0]["evaluation_noc"]), (&all, &noc));
    assert!(all["pixels"] != noc["pixels"] && all["d1_all"] != noc["d1_all"]);
    let sets = found["sets"].as_array().unwrap();
    assert_eq!(sets.len(), 2, "testing has no truth: {sets:?}");
    assert_eq!((&sets[0]["region"], &sets[1]["region"], &sets[0]["scenes"]), (&"all".into(), &"noc".into(), &2.into()));
    let figure = |scene: usize, name: &str| scenes[scene]["evaluation"][name].as_f64().unwrap();
    let mean = (figure(0, "d1_all") + figure(1, "d1_all")) / 2.0;
    let (n0, n1) = (figure(0, "pixels"), figure(1, "pixels"));
    let pooled = (figure(0, "d1_all") * n0 + figure(1, "d1_all") * n1) / (n0 + n1);
    assert!(mean != pooled);
    assert!((sets[0]["mean"]["d1_all"].as_f64().unwrap() - mean).abs() < 1e-12);
    assert!((sets[0]["pooled"]["d1_all"].as_f64().unwrap() - pooled).abs() < 1e-12);
    assert!(sets[0]["pooled"]["a50"].is_null() && sets[0]["mean"]["a50"].is_number());

    // What the command writes alone is what is submitted.
    let expected = ["testing", "training", "training"].into_iter().zip([0, 0, 1]);
    let expected: Vec<_> = expected.map(|(set, n)| format!("{set}/disp_0/{n:06}_10.png")).collect();
    assert_eq!(files_below(&folder.path().join("submit")), expected);
    let submitted = fs::read(folder.path().join("submit/training/disp_0/000000_10.png")).unwrap();
    assert!(submitted == fs::read(folder.path().join("map.png")).unwrap());

    // Every picture of the report is there, and no other.
    let report = fs::read_to_string(folder.path().join("report/report.md")).unwrap();
    let shown: Vec<_> = report.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()).collect();
    assert_eq!(shown.len(), 2 * 4 + 2);
    for picture in &shown {
        let picture = image::open(folder.path().join("report").join(picture)).unwrap();
        assert!(picture.height() == 30, "{shown:?}");
    }
    assert_eq!(files_below(&folder.path().join("report")).len(), shown.len() + 3); // report.md, results.json, done.jsonl
    let json: Value = serde_json::from_slice(&fs::read(folder.path().join("report/results.json")).unwrap()).unwrap();
    assert_eq!(json["scenes"][0]["evaluation"], all);

    // The training folder alone; one scene of it; several variants.
    let args =
        ["bench", "set/training", "--layout", "kitti2015", "--backend", "cpu", "--disp", "16", "--only", "000001"];
    let variants = ["--variants", "bm,sad+paths=8", "--submission", "two"];
    let told = stdout(&succeeds(folder.path(), &[&args[..], &variants].concat()));
    for word in ["training/000001_10", "method bm", "cost sad, paths 8", "D1-all pooled", "noc"] {
        assert!(told.contains(word), "{told}");
    }
    let expected = ["cost_sad__paths_8", "method_bm"].map(|v| format!("{v}/training/disp_0/000001_10.png"));
    assert_eq!(files_below(&folder.path().join("two")), expected);
    // Without --disp KITTI is searched to 192.
    let found = bench(folder.path(), "kitti2015", &["--method", "bm", "--only", "testing"]);
    assert_eq!(found["scenes"][0]["disparities"], 192);
}

#[test]
fn kitti_2012_in_its_layout() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set/training");
    for kind in ["image", "colored"] {
        put_pair(&set, [&format!("{kind}_0/000000_10.png"), &format!("{kind}_1/000000_10.png")], 48);
    }
    put_kitti_truth(&set, "disp_occ/000000_10.png", "disp_noc/000000_10.png", 48);
    let options = ["--disp", "16", "--submission", "submit"];
    let found = bench(folder.path(), "kitti2012", &options);
    assert!(found["scenes"][0]["evaluation_noc"]["bad_1_of_valid"].as_f64().unwrap() < 0.05, "{found}");
    assert_eq!(files_below(&folder.path().join("submit")), ["training/000000_10.png"]);
    // Gray images where there are no others, and the truth of what is not occluded.
    fs::remove_dir_all(set.join("colored_0")).unwrap();
    fs::remove_dir_all(set.join("disp_occ")).unwrap();
    let gray = bench(folder.path(), "kitti2012", &options);
    assert_eq!(gray["scenes"][0]["evaluation"], found["scenes"][0]["evaluation_noc"]);
}

/// A scene of Middlebury or ETH3D.
fn put_middlebury(scene: &Path, width: u32, calib: Option<&str>) {
    put_pair(scene, ["im0.png", "im1.png"], width);
    let truth = vec![5.0; width as usize * 30];
    put(scene, "disp0GT.pfm", |path| fs::write(path, pfm(width as usize, &truth, false, "\n")).unwrap());
    let mask = (0..width as usize * 30).map(|i| if i % width as usize > 7 { 255 } else { 128 }).collect();
    put(scene, "mask0nocc.png", |path| png8(path, width as usize, mask));
    if let Some(calib) = calib {
        put(scene, "calib.txt", |path| fs::write(path, calib).unwrap());
    }
}

#[test]
fn middlebury_and_eth3d_in_their_layout() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let calib = "cam0=[994.978 0 311.193; 0 994.978 254.877; 0 0 1]\nbaseline=193.001\nndisp=20\r\nisint=0\n";
    put_middlebury(&set.join("trainingQ/Adirondack"), 48, Some(calib));
    put_middlebury(&set.join("trainingQ/Motorcycle"), 40, Some("ndisp=24"));
    put_middlebury(&set.join("testQ/Plants"), 44, Some("ndisp=16\n"));
    fs::remove_file(set.join("testQ/Plants/disp0GT.pfm")).unwrap();
    let options = ["--method", "bm", "--block", "7", "--submission", "submit", "--method-name", "Ours"];
    let found = bench(folder.path(), "middlebury", &options);
    let scenes = found["scenes"].as_array().unwrap();
    let disparities: Vec<_> = scenes.iter().map(|scene| scene["disparities"].as_u64().unwrap()).collect();
    assert_eq!(disparities, [16, 20, 24]);
    assert_eq!(scenes[1]["evaluation_noc"]["pixels"], 40 * 30);
    let expected = ["testQ/Plants", "trainingQ/Adirondack", "trainingQ/Motorcycle"];
    let expected = expected.map(|scene| [format!("{scene}/disp0Ours_s.pfm"), format!("{scene}/timeOurs.txt")]);
    assert_eq!(files_below(&folder.path().join("submit")), expected.concat());
    let time = fs::read_to_string(folder.path().join("submit/testQ/Plants/timeOurs.txt")).unwrap();
    let ms = scenes[0]["frame_ms"]["median"].as_f64().unwrap();
    assert!((time.trim().parse::<f64>().unwrap() * 1e3 - ms).abs() < 0.002, "{time}, {ms}");
    // The submitted map scores as the scene did.
    let (map, truth) = ("submit/trainingQ/Motorcycle/disp0Ours_s.pfm", "set/trainingQ/Motorcycle/disp0GT.pfm");
    assert_eq!(eval(folder.path(), &[map.into(), truth.into()]), scenes[2]["evaluation"]);
    // A map without holes has the other name.
    let dense = ["--method", "bm", "--preset", "dense", "--submission", "dense", "--only", "Plants"];
    bench(folder.path(), "middlebury", &dense);
    let expected = ["disp0gpu-stereo.pfm", "timegpu-stereo.txt"].map(|name| format!("testQ/Plants/{name}"));
    assert_eq!(files_below(&folder.path().join("dense")), expected);

    let eth = tempfile::tempdir().unwrap();
    put_middlebury(&eth.path().join("set/two_view_training/delivery_area_1l"), 48, None);
    let found = bench(eth.path(), "eth3d", &["--method", "bm", "--submission", "submit"]);
    assert_eq!(
        (&found["scenes"][0]["set"], &found["scenes"][0]["disparities"]),
        (&"two_view_training".into(), &128.into())
    );
    let expected = ["delivery_area_1l.pfm", "delivery_area_1l.txt"].map(|name| format!("low_res_two_view/{name}"));
    assert_eq!(files_below(&eth.path().join("submit")), expected);
    let text = fs::read_to_string(eth.path().join("submit").join(&expected[1])).unwrap();
    assert!(text.strip_prefix("runtime ").unwrap().trim().parse::<f64>().unwrap() > 0.0);
}

/// Scenes of 2005 and 2006, whose truths have the disparities of the full size, and whose images were shifted.
#[test]
fn middlebury_2005_in_its_layout() {
    let folder = tempfile::tempdir().unwrap();
    for (name, rows, factor) in [("FullSize/Art", 1110, 1_u32), ("ThirdSize/Art", 370, 3)] {
        let scene = folder.path().join("set").join(name);
        for (image, view) in crate::support::pair(40, rows).iter().zip(["view1.png", "view5.png"]) {
            put(&scene, view, |path| image.save(path).unwrap());
        }
        // 5 px; nothing is known of the left columns.
        let truth = (0..40 * rows as usize).map(|i| if i % 40 < 8 { 0 } else { 5 * factor as u8 }).collect();
        put(&scene, "disp1.png", |path| png8(path, 40, truth));
        put(&scene, "dmin.txt", |path| fs::write(path, "21\n").unwrap());
    }
    let options = ["--method", "bm", "--maps", "maps", "--format", "depth-npy,points"];
    let found = bench(folder.path(), "middlebury", &options);
    for (place, (set, disparities, factor)) in [("FullSize", 256, 1.0), ("ThirdSize", 96, 3.0)].into_iter().enumerate()
    {
        let scene = &found["scenes"][place];
        assert_eq!([&scene["set"], &scene["scene"]], [set, "Art"]);
        assert_eq!(scene["disparities"], disparities);
        assert!(scene["evaluation"]["a50"].as_f64().unwrap() < 0.1, "{scene}");
        let npy = fs::read(folder.path().join(format!("maps/{set}/Art_depth.npy"))).unwrap();
        let floats =
            npy[npy.len() - 4 * 40 * 100..].chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()));
        let mut depths: Vec<_> = floats.filter(|depth| depth.is_finite()).collect();
        depths.sort_by(f32::total_cmp);
        // What the depth says of the disparity, to a sixteenth of a pixel.
        let disparity = 3740.0 / factor * 0.16 / f64::from(depths[depths.len() / 2]) - 21.0 / factor;
        assert!((disparity - 5.0).abs() < 0.07, "{set}: {disparity}");
        assert!(folder.path().join(format!("maps/{set}/Art_points.ply")).exists());
    }
    let damaged = folder.path().join("set/FullSize/Art/dmin.txt");
    fs::write(damaged, "many").unwrap();
    let args = ["bench", "set", "--layout", "middlebury", "--backend", "cpu", "--only", "Full"];
    let output = run(folder.path(), &[&args[..], &options].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("dmin.txt\" has \"many\""), "{}", stderr(&output));
    crate::support::pair(40, 500)[0].save(folder.path().join("set/FullSize/Art/view1.png")).unwrap();
    refuses(folder.path(), &args, &["500 rows", "1110, 555 or 370", "manifest"]);
}

#[test]
fn virtual_kitti_in_its_layout() {
    let folder = tempfile::tempdir().unwrap();
    let frames = folder.path().join("set/Scene01/15-deg-left/frames");
    for (image, camera) in crate::support::pair(48, 30).iter().zip([0, 1]) {
        let file = frames.join(format!("rgb/Camera_{camera}/rgb_00003.png"));
        put(&frames, file.to_str().unwrap(), |path| image.save(path).unwrap());
    }
    // 5 px, in whole centimetres; the sky above.
    let depth = (725.0087_f64 * 0.532725 * 100.0 / 5.0).round() as u16;
    let samples: Vec<u16> = (0..48 * 30).map(|i| if i < 480 { 65535 } else { depth }).collect();
    let image = ImageBuffer::<Luma<u16>, Vec<u16>>::from_raw(48, 30, samples).unwrap();
    put(&frames, "depth/Camera_0/depth_00003.png", |path| image.save(path).unwrap());
    let found = bench(folder.path(), "vkitti2", &["--disp", "16"]);
    let scene = &found["scenes"][0];
    assert_eq!((&scene["set"], &scene["scene"]), (&"Scene01/15-deg-left".into(), &"00003".into()));
    assert_eq!(scene["evaluation"]["pixels"], 48 * 20);
    assert!(scene["evaluation"]["a50"].as_f64().unwrap() < 0.2, "{scene}");
    let args = ["bench", "set", "--layout", "vkitti2", "--submission", "out"];
    refuses(folder.path(), &args, &["--submission", "kitti2015"]);
}

#[test]
fn a_manifest_and_scenes_that_fail() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    put_middlebury(&set.join("good"), 48, None);
    put_middlebury(&set.join("cut"), 48, None);
    put_middlebury(&set.join("other"), 40, None);
    fs::write(set.join("cut/disp0GT.pfm"), "Pf\n48 30\n-1\n").unwrap();
    put_pair(&set, ["seq/l/000000.png", "seq/r/000000.png"], 48);
    put_pair(&set, ["seq/l/000001.png", "seq/r/000001.png"], 48);
    let manifest = r#"[
        {"set": "a", "scene": "good", "left": "good/im0.png", "right": "good/im1.png", "gt": "good/disp0GT.pfm",
         "gt_scale": 1, "max_disp": 19.5, "mask": {"nonocc": "good/mask0nocc.png"}, "note": "passed over"},
        {"set": "a", "scene": "cut", "left": "cut/im0.png", "right": "cut/im1.png", "gt": "cut/disp0GT.pfm", "max_disp": 15},
        {"set": "a", "scene": "other", "left": "other/im0.png", "right": "other/im1.png", "gt": "good/disp0GT.pfm"},
        {"set": "a", "scene": "gone", "left": "gone/im0.png", "right": "gone/im1.png", "gt": null, "max_disp": 15},
        {"set": "s", "scene": "seq", "left": "seq/l/%06d.png", "right": "seq/r/%06d.png", "frames": 2, "gt": null}
    ]"#;
    fs::write(set.join("MANIFEST.json"), manifest).unwrap();
    let args =
        ["bench", "set", "--layout", "manifest", "--backend", "cpu", "--method", "bm", "--json", "--report", "report"];
    let output = run(folder.path(), &args);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let told: Vec<_> = stderr(&output).lines().filter(|line| line.starts_with("failed: ")).map(String::from).collect();
    assert_eq!(told.len(), 3, "{told:?}");
    for (line, words) in told.iter().zip([["a/cut", "cut short"], ["a/other", "48x30"], ["a/gone", "does not exist"]]) {
        assert!(words.iter().all(|word| line.contains(word)), "{line}");
    }
    let found: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let field = |name: &str| found["scenes"].as_array().unwrap().iter().map(|s| s[name].clone()).collect::<Vec<_>>();
    assert_eq!(field("scene"), ["good", "seq_000000", "seq_000001"]);
    assert_eq!(field("disparities"), [32, 128, 128]);
    assert_eq!(found["failures"].as_array().unwrap().len(), 3);
    let report = fs::read_to_string(folder.path().join("report/report.md")).unwrap();
    assert!(report.contains("## Failures") && report.contains("a/gone") && report.contains("seq\\_000001"), "{report}");

    // The file itself; what cannot be.
    let only = ["bench", "set/MANIFEST.json", "--layout", "manifest", "--backend", "cpu", "--method", "bm"];
    succeeds(folder.path(), &[&only[..], &["--only", "a/good"]].concat());
    refuses(folder.path(), &[&only[..], &["--only", "b/"]].concat(), &["--only", "b/", "6 scenes", "a/good"]);
    refuses(folder.path(), &[&only[..], &["--variants", "nothing"]].concat(), &["--variants", "nothing"]);
    refuses(folder.path(), &[&only[..], &["--report", "set/MANIFEST.json"]].concat(), &["MANIFEST.json", "is a file"]);
    let as_layout = |layout: &'static str| ["bench", "set", "--layout", layout];
    refuses(folder.path(), &as_layout("kitti2015"), &["no scene", "training/image_2/000000_10.png"]);
    refuses(folder.path(), &as_layout("vkitti2"), &["no scene", "Scene01"]);
    refuses(folder.path(), &as_layout("sintel"), &["sintel", "kitti2012"]);
    refuses(folder.path(), &["bench", "gone", "--layout", "eth3d"], &["gone", "not a folder"]);
    refuses(folder.path(), &["bench", "gone", "--layout", "manifest"], &["gone", "does not exist"]);
    let submit = ["bench", "set", "--layout", "middlebury", "--submission", "out", "--method-name", "a/b"];
    refuses(folder.path(), &submit, &["--method-name", "a/b"]);
    for (text, words) in [
        ("[]", "no scene"),
        ("{", "not a list of scenes"),
        (r#"[{"set": "a"}]"#, "missing field"),
        (r#"[{"set": "a", "scene": "b", "left": "l", "right": "r", "max_disp": -4}]"#, "max_disp -4"),
        (r#"[{"set": "a", "scene": "b", "left": "l", "right": "r", "max_disp": 1e30}]"#, "max_disp"),
        (r#"[{"set": "a", "scene": "b", "left": "l", "right": "r", "gt_scale": 0}]"#, "gt_scale 0"),
        (r#"[{"set": "a", "scene": "b", "left": "l", "right": "r", "frames": 4000000000}]"#, "4000000000 frames"),
    ] {
        fs::write(set.join("bad.json"), text).unwrap();
        refuses(folder.path(), &["bench", "set/bad.json", "--layout", "manifest"], &["bad.json", words]);
    }
    // A calibration that is wrong is the scene's failure.
    put_middlebury(&set.join("trainingQ/Bad"), 48, Some("ndisp=-3\n"));
    let output = run(folder.path(), &["bench", "set/trainingQ", "--layout", "middlebury", "--backend", "cpu"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("ndisp=-3"), "{}", stderr(&output));
}

#[test]
fn truths_of_other_programs_are_read_or_doubted() {
    let Some(cases) = shared("cases", "truths of other programs") else { return };
    let told = |args: &[&str]| -> (Value, String) {
        let output = succeeds(&cases, &[&["eval", "--json"], args].concat());
        (serde_json::from_str(&stdout(&output)).unwrap(), stderr(&output))
    };
    // OpenCV's map of 16 bits is the truth, but for a tenth that has no disparity.
    let (found, notes) = told(&["sgbm_cv16s.npy", "truth.npy"]);
    let of = |found: &Value, name: &str| found["evaluation"][name].as_f64().unwrap();
    assert_eq!(of(&found, "average_error"), 0.0);
    assert!((0.85..0.95).contains(&of(&found, "density")), "{found}");
    assert!(notes.contains("read as a map of OpenCV") && found["warnings"].as_array().unwrap().len() == 1, "{notes}");
    // A quarter of the truth is unknown, which is 0 in its floats.
    let (found, notes) = told(&["truth.npy", "truth_zero_is_unknown.npy"]);
    assert!(of(&found, "average_error") > 1.0 && notes.contains("give --gt-invalid 0"), "{notes}");
    let (found, notes) = told(&["truth.npy", "truth_zero_is_unknown.npy", "--gt-invalid", "0"]);
    assert_eq!((of(&found, "average_error"), of(&found, "pixels"), notes.as_str()), (0.0, 180.0 * 160.0, ""));
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| cases.join(name).to_str().unwrap().to_owned();
    let args =
        [at("l.png"), at("r.png"), "--disp".into(), "32".into(), "--backend".into(), "cpu".into(), "--json".into()];
    let truth = ["--gt".into(), at("truth_zero_is_unknown.npy"), "--gt-invalid".into(), "0".into()];
    let output = succeeds(folder.path(), &[&args[..], &truth].concat());
    let found: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(of(&found, "pixels"), 180.0 * 160.0);
    refuses(folder.path(), &[&args[..], &truth[2..]].concat(), &["--gt-invalid needs a truth; add --gt FILE"]);
}
