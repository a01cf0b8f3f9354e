//! Pairs of known faults: synthetic ones, and those of ../shared/data where that is there.

use super::corners::Gray;
use super::{Evidence, Finding};
use image::{GrayImage, Luma, imageops};
use rand::{Rng as _, SeedableRng as _, rngs::StdRng};
use std::path::Path;

struct Scene {
    name: String,
    left: GrayImage,
    right: GrayImage,
    /// The range that holds its disparities, and the largest one.
    range: i32,
    largest: f64,
}

fn gray(image: &GrayImage) -> Gray {
    Gray { width: image.width() as usize, height: image.height() as usize, data: image.as_raw().clone() }
}

fn finding(left: &GrayImage, right: &GrayImage, range: i32) -> Option<Finding> {
    Evidence::of(&gray(left), &gray(right)).finding(&(0..=range - 1))
}

/// The image turned clockwise around its middle, and moved down.
fn moved(image: &GrayImage, degrees: f64, down: f64) -> GrayImage {
    let (width, height) = image.dimensions();
    let (sin, cos) = degrees.to_radians().sin_cos();
    let middle = [f64::from(width) / 2.0, f64::from(height) / 2.0];
    GrayImage::from_fn(width, height, |x, y| {
        let (u, v) = (f64::from(x) - middle[0], f64::from(y) - middle[1] - down);
        let x = (cos * u + sin * v + middle[0]).clamp(0.0, f64::from(width) - 1.001);
        let y = (cos * v - sin * u + middle[1]).clamp(0.0, f64::from(height) - 1.001);
        let (a, b) = (x.fract(), y.fract());
        let at = |dx: u32, dy: u32| f64::from(image.get_pixel(x as u32 + dx, y as u32 + dy).0[0]);
        let above = (1.0 - a) * at(0, 0) + a * at(1, 0);
        let below = (1.0 - a) * at(0, 1) + a * at(1, 1);
        Luma([((1.0 - b) * above + b * below).round() as u8])
    })
}

/// A plane with a square before it, of a texture that repeats nowhere.
fn synthetic(random: &mut StdRng) -> Scene {
    let (width, height) = (random.random_range(240..400), random.random_range(160..260));
    let (near, far) = (random.random_range(20..30), random.random_range(3..10));
    let noise = GrayImage::from_fn(width + 64, 2 * height, |_, _| Luma([random.random()]));
    let texture = imageops::blur(&noise, 1.0);
    let stretched = |x: u32, y: u32| {
        let v = (i32::from(texture.get_pixel(x, y).0[0]) - 128) * 4 + 128;
        Luma([v.clamp(0, 255) as u8])
    };
    let view = |shift: u32| {
        let (columns, rows) = (width / 3..2 * width / 3, height / 4..3 * height / 4);
        GrayImage::from_fn(width, height, |x, y| match columns.contains(&(x + shift * near)) && rows.contains(&y) {
            true => stretched(x + shift * near, y + height),
            false => stretched(x + shift * far, y),
        })
    };
    Scene { name: "synthetic".into(), left: view(0), right: view(1), range: 32, largest: near.into() }
}

/// The pairs of a manifest.
fn shared() -> Option<Vec<Scene>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let Ok(manifest) = std::fs::read(folder.join("MANIFEST.json")) else {
        eprintln!("not tested: the pairs of ../shared/data, since it is not there");
        return None;
    };
    let entries: Vec<serde_json::Value> = serde_json::from_slice(&manifest).unwrap();
    let mut scenes = Vec::new();
    for entry in &entries {
        let frames = entry["frames"].as_u64().unwrap_or(1);
        for frame in 0..frames {
            let open = |side: &str| {
                let path = entry[side].as_str().unwrap().replace("%06d", &format!("{frame:06}"));
                image::open(folder.join(path)).unwrap().into_luma8()
            };
            let largest = entry["max_disp"].as_f64();
            scenes.push(Scene {
                name: format!("{} {frame}", entry["scene"].as_str().unwrap()),
                left: open("left"),
                right: open("right"),
                range: largest.map_or(128, |largest| (largest as i32 + 16) / 16 * 16),
                largest: largest.unwrap_or(if entry["set"] == "student_report" { 10.0 } else { 64.0 }),
            });
        }
    }
    Some(scenes)
}

/// What is done to a pair, and whether the finding is the right one.
fn spoilt(scenes: &[Scene], place: usize, random: &mut StdRng) -> (String, bool) {
    let Scene { name, left, right, range, largest } = &scenes[place];
    let sign = |random: &mut StdRng| if random.random() { 1.0 } else { -1.0 };
    let (what, found, is_right): (String, _, fn(&Finding) -> bool) = match random.random_range(0..6) {
        0 => ("exchanged".into(), finding(right, left, *range), |f| matches!(f, Finding::Exchanged { .. })),
        1 => ("twice".into(), finding(left, left, *range), |f| matches!(f, Finding::Same)),
        2 => {
            let down = random.random_range(2.0..20.0) * sign(random);
            let found = finding(left, &moved(right, 0.0, down), *range);
            (format!("{down:.1} px lower"), found, |f| matches!(f, Finding::Rows { .. }))
        }
        3 => {
            let degrees = random.random_range(0.8..4.0) * sign(random);
            let found = finding(left, &moved(right, degrees, 0.0), *range);
            (format!("{degrees:.2} degrees"), found, |f| matches!(f, Finding::Rows { .. }))
        }
        4 => {
            let range = (largest / random.random_range(2.0..4.0)).max(1.0) as i32;
            (format!("range {range}"), finding(left, right, range), |f| matches!(f, Finding::Range { .. }))
        }
        _ => {
            let others: Vec<_> = scenes.iter().filter(|other| other.name[..3] != name[..3]).collect();
            let other = others[random.random_range(0..others.len())];
            let filter = imageops::FilterType::Triangle;
            let right = imageops::resize(&other.right, left.width(), left.height(), filter);
            let is_right: fn(&Finding) -> bool = |f| matches!(f, Finding::Unrelated { .. });
            (format!("with {}", other.name), finding(left, &right, *range), is_right)
        }
    };
    let told = format!("{name}, {what}: {}", found.as_ref().map_or("nothing".into(), Finding::to_string));
    (told, found.as_ref().is_some_and(is_right))
}

