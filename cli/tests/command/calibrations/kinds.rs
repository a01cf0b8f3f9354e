//! Calibrations as other programs and people write them: each says what OpenCV's matrices say; and files whose true disparities
//! are known.

use super::{BENT, given, good, matrix, pair, refused, scene, unrectified};
use crate::support;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;

const RECTIFY: [&str; 2] = ["--rectify", "calib"];
const LENS: [f64; 5] = [0.1, 0.0, 0.001, 0.0, 0.0];
const K: &str = "[[52.0, 0.0, 29.5], [0.0, 52.0, 19.5], [0.0, 0.0, 1.0]]";
const D: &str = "[[0.1, 0.0, 0.001, 0.0, 0.0]]";
const R: &str = "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]";
const T: &str = "[[-0.1], [0.0], [0.0]]";

fn kalibr_camera(lens: &str, pose: &str) -> String {
    let lens = match lens {
        "none" => "camera_model: pinhole\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n  intrinsics: [52.0, 52.0, 29.5, 19.5]".into(),
        model => format!(
            "camera_model: pinhole\n  distortion_coeffs: [0.0158, -0.0197, 0.0204, -0.0072]\n  distortion_model: {model}\n  intrinsics: [52.0, 52.0, 29.5, 19.5]"
        ),
    };
    format!("{pose}  {lens}\n  resolution: [60, 40]\n  rostopic: /cam\n")
}

fn kalibr_pose(name: &str, t: [f64; 3]) -> String {
    let row =
        |i: usize| format!("  - [{}, {}, {}, {:?}]\n", i8::from(i == 0), i8::from(i == 1), i8::from(i == 2), t[i]);
    format!("  {name}:\n{}{}{}  - [0.0, 0.0, 0.0, 1.0]\n", row(0), row(1), row(2))
}

#[test]
fn two_of_many_cameras() {
    let folder = scene();
    let path = folder.path();
    let chain = |lens: &str| {
        let first = kalibr_camera(lens, "");
        let [second, third] = [-0.04, -0.06].map(|x| kalibr_camera(lens, &kalibr_pose("T_cn_cnm1", [x, 0.0, 0.0])));
        format!("cam0:\n{first}cam1:\n{second}cam2:\n{third}")
    };
    let expected = good(path, &unrectified(&BENT), &["--rectify", "calib", "--lens", "fisheye"]);
    let text = chain("equidistant");
    let with = |cameras: &'static str| ["--rectify", "calib", "--calib-cams", cameras];
    assert!(good(path, &text, &with("0,2")) == expected);
    assert!(good(path, &text, &with("0,1")) != expected);
    refused(path, &text, &RECTIFY, "3 cameras, cam0, cam1, cam2; give --calib-cams");
    // A model that is not known is named, though its numbers are as few as no other's.
    let fov = chain("fov").replace("[0.0158, -0.0197, 0.0204, -0.0072]", "[0.9]");
    refused(path, &fov, &with("0,1"), "distortion_model \"fov\"");
    refused(path, &text, &with("2,0"), "exchange");
    refused(path, &text, &with("0,3"), "the cameras 0 to 2");
    refused(path, &text, &with("1,1"), "T is 0");
    refused(path, &unrectified(&LENS), &with("0,1"), "--calib-cams is for");
    // Beside an inertial sensor, both ways round.
    for (name, x) in [("T_cam_imu", 0.05), ("T_imu_cam", -0.05)] {
        let both = [x, -x].map(|x| kalibr_camera("equidistant", &kalibr_pose(name, [x, 0.3, 0.1])));
        assert!(good(path, &format!("cam0:\n{}cam1:\n{}", both[0], both[1]), &RECTIFY) == expected, "{name}");
    }
    // KITTI's are numbered, too.
    let row = |shift: f64| format!("50 0 29.5 {shift} 0 50 19.5 0 0 0 1 0");
    let kitti = format!("P0: {}\nP1: {}\nP2: {}\nP3: {}\n", row(0.0), row(-9.0), row(3.0), row(-5.0));
    let plain = good(path, &pair(|_, _| ()), &["--calib", "calib"]);
    assert!(good(path, &kitti, &["--calib", "calib", "--calib-cams", "0,3"]) == plain);
    refused(path, &kitti, &["--calib", "calib", "--calib-cams", "0,7"], "P0, P1, P2, P3");
}

