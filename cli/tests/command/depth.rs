//! Depth and points of the command: the files, read by cli/tests/command/depth.py and computed again from the disparities; calibrations
//! of every kind; and those that are no calibration.
//!
//! Everything runs on the CPU, so that no adapter is needed.

use crate::support::{command, not_tested, stderr};
use image::RgbImage;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output};

const FILES: [&str; 6] = ["depth.png", "depth.pfm", "depth.npy", "depth.tif", "scene.ply", "scene.pcd"];

fn run(folder: &Path, args: &[&str]) -> Output {
    let disparities = if args.contains(&"--disp") { &[][..] } else { &["--disp", "16"] };
    let mut command = command(folder);
    command.args(["left.png", "right.png", "--backend", "cpu"]).args(disparities).args(args).output().unwrap()
}

/// What cli/tests/command/depth.py says of a folder; `None` where there is no Python, and then says so.
fn read_again(folder: &Path, camera: [f64; 5], truth: Option<&Path>) -> Option<String> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/command/depth.py");
    let mut python = Command::new("python3");
    python.arg(script).arg(folder).args(camera.map(|number| number.to_string())).args(truth);
    match python.output() {
        Ok(output) => {
            assert!(output.status.success(), "cli/tests/command/depth.py failed:\n{}", stderr(&output));
            Some(String::from_utf8(output.stdout).unwrap())
        }
        Err(error) => {
            not_tested(&format!("the files of a depth, python3 does not start: {error}"));
            None
        }
    }
}

/// A coloured pair, 67 x 31, whose disparity is 2 in the upper and 7 in the lower half.
fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let color = |x: u32, y: u32| {
        let noise = (x * 7919 + y * 104_729 + x * y * 31).wrapping_mul(2_654_435_761);
        image::Rgb([(noise >> 24) as u8, (noise >> 16) as u8, (noise >> 8) as u8])
    };
    let shift = |y: u32| if y < 16 { 2 } else { 7 };
    let left = RgbImage::from_fn(67, 31, color);
    let right = RgbImage::from_fn(67, 31, |x, y| color(x + shift(y), y));
    left.save(folder.path().join("left.png")).unwrap();
    right.save(folder.path().join("right.png")).unwrap();
    fs::write(folder.path().join("left.ppm"), [b"P6\n67 31\n255\n", left.as_raw().as_slice()].concat()).unwrap();
    folder
}

/// A map that is not smoothed has more depths.
const ROUGH: [&str; 6] = ["--p1", "21", "--uniqueness", "6", "--weighted-median", "off"];

fn outputs() -> Vec<&'static str> {
    let written = FILES.iter().flat_map(|file| [if file.starts_with("scene") { "--points" } else { "--depth" }, file]);
    ["-o", "map.npy"].into_iter().chain(written).chain(ROUGH).collect()
}

/// Cameras of every kind of calibration, the same each time: focal length 100 px, baseline 0.5 m, doffs 1.5 px, principal
/// point (33, 15.5). So 2 px are 14.3 m away and 7 px 5.9 m.
const CAMERA: [f64; 5] = [100.0, 0.5, 1.5, 33.0, 15.5];

const MIDDLEBURY: &str = "cam0=[100 0 33; 0 100 15.5; 0 0 1]\ncam1=[100 0 34.5; 0 100 15.5; 0 0 1]\ndoffs=1.5\n\
    baseline=500\nwidth=67\nheight=31\nndisp=16\n";

const KITTI: &str = "P0: 1e2 0 20 0 0 1e2 15.5 0 0 0 1 0\nP1: 1e2 0 20 -7 0 1e2 15.5 0 0 0 1 0\n\
    P2: 1.0e+02 0 33 4.5 0 1e2 15.5 0.2 0 0 1 0.003\nP3: 1.0e+02 0 34.5 -45.5 0 1e2 15.5 0.3 0 0 1 0.003\n\
    R0_rect: 1 0 0 0 1 0 0 0 1\n";

