//! Files that are spoilt, and the errors' advice.

use super::content::yaml;
use super::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SAMPLES: [&str; 7] = [
    "cam0=[100 0 33; 0 100 15.5; 0 0 1]\ncam1=[100 0 34.5; 0 100 15.5; 0 0 1]\ndoffs=1.5\nbaseline=500\nwidth=67\n",
    "P2: 1.0e+02 0 33 4.5 0 1e2 15.5 0.2 0 0 1 0.003\nP3: 1.0e+02 0 34.5 -45.5 0 1e2 15.5 0.3 0 0 1 0.003\n",
    "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0., 2., 0., 1., 3., 0., 0., 1. ]\n",
    "<?xml version=\"1.0\"?>\n<opencv_storage><Q type_id=\"opencv-matrix\"><rows>4</rows><cols>4</cols><dt>d</dt>\n\
     <data>1. 0. 0. -33. 0. 1. 0. -15. 0. 0. 0. 100. 0. 0. 2. 3.</data></Q></opencv_storage>\n",
    "image_width: 67\nimage_height: 31\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [100.0, 0.0, 33, 0, 0.0, 100.0, \
     15.5, 0.0, 0.0, 0.0, 1.0, 0.0]\n",
    "cam0: {camera_model: pinhole, intrinsics: [100, 100, 33, 15], distortion_model: radtan, distortion_coeffs: [0, 0, 0, 0]}\n\
     cam1:\n  T_cn_cnm1:\n  - [1, 0, 0, -0.5]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n  camera_model: pinhole\n  \
     intrinsics: [100, 100, 33, 15]\n  distortion_model: equidistant\n  distortion_coeffs: [0.1, 0, 0, 0]\n",
    "[LEFT_CAM_VGA]\nfx=100\nfy=100\ncx=33\ncy=15\nk1=0\n[RIGHT_CAM_VGA]\nfx=100\nfy=100\ncx=33\ncy=15\n[STEREO]\nBaseline=500\n\
     TY=0\nCV_VGA=0.01\n",
];

fn with_lenses() -> Reading {
    Reading { lenses: true, ..Reading::default() }
}

/// KITTI's matrices as some pass them on, without their names.
#[test]
fn lines_of_twelve_numbers_are_p0_and_p1() {
    let text = "1e2 0 33 0 0 1e2 15.5 0 0 0 1 0\n1e2 0 33 -45 0 1e2 15.5 0 0 0 1 0";
    let source = Source::parse(text.as_bytes()).unwrap();
    let camera = Calibration::of(&source, None, Reading::default()).unwrap().fit(67, 31).unwrap().camera;
    assert_eq!((camera.focal, camera.baseline, camera.cx, camera.cy), (100.0, 0.45, 33.0, 15.5));
    assert!(Source::parse(b"1e2 0 33 0 0 1e2 15.5 0 0 0 1\n").is_err());
}

#[test]
fn nested_namespaces_are_refused_at_once() {
    let nested: String = (0..30_000).map(|i| format!("<a xmlns:b{i}=\"c{i}\">")).collect();
    let error = Source::parse(nested.as_bytes()).err().unwrap();
    assert!(error.to_string().contains("xmlns"), "{error}");
}

/// Whatever bytes are changed, lost, doubled or taken from another kind: an answer or an error, and an answer is sound.
#[test]
fn spoilt_calibrations_never_panic() {
    let (mut good, mut bad) = (0, 0);
    for seed in 0..20_000 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut bytes = SAMPLES[seed as usize % SAMPLES.len()].as_bytes().to_vec();
        for _ in 0..random.random_range(0..4) {
            let (at, to) = (random.random_range(0..bytes.len()), random.random_range(0..bytes.len()));
            let (from, to) = (at.min(to), at.max(to));
            match random.random_range(0..5) {
                0 => bytes[at] = b"0123456789.-+eE[]{}<>:;,=%!&*#'\" \n\tPQnaif\0\xff"[random.random_range(0..43)],
                1 => bytes.truncate(at.max(1)),
                2 => drop(bytes.drain(from..to)),
                3 => bytes.extend_from_within(from..to),
                _ => bytes.extend_from_slice(SAMPLES[random.random_range(0..SAMPLES.len())].as_bytes()),
            }
            if bytes.is_empty() {
                bytes.push(b' ');
            }
        }
        for reading in [Reading::default(), with_lenses(), Reading { scale: Some(Scale::ONE), ..with_lenses() }] {
            let parse = || Source::parse(&bytes);
            let (Ok(source), Ok(again)) = (parse(), parse()) else {
                bad += 1;
                continue;
            };
            let _ = Calibration::of(&again, parse().ok().as_ref(), reading);
            match Calibration::of(&source, None, reading).and_then(|calibration| calibration.fit(67, 31)) {
                Ok(Fitted { camera, .. }) => {
                    assert!(camera.focal > 0.0 && camera.baseline > 0.0, "{camera:?}, seed {seed}");
                    good += 1;
                }
                Err(error) => {
                    assert!(!format!("{error:#}").contains('\n'), "{error:#}, seed {seed}");
                    bad += 1;
                }
            }
        }
    }
    assert!(good > 2000 && bad > 2000, "{good} good, {bad} bad");
}