#[test]
fn basalt_s_cameras() {
    let folder = scene();
    let path = folder.path();
    let file = |kind: &str, numbers: &str| {
        let pose =
            |x: f64| format!("{{\"px\": {x}, \"py\": 0.2, \"pz\": 0, \"qx\": 0, \"qy\": 0, \"qz\": 0, \"qw\": 1}}");
        let lens = format!(
            "{{\"camera_type\": \"{kind}\", \"intrinsics\": {{\"fx\": 52, \"fy\": 52, \"cx\": 29.5, \"cy\": 19.5{numbers}}}}}"
        );
        format!(
            "{{\n\t\"value0\": {{\"T_imu_cam\": [{}, {}], \"intrinsics\": [{lens}, {lens}],\n\t\"resolution\": [[60, 40], [60, 40]], \
             \"calib_accel_bias\": [0, 0]}}}}",
            pose(0.0),
            pose(0.1)
        )
    };
    let fisheye = good(path, &unrectified(&BENT), &["--rectify", "calib", "--lens", "fisheye"]);
    let kb4 = file("kb4", ", \"k1\": 0.0158, \"k2\": -0.0197, \"k3\": 0.0204, \"k4\": -0.0072");
    assert!(good(path, &kb4, &RECTIFY) == fisheye);
    let eight = file(
        "pinhole-radtan8",
        ", \"k1\": 0.1, \"k2\": 0, \"p1\": 0.001, \"p2\": 0, \"k3\": 0, \"k4\": 0, \"k5\": 0, \"k6\": 0",
    );
    assert!(good(path, &eight, &RECTIFY) == good(path, &unrectified(&LENS), &RECTIFY));
    // A double sphere of xi 0 is a unified camera, which an extended one of beta 1 is, too; of alpha 0 a pinhole.
    let sphere = good(path, &file("ds", ", \"xi\": 0.0, \"alpha\": 0.4"), &RECTIFY);
    assert!(sphere == good(path, &file("eucm", ", \"alpha\": 0.4, \"beta\": 1.0"), &RECTIFY));
    assert!(sphere != good(path, &file("ds", ", \"xi\": -0.2, \"alpha\": 0.55"), &RECTIFY));
    refused(path, &file("ucm", ", \"alpha\": 0.5"), &RECTIFY, "\"ucm\", but pinhole");
    refused(path, &kb4.replace("\"qw\": 1", "\"qw\": 2"), &RECTIFY, "quaternion");
    refused(path, &kb4.replacen("\"fx\": 52, ", "", 1), &RECTIFY, "intrinsics.0.intrinsics.fx");
}

fn sensor(x: f64, bent: &str) -> String {
    format!(
        "%YAML:1.0\n# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor cam\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0.0, -1.0, \
         0.0, 0.3,\n         1.0, 0.0, 0.0, {x},\n         0.0, 0.0, 1.0, 0.1,\n         0.0, 0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [60, \
         40]\ncamera_model: pinhole\nintrinsics: [52.0, 52.0, 29.5, 19.5] #fu, fv, cu, cv\ndistortion_model: \
         radial-tangential\ndistortion_coefficients: [{bent}]\n"
    )
}

#[test]
fn a_file_for_each_camera() {
    let folder = scene();
    let path = folder.path();
    let write = |x: f64, bent: &str| fs::write(path.join("right"), sensor(x, bent)).unwrap();
    let both = ["--rectify", "calib", "--calib-right", "right"];
    let bent = "0.1, 0.0, 0.001, 0.0";
    write(0.15, bent);
    // The pair lies along the body's second axis.
    assert!(good(path, &sensor(0.05, bent), &both) == good(path, &unrectified(&LENS), &RECTIFY));
    refused(path, &sensor(0.05, bent), &RECTIFY, "--calib-right");
    refused(path, &sensor(0.25, bent), &both, "exchange");
    refused(path, &pair(|_, _| ()), &both, "drop it");
    // ROS: without a name of the model there are no numbers of it.
    let info = |shift: f64, d: &str| {
        format!(
            "header: {{frame_id: cam}}\nheight: 40\nwidth: 60\ndistortion_model: ''\nD: {d}\nK: [50, 0, 29.5, 0, 50, 19.5, 0, 0, 1]\nR: [1, \
             0, 0, 0, 1, 0, 0, 0, 1]\nP: [50, 0, 29.5, {shift}, 0, 50, 19.5, 0, 0, 0, 1, 0]\nbinning_x: 0\n---\n"
        )
    };
    for d in ["[]", "[0.0, 0.0, 0.0, 0.0, 0.0]"] {
        fs::write(path.join("right"), info(-5.0, d)).unwrap();
        let plain = good(path, &pair(|_, _| ()), &["--calib", "calib"]);
        assert!(good(path, &info(0.0, d), &["--calib", "calib", "--calib-right", "right"]) == plain);
        // Without a lens and a turn the pair is as it was, but for where it lies outside.
        good(path, &info(0.0, d), &both);
    }
}

