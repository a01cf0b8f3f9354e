//! `--mask-in` and `--rectify` as a user meets them: what has no content has no disparity in any file, and what is no mask is
//! refused.

use crate::support::{SHIFT, contents, is_one_line_error, pair, refuses, run, stderr, stdout, succeeds};
use image::{GrayImage, Luma, LumaA, Rgb, RgbImage};
use std::fs;
use std::path::Path;

const SIZE: (u32, u32) = (64, 40);

/// Hidden: of the left image the right third, of the right image rows 10 to 14.
fn hides(side: usize, x: u32, y: u32) -> bool {
    if side == 0 { x >= 43 } else { (10..15).contains(&y) }
}

/// Whether a pixel that is [`SHIFT`] apart keeps its disparity.
fn stays(x: u32, y: u32) -> bool {
    !hides(0, x, y) && !hides(1, x, y)
}

fn mask(side: usize) -> GrayImage {
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([if hides(side, x, y) { 0 } else { 1 + (x + y) as u8 }]))
}

fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (side, image) in pair(SIZE.0, SIZE.1).into_iter().enumerate() {
        image.save(folder.path().join(["left.png", "right.png"][side])).unwrap();
        mask(side).save(folder.path().join(["lm.png", "rm.png"][side])).unwrap();
    }
    folder
}

/// A map of 32-bit floats, NaN where there is none.
fn npy(path: &Path) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    let header = bytes.len() - 4 * (SIZE.0 * SIZE.1) as usize;
    bytes[header..].chunks(4).map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]])).collect()
}

const RUN: [&str; 6] = ["left.png", "right.png", "--disp", "16", "--backend", "cpu"];

fn with<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [&RUN[..], args].concat()
}

#[test]
fn every_file_follows_the_masks() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    let truth = vec![SHIFT as f32; (SIZE.0 * SIZE.1) as usize];
    let mut pfm = format!("Pf\n{} {}\n-1\n", SIZE.0, SIZE.1).into_bytes();
    pfm.extend(truth.iter().flat_map(|v| v.to_le_bytes()));
    fs::write(at("truth.pfm"), pfm).unwrap();
    for preset in ["dense", "classic"] {
        let outputs: [&[&str]; 3] = [
            &["-o", "map.npy", "-o", "map.png", "--mask", "valid.png", "--confidence", "sure.png"],
            &["--depth", "depth.npy", "--points", "scene.ply", "--focal", "100", "--baseline", "1"],
            &["--gt", "truth.pfm", "--json", "--preset", preset, "--mask-in", "lm.png,rm.png"],
        ];
        let output = succeeds(folder.path(), &with(&outputs.concat()[..]));
        assert_eq!(stderr(&output), "");
        let map = npy(&at("map.npy"));
        let depth = npy(&at("depth.npy"));
        let valid = image::open(at("valid.png")).unwrap().into_luma8();
        let sure = image::open(at("sure.png")).unwrap().into_luma8();
        let kitti = image::open(at("map.png")).unwrap().into_luma16();
        let mut count = 0;
        for (i, &disparity) in map.iter().enumerate() {
            let (x, y) = (i as u32 % SIZE.0, i as u32 / SIZE.0);
            let has = disparity.is_finite();
            count += usize::from(has);
            assert!(stays(x, y) || !has, "{preset}: ({x}, {y}) has {disparity}");
            assert!(has || !stays(x, y) || preset == "classic", "({x}, {y}) is not filled");
            assert_eq!(valid.get_pixel(x, y)[0], if has { 255 } else { 0 });
            assert_eq!((sure.get_pixel(x, y)[0] > 0, kitti.get_pixel(x, y)[0] > 0), (has, has));
            assert_eq!(depth[i].is_finite(), has);
        }
        assert!(count > 1000);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let share = count as f64 / map.len() as f64;
        assert!((json["valid"].as_f64().unwrap() - share).abs() < 1e-9);
        let evaluation = json["evaluation"].to_string();
        let density = json["evaluation"]["density"].as_f64().unwrap_or_else(|| panic!("{evaluation}"));
        assert!((density - share).abs() < 1e-6 || (density - 100.0 * share).abs() < 1e-4, "{evaluation}, {share}");
        let points = fs::read(at("scene.ply")).unwrap();
        let head = String::from_utf8_lossy(&points[..points.len().min(400)]).into_owned();
        assert!(head.contains(&format!("element vertex {count}\n")), "{head}");
    }
    // Without masks all is there.
    succeeds(folder.path(), &with(&["--preset", "dense", "-o", "map.npy"]));
    assert!(npy(&at("map.npy")).iter().all(|v| v.is_finite()));
}

