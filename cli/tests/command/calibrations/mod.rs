//! Calibrations of every kind, model and size: read as they are meant, or refused with an advice that leads on.
//!
//! Everything runs on the CPU, so that no adapter is needed.

mod kinds;
mod truth;

use image::GrayImage;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A pair, 60 x 40, whose disparity is 3.
fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let gray = |x: u32, y: u32| {
        let noise = (x / 2 * 7919 + y / 2 * 104_729 + x / 2 * (y / 2) * 31).wrapping_mul(2_654_435_761);
        image::Luma([(noise >> 24) as u8])
    };
    GrayImage::from_fn(60, 40, gray).save(folder.path().join("left.png")).unwrap();
    GrayImage::from_fn(60, 40, |x, y| gray(x + 3, y)).save(folder.path().join("right.png")).unwrap();
    folder
}

fn run(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-stereo"));
    command.current_dir(folder).args(["left.png", "right.png", "--backend", "cpu", "--disp", "8"]);
    command.args(args).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// What the file of this text gives with these options: the map and the depth, and what is said.
fn given(folder: &Path, text: &str, options: &[&str]) -> Result<(Vec<u8>, String), String> {
    fs::write(folder.join("calib"), text).unwrap();
    for file in ["map.npy", "depth.npy"] {
        let _ = fs::remove_file(folder.join(file));
    }
    let output = run(folder, &[options, &["-o", "map.npy", "--depth", "depth.npy"]].concat());
    match output.status.code() {
        Some(0) => {
            let files = ["map.npy", "depth.npy"].map(|file| fs::read(folder.join(file)).unwrap()).concat();
            Ok((files, stderr(&output)))
        }
        code => {
            let told = stderr(&output);
            assert_eq!(code, Some(2), "{told}");
            assert!(told.starts_with("error: ") && told.lines().count() == 1, "{told}");
            assert!(!folder.join("map.npy").exists() && !folder.join("depth.npy").exists(), "{told}");
            Err(told)
        }
    }
}

fn good(folder: &Path, text: &str, options: &[&str]) -> Vec<u8> {
    let (files, told) = given(folder, text, options).unwrap_or_else(|told| panic!("{options:?}: {told}, of {text}"));
    assert_eq!(told, "", "{options:?}, of {text}");
    files
}

fn refused(folder: &Path, text: &str, options: &[&str], words: &str) {
    let told = given(folder, text, options).expect_err(&format!("{options:?} must be refused, of {text}"));
    assert!(told.contains(words), "{words:?} is not in {told}, of {text}");
}

fn matrix(name: &str, rows: usize, numbers: &[f64]) -> String {
    let all = numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(", ");
    let cols = numbers.len().checked_div(rows).unwrap_or(0);
    format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {all} ]\n")
}

const ONE: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