#[test]
fn names_that_people_give() {
    let folder = scene();
    let path = folder.path();
    let expected = good(path, &unrectified(&LENS), &RECTIFY);
    let rows = |names: [&str; 6]| {
        let values = [K, D, K, D, R, T];
        names.iter().zip(values).map(|(name, value)| format!("{name}: {value}\n")).collect::<String>()
    };
    for names in [
        ["M1", "D1", "M2", "D2", "R", "T"],
        ["K1", "D1", "K2", "D2", "R", "T"],
        ["camera_matrix_left", "dist_coeffs_left", "camera_matrix_right", "dist_coeffs_right", "R", "T"],
        ["mtx_l", "dist_l", "mtx_r", "dist_r", "rotation", "translation"],
        ["mtxL", "distL", "mtxR", "distR", "Rot", "Trans"],
        ["mtxl", "distl", "mtxr", "distr", "rot", "tvec"],
        ["cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "R", "T"],
        ["left_camera_matrix", "left_distortion", "right_camera_matrix", "right_distortion", "R", "T"],
        ["K_left", "D_left", "K_right", "D_right", "rotation_matrix", "translation_vector"],
        ["K0", "dist0", "K1", "dist1", "R", "T"],
        ["cam0_intrinsics", "cam0_distortion", "cam1_intrinsics", "cam1_distortion", "R", "T"],
        ["LEFT_K", "LEFT_D", "RIGHT_K", "RIGHT_D", "R", "T"],
    ] {
        let text = rows(names);
        assert!(good(path, &text, &RECTIFY) == expected, "{text}");
        let quoted = |line: &str| line.split_once(": ").map(|(name, value)| format!("\t\"{name}\": {value}")).unwrap();
        let json = format!("{{\n{}\n}}", text.lines().map(quoted).collect::<Vec<_>>().join(",\n"));
        assert!(good(path, &json, &RECTIFY) == expected, "{json}");
        let nested = text.lines().map(|line| format!("  {line}\n")).collect::<String>();
        assert!(good(path, &format!("stereo_calibration:\n{nested}"), &RECTIFY) == expected, "{names:?}");
    }
    let side = format!("{{\"camera_matrix\": {K}, \"distortion_coefficients\": {D}, \"image_size\": [60, 40]}}");
    for text in [
        format!("{{\"left\": {side}, \"right\": {side}, \"R\": {R}, \"T\": [-0.1, 0, 0], \"rms\": 0.3}}"),
        format!("{{\"cam0\": {side}, \"cam1\": {side}, \"extrinsics\": {{\"rotation\": {R}, \"translation\": {T}}}}}"),
        format!("{{\"cameras\": [{side}, {side}], \"stereo\": {{\"R\": {R}, \"T\": {T}, \"E\": {R}, \"F\": {R}}}}}"),
        format!("left: {{K: {K}, D: {D}}}\nright: {{K: {K}, D: {D}, R: {R}, T: {T}}}\n"),
        format!("left: &a {{K: {K}, D: {D}}}\nright: *a\nrvec: [0, 0, 0]\nT: {T}\nimg_shape: [40, 60]\n"),
        format!("left: &a {{K: {K}, D: {D}}}\nright: *a\nR: {R}\nT: {T}\nimage_shape: [60, 40]\n"),
        "left: &a {fx: 52, fy: 52, cx: 29.5, cy: 19.5, k1: 0.1, k2: 0, p1: 0.001, p2: 0}\nright: *a\nR: [0, 0, 0]\nT: [-0.1, 0, 0]\n".into(),
        NUMPY.into(),
    ] {
        assert!(good(path, &text, &RECTIFY) == expected, "{text}");
    }
    refused(
        path,
        &(rows(["K1", "D1", "K2", "D2", "R", "T"]) + "M1: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"),
        &RECTIFY,
        "mean the same",
    );
    refused(
        path,
        &format!("left: {{K: {K}, D: {D}}}\nright: {{K: {K}, D: {D}}}\n"),
        &RECTIFY,
        "R1, P1, R2 and P2 or R and T",
    );
    // The images tell the size, and refuse another one.
    refused(
        path,
        &(rows(["K1", "D1", "K2", "D2", "R", "T"]) + "image_size: [120, 80]\n"),
        &RECTIFY,
        "--calib-scale 0.5",
    );
    // An alias of an alias of ..
    let many: String = (1..40).fold("a0: &a0 [1, 1]\n".into(), |text, i| {
        let before = i - 1;
        text + &format!("a{i}: &a{i} [*a{before}, *a{before}]\n")
    });
    refused(path, &many, &RECTIFY, "values");
}

/// What `yaml.dump` makes of NumPy's arrays.
const NUMPY: &str = "\
R: !!python/object/apply:numpy._core.multiarray._reconstruct
  args:
  - &id001 !!python/name:numpy.ndarray ''
  - !!python/tuple
    - 0
  - !!binary |
    Yg==
  state: !!python/tuple
  - 1
  - !!python/tuple
    - 3
    - 3
  - &id002 !!python/object/apply:numpy.dtype
    args:
    - f8
    - false
    - true
    state: !!python/tuple
    - 3
    - <
    - null
    - null
    - null
    - -1
    - -1
    - 0
  - false
  - !!binary |
    AAAAAAAA8D8AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAADwPwAAAAAAAAAAAAAAAAAAAAAA
    AAAAAAAAAAAAAAAAAPA/
T: !!python/object/apply:numpy._core.multiarray._reconstruct
  args:
  - *id001
  - !!python/tuple
    - 0
  - !!binary |
    Yg==
  state: !!python/tuple
  - 1
  - !!python/tuple
    - 3
    - 1
  - *id002
  - false
  - !!binary |
    mpmZmZmZub8AAAAAAAAAAAAAAAAAAAAA
camera_matrix_left: !!python/object/apply:numpy._core.multiarray._reconstruct
  args:
  - *id001
  - !!python/tuple
    - 0
  - !!binary |
    Yg==
  state: !!python/tuple
  - 1
  - !!python/tuple
    - 3
    - 3
  - *id002
  - false
  - !!binary |
    AAAAAAAASkAAAAAAAAAAAAAAAAAAgD1AAAAAAAAAAAAAAAAAAABKQAAAAAAAgDNAAAAAAAAAAAAA
    AAAAAAAAAAAAAAAAAPA/
camera_matrix_right: !!python/object/apply:numpy._core.multiarray._reconstruct
  args:
  - *id001
  - !!python/tuple
    - 0
  - !!binary |
    Yg==
  state: !!python/tuple
  - 1
  - !!python/tuple
    - 3
    - 3
  - *id002
  - false
  - !!binary |
    AAAAAAAASkAAAAAAAAAAAAAAAAAAgD1AAAAAAAAAAAAAAAAAAABKQAAAAAAAgDNAAAAAAAAAAAAA
    AAAAAAAAAAAAAAAAAPA/
dist_left: !!python/object/apply:numpy._core.multiarray._reconstruct
  args:
  - *id001
  - !!python/tuple
    - 0
  - !!binary |
    Yg==
  state: !!python/tuple
  - 1
  - !!python/tuple
    - 1
    - 5
  - *id002
  - false
  - !!binary |
    mpmZmZmZuT8AAAAAAAAAAPyp8dJNYlA/AAAAAAAAAAAAAAAAAAAAAA==
dist_right: !!python/object/apply:numpy._core.multiarray._reconstruct
  args:
  - *id001
  - !!python/tuple
    - 0
  - !!binary |
    Yg==
  state: !!python/tuple
  - 1
  - !!python/tuple
    - 1
    - 5
  - *id002
  - false
  - !!binary |
    mpmZmZmZuT8AAAAAAAAAAPyp8dJNYlA/AAAAAAAAAAAAAAAAAAAAAA==
";

/// An archive as np.savez and np.savez_compressed write it.
fn npz(arrays: &[(&str, &str, &[f64])], compressed: bool) -> Vec<u8> {
    let (mut body, mut directory) = (Vec::new(), Vec::new());
    for (name, shape, numbers) in arrays {
        let name = format!("{name}.npy");
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut array = b"\x93NUMPY\x01\0".to_vec();
        array.extend((header.len() as u16).to_le_bytes());
        array.extend(header.bytes());
        array.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let mut stored = array.clone();
        if compressed {
            let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(&array).unwrap();
            stored = encoder.finish().unwrap();
        }
        let mut fields =
            [if compressed { 8u16 } else { 0 }, 0, 0].iter().flat_map(|field| field.to_le_bytes()).collect::<Vec<_>>();
        fields.extend([0, stored.len() as u32, array.len() as u32].iter().flat_map(|field| field.to_le_bytes()));
        fields.extend((name.len() as u16).to_le_bytes());
        let place = body.len() as u32;
        body.extend(b"PK\x03\x04\x14\0\0\0");
        body.extend(&fields);
        body.extend([0, 0]);
        body.extend(name.bytes());
        body.extend(stored);
        directory.extend(b"PK\x01\x02\x14\0\x14\0\0\0");
        directory.extend(&fields);
        directory.extend([0; 12]);
        directory.extend(place.to_le_bytes());
        directory.extend(name.bytes());
    }
    let (count, place) = (arrays.len() as u16, body.len() as u32);
    body.extend(&directory);
    body.extend(b"PK\x05\x06\0\0\0\0");
    body.extend([count.to_le_bytes(), count.to_le_bytes()].concat());
    body.extend((directory.len() as u32).to_le_bytes());
    body.extend(place.to_le_bytes());
    body.extend([0, 0]);
    body
}

#[test]
fn archives_of_numpy() {
    let folder = scene();
    let path = folder.path();
    let expected = good(path, &unrectified(&LENS), &RECTIFY);
    let k = [52.0, 0.0, 29.5, 0.0, 52.0, 19.5, 0.0, 0.0, 1.0];
    let r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let large = vec![0.0; 20_000];
    let arrays: [(&str, &str, &[f64]); 8] = [
        ("mtx_l", "(3, 3)", &k),
        ("dist_l", "(1, 5)", &LENS),
        ("mtx_r", "(3, 3)", &k),
        ("dist_r", "(5,)", &LENS),
        ("R", "(3, 3)", &r),
        ("T", "(3, 1)", &[-0.1, 0.0, 0.0]),
        ("rvecs", "(1, 3, 1)", &[0.0, 0.0, 0.0]),
        ("map_x", "(100, 200)", &large),
    ];
    let run = |bytes: &[u8]| {
        fs::write(path.join("c.npz"), bytes).unwrap();
        given(path, "", &["--rectify", "c.npz"])
    };
    for compressed in [false, true] {
        let (files, told) = run(&npz(&arrays, compressed)).unwrap();
        assert_eq!(told, "");
        assert!(files == expected, "{compressed}");
    }
    let told = run(&npz(&arrays[6..], false)).unwrap_err();
    assert!(told.contains("no array of numbers"), "{told}");
    let told = run(&npz(&arrays[..4], false)).unwrap_err();
    assert!(told.contains("R and T"), "{told}");
    let whole = npz(&arrays, true);
    for end in [4, 40, 300, whole.len() - 30] {
        assert!(run(&whole[..end]).is_err(), "{end}");
    }
}

#[test]
fn matrices_in_lines() {
    let folder = scene();
    let path = folder.path();
    let plain = good(path, &pair(|_, _| ()), &["--calib", "calib"]);
    for text in ["50.0 0.0 29.5 0.0 50.0 19.5 0.0 0.0 1.0\n0.1\n", "50 0 29.5\n0 50 19.5\n0 0 1\n\n0.1"] {
        assert!(good(path, text, &["--calib", "calib"]) == plain, "{text}");
    }
    let text = "50.0 0.0 29.5 0.0 50.0 19.5 0.0 0.0 1.0\n";
    refused(path, &format!("{text}-0.1\n"), &["--calib", "calib"], "must be more than 0");
    refused(
        path,
        &format!("{text}0.1\n").replace("29.5 0.0", "29.5 0.5"),
        &["--calib", "calib"],
        "fx 0 cx 0 fy cy 0 0 1",
    );
    refused(path, &format!("{text}0.1\n"), &RECTIFY, "--calib");
}

/// Single numbers of a rectified pair, as people write them, and as ORB-SLAM's settings have them.
#[test]
fn numbers_of_a_rectified_pair() {
    let folder = scene();
    let path = folder.path();
    let calib = ["--calib", "calib"];
    let plain = good(path, &pair(|_, _| ()), &calib);
    for text in [
        r#"{"fx": 50, "fy": 50, "cx": 29.5, "cy": 19.5, "baseline": 0.1}"#,
        r#"{"focal_length": 50, "cx": 29.5, "cy": 19.5, "baseline_mm": 100, "width": 60, "height": 40}"#,
        "left:\n  fx: 50.0\n  fy: 50.0\n  cx: 29.5\n  cy: 19.5\n  k1: 0.0\nright:\n  fx: 50.0\n  fy: 50.0\n  cx: 29.5\n  \
         cy: 19.5\n  k1: 0.0\nbaseline: 0.1\n",
        "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera.fx: 50.0\nCamera.fy: 50.0\nCamera.cx: 29.5\nCamera.cy: 19.5\nCamera.k1: 0.0\n\
         Camera.width: 60\nCamera.height: 40\nCamera.bf: 5.0\n",
        "%YAML:1.0\nCamera.type: \"Rectified\"\nCamera1.fx: 50.0\nCamera1.fy: 50.0\nCamera1.cx: 29.5\nCamera1.cy: 19.5\n\
         Stereo.b: 0.1\nORBextractor.nFeatures: 1200\n",
    ] {
        assert!(good(path, text, &calib) == plain, "{text}");
        refused(path, text, &RECTIFY, "--calib");
    }
    // R beside T, as one matrix.
    let one = |t: &str| format!("K_left: {K}\nK_right: {K}\ndist_left: {D}\ndist_right: {D}\n{t}");
    let beside = one("extrinsics: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n");
    assert!(good(path, &beside, &RECTIFY) == good(path, &one(&format!("R: {R}\nT: {T}\n")), &RECTIFY));
    refused(path, &one("extrinsics: [[1, 0, 0, -0.1], [0, 1, 0, 0]]\n"), &RECTIFY, "it has no R");
    // Principal points in other columns.
    let apart = "left: {fx: 50, cx: 29.5, cy: 19.5}\nright: {fx: 50, cx: 30.5, cy: 19.5}\nbaseline: 0.1\n";
    let shifted = r#"{"fx": 50, "cx": 29.5, "cy": 19.5, "baseline": 0.1, "doffs": 1}"#;
    assert!(good(path, apart, &calib) == good(path, shifted, &calib));
    assert!(good(path, apart, &calib) != plain);
    let one = r#"{"fx": 50, "cx": 29.5, "cy": 19.5, "baseline": 0.1}"#;
    for (from, to, words) in [
        ("\"cy\": 19.5", "\"cy\": 19.5, \"width\": 99, \"height\": 40", "99x40"),
        ("0.1}", "-0.1}", "more than 0"),
        ("0.1}", "0.1, \"k1\": 0.2}", "not rectified"),
        ("0.1}", "0.1, \"fy\": 60}", "square"),
        ("\"cy\": 19.5, ", "", "it has no cy"),
        ("0.1}", "0.1, \"camera\": {\"fx\": 51}}", "differ"),
        ("50", "\"wide\"", "not a number"),
    ] {
        assert!(one.contains(from));
        refused(path, &one.replace(from, to), &calib, words);
    }
    refused(path, &apart.replace("fx: 50, cx: 30.5", "fx: 52, cx: 30.5"), &calib, "focal lengths are 50 and 52");
}

/// The factory calibration of a ZED has all resolutions, and TY and TZ.
#[test]
fn the_images_tell_the_resolution() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (side, image) in ["left", "right"].into_iter().zip(support::pair(672, 376)) {
        image.save(path.join(format!("{side}.png"))).unwrap();
    }
    let mut text = String::new();
    for side in ["LEFT", "RIGHT"] {
        for (name, f, cx, cy) in
            [("2K", 1400.0, 1104.0, 621.0), ("HD", 700.0, 640.0, 360.0), ("VGA", 350.0, 336.5, 187.5)]
        {
            write!(
                text,
                "[{side}_CAM_{name}]\nfx={f}\nfy={f}\ncx={cx}\ncy={cy}\nk1=-0.02\nk2=0.01\np1=0\np2=0\nk3=0\n\n"
            )
            .unwrap();
        }
    }
    text +=
        "[STEREO]\nBaseline=119.9\nTY=0.4\nTZ=-0.3\nCV_2K=0.5\nCV_HD=0.5\nCV_VGA=0.004\nRX_VGA=-0.003\nRZ_VGA=0.002\n";
    let camera = |name: &str| {
        let k = [350.0, 0.0, 336.5, 0.0, 350.0, 187.5, 0.0, 0.0, 1.0];
        matrix(&format!("M{name}"), 3, &k) + &matrix(&format!("D{name}"), 1, &[-0.02, 0.01, 0.0, 0.0, 0.0])
    };
    let r = matrix("R", 3, &[-0.003, 0.004, 0.002]);
    let opencv = camera("1") + &camera("2") + &r + &matrix("T", 3, &[-119.9, -0.4, 0.3]);
    // The pair is of no such cameras, which a note says.
    let near = |options: &[&str], text: &str| given(path, text, options).unwrap().0;
    assert!(near(&RECTIFY, &text) == near(&["--rectify", "calib", "--calib-unit", "mm"], &opencv));
    let other = text.replace("VGA", "FHD").replace("336.5", "960").replace("187.5", "540");
    refused(path, &other, &RECTIFY, "2K (2208x1242), HD (1280x720), FHD (1920x1080)");
}

