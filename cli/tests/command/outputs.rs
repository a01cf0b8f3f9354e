//! What every verb writes of a pair besides its map, and the cameras that it takes: the options of a single run, and the same bytes.
//!
//! On the CPU, so that no adapter is needed.

use crate::support::{is_one_line_error, on, refuses, run, scene, stderr, stdout, succeeds};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// What is written of each pair: the word of --format, what follows the name, and the option of a single run.
const KINDS: [(&str, &str, &str); 8] = [
    ("npy", ".npy", "-o"),
    ("color", "_color.png", "--color"),
    ("right-npy", "_right.npy", "--right"),
    ("right", "_right.png", "--right"),
    ("depth", "_depth.png", "--depth"),
    ("depth-tif", "_depth.tif", "--depth"),
    ("points", "_points.ply", "--points"),
    ("confidence", "_confidence.png", "--confidence"),
];

/// The lenses of the pairs of [`scene`]: rectified ones see 2 px farther to the left.
fn lenses(size: [u32; 2], baseline: f64) -> String {
    let matrix = |name: &str, rows: u32, numbers: &[f64]| {
        let columns = numbers.len() as u32 / rows;
        format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: {numbers:?}\n")
    };
    let [width, height] = size;
    let (cx, cy) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
    let mut text = format!("%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\n");
    for (side, shift) in [("1", 0.0), ("2", -50.0 * baseline)] {
        text += &matrix(&format!("M{side}"), 3, &[50.0, 0.0, cx, 0.0, 50.0, cy, 0.0, 0.0, 1.0]);
        text += &matrix(&format!("D{side}"), 1, &[0.0; 5]);
        text += &matrix(&format!("R{side}"), 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let projection = [50.0, 0.0, cx + 2.0, shift, 0.0, 50.0, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
        text += &matrix(&format!("P{side}"), 3, &projection);
    }
    text
}

/// [`scene`] with its lenses in lenses.yml, and the same pair in folders l and r.
fn folder() -> TempDir {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("lenses.yml"), lenses([48, 30], 0.1)).unwrap();
    for (side, image) in [("l", "left.png"), ("r", "right.png")] {
        fs::create_dir(at(side)).unwrap();
        fs::copy(at(image), at(side).join("a.png")).unwrap();
    }
    fs::write(at("pairs.csv"), "left,right,name\nleft.png,right.png,a\n").unwrap();
    folder
}

fn formats() -> String {
    KINDS.map(|(word, ..)| word).join(",")
}

/// What a single run writes with these options, as `maps/a` and what follows.
fn expected(folder: &Path, options: &[&str]) -> Vec<(String, Vec<u8>)> {
    fs::create_dir_all(folder.join("single")).unwrap();
    let names = KINDS.map(|(_, ending, option)| (option, format!("single/a{ending}")));
    let files: Vec<_> = names.iter().flat_map(|(option, name)| [*option, name.as_str()]).collect();
    succeeds(folder, &on("left.png", "right.png", &[options, &files, &["-q"]].concat()));
    KINDS
        .iter()
        .map(|(_, ending, _)| (format!("a{ending}"), fs::read(folder.join(format!("single/a{ending}"))).unwrap()))
        .collect()
}

#[track_caller]
fn has(folder: &Path, expected: &[(String, Vec<u8>)], of: &str) {
    for (name, bytes) in expected {
        let found = fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{of}: {name}: {error}"));
        assert!(found == *bytes, "{of}: {name} is not what a single run writes");
    }
}

const RECTIFY: [&str; 2] = ["--rectify", "lenses.yml"];
const FOCAL: [&str; 4] = ["--focal", "50", "--baseline", "0.2"];

#[test]
fn every_verb_writes_what_a_single_run_writes() {
    let folder = folder();
    let path = folder.path();
    let formats = formats();
    let plain = expected(path, &FOCAL);
    let far = [&FOCAL[..], &["--max-depth", "1.9", "--colors", "magma", "--scale-bar"]].concat();
    for options in [&RECTIFY[..], &FOCAL, &far] {
        let expected = expected(path, options);
        let is_rectified = expected != plain;
        assert_eq!(is_rectified, options != FOCAL);
        let tail = [&["--disp", "16", "--backend", "cpu", "-q", "--format", &formats], options].concat();
        for (of, verb) in [("batch", &["batch", "pairs.csv"][..]), ("video", &["video", "l", "r"])] {
            succeeds(path, &[verb, &["-o", "maps"], &tail].concat());
            has(&path.join("maps"), &expected, of);
            fs::remove_dir_all(path.join("maps")).unwrap();
        }
        let compare: &[&str] = &["compare", "left.png", "right.png", "--variants", "balanced", "sad", "--maps", "maps"];
        succeeds(path, &[compare, &tail].concat());
        for (name, bytes) in &expected {
            assert!(
                fs::read(path.join(format!("maps/1_preset_balanced{}", &name[1..]))).unwrap() == *bytes,
                "compare: {name}"
            );
            assert!(path.join(format!("maps/2_cost_sad{}", &name[1..])).exists());
        }
        fs::remove_dir_all(path.join("maps")).unwrap();
        succeeds(path, &[&["sweep", "left.png", "right.png", "--maps", "maps"], &tail[..]].concat());
        assert_eq!(fs::read_dir(path.join("maps")).unwrap().count(), KINDS.len());
        fs::remove_dir_all(path.join("maps")).unwrap();
        fs::write(
            path.join("MANIFEST.json"),
            r#"[{"set": "s", "scene": "a", "left": "left.png", "right": "right.png"}]"#,
        )
        .unwrap();
        succeeds(path, &[&["bench", "MANIFEST.json", "--layout", "manifest", "--maps", "maps"], &tail[..]].concat());
        has(&path.join("maps/s"), &expected, "bench");
        fs::remove_dir_all(path.join("maps")).unwrap();
    }
}

#[test]
fn the_right_map_holds_what_the_right_view_shows() {
    let folder = folder();
    let options = ["--right", "right.npy", "-o", "left.npy", "--p1", "21"];
    succeeds(folder.path(), &on("left.png", "right.png", &options));
    let read = |name: &str| -> Vec<f32> {
        let file = npyz::NpyFile::new(fs::File::open(folder.path().join(name)).unwrap()).unwrap();
        assert_eq!(file.shape(), [30, 48]);
        file.into_vec().unwrap()
    };
    let right = read("right.npy");
    // At the right view's left border the partner lies at column 5, at its right border outside.
    let known = |x: usize| (0..30).filter(|y| right[y * 48 + x] == 5.0).count();
    assert!(known(1) > 25 && known(30) > 25, "{} {}", known(1), known(30));
    assert!(known(46) < 15, "{}", known(46));
}

#[test]
fn frames_of_other_sizes_are_fitted_one_by_one() {
    let folder = folder();
    let path = folder.path();
    for (side, image) in ["left", "right"].into_iter().zip(crate::support::pair(60, 40)) {
        image.save(path.join(format!("{side}2.png"))).unwrap();
    }
    fs::write(
        path.join("pairs.csv"),
        "left,right,name\nleft.png,right.png,a\nleft2.png,right2.png,b\nleft.png,right.png,c\n",
    )
    .unwrap();
    let tail = ["--disp", "16", "--backend", "cpu", "-o", "maps", "--format", "depth-npy,points"];
    // Typed cameras have their principal point in the middle of each size.
    succeeds(path, &[&["batch", "pairs.csv"], &tail[..], &FOCAL].concat());
    for (name, left, right) in
        [("a", "left.png", "right.png"), ("b", "left2.png", "right2.png"), ("c", "left.png", "right.png")]
    {
        let single = [&FOCAL[..], &["--depth", "d.npy", "--points", "p.ply"]].concat();
        succeeds(path, &on(left, right, &single));
        for (one, other) in [("d.npy", format!("maps/{name}_depth.npy")), ("p.ply", format!("maps/{name}_points.ply"))]
        {
            assert!(fs::read(path.join(one)).unwrap() == fs::read(path.join(&other)).unwrap(), "{other}");
        }
    }
    fs::remove_dir_all(path.join("maps")).unwrap();
    // A calibration of one size fits the others or fails for them alone.
    let output = run(path, &[&["batch", "pairs.csv"], &tail[..], &RECTIFY].concat());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("the images are 60x40, but the calibration is of 48x30"), "{}", stderr(&output));
    assert!(stdout(&output).contains("2 done, 1 failed"), "{}", stdout(&output));
}