const OPENCV: &str = "%YAML:1.0\n---\nimage_size: [ 67, 31 ]\nR1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
    data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]\nP1: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ 100., 0., \
    33., 0., 0., 100.,\n       15.5, 0., 0., 0., 1., 0. ]\nP2: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ \
    1.0000000000000000e+02, 0., 34.5, -50., 0., 100., 15.5, 0., 0., 0., 1., 0. ]\n";

const Q: &str = "%YAML:1.0\nQ: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [ 1., 0., 0., -33., 0., 1., 0., \
    -15.5, 0., 0., 0., 100., 0., 0., 2., 3. ]\n";

const XML: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<P1 type_id=\"opencv-matrix\">\n<rows>3</rows>\n<cols>4</cols>\n\
    <dt>d</dt>\n<data>\n100. 0. 33. 0. 0. 100.\n15.5 0. 0. 0. 1. 0.</data></P1>\n<P2 type_id=\"opencv-matrix\">\n\
    <rows>3</rows><cols>4</cols><dt>d</dt>\n<data>100. 0. 34.5 -50. 0. 100. 15.5 0. 0. 0. 1. 0.</data></P2>\n\
    </opencv_storage>\n";

fn ros(cx: &str, shift: &str) -> String {
    format!(
        "image_width: 67\nimage_height: 31\ncamera_name: eye\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [100.0, 0.0, \
         {cx}, {shift}, 0.0, 100.0, 15.5, 0.0, 0.0, 0.0, 1.0, 0.0]\n"
    )
}

#[test]
fn every_kind_of_calibration_gives_the_same_depth() {
    let folder = scene();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("calib.txt", MIDDLEBURY);
    write("kitti.txt", KITTI);
    let raw = ["P0", "P1", "P2", "P3"]
        .iter()
        .enumerate()
        .fold(KITTI.to_string(), |text, (i, name)| text.replace(name, &format!("P_rect_0{i}")));
    write("kitti_raw.txt", &raw);
    write("opencv.yml", OPENCV);
    write("mm.yml", &OPENCV.replace("-50.", "-50000."));
    write("q.yml", Q);
    write("opencv.xml", XML);
    write("left.yaml", &ros("33.0", "0.0"));
    write("right.yaml", &ros("34.5", "-50.0"));
    let brief = |cx: &str, shift: &str| {
        format!("height: 31\nwidth: 67\nP: [100, 0, {cx}, {shift}, 0, 100, 15.5, 0, 0, 0, 1, 0]\n")
    };
    write("left_message.yaml", &brief("33", "0"));
    write("right_message.yaml", &brief("34.5", "-50"));
    let mut first: Option<Vec<Vec<u8>>> = None;
    for options in [
        &["--calib", "calib.txt"][..],
        &["--calib", "kitti.txt"],
        &["--calib", "kitti_raw.txt", "--calib-pair", "color"],
        &["--calib", "opencv.yml"],
        &["--calib", "mm.yml", "--calib-unit", "mm"],
        &["--calib", "q.yml"],
        &["--calib", "opencv.xml"],
        &["--calib", "left.yaml", "--calib-right", "right.yaml"],
        &["--calib", "left_message.yaml", "--calib-right", "right_message.yaml"],
        &["--focal", "100", "--baseline", "0.5", "--doffs", "1.5", "--cx", "33", "--cy", "15.5"],
    ] {
        let output = run(folder.path(), &[options, &outputs()].concat());
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{options:?}");
        let files: Vec<_> = FILES.iter().map(|file| fs::read(folder.path().join(file)).unwrap()).collect();
        match &first {
            None => first = Some(files),
            Some(first) => assert!(*first == files, "{options:?} gives other files than calib.txt"),
        }
        FILES.iter().for_each(|file| fs::remove_file(folder.path().join(file)).unwrap());
    }
    // The gray pair of the same file has another baseline, and no principal points are those in the middle.
    for (options, camera) in [
        (&["--calib", "kitti.txt", "--calib-pair", "gray"][..], [100.0, 0.07, 0.0, 20.0, 15.5]),
        (&["--focal", "100", "--baseline", "90"], [100.0, 90.0, 0.0, 33.0, 15.0]),
        (&["--calib", "calib.txt"], CAMERA),
    ] {
        let output = run(folder.path(), &[options, &outputs()].concat());
        assert_eq!(output.status.code(), Some(0), "{options:?}: {}", stderr(&output));
        assert_eq!(stderr(&output).contains("65.5355 m"), options.contains(&"90"), "{}", stderr(&output));
        let _ = read_again(folder.path(), camera, None);
    }
    // The test of the reader: cameras that are a little off.
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/command/depth.py");
    for (i, off) in [(0, 100.01), (1, 0.50001), (2, 1.501), (3, 33.1), (4, 15.4)] {
        let mut camera = CAMERA;
        camera[i] = off;
        let python =
            Command::new("python3").arg(script).arg(folder.path()).args(camera.map(|n| n.to_string())).output();
        assert!(python.is_err() || python.is_ok_and(|output| !output.status.success()), "{camera:?} goes unnoticed");
    }
}