fn projection(focal: f64, cx: f64, cy: f64, shift: f64) -> [f64; 12] {
    [focal, 0.0, cx, shift, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
}

fn camera(focal: f64, cx: f64, cy: f64) -> [f64; 9] {
    [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
}

/// P1 and P2 of a focal length of 50 px and a baseline of 0.1 m.
fn pair(change: impl Fn(&mut [f64; 12], &mut [f64; 12])) -> String {
    let (mut left, mut right) = (projection(50.0, 29.5, 19.5, 0.0), projection(50.0, 29.5, 19.5, -5.0));
    change(&mut left, &mut right);
    format!("%YAML:1.0\n---\n{}{}", matrix("P1", 3, &left), matrix("P2", 3, &right))
}

/// The same with lenses whose distortion is a column of these numbers; `scale` of the numbers in pixels.
fn lenses(distortion: &[f64], scale: f64) -> String {
    let [cx, cy] = [29.5, 19.5].map(|place| (place + 0.5) * scale - 0.5);
    let mut text = "%YAML:1.0\n---\n".to_string();
    for (side, shift) in [(1, 0.0), (2, -5.0)] {
        text += &matrix(&format!("K{side}"), 3, &camera(52.0 * scale, cx, cy));
        text += &matrix(&format!("D{side}"), distortion.len(), distortion);
        text += &matrix(&format!("R{side}"), 3, &ONE);
        text += &matrix(&format!("P{side}"), 3, &projection(50.0 * scale, cx, cy, shift * scale));
    }
    text
}

/// What stereoCalibrate gives: R and T in place of R1 .. P2.
fn unrectified(distortion: &[f64]) -> String {
    let mut text = "%YAML:1.0\n---\n".to_string();
    for side in [1, 2] {
        text += &matrix(&format!("K{side}"), 3, &camera(52.0, 29.5, 19.5));
        text += &matrix(&format!("D{side}"), 1, distortion);
    }
    text + &matrix("R", 3, &ONE) + &matrix("T", 3, &[-0.1, 0.0, 0.0])
}

const BENT: [f64; 4] = [0.0158, -0.0197, 0.0204, -0.0072];

#[test]
fn four_numbers_are_of_no_model_until_one_is_named() {
    let folder = scene();
    let path = folder.path();
    let rectify = ["--rectify", "calib"];
    let with = |lens: &'static str| ["--rectify", "calib", "--lens", lens];
    let text = lenses(&BENT, 1.0);
    refused(path, &text, &rectify, "--lens pinhole or --lens fisheye");
    let [pinhole, fisheye] = ["pinhole", "fisheye"].map(|lens| good(path, &text, &with(lens)));
    assert!(pinhole != fisheye);
    // Zeros are no less of two models.
    let still = lenses(&[0.0; 4], 1.0);
    refused(path, &still, &rectify, "--lens");
    assert!(good(path, &still, &with("pinhole")) != good(path, &still, &with("fisheye")));
    assert!(good(path, &still, &with("pinhole")) == good(path, &lenses(&[0.0; 5], 1.0), &rectify));
    for (names, files) in [(["plumb_bob", "radtan"], &pinhole), (["equidistant", "fisheye"], &fisheye)] {
        for name in names {
            assert!(good(path, &format!("{text}distortion_model: {name}\n"), &rectify) == *files, "{name}");
        }
    }
    refused(path, &format!("{text}distortion_model: rational_polynomial\n"), &rectify, "8, 12, 14");
    refused(path, &format!("{text}distortion_model: bent\n"), &rectify, "plumb_bob, rational_polynomial");
    refused(path, &format!("{text}model: omni\n"), &with("fisheye"), "calibrate with one of these");
    refused(path, &format!("{text}distortion_model: equidistant\n"), &with("pinhole"), "drop --lens");
    // None at all is none.
    assert!(good(path, &lenses(&[], 1.0), &rectify) == good(path, &lenses(&[0.0; 5], 1.0), &rectify));
    // 12 and 14 numbers are taken as they are.
    let mut long = [0.0; 14];
    long[..4].copy_from_slice(&BENT);
    for count in [5, 8, 12, 14] {
        assert!(good(path, &lenses(&long[..count], 1.0), &rectify) == pinhole, "{count}");
    }
    for (i, value) in [(8, 0.2), (12, 0.1)] {
        let mut more = long;
        more[i] = value;
        assert!(good(path, &lenses(&more, 1.0), &rectify) != pinhole, "{i}");
    }
    // The same lens from R and T, in the two ways of OpenCV.
    let apart = unrectified(&BENT);
    refused(path, &apart, &rectify, "--lens");
    assert!(good(path, &apart, &with("pinhole")) != good(path, &apart, &with("fisheye")));
    refused(path, &lenses(&BENT, 1.0), &["--calib", "calib", "--lens", "fisheye"], "--rectify");
}

#[test]
fn kalibr_s_cameras_are_those_of_opencv() {
    let folder = scene();
    let chain = |model: &str, numbers: &str| {
        let camera = format!(
            "  camera_model: pinhole\n  distortion_coeffs: {numbers}\n  distortion_model: {model}\n  intrinsics: [52.0, 52.0, \
             29.5, 19.5]\n  resolution: [60, 40]\n"
        );
        let between = "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, \
            0.0, 0.0, 1.0]\n";
        format!("cam0:\n{camera}cam1:\n{between}{camera}")
    };
    let numbers = "[0.0158, -0.0197, 0.0204, -0.0072]";
    let rectify = ["--rectify", "calib"];
    for (model, lens) in [("equidistant", "fisheye"), ("radtan", "pinhole")] {
        let files = good(folder.path(), &chain(model, numbers), &rectify);
        assert!(files == good(folder.path(), &unrectified(&BENT), &["--rectify", "calib", "--lens", lens]), "{model}");
    }
    // Cameras without lenses and turns are rectified as they are.
    let still = chain("radtan", "[0.0, 0.0, 0.0, 0.0]");
    assert!(
        good(folder.path(), &still, &["--calib", "calib"])
            == good(folder.path(), &unrectified(&[0.0; 5]), &["--calib", "calib"])
    );
    refused(folder.path(), &chain("radtan", numbers), &["--calib", "calib"], "--rectify");
    refused(folder.path(), &chain("fov", "[0.9]"), &rectify, "distortion_coeffs is 1 numbers");
    refused(folder.path(), &chain("equidistant", "[]"), &rectify, "0 numbers");
    refused(folder.path(), &still.replace("camera_model: pinhole", "camera_model: omni"), &rectify, "pinhole-equi");
    refused(folder.path(), &still.replace("T_cn_cnm1", "T_cam_imu"), &rectify, "T_cn_cnm1");
    refused(folder.path(), &still.replacen("60, 40", "30, 20", 2), &rectify, "--calib-scale 2");
}

/// A calibration of images of another size: by its size, or by where its principal points lie.
#[test]
fn another_size_is_refused_and_scaled() {
    let folder = scene();
    let path = folder.path();
    let distortion = [-0.1, 0.02, 0.001, 0.0, 0.01];
    let right = good(path, &lenses(&distortion, 1.0), &["--rectify", "calib"]);
    for (scale, factor, size) in [
        (2.0, "0.5", "[ 120, 80 ]"),
        (4.0, "0.25", "[ 240, 160 ]"),
        (0.5, "2", "[ 30, 20 ]"),
        (1.5, "2/3", "[ 90, 60 ]"),
        (0.75, "4/3", "[ 45, 30 ]"),
    ] {
        let text = lenses(&distortion, scale);
        let sized = format!("{text}image_size: {size}\n");
        for text in [text, sized] {
            refused(path, &text, &["--rectify", "calib"], &format!("--calib-scale {factor}"));
            let scaled = good(path, &text, &["--rectify", "calib", "--calib-scale", factor]);
            let ends = |files: &[u8]| files[files.len() - 4 * 2400..].to_vec();
            let metres = |files: &[u8]| -> Vec<f32> {
                ends(files).chunks(4).map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]])).collect()
            };
            let near = |a: f32, b: f32| a.is_nan() == b.is_nan() && (a.is_nan() || (a - b).abs() <= 1e-4);
            let (a, b) = (metres(&scaled), metres(&right));
            assert!(a.iter().zip(&b).filter(|(a, b)| near(**a, **b)).count() >= 2390, "{scale}");
        }
    }
    // The same of rectified pairs.
    let twice = |text: &str| format!("{text}image_size: [ 120, 80 ]\n");
    let scaled = pair(|left, right| {
        *left = projection(100.0, 59.5, 39.5, 0.0);
        *right = projection(100.0, 59.5, 39.5, -10.0);
    });
    let plain = good(path, &pair(|_, _| ()), &["--calib", "calib"]);
    for text in [scaled.clone(), twice(&scaled)] {
        refused(path, &text, &["--calib", "calib"], "--calib-scale 0.5");
        assert!(good(path, &text, &["--calib", "calib", "--calib-scale", "1/2"]) == plain);
    }
    let q = "%YAML:1.0\n".to_string()
        + &matrix("Q", 4, &[1., 0., 0., -59.5, 0., 1., 0., -39.5, 0., 0., 0., 100., 0., 0., 10., 0.]);
    refused(path, &q, &["--calib", "calib"], "--calib-scale 0.5");
    let row = |p: [f64; 12]| p.map(|number| number.to_string()).join(" ");
    let [left, right] = [projection(100.0, 59.5, 39.5, 0.0), projection(100.0, 59.5, 39.5, -10.0)].map(row);
    refused(path, &format!("P0: {left}\nP1: {right}\n"), &["--calib", "calib"], "--calib-scale 0.5");
    // What is told to be right is right, but not what lies outside of the images after it was scaled, nor another size.
    let (_, told) = given(path, &scaled, &["--calib", "calib", "--calib-scale", "1"]).unwrap();
    assert_eq!(told, "");
    refused(path, &scaled, &["--calib", "calib", "--calib-scale", "2"], "outside");
    refused(path, &twice(&scaled), &["--calib", "calib", "--calib-scale", "1"], "120x80");
    refused(path, &twice(&scaled), &["--calib", "calib", "--calib-scale", "2"], "--calib-scale 0.5");
    refused(path, &format!("{scaled}image_size: [ 120, 60 ]\n"), &["--calib", "calib"], "--focal");
    for scale in ["0", "-1", "nan", "inf", "1/0", "half"] {
        refused(path, &scaled, &["--calib", "calib", "--calib-scale", scale], "such as 0.5 or 2/3");
    }
    // Lenses of these images, but rectified ones of larger images.
    let larger = lenses(&distortion, 1.0).replace("50.0, 0.0, 29.5,", "50.0, 0.0, 60.5,");
    for text in [larger.clone(), format!("{larger}image_size: [ 60, 40 ]\n")] {
        refused(path, &text, &["--rectify", "calib"], "newImageSize");
    }
    // Principal points that are off the middle, as those of real cameras: by a sixth along one side.
    for (cx, cy) in [(35.0, 19.0), (24.0, 20.0), (29.0, 23.0)] {
        let off = pair(|left, right| [left[2], right[2], left[6], right[6]] = [cx, cx, cy, cy]);
        good(path, &off, &["--calib", "calib"]);
    }
    let aside = pair(|left, right| [left[2], right[2]] = [50.0, 50.0]);
    refused(path, &aside, &["--calib", "calib"], "--calib-scale 1");
    good(path, &aside, &["--calib", "calib", "--calib-scale", "1"]);
}