/// The kinds of ../shared/cases.
#[test]
fn cases() {
    let Some(cases) = support::shared("cases", "calibrations that people bring") else { return };
    let run = |file: &str, options: &[&str]| {
        let mut command = support::command(&cases);
        command.args(["l.png", "r.png", "--disp", "32", "--backend", "cpu", "--json", "-o"]);
        let folder = tempfile::tempdir().unwrap();
        command.arg(folder.path().join("map.npy")).args(options).arg(file);
        let output = command.output().unwrap();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        (output.status.code(), json["camera"]["baseline_m"].as_f64(), support::stderr(&output))
    };
    for (file, option, baseline) in [
        ("camchain.yaml", "--rectify", 0.1),
        ("camchain.yaml", "--calib", 0.1),
        ("drivingstereo.txt", "--calib", 0.1),
        ("zed.conf", "--rectify", 0.1),
        ("zed.conf", "--calib", 0.1),
        ("r_t_no_size.yml", "--rectify", 0.1),
        ("key_cam0.yml", "--calib", 0.1),
        ("zoomed_out.yml", "--rectify", 0.1),
        ("millimetres.yml", "--calib", 60.0),
    ] {
        let (code, found, told) = run(file, &[option]);
        assert_eq!((code, found.map(|found| (found * 1e6).round() / 1e6)), (Some(0), Some(baseline)), "{file}: {told}");
        assert_eq!(told.contains("--calib-unit mm"), file == "millimetres.yml", "{told}");
    }
    for (file, words) in [("fisheye_4x1.yml", "--lens fisheye"), ("twice_the_size.yml", "--calib-scale 0.5")] {
        let (code, _, told) = run(file, &["--rectify"]);
        assert!(code == Some(2) && told.contains(words), "{file}: {told}");
    }
}