/// Against the ground truth of data/motorcycle.
#[test]
fn the_depth_of_known_points_is_right() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/motorcycle");
    let folder = tempfile::tempdir().unwrap();
    for name in ["left.png", "right.png"] {
        fs::copy(data.join(name), folder.path().join(name)).unwrap();
    }
    let calib = data.join("calib.txt");
    let output = run(folder.path(), &[&["--disp", "64", "--calib", calib.to_str().unwrap()], &outputs()[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let camera = [994.978, 0.193001, 31.086, 311.193, 254.877];
    let Some(said) = read_again(folder.path(), camera, Some(&data.join("disp_left.pfm"))) else { return };
    let numbers: Vec<f64> = said.split_whitespace().map(|number| number.parse().unwrap()).collect();
    // A tenth of a pixel of 38 to 91 is 0.1 to 0.3 per cent of the depth.
    assert!(numbers[0] > 250_000.0 && numbers[1] < 0.003 && numbers[2] < 0.012, "{said}");
}

#[test]
fn what_is_no_calibration_is_refused() {
    let folder = scene();
    let before = |text: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from:?}");
        text.replacen(from, to, 1).into_bytes()
    };
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (b"".to_vec(), "empty"),
        (b"hello".to_vec(), "no named value"),
        (vec![0xff, 0xfe, 0, 1], "not text"),
        (b"{ unclosed".to_vec(), "YAML"),
        (b"a: [1, 2".to_vec(), "YAML"),
        ("[".repeat(100_000).into_bytes(), "YAML"),
        ("- ".repeat(100_000).into_bytes(), "deep"),
        (b"a: &x [1]\nb: *x\n".to_vec(), "no known kind"),
        (b"a: 1\n".to_vec(), "no known kind"),
        (b"<opencv_storage><P1>".to_vec(), "XML"),
        (b"<opencv_storage></opencv_storage>".to_vec(), "no named value"),
        (vec![b'#'; (1 << 20) + 1], "bytes"),
        (before(MIDDLEBURY, "baseline", "base"), "no baseline"),
        (before(MIDDLEBURY, "cam1", "cam2"), "no cam1"),
        (before(MIDDLEBURY, "cam0=[100", "cam0=[-100"), "focal length is -100"),
        (before(MIDDLEBURY, "cam0=[100", "cam0=[0"), "focal length is 0"),
        (before(MIDDLEBURY, "cam0=[100", "cam0=[nan"), "not finite"),
        (before(MIDDLEBURY, "cam0=[100", "cam0=[101"), "101 and 100"),
        (before(MIDDLEBURY, "0 100 15.5", "0 110 15.5"), "square"),
        (before(MIDDLEBURY, "; 0 0 1]", "]"), "6 numbers"),
        (before(MIDDLEBURY, "baseline=500", "baseline=-500"), "exchange"),
        (before(MIDDLEBURY, "baseline=500", "baseline=0"), "both cameras are one"),
        (before(MIDDLEBURY, "baseline=500", "baseline=5e9"), "baseline"),
        (before(MIDDLEBURY, "baseline=500", "baseline=five"), "\"five\" is not a number"),
        (before(MIDDLEBURY, "doffs=1.5", "doffs=9"), "doffs is 9"),
        (before(MIDDLEBURY, "width=67", "width=134"), "134x31"),
        (before(MIDDLEBURY, "width=67", "width=6.5"), "not a size"),
        (before(KITTI, "P3", "X3"), "no P3"),
        (before(KITTI, "34.5 -45.5", "34.5"), "11 numbers"),
        (before(KITTI, "-45.5", "inf"), "not finite"),
        (before(OPENCV, "P2", "P3"), "no P2"),
        (before(OPENCV, "cols: 4", "cols: 5"), "3 x 5"),
        (before(OPENCV, "-50., 0., 100., 15.5, 0.", "0., 0., 100., 15.5, -50."), "lie in the columns"),
        (before(OPENCV, "-50.", ".Nan"), "Nan"),
        (before(OPENCV, "67, 31", "640, 480"), "640x480"),
        (before(Q, "2., 3.", "0., 3."), "Q"),
        (before(XML, "<cols>4</cols>", "<cols>3</cols>"), "3 x 3"),
        (ros("33.0", "0.0").into_bytes(), "--calib-right"),
    ];
    for (text, words) in cases {
        fs::write(folder.path().join("calib"), &text).unwrap();
        let output = run(folder.path(), &[&["--calib", "calib"][..], &outputs()].concat());
        let told = stderr(&output);
        let shown = String::from_utf8_lossy(&text[..text.len().min(300)]).into_owned();
        assert_eq!(output.status.code(), Some(2), "{shown}: {told}");
        assert!(told.starts_with("error: ") && told.lines().count() == 1 && !told.contains("bug"), "{shown}: {told}");
        assert!(told.contains(words), "{words:?} is not in {told}, of {shown}");
        assert!(FILES.iter().all(|file| !folder.path().join(file).exists()), "{shown}");
    }
    fs::write(folder.path().join("calib"), MIDDLEBURY).unwrap();
    fs::write(folder.path().join("calib.npy"), MIDDLEBURY).unwrap();
    for (options, words) in [
        (&["--depth", "depth.npy"][..], "--calib"),
        (&["--points", "scene.ply"], "--calib"),
        (&["--calib", "calib", "--points", "scene.xyz"], ".ply or .pcd"),
        (&["--calib", "calib", "--depth", "depth.jpg"], ".jpg"),
        (&["--calib", "calib", "--depth", "left.png"], "is an input"),
        (&["--calib", "calib.npy", "--depth", "calib.npy"], "is an input"),
        (&["--calib", "missing", "--depth", "depth.npy"], "missing"),
        (&["--calib", ".", "--depth", "depth.npy"], "regular file"),
        (&["--calib", "calib", "--calib-right", "calib", "--depth", "depth.npy"], "drop it"),
        (&["--calib", "calib", "--focal", "3", "--baseline", "1", "--depth", "depth.npy"], "cannot be used with"),
        (&["--focal", "-3", "--baseline", "1", "--depth", "depth.npy"], "--focal is -3"),
        (&["--focal", "NaN", "--baseline", "1", "--depth", "depth.npy"], "--focal is NaN"),
        (&["--focal", "3", "--baseline", "0", "--depth", "depth.npy"], "--baseline is 0"),
        (&["--focal", "3", "--depth", "depth.npy"], "--baseline"),
    ] {
        let output = run(folder.path(), options);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {told}");
        assert!(
            told.starts_with("error: ") && told.lines().count() == 1 && told.contains(words),
            "{options:?}: {told}"
        );
    }
    let output = run(folder.path(), &["--calib", "calib", "-o", "map.npy"]);
    assert!(output.status.success() && stderr(&output).contains("have no effect"), "{}", stderr(&output));
}