#[test]
fn projections_of_no_rectified_pair_are_refused() {
    let folder = scene();
    let path = folder.path();
    let calib = ["--calib", "calib"];
    for (text, words) in [
        (pair(|_, right| right[0] = 51.0), "focal lengths are 50 and 51"),
        (pair(|_, right| right[5] = 51.0), "square"),
        (pair(|_, right| right[6] = 20.5), "rows 19.5 and 20.5"),
        (pair(|left, _| left[1] = 0.5), "skew of 0.5"),
        (pair(|_, right| right[1] = -0.5), "skew of -0.5"),
        (pair(|_, right| right[7] = -0.5), "side by side"),
        (pair(|_, right| right[11] = 0.01), "side by side"),
        (pair(|_, right| (right[3], right[7]) = (-5.0, -5.0)), "one above the other"),
        (pair(|_, right| (right[3], right[7]) = (0.0, 5.0)), "above the upper one"),
        (pair(|_, right| right[3] = 5.0), "exchange"),
        (pair(|left, right| (left[3], right[3]) = (-5.0, 0.0)), "exchange"),
        (pair(|_, right| right[3] = 0.0), "both cameras are one"),
        (pair(|_, right| right[8] = 0.1), "[f 0 cx tx"),
        (pair(|_, right| right[10] = 2.0), "[f 0 cx tx"),
        (pair(|_, _| ()) + &matrix("R", 3, &ONE) + &matrix("T", 3, &[-0.2, 0.0, 0.0]), "0.2 m by its T"),
        (
            pair(|_, _| ())
                + &matrix("Q", 4, &[1., 0., 0., -29.5, 0., 1., 0., -19.5, 0., 0., 0., 60., 0., 0., 10., 0.]),
            "different focal lengths",
        ),
        (
            "%YAML:1.0\n".to_string()
                + &matrix("Q", 4, &[2., 0., 0., -29.5, 0., 1., 0., -19.5, 0., 0., 0., 60., 0., 0., 10., 0.]),
            "its Q has 2",
        ),
        (
            "%YAML:1.0\n".to_string()
                + &matrix("Q", 4, &[1., 0., 0., -29.5, 0., 1., 0., -19.5, 0., 0., 0., 60., 0., 0., -10., 0.]),
            "exchange",
        ),
    ] {
        refused(path, &text, &calib, words);
    }
    // R and T beside P1 and P2 that agree; the tenths of a per cent of KITTI's files.
    good(path, &(pair(|_, _| ()) + &matrix("R", 3, &ONE) + &matrix("T", 3, &[-0.0999, 0.003, 0.002])), &calib);
    good(path, &pair(|_, right| (right[7], right[11]) = (0.03, 0.0002)), &calib);
    let rectify = ["--rectify", "calib"];
    let bent = lenses(&[0.0; 5], 1.0);
    for (from, to, words) in [
        ("52.0, 0.0, 29.5", "52.0, 0.4, 29.5", "skew of 0.4"),
        ("data: [ 1.0, 0.0, 0.0", "data: [ -1.0, 0.0, 0.0", "mirrors"),
        ("0.0, 0.0, 1.0 ]", "0.0, 0.0, 2.0 ]", "[fx 0 cx; 0 fy cy; 0 0 1]"),
    ] {
        assert!(bent.contains(from), "{from}");
        refused(path, &bent.replacen(from, to, 1), &rectify, words);
    }
}