#[test]
fn the_frames_of_a_video_are_refused_together() {
    let folder = folder();
    fs::write(folder.path().join("lenses.yml"), lenses([96, 60], 0.1)).unwrap();
    let args = ["video", "l", "r", "-o", "maps", "--disp", "16", "--backend", "cpu", "--rectify", "lenses.yml"];
    let output = run(folder.path(), &args);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("give --calib-scale 0.5"), "{}", stderr(&output));
}

#[test]
fn resume_compares_the_cameras() {
    let folder = folder();
    let path = folder.path();
    let args = |more: &[&'static str]| {
        let all = ["batch", "pairs.csv", "-o", "maps", "--disp", "16", "--backend", "cpu", "--resume", "--json"];
        [&all, more].concat()
    };
    let told =
        |more: &[&'static str]| -> Value { serde_json::from_str(&stdout(&succeeds(path, &args(more)))).unwrap() };
    assert_eq!(told(&RECTIFY)["done"], 1);
    assert_eq!(told(&RECTIFY)["skipped"], 1);
    // The same numbers in a file of another name are the same cameras.
    fs::rename(path.join("lenses.yml"), path.join("other.yml")).unwrap();
    assert_eq!(told(&["--rectify", "other.yml"])["skipped"], 1);
    assert_eq!(told(&["--rectify", "other.yml", "--format", "png,depth"])["done"], 1);
    fs::write(path.join("lenses.yml"), lenses([48, 30], 0.2)).unwrap();
    for more in [&RECTIFY[..], &[]] {
        is_one_line_error(&run(path, &args(more)), &["maps made with other settings", "cameras"]);
    }
    // bench keeps a scene only with the same cameras.
    fs::write(path.join("MANIFEST.json"), r#"[{"set": "s", "scene": "a", "left": "left.png", "right": "right.png"}]"#)
        .unwrap();
    let bench = |more: &[&'static str]| {
        let all = ["bench", "MANIFEST.json", "--layout", "manifest", "--disp", "16", "--backend", "cpu", "--json"];
        let found: Value = serde_json::from_str(&stdout(&succeeds(
            path,
            &[&all[..], &["--report", "report", "--resume"], more].concat(),
        )))
        .unwrap();
        found["scenes"][0]["valid"].as_f64().unwrap()
    };
    let plain = bench(&[]);
    assert!(bench(&RECTIFY) < plain && bench(&[]) == plain);
}

#[test]
fn what_is_missing_is_said() {
    let folder = folder();
    let path = folder.path();
    for (args, words) in [
        (
            &["batch", "pairs.csv", "-o", "maps", "--format", "depth"][..],
            &["a depth needs the cameras", "--calib FILE"][..],
        ),
        (&["video", "l", "r", "-o", "maps", "--format", "points"], &["points needs the cameras", "--calib FILE"]),
        (&["compare", "left.png", "right.png", "--variants", "sad", "--format", "depth"], &["add --maps FOLDER"]),
        (&["batch", "pairs.csv", "-o", "maps", "--depth", "d.png"], &["use --format depth", "NAME_depth.png"]),
        (&["compare", "left.png", "right.png", "--points", "p.ply"], &["use --maps <FOLDER> --format points"]),
        (&["batch", "pairs.csv", "-o", "maps", "--format", "deph"], &["a similar value is depth"]),
        (&["batch", "pairs.csv", "-o", "maps", "--rectify", "missing.yml"], &["missing.yml"]),
        (&["compare", "left.png", "right.png", "--variants", "sad", "--lens", "fisheye"], &["--rectify"]),
        (&["left.png", "right.png", "--right", "map.jpg"], &[".jpg"]),
        (&["left.png", "right.png", "--right", "map.npy", "-o", "map.npy"], &["is given twice"]),
        (&["left.png", "right.png", "--right", "right.png"], &["is an input"]),
    ] {
        refuses(path, &[args, &["--disp", "16", "--backend", "cpu"]].concat(), words);
    }
    // A calibration is an input: no map replaces it.
    fs::write(path.join("l/a.npy"), lenses([48, 30], 0.1)).unwrap();
    let args = ["video", "l", "r", "-o", "l", "--format", "npy", "--rectify", "l/a.npy", "--disp", "16"];
    let output = run(path, &args);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("is an input"), "{}", stderr(&output));
    // Cameras that nothing needs are reported.
    let output = succeeds(
        path,
        &[&["batch", "pairs.csv", "-o", "maps", "--disp", "16", "--backend", "cpu"], &FOCAL[..]].concat(),
    );
    assert!(stderr(&output).contains("note: the cameras have no effect"), "{}", stderr(&output));
}

/// The floats of an array.
fn floats(folder: &Path, name: &str) -> Vec<f32> {
    npyz::NpyFile::new(fs::File::open(folder.join(name)).unwrap()).unwrap().into_vec().unwrap()
}

fn picture(folder: &Path, name: &str) -> image::DynamicImage {
    image::open(folder.join(name)).unwrap()
}

#[test]
fn pictures_have_the_colours_that_were_asked_for() {
    let folder = folder();
    let path = folder.path();
    succeeds(path, &on("left.png", "right.png", &["-o", "map.npy", "--color", "turbo.png"]));
    let map = floats(path, "map.npy");
    assert!(map.iter().any(|d| d.is_nan()) && map.iter().any(|d| d.is_finite()));
    for (name, colors) in gpu_stereo::Colors::ALL {
        let file = format!("{name}.png");
        succeeds(path, &on("left.png", "right.png", &["--color", &file, "--colors", name]));
        let drawn = picture(path, &file).into_rgb8();
        assert_eq!(drawn.dimensions(), (48, 30));
        for (pixel, disparity) in drawn.pixels().zip(&map) {
            let expected = if disparity.is_nan() { [0; 3] } else { colors.at(f64::from(*disparity) / 15.0) };
            assert_eq!(pixel.0, expected, "{name}");
        }
    }
    // A bar stands beside the picture, in px or in metres, and changes nothing of it.
    let bars = [&[][..], &FOCAL].map(|cameras: &[&str]| {
        let args = [&["--color", "bar.png", "--scale-bar"], cameras].concat();
        succeeds(path, &on("left.png", "right.png", &args));
        let bar = picture(path, "bar.png").into_rgb8();
        let plain = picture(path, "turbo.png").into_rgb8();
        assert!(plain.enumerate_pixels().all(|(x, y, pixel)| bar.get_pixel(x, y) == pixel));
        bar
    });
    assert!(bars[0].width() > 60 && bars[0] != bars[1]);
    let output = succeeds(path, &on("left.png", "right.png", &["-o", "map.npy", "--scale-bar"]));
    assert!(stderr(&output).contains("no effect without a picture"), "{}", stderr(&output));
    // The sheet of several maps has them, too.
    let tail = ["--disp", "16", "--backend", "cpu", "-o", "sheet.png", "--colors", "gray"];
    succeeds(path, &[&["compare", "left.png", "right.png", "--variants", "sad"], &tail[..]].concat());
    let is_gray = picture(path, "sheet.png").into_rgb8().pixels().all(|p| p.0[0] == p.0[1] && p.0[1] == p.0[2]);
    assert!(is_gray, "left image and maps of a gray pair in gray");
}

#[test]
fn nothing_is_farther_away_than_allowed() {
    let folder = folder();
    let path = folder.path();
    let depths = |more: &[&str]| {
        succeeds(
            path,
            &on("left.png", "right.png", &[&FOCAL[..], &["--depth", "d.npy", "--points", "p.ply"], more].concat()),
        );
        let points = fs::read(path.join("p.ply")).unwrap();
        (floats(path, "d.npy"), points.len())
    };
    let (all, size) = depths(&[]);
    // 5 px are 2 m away.
    let farther = all.iter().filter(|d| **d > 2.0).count();
    assert!(farther > 0 && farther < all.len() / 2, "{farther}");
    let (cut, smaller) = depths(&["--max-depth", "2"]);
    for (cut, all) in cut.iter().zip(&all) {
        assert!(if *all > 2.0 { cut.is_nan() } else { cut.to_bits() == all.to_bits() }, "{cut} {all}");
    }
    let header = |size: usize| size.ilog10() as usize; // the number of points in the header may lose a digit
    assert!((size - smaller).abs_diff(15 * farther) <= header(size), "{size} {smaller} {farther}");
}

#[test]
fn the_rectified_pair_is_written_as_it_is_matched() {
    let folder = folder();
    let path = folder.path();
    let args = [&RECTIFY[..], &["--rectified", "a.png,b.png"]].concat();
    succeeds(path, &on("left.png", "right.png", &args));
    // The rectified cameras see 2 px farther to the left.
    for (given, rectified) in [("left.png", "a.png"), ("right.png", "b.png")] {
        let (given, rectified) = (picture(path, given).into_luma8(), picture(path, rectified));
        assert!(matches!(rectified, image::DynamicImage::ImageLuma8(_)), "{rectified:?}");
        for (x, y, pixel) in rectified.into_luma8().enumerate_pixels() {
            assert_eq!(pixel.0[0], if x < 2 { 0 } else { given.get_pixel(x - 2, y).0[0] }, "({x}, {y})");
        }
    }
    // Colours and 16 bits stay.
    let deep = |name: &str| {
        image::DynamicImage::from(picture(path, name).into_rgb16()).save(path.join(format!("deep_{name}")))
    };
    deep("left.png").unwrap();
    deep("right.png").unwrap();
    let batch = ["batch", "deep.csv", "-o", "maps", "--disp", "16", "--backend", "cpu", "--format"];
    fs::write(path.join("deep.csv"), "deep_left.png,deep_right.png,a\n").unwrap();
    succeeds(path, &[&batch[..], &["rectified-left,rectified-right"], &RECTIFY].concat());
    succeeds(path, &on("deep_left.png", "deep_right.png", &args));
    for (one, other) in [("a.png", "maps/a_rectified_left.png"), ("b.png", "maps/a_rectified_right.png")] {
        assert!(matches!(picture(path, one), image::DynamicImage::ImageRgb16(_)));
        assert!(fs::read(path.join(one)).unwrap() == fs::read(path.join(other)).unwrap());
    }
    for (args, words) in [
        (&["--rectified", "a.png,b.png"][..], &["nothing rectifies them", "--rectify FILE"][..]),
        (&["--rectified", "a.png", "--rectify", "lenses.yml"], &["LEFT,RIGHT", "one comma"]),
        (&["--rectified", "a.png,b.jpg", "--rectify", "lenses.yml"], &["--rectified is \"b.jpg\"", ".png"]),
        (&["--max-depth", "0"], &["--max-depth is 0", "above 0"]),
        (&["--max-depth", "nan"], &["--max-depth is NaN"]),
        (&["--colors", "turb"], &["a similar value is turbo"]),
    ] {
        refuses(path, &on("left.png", "right.png", args), words);
    }
}

#[test]
fn a_part_is_matched_as_if_it_were_all() {
    let folder = folder();
    let path = folder.path();
    let [x, y, width, height] = [7, 3, 33, 20];
    for name in ["left.png", "right.png"] {
        picture(path, name).crop_imm(x, y, width, height).save(path.join(format!("part_{name}"))).unwrap();
    }
    let crop = ["--crop", "7,3,33,20"];
    let files = ["-o", "a.npy", "--right", "b.npy", "--color", "c.png", "--points", "d.ply"];
    let written = || files.iter().skip(1).step_by(2).map(|name| fs::read(path.join(name)).unwrap()).collect::<Vec<_>>();
    succeeds(path, &on("left.png", "right.png", &[&crop[..], &FOCAL, &files].concat()));
    let cropped = written();
    // The principal point of the whole is in its middle, (23.5, 14.5).
    succeeds(
        path,
        &on("part_left.png", "part_right.png", &[&FOCAL[..], &["--cx", "16.5", "--cy", "11.5"], &files].concat()),
    );
    assert!(cropped == written());
    // Of rectified pairs it is a part of the rectified images.
    let whole = [&RECTIFY[..], &["--rectified", "l.png,r.png"]].concat();
    succeeds(path, &on("left.png", "right.png", &whole));
    let part = [&RECTIFY[..], &crop, &["--rectified", "pl.png,pr.png", "--points", "p.ply"]].concat();
    let output = succeeds(path, &on("left.png", "right.png", &[&part[..], &["--json"]].concat()));
    for (whole, part) in [("l.png", "pl.png"), ("r.png", "pr.png")] {
        assert!(picture(path, whole).crop_imm(x, y, width, height) == picture(path, part), "{part}");
    }
    let found: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!((&found["width"], &found["height"]), (&33.into(), &20.into()));
    assert_eq!(
        (found["camera"]["cx_px"].as_f64(), found["camera"]["cy_px"].as_f64()),
        (Some(26.0 - 7.0), Some(15.0 - 3.0))
    );
    // So it is in other verbs.
    let points = fs::read(path.join("p.ply")).unwrap();
    let batch = ["batch", "pairs.csv", "-o", "maps", "--disp", "16", "--backend", "cpu", "--format", "points"];
    succeeds(path, &[&batch[..], &RECTIFY, &crop].concat());
    assert!(fs::read(path.join("maps/a_points.ply")).unwrap() == points);
    is_one_line_error(&run(path, &[&batch[..], &RECTIFY, &["--resume"]].concat()), &["other settings", "cameras"]);
    // A truth is one of the whole.
    succeeds(path, &on("left.png", "right.png", &["-o", "truth.npy"]));
    let score = |more: &[&str]| {
        let output = succeeds(path, &on("left.png", "right.png", &[&["--gt", "truth.npy", "--json"], more].concat()));
        let found: Value = serde_json::from_str(&stdout(&output)).unwrap();
        (found["evaluation"]["pixels"].as_u64().unwrap(), found["evaluation"]["average_error"].as_f64().unwrap())
    };
    let (all, part) = (score(&[]), score(&crop));
    assert!(part.0 < all.0 && part.0 <= 33 * 20 && part.1 < 0.3, "{all:?} {part:?}");
    for (args, words) in [
        (&["--crop", "20,0,29,30"][..], &["--crop is 20,0,29,30", "48x30 pixels"][..]),
        (&["--crop", "0,0,0,30"], &["four whole numbers", "100,50,640,480"]),
        (&["--crop", "1,2,3"], &["four whole numbers"]),
    ] {
        refuses(path, &on("left.png", "right.png", args), words);
    }
}