/// A file of OpenCV with lenses: the camera matrices have these columns of the principal points, `more` replaces lines.
fn lenses(columns: [f64; 2], more: &[(&str, &str)]) -> String {
    let matrix = |name: &str, rows: usize, cols: usize, data: &str| {
        format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n")
    };
    let mut text = "%YAML:1.0\n---\n".to_string();
    for (i, column, shift) in [(1, columns[0], "33., 0."), (2, columns[1], "34.5, -50.")] {
        text += &matrix(&format!("M{i}"), 3, 3, &format!("100., 0., {column}, 0., 100., 15.5, 0., 0., 1."));
        text += &matrix(&format!("D{i}"), 1, 5, "0., 0., 0., 0., 0.");
        text += &matrix(&format!("R{i}"), 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.");
        text += &matrix(&format!("P{i}"), 3, 4, &format!("100., 0., {shift}, 0., 100., 15.5, 0., 0., 0., 1., 0."));
    }
    for (from, to) in more {
        assert!(text.contains(from), "{from:?}");
        text = text.replacen(from, to, 1);
    }
    text
}

#[test]
fn a_pair_is_rectified_before_it_is_matched() {
    let folder = scene();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    let done = |args: &[&str]| {
        let output = run(folder.path(), args);
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
    };
    write("calib.txt", MIDDLEBURY);
    done(&[&["--calib", "calib.txt"], &outputs()[..]].concat());
    let plain: Vec<_> = ["map.npy"].iter().chain(&FILES).map(|name| read(name)).collect();

    // Cameras that are rectified already change nothing.
    write("still.yml", &lenses([33.0, 34.5], &[]));
    done(&[&["--rectify", "still.yml"], &outputs()[..]].concat());
    let same: Vec<_> = ["map.npy"].iter().chain(&FILES).map(|name| read(name)).collect();
    assert!(plain == same, "a rectification that moves nothing changes something");

    // The same scene, 3 and 5 columns to the right: the principal points are, too. A file a camera, as in ROS.
    for (name, columns) in [("left.png", 3), ("right.png", 5)] {
        let given = image::open(folder.path().join(name)).unwrap().to_rgb8();
        let moved = RgbImage::from_fn(67, 31, |x, y| *given.get_pixel(x.saturating_sub(columns), y));
        moved.save(folder.path().join(name)).unwrap();
    }
    let info = |cx: &str, column: &str, shift: &str| {
        let three = "  rows: 3\n  cols: 3\n";
        format!(
            "{}distortion_model: plumb_bob\ncamera_matrix:\n{three}  data: [100, 0, {cx}, 0, 100, 15.5, 0, 0, 1]\n\
             distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n\
             rectification_matrix:\n{three}  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n",
            ros(column, shift)
        )
    };
    write("left.yaml", &info("36", "33.0", "0.0"));
    write("right.yaml", &info("39.5", "34.5", "-50.0"));
    write("moved.yml", &lenses([36.0, 39.5], &[]));
    for options in [&["--rectify", "moved.yml"][..], &["--rectify", "left.yaml", "--calib-right", "right.yaml"]] {
        done(&[options, &["-o", "map.npy"], &ROUGH].concat());
        let found = read("map.npy");
        assert_eq!(found.len(), plain[0].len());
        let values =
            |bytes: &[u8]| bytes[bytes.len() - 4 * 67 * 31..].chunks(4).map(<[u8]>::to_vec).collect::<Vec<_>>();
        let inner =
            values(&found).into_iter().zip(values(&plain[0])).enumerate().filter(|(i, _)| (12..55).contains(&(i % 67)));
        let (same, all) = inner.fold((0, 0), |(same, all), (_, (a, b))| (same + usize::from(a == b), all + 1));
        assert!(same * 100 > all * 95, "{options:?}: {same} of {all} pixels");
    }
    // The same from R and T, in two files: both principal points come to lie in the middle, so that the map is of another
    // doffs, by what they are apart.
    let between = "%YAML:1.0\n---\nR: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0., 0., 0., 1., 0., 0., \
        0., 1. ]\nT: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ -0.5, 0., 0. ]\n";
    write("extrinsics.yml", between);
    let lenses = lenses([36.0, 39.0], &[("---\n", "---\nsize: [ 67, 31 ]\n")]);
    write(
        "intrinsics.yml",
        &lenses.replace("R1:", "x1:").replace("R2:", "x2:").replace("P1:", "x3:").replace("P2:", "x4:"),
    );
    done(&["--rectify", "extrinsics.yml", "--calib-right", "intrinsics.yml", "-o", "map.npy", "--depth", "depth.npy"]);
    let values = |bytes: &[u8]| -> Vec<f32> {
        let data = &bytes[bytes.len() - 4 * 67 * 31..];
        data.chunks(4).map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]])).collect()
    };
    let (map, depth) = (values(&read("map.npy")), values(&read("depth.npy")));
    let right = map.iter().zip(&depth).filter(|(d, z)| d.is_finite() && (**z - 50.0 / **d).abs() < 1e-3).count();
    assert!(right > 1000, "{right}");
    done(&["-o", "map.npy"]);
    assert!(read("map.npy") != plain[0]);
}