/// One side or the other, whatever the samples are: only what is 0 hides.
#[test]
fn masks_of_every_kind_say_the_same() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    let of = |given: &str| {
        succeeds(folder.path(), &with(&["--preset", "dense", "-o", "map.npy", "--mask-in", given]));
        npy(&at("map.npy"))
    };
    let left = of("lm.png");
    for (i, value) in left.iter().enumerate() {
        assert_eq!(value.is_finite(), !hides(0, i as u32 % SIZE.0, 0), "{i}");
    }
    let right = of(",rm.png");
    for (i, value) in right.iter().enumerate() {
        assert_eq!(value.is_finite(), !hides(1, 0, i as u32 / SIZE.0), "{i}");
    }
    let (w, h) = SIZE;
    RgbImage::from_fn(w, h, |x, y| Rgb([0, 0, u8::from(!hides(0, x, y))])).save(at("blue.png")).unwrap();
    image::ImageBuffer::from_fn(w, h, |x, y| Luma([u16::from(!hides(0, x, y))])).save(at("deep.png")).unwrap();
    let clear = image::ImageBuffer::from_fn(w, h, |x, y| LumaA([u8::from(!hides(0, x, y)), 0u8]));
    clear.save(at("clear.png")).unwrap();
    mask(0).save(at("a,b.png")).unwrap();
    mask(0).save(at("l.pgm")).unwrap();
    let bits: String = (0..w * h).map(|i| if hides(0, i % w, 0) { "1 " } else { "0 " }).collect();
    fs::write(at("bits.pbm"), format!("P1\n{w} {h}\n{bits}\n")).unwrap(); // 1 is black
    for other in ["blue.png", "deep.png", "clear.png", "a,b.png", "l.pgm", "bits.pbm", "lm.png,"] {
        let found = of(other);
        assert!(found.iter().zip(&left).all(|(a, b)| a.to_bits() == b.to_bits()), "{other}");
    }
    let both = of("a,b.png,rm.png");
    assert!((0..w * h).all(|i| both[i as usize].is_nan() || stays(i % w, i / w)));
    assert!(both.iter().zip(&right).any(|(a, b)| a.is_finite() != b.is_finite()));
    // A mask that hides nothing changes nothing; one that hides all says so.
    GrayImage::from_pixel(w, h, Luma([255])).save(at("all.png")).unwrap();
    GrayImage::new(w, h).save(at("none.png")).unwrap();
    succeeds(folder.path(), &with(&["-o", "plain.npy"]));
    succeeds(folder.path(), &with(&["-o", "all.npy", "--mask-in", "all.png,all.png"]));
    assert!(fs::read(at("plain.npy")).unwrap() == fs::read(at("all.npy")).unwrap());
    let output = succeeds(folder.path(), &with(&["-o", "none.npy", "--mask-in", "none.png", "--json"]));
    assert!(stderr(&output).contains("none.png") && stderr(&output).lines().count() == 1, "{}", stderr(&output));
    assert!(stdout(&output).contains("0 (no content) everywhere"), "{}", stdout(&output));
    assert!(npy(&at("none.npy")).iter().all(|v| v.is_nan()));
}

#[test]
fn what_is_no_mask_is_refused() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    GrayImage::new(SIZE.1, SIZE.0).save(at("turned.png")).unwrap();
    fs::write(at("text.png"), "no image").unwrap();
    for name in ["p", "q", "p,q", "q,p"] {
        mask(0).save(at("x.png")).unwrap();
        fs::rename(at("x.png"), at(name)).unwrap();
    }
    for (given, words) in [
        ("turned.png", &["turned.png", "40x64", "64x40"][..]),
        ("lm.png,turned.png", &["turned.png", "40x64"]),
        (",turned.png", &["turned.png", "64x40"]),
        ("missing.png", &["missing.png", "does not exist"]),
        ("lm.png,missing.png", &["missing.png", "does not exist"]),
        ("missing.png,rm.png", &["missing.png", "does not exist"]),
        ("text.png", &["text.png", "known format"]),
        (".", &["folder"]),
        (",", &["names no file"]),
        ("p,q,p", &["more than one"]),
    ] {
        refuses(folder.path(), &with(&["-o", "map.npy", "--mask-in", given]), words);
        let words = words.iter().copied().filter(|word| *word != "64x40").collect::<Vec<_>>();
        refuses(folder.path(), &[&["sweep"], &with(&["-o", "s.png", "--mask-in", given])[..]].concat(), &words);
    }
    refuses(folder.path(), &with(&["-o", "lm.png", "--mask-in", "lm.png"]), &["lm.png", "input"]);
    refuses(folder.path(), &with(&["--mask", "rm.png", "--mask-in", "lm.png,rm.png"]), &["rm.png", "input"]);
    refuses(
        folder.path(),
        &[
            "compare",
            "left.png",
            "right.png",
            "--disp",
            "16",
            "--variants",
            "bm",
            "--mask-in",
            "lm.png",
            "-o",
            "lm.png",
        ],
        &["input"],
    );
    let output = run(folder.path(), &["bench", ".", "--layout", "manifest", "--mask-in", "lm.png"]);
    is_one_line_error(&output, &["--mask-in"]);
}