/// What is understood, in words and as JSON, and the picture of both fields of view.
#[test]
fn what_is_understood_of_a_calibration() {
    let folder = scene();
    let path = folder.path();
    let write = |name: &str, text: &str| fs::write(path.join(name), text).unwrap();
    let told = |args: &[&str]| {
        let output = support::succeeds(path, &[&["calib"], args].concat());
        let json = support::succeeds(path, &[&["calib"], args, &["--json"]].concat());
        let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
        assert_eq!(support::stderr(&output).lines().count(), json["notes"].as_array().unwrap().len(), "{json}");
        (support::stdout(&output), support::stderr(&output), json)
    };
    // A rectified pair.
    write("p.yml", &pair(|_, right| right[2] += 1.0));
    let (text, notes, json) = told(&["p.yml", "--size", "60x40"]);
    assert!(text.contains("give it with --calib") && text.contains("focal length 50 px") && notes.is_empty(), "{text}");
    assert_eq!((json["rectified"].as_bool(), json["baseline_m"].as_f64()), (Some(true), Some(0.1)), "{json}");
    assert_eq!(json["rectified_cameras"]["doffs_px"].as_f64(), Some(1.0));
    support::refuses(path, &["calib", "p.yml", "--size", "60x40", "-o", "fields.png"], &["drop --output"]);
    // R and T without a size.
    write("rt.yml", &unrectified(&LENS));
    let (text, notes, json) = told(&["rt.yml"]);
    assert!(text.contains("give it with --rectify") && notes.contains("--size WxH"), "{text}{notes}");
    assert!(json["rectified_cameras"].is_null() && json["cameras"][1]["numbers"][0].as_f64() == Some(0.1), "{json}");
    support::refuses(path, &["calib", "rt.yml", "-o", "fields.png"], &["--size WxH"]);
    support::refuses(path, &["calib", "rt.yml", "--size", "600x400"], &["--calib-scale"]);
    let (text, notes, json) =
        told(&["rt.yml", "--size", "60x40", "--alpha", "1", "-o", "fields.png", "--calib-unit", "cm"]);
    assert!(notes.contains("--calib-unit m makes it 0.1 m") && text.contains("written    fields.png"), "{text}{notes}");
    let content = json["cameras"][0]["content"].as_f64().unwrap();
    assert!(content > 0.7 && content < 1.0, "{content}");
    let picture = image::open(path.join("fields.png")).unwrap().to_rgb8();
    let count = |color: [u8; 3]| picture.pixels().filter(|pixel| pixel.0 == color).count();
    // Both outlines, what both see, and nothing around.
    for color in [[230, 159, 0], [86, 180, 233], [112, 112, 118], [24, 24, 28], [255, 255, 255]] {
        assert!(count(color) > 100, "{color:?}: {}", count(color));
    }
    // One above the other, and of a unit that is doubtful.
    let upper = unrectified(&LENS).replace("data: [ -0.1, 0.0, 0.0 ]", "data: [ 0.0, -0.1, 0.0 ]");
    write("upper.yml", &upper);
    let (text, notes, json) = told(&["upper.yml", "--size", "60x40"]);
    assert!(
        text.contains("one above the other") && text.contains("lower") && notes.contains("upper one"),
        "{text}{notes}"
    );
    assert_eq!(json["vertical"].as_bool(), Some(true));
    // A lens of two models, of a file that has rectified cameras, too.
    write("both.yml", &(unrectified(&BENT) + pair(|_, _| ()).trim_start_matches("%YAML:1.0\n---\n")));
    let (_, notes, _) = told(&["both.yml", "--size", "60x40"]);
    assert!(notes.contains("--lens pinhole or --lens fisheye"), "{notes}");
    // Two files, and what is refused.
    write("cam0", &sensor(0.05, "0.1, 0.0, 0.001, 0.0"));
    write("cam1", &sensor(0.15, "0.1, 0.0, 0.001, 0.0"));
    let (text, _, json) = told(&["cam0", "cam1"]);
    assert!(text.contains("EuRoC") && json["size"] == serde_json::json!([60, 40]), "{text}");
    support::refuses(path, &["calib", "cam0"], &["--calib-right"]);
    support::refuses(path, &["calib", "none.yml"], &["none.yml", "give a calibration file"]);
    support::refuses(path, &["calib", "p.yml", "--alpha", "0"], &["--calib"]);
    support::refuses(path, &["calib", "rt.yml", "--alpha", "2"], &["from 0 to 1"]);
    support::refuses(path, &["calib", "rt.yml", "-o", "rt.yml"], &[".png"]);
}