#[test]
fn what_is_no_rectification_is_refused() {
    let folder = scene();
    for (text, words) in [
        (lenses([33.0, 34.5], &[("M1", "X1")]), "no M1"),
        (lenses([33.0, 34.5], &[("R2", "X2")]), "no R2"),
        (lenses([33.0, 34.5], &[("R1", "R"), ("P1", "T")]), "3 x 4"),
        (lenses([33.0, 34.5], &[("R1", "R"), ("P1", "T"), ("---\n", "---\nsize: [ 67, 31 ]\n")]), "3 x 4"),
        (lenses([33.0, 34.5], &[("P2", "X2")]), "no P2"),
        (lenses([33.0, 34.5], &[("cols: 5", "cols: 3"), ("0., 0., 0., 0., 0. ]", "0., 0., 0. ]")]), "1 x 3"),
        (lenses([33.0, 34.5], &[("data: [ 1., 0., 0.,", "data: [ 2., 0., 0.,")]), "no rotation"),
        (lenses([33.0, 34.5], &[("data: [ 100.,", "data: [ -100.,")]), "focal length of -100"),
        (lenses([33.0, 34.5], &[("---\n", "---\nimage_width: 5\nimage_height: 5\n")]), "5x5"),
        (lenses([33.0, 34.5], &[("---\n", "---\ndistortion_model: equidistant\n")]), "equidistant"),
        (MIDDLEBURY.to_string(), "no lenses"),
        (KITTI.to_string(), "no lenses"),
        (ros("33.0", "0.0"), "--calib-right"),
    ] {
        fs::write(folder.path().join("calib"), &text).unwrap();
        let output = run(folder.path(), &["--rectify", "calib", "-o", "map.npy"]);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{text}: {told}");
        assert!(
            told.starts_with("error: ") && told.lines().count() == 1 && told.contains(words),
            "{words}: {told}, {text}"
        );
        assert!(!folder.path().join("map.npy").exists(), "{text}");
    }
}

/// cli/tests/command/rectify.py, where there is OpenCV; else it says that there is none.
#[test]
fn the_rectification_is_that_of_opencv() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/command/rectify.py");
    let (code, told) = match Command::new("python3").arg("-B").arg(script).output() {
        Ok(output) => (output.status.code(), stderr(&output)),
        Err(error) => (Some(3), format!("NOT TESTED: rectify beside OpenCV, python3 does not start: {error}\n")),
    };
    match code {
        Some(0) => {}
        Some(3) => std::io::stderr().write_all(told.as_bytes()).unwrap(),
        _ => panic!("cli/tests/command/rectify.py failed:\n{told}"),
    }
}