#[test]
fn the_structure_tells_the_kind() {
    for (text, name) in SAMPLES.iter().zip(["Middlebury", "KITTI", "OpenCV", "OpenCV", "ROS", "Kalibr", "ZED"]) {
        assert!(Source::parse(text.as_bytes()).unwrap().name().starts_with(name), "{text}");
    }
    // A key that begins as another kind's does.
    for key in
        ["cam0_serial: \"17083\"", "cam0: left", "Position: 1 2 3", "P10_note: 1 2", "model: none", "STEREO: [1, 2]"]
    {
        let text = format!("{}{key}\n", SAMPLES[2]);
        assert!(Source::parse(text.as_bytes()).unwrap().name().starts_with("OpenCV"), "{key}");
    }
    for (text, name) in [
        ("model_type: PINHOLE\nprojection_parameters: {fx: 1}\n", "camodocal"),
        ("Camera.type: KannalaBrandt8\nCamera.bf: 20\n", "ORB-SLAM3"),
        ("{\"cameraData\": {\"intrinsicMatrix\": [1, 2]}}", "DepthAI"),
    ] {
        let refused = Calibration::of(&Source::parse(text.as_bytes()).unwrap(), None, with_lenses());
        let told = refused.unwrap_err().to_string();
        assert!(told.contains(name) && told.contains("file of OpenCV"), "{told}");
    }
    let told = Source::parse(b"a: 1\nb: [2]\n").err().unwrap().to_string();
    assert!(told.contains("has a, b") && told.contains("Kalibr"), "{told}");
    assert!(yaml("a: []\nb: {}\n", "").unwrap() == [("a".to_string(), vec![])].into());
}

#[test]
fn a_model_is_what_its_name_says_or_what_is_chosen() {
    use LensModel::{Auto, Fisheye, Pinhole};
    let of = |count: usize, named: Option<&str>, choice| lenses::of_model(&vec![0.01; count], named, choice, "D1");
    for count in [5, 8, 12, 14] {
        assert_eq!(of(count, None, Auto).unwrap(), crate::Distortion::pinhole(&vec![0.01; count]).unwrap());
    }
    for (count, named, choice) in [
        (4, None, Fisheye),
        (4, Some("equidistant"), Auto),
        (4, Some("Kannala_Brandt4"), Auto),
        (4, Some("bent"), Fisheye),
    ] {
        assert_eq!(of(count, named, choice).unwrap(), crate::Distortion::Fisheye([0.01; 4]), "{count} {named:?}");
    }
    for (count, named, choice) in
        [(4, None, Pinhole), (4, Some("plumb_bob"), Auto), (4, Some("radtan"), Pinhole), (4, Some(" "), Pinhole)]
    {
        assert_eq!(of(count, named, choice).unwrap(), crate::Distortion::pinhole(&[0.01; 4]).unwrap());
    }
    for named in [None, Some(""), Some("none"), Some("plumb_bob")] {
        assert_eq!(of(0, named, Auto).unwrap(), crate::Distortion::NONE);
    }
    for (count, named, choice, words) in [
        (4, None, Auto, "--lens pinhole or --lens fisheye"),
        (4, Some(""), Auto, "--lens pinhole or --lens fisheye"),
        (5, None, Fisheye, "--lens pinhole"),
        (5, Some("equidistant"), Auto, "5 numbers"),
        (0, Some("equidistant"), Auto, "0 numbers"),
        (8, Some("plumb_bob"), Auto, "8 numbers"),
        (5, Some("rational_polynomial"), Auto, "5 numbers"),
        (5, Some("none"), Auto, "5 numbers"),
        (4, Some("equidistant"), Pinhole, "drop --lens"),
        (5, Some("plumb_bob"), Fisheye, "drop --lens"),
        (5, Some("bent"), Auto, "plumb_bob, rational_polynomial"),
        (4, Some("omni"), Fisheye, "calibrate with"),
    ] {
        let told = of(count, named, choice).unwrap_err().to_string();
        assert!(told.contains(words), "{count} {named:?} {choice:?}: {told}");
    }
}