#[test]
fn the_cameras_are_told_and_doubted() {
    let folder = scene();
    let path = folder.path();
    let told = |text: &str, options: &[&str]| {
        fs::write(path.join("calib"), text).unwrap();
        let plain = run(path, &[options, &["--depth", "depth.npy"]].concat());
        let json = run(path, &[options, &["--depth", "depth.npy", "--json"]].concat());
        assert!(plain.status.success() && json.status.success(), "{}", stderr(&plain));
        assert_eq!(stderr(&plain), stderr(&json));
        let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
        (String::from_utf8(plain.stdout.clone()).unwrap(), stderr(&plain), json)
    };
    let (summary, notes, json) = told(&pair(|_, _| ()), &["--calib", "calib"]);
    assert!(summary.contains("cameras  focal length 50 px, baseline 0.1 m\n"), "{summary}");
    assert_eq!(notes, "");
    assert_eq!((json["camera"]["focal_px"].as_f64(), json["camera"]["baseline_m"].as_f64()), (Some(50.0), Some(0.1)));
    for (shift, options, words) in [
        (-50.0 * 60.0, &["--calib", "calib"][..], Some("--calib-unit mm makes it 0.06 m")),
        (-50.0 * 12.0, &["--calib", "calib"], Some("--calib-unit cm makes it 0.12 m")),
        (-50.0 * 60.0, &["--calib", "calib", "--calib-unit", "mm"], None),
        (-50.0 * 0.12, &["--calib", "calib", "--calib-unit", "mm"], Some("--calib-unit m makes it 0.12 m")),
        (-50.0 * 2.9, &["--calib", "calib"], None),
        (-50.0 * 0.0051, &["--calib", "calib"], None),
        (-50.0 * 0.0049, &["--calib", "calib"], Some("--calib-unit")),
    ] {
        let (_, notes, json) = told(&pair(|_, right| right[3] = shift), options);
        match words {
            Some(words) => {
                assert!(notes.starts_with("note: the baseline is ") && notes.contains(words), "{words}: {notes}");
                assert!(json["warnings"][0].as_str().unwrap().contains(words), "{json}");
            }
            None => assert_eq!((notes.as_str(), json["warnings"].as_array().unwrap().len()), ("", 0), "{options:?}"),
        }
    }
    let (summary, notes, _) = told("", &["--focal", "50", "--baseline", "60"]);
    assert!(
        summary.contains("focal length 50 px, baseline 60 m") && notes.contains("give --baseline in metres"),
        "{notes}"
    );
    let (summary, ..) = told(&lenses(&[0.0; 5], 1.0), &["--rectify", "calib"]);
    assert!(summary.contains("focal length 50 px, baseline 0.1 m"), "{summary}");
}