#[test]
fn real_pairs_are_not_accused_and_spoilt_ones_are_named() {
    let Some(scenes) = shared() else { return };
    for Scene { name, left, right, range, .. } in &scenes {
        for range in [*range, 2 * range, 256] {
            assert_eq!(finding(left, right, range), None, "{name}, range {range}");
        }
    }
    let seed = rand::rng().random();
    let mut random = StdRng::seed_from_u64(seed);
    let mut wrong = Vec::new();
    for _ in 0..60 {
        let place = random.random_range(0..scenes.len());
        let (told, is_right) = spoilt(&scenes, place, &mut random);
        if !is_right {
            wrong.push(told);
        }
    }
    assert!(wrong.len() <= 6, "seed {seed}: {wrong:#?}");
}

#[test]
fn synthetic_pairs_are_named() {
    let seed = rand::rng().random();
    let mut random = StdRng::seed_from_u64(seed);
    for _ in 0..3 {
        let Scene { left, right, range, largest, .. } = synthetic(&mut random);
        assert_eq!(finding(&left, &right, range), None, "seed {seed}");
        assert_eq!(finding(&left, &left, range), Some(Finding::Same), "seed {seed}");
        let exchanged = finding(&right, &left, range);
        assert!(matches!(exchanged, Some(Finding::Exchanged { .. })), "seed {seed}: {exchanged:?}");
        let rows = finding(&left, &moved(&right, 0.0, 6.0), range);
        let is_six = |offset: f64, degrees: f64| (offset - 6.0).abs() < 0.5 && degrees.abs() < 0.3;
        assert!(
            matches!(rows, Some(Finding::Rows { offset, degrees, .. }) if is_six(offset, degrees)),
            "{seed}: {rows:?}"
        );
        let rows = finding(&left, &moved(&right, 2.0, 0.0), range);
        let is_two = |degrees: f64| (degrees - 2.0).abs() < 0.3;
        assert!(matches!(rows, Some(Finding::Rows { degrees, .. }) if is_two(degrees)), "{seed}: {rows:?}");
        let small = finding(&left, &right, largest as i32 - 8);
        let Some(Finding::Range { needed, .. }) = &small else { panic!("seed {seed}: {small:?}") };
        assert_eq!(*needed.end(), largest as i32, "seed {seed}");
        let upside_down = finding(&left, &imageops::rotate180(&right), range);
        assert_eq!(upside_down, Some(Finding::Turned { how: "upside down" }), "seed {seed}");
        let other = synthetic(&mut random).right;
        let other = imageops::resize(&other, left.width(), left.height(), imageops::FilterType::Nearest);
        let unrelated = finding(&left, &other, range);
        assert!(matches!(unrelated, Some(Finding::Unrelated { .. })), "seed {seed}: {unrelated:?}");
        // Exposure is no fault.
        let dark = GrayImage::from_fn(right.width(), right.height(), |x, y| Luma([right.get_pixel(x, y).0[0] / 3 + 9]));
        assert_eq!(finding(&left, &dark, range), None, "seed {seed}");
    }
}

#[test]
fn what_tells_nothing_is_not_accused() {
    let flat = |gray: u8| GrayImage::from_pixel(100, 80, Luma([gray]));
    assert_eq!(finding(&flat(0), &flat(9), 16), Some(Finding::Flat { side: "left", levels: 0 }));
    let ramp = GrayImage::from_fn(100, 80, |x, _| Luma([2 * x as u8]));
    let shifted = GrayImage::from_fn(100, 80, |x, _| Luma([2 * x as u8 + 6]));
    assert_eq!(finding(&ramp, &shifted, 16), None);
    // A pattern that repeats has no corner with one partner.
    let mut random = StdRng::seed_from_u64(5);
    let tile = GrayImage::from_fn(40, 40, |_, _| Luma([random.random()]));
    let tiled = |shift: u32| GrayImage::from_fn(320, 240, |x, y| *tile.get_pixel((x + shift) % 40, y % 40));
    assert_eq!(finding(&tiled(0), &tiled(6), 16), None);
    for (width, height) in [(1, 1), (7, 300), (24, 24), (25, 25)] {
        let of = |seed: u32| GrayImage::from_fn(width, height, |x, y| Luma([(x * 37 + y * 91 + seed * x * y) as u8]));
        Evidence::of(&gray(&of(3)), &gray(&of(5))).finding(&(0..=15));
    }
}