/// The same mask for all pairs of its size; another mask is another setting.
#[test]
fn folders_and_sheets_take_masks() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    succeeds(folder.path(), &with(&["-o", "single.npy", "--mask-in", "lm.png,rm.png"]));
    let single = fs::read(at("single.npy")).unwrap();
    for side in ["l", "r"] {
        fs::create_dir(at(side)).unwrap();
        let (name, small) = if side == "l" { ("left.png", 0) } else { ("right.png", 1) };
        for frame in ["1.png", "3.png"] {
            fs::copy(at(name), at(side).join(frame)).unwrap();
        }
        pair(30, 20)[small].save(at(side).join("2.png")).unwrap();
    }
    let end = ["--disp", "16", "--backend", "cpu", "--format", "npy", "--mask-in"];
    for verb in ["video", "batch"] {
        let args = |mask: &'static str| [&[verb, "l", "r", "-o", verb], &end[..], &[mask]].concat();
        let output = run(folder.path(), &args("lm.png,rm.png"));
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains("30x20"), "{}", stderr(&output));
        for frame in ["1.npy", "3.npy"] {
            assert!(fs::read(at(verb).join(frame)).unwrap() == single, "{verb} {frame}");
        }
        assert!(!at(verb).join("2.npy").exists());
        // What is there is kept only with the same masks.
        let before = contents(&at(verb));
        let told = run(folder.path(), &[&args("lm.png")[..], &["--resume"]].concat());
        is_one_line_error(&told, &["mask-in"]);
        assert!(contents(&at(verb)) == before);
        let again = run(folder.path(), &[&args("lm.png,rm.png")[..], &["--resume"]].concat());
        // The frames of a video are all as the first one that is missing.
        let told = stdout(&again) + &stderr(&again);
        assert!(told.contains(if verb == "video" { "30x20" } else { "2 there already" }), "{told}");
        let kept = contents(&at(verb));
        assert!(before.iter().filter(|(path, _)| path.ends_with("1.npy")).all(|(path, map)| kept[path] == *map));
    }
    let variants = ["compare", "left.png", "right.png", "--disp", "16", "--backend", "cpu", "--variants", "dense"];
    let share = |more: &[&str]| {
        let output = succeeds(folder.path(), &[&variants[..], &["--json", "-o", "sheet.png"], more].concat());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["variants"][0]["valid"].as_f64().unwrap()
    };
    assert_eq!(share(&[]), 1.0);
    let masked = share(&["--mask-in", "lm.png,rm.png"]);
    let all = (0..SIZE.0 * SIZE.1).filter(|i| stays(i % SIZE.0, i / SIZE.0)).count();
    assert!((masked - all as f64 / f64::from(SIZE.0 * SIZE.1)).abs() < 0.01, "{masked}");
}

/// A calibration that shows more than the images do, and a mask of the given images.
#[test]
fn nothing_outside_the_given_images_has_a_disparity() {
    let folder = scene();
    let matrix = |name: &str, rows: usize, cols: usize, data: &str| {
        format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n")
    };
    let mut text = "%YAML:1.0\n---\n".to_string();
    for (i, shift) in [(1, "0."), (2, "-14.")] {
        text += &matrix(&format!("M{i}"), 3, 3, "100., 0., 32., 0., 100., 20., 0., 0., 1.");
        text += &matrix(&format!("D{i}"), 1, 5, "0., 0., 0., 0., 0.");
        text += &matrix(&format!("R{i}"), 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.");
        text += &matrix(&format!("P{i}"), 3, 4, &format!("70., 0., 32., {shift}, 0., 70., 20., 0., 0., 0., 1., 0."));
    }
    fs::write(folder.path().join("stereo.yml"), text).unwrap();
    // Where the rectified pixel (x, y) comes from.
    let from = |x: u32, y: u32| ((f64::from(x) - 32.0) / 0.7 + 32.0, (f64::from(y) - 20.0) / 0.7 + 20.0);
    for (preset, more) in [
        ("balanced", &[][..]),
        ("dense", &[]),
        ("dense", &["--wls", "on"]),
        ("strict", &["--fill", "hirschmuller"]),
        ("classic", &["--fill", "background"]),
        ("fast", &["--wls", "on"]),
        ("balanced", &["--method", "bm", "--fill", "rays"]),
        ("dense", &["--mask-in", "lm.png"]),
    ] {
        let args = [&["--preset", preset, "--rectify", "stereo.yml", "-o", "map.npy"], more].concat();
        succeeds(folder.path(), &with(&args));
        let map = npy(&folder.path().join("map.npy"));
        let mut valid = 0;
        for (i, value) in map.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            let (x, y) = from(i as u32 % SIZE.0, i as u32 / SIZE.0);
            assert!((0.0..=63.0).contains(&x) && (0.0..=39.0).contains(&y), "{preset} {more:?}: {i} has {value}");
            assert!(x <= 42.0 || !more.contains(&"lm.png"), "{i} has {value}");
            valid += 1;
        }
        assert!(valid > 300, "{preset} {more:?}: {valid}");
    }
}