/// Whoever does what an error says does not come back to where he was.
#[test]
fn no_two_errors_send_in_a_circle() {
    let folder = scene();
    let path = folder.path();
    let row = |shift: f64| projection(50.0, 29.5, 19.5, shift).map(|number| number.to_string()).join(" ");
    let driving = format!(
        "calib_time: 20180101\nS_rect_101: 6e+01 4e+01\nP_rect_101: {}\nS_rect_103: 6e1 4e1\nP_rect_103: {}\n",
        row(0.0),
        row(-5.0)
    );
    let zed = "[LEFT_CAM_VGA]\nfx=50\nfy=50\ncx=29.5\ncy=19.5\nk1=0\n\n[RIGHT_CAM_VGA]\nfx=50\nfy=50\ncx=29.5\ncy=19.5\nk1=0\n\n\
        [STEREO]\nBaseline=100\nTY=0\nTZ=0\nCV_VGA=0\nRX_VGA=0\nRZ_VGA=0\n";
    let keyed = pair(|_, _| ()) + "cam0_serial: \"17083\"\ncam1: right\n";
    let plain = good(path, &pair(|_, _| ()), &["--calib", "calib"]);
    for text in [&driving, zed, &keyed] {
        assert!(good(path, text, &["--calib", "calib"]) == plain, "{text}");
    }
    let gray = format!("P0: {}\nP1: {}\n", row(0.0), row(-5.0));
    let half = format!("P0: {}\nP1: {}\nP2: {}\n", row(0.0), row(-5.0), row(0.0));
    let none = format!("P1: {}\n", row(0.0));
    let zed_bent = zed.replace("k1=0", "k1=0.1");
    // What is given, what is said, and what is then given.
    for (text, options, words, then) in [
        (&driving, &["--calib", "calib", "--calib-pair", "gray"][..], "drop it", &["--calib", "calib"][..]),
        (
            &gray,
            &["--calib", "calib", "--calib-pair", "color"],
            "no P2 and no P3",
            &["--calib", "calib", "--calib-pair", "gray"],
        ),
        (&half, &["--calib", "calib"], "--calib-pair gray", &["--calib", "calib", "--calib-pair", "gray"]),
        (&keyed, &["--calib", "calib", "--calib-pair", "gray"], "drop it", &["--calib", "calib"]),
        (&keyed, &["--rectify", "calib"], "--calib", &["--calib", "calib"]),
        (&gray, &["--rectify", "calib"], "--calib", &["--calib", "calib"]),
        (&unrectified(&[0.1; 5]), &["--calib", "calib"], "--rectify", &["--rectify", "calib"]),
        (&unrectified(&BENT), &["--calib", "calib"], "--rectify", &["--rectify", "calib", "--lens", "fisheye"]),
        (&zed_bent, &["--calib", "calib"], "--rectify", &["--rectify", "calib"]),
    ] {
        refused(path, text, options, words);
        good(path, text, then);
    }
    refused(path, &none, &["--calib", "calib"], "it has P1, but no P0");
    let two =
        format!("{zed}[LEFT_CAM_HD]\nfx=640\nfy=640\ncx=640\ncy=360\n[RIGHT_CAM_HD]\nfx=640\nfy=640\ncx=640\ncy=360\n");
    // Of the two resolutions only one has these images.
    good(path, &two, &["--rectify", "calib"]);
    let far = two.replace("cx=29.5", "cx=336").replace("cy=19.5", "cy=188");
    refused(path, &far, &["--rectify", "calib"], "VGA (672x376), HD (1280x720)");
    fs::write(path.join("right"), zed).unwrap();
    refused(path, zed, &["--rectify", "calib", "--calib-right", "right"], "drop it");
}

#[test]
fn r_and_t_take_the_size_of_the_images() {
    let folder = scene();
    let text = unrectified(&[0.1, 0.0, 0.001, 0.0, 0.0]);
    let rectify = ["--rectify", "calib"];
    let sized = format!("{text}image_width: 60\nimage_height: 40\n");
    assert!(good(folder.path(), &text, &rectify) == good(folder.path(), &sized, &rectify));
    // Two files that contradict each other.
    fs::write(folder.path().join("more"), matrix("T", 3, &[-0.3, 0.0, 0.0])).unwrap();
    refused(folder.path(), &text, &["--rectify", "calib", "--calib-right", "more"], "both files have T.data");
}
