//! Renders data/corridor: a rectified pair of a corridor with a sphere, a ball and a cone, and its exact ground truth.
//!
//!     cargo run --release --example render_corridor [-- DIRECTORY]
//!
//! Rays are cast analytically in f64, 8 x 8 a pixel for the pictures and one through the pixel's centre for the truth.
//! Only integer hashes, the four operations, floor and sqrt are used, which IEEE 754 defines to the bit: every
//! platform writes the same files.

use std::path::Path;

use image::ExtendedColorType;
use rayon::prelude::*;

mod caster;

use caster::{Shape, V, add, dot, hash, pfm, png, unit, value_noise};

// The camera: x to the right, y downwards, z forwards, in metres; pixel centres at whole coordinates.
const WIDTH: usize = 400;
const HEIGHT: usize = 300;
const FOCAL: f64 = 400.0; // px
const CENTRE: [f64; 2] = [199.5, 149.5];
const BASELINE: f64 = 0.12;
const SAMPLES: usize = 8; // along each side of a pixel

const LEFT: f64 = 0.0; // x of the cameras
const RIGHT: f64 = BASELINE;
const LIGHT: V = [0.45, -0.45, 0.9];

/// A surface: its shape and its colour at a point.
struct Surface {
    shape: Shape,
    colour: fn(V) -> V,
}

fn scene() -> Vec<Surface> {
    let plane = |axis, at, colour| Surface { shape: Shape::Plane { axis, at }, colour };
    vec![
        plane(1, 0.55, |p| {
            // Tiles, with a joint between them.
            let (x, z) = (p[0] / 0.22, p[2] / 0.22);
            let dark = (x.floor() + z.floor()).rem_euclid(2.0) < 0.5;
            let tile = if dark { [0.30, 0.25, 0.22] } else { [0.62, 0.57, 0.50] };
            let joint = (x - x.floor()).min(z - z.floor()) < 0.05;
            speckled(if joint { [0.20, 0.19, 0.18] } else { tile }, p, 1)
        }),
        plane(1, -0.60, |p| {
            let beam = (p[2] / 0.8).rem_euclid(1.0) < 0.3;
            speckled(if beam { [0.38, 0.26, 0.16] } else { [0.66, 0.64, 0.58] }, p, 2)
        }),
        plane(0, -0.80, |p| speckled(brick(p[2], p[1], [0.52, 0.24, 0.17], 3), p, 3)),
        plane(0, 0.80, |p| speckled(brick(p[2], p[1], [0.40, 0.44, 0.30], 4), p, 4)),
        plane(2, 10.0, |p| {
            let (x, y) = ((p[0] / 0.2).floor() as i64, (p[1] / 0.2).floor() as i64);
            let level = hash([x, y, 0], 5);
            speckled([0.15 + 0.65 * level, 0.25 + 0.45 * level, 0.75 - 0.4 * level], p, 5)
        }),
        Surface {
            shape: Shape::Sphere { centre: [-0.24, 0.30, 1.55], radius: 0.25 },
            colour: |p| {
                let band = ((p[1] - 0.5 * p[0]) / 0.07).rem_euclid(2.0) < 1.0;
                speckled(if band { [0.16, 0.36, 0.60] } else { [0.75, 0.70, 0.45] }, p, 6)
            },
        },
        Surface {
            shape: Shape::Sphere { centre: [0.12, -0.17, 1.10], radius: 0.06 },
            colour: |p| speckled([0.70, 0.22, 0.15], p, 7),
        },
        Surface {
            shape: Shape::Cone { apex: [0.36, -0.28, 2.15], height: 0.83, radius: 0.28 },
            colour: |p| {
                let band = (p[1] / 0.12).rem_euclid(2.0) < 1.0;
                speckled(if band { [0.85, 0.45, 0.10] } else { [0.80, 0.78, 0.72] }, p, 8)
            },
        },
    ]
}

/// Courses of bricks, each brick of its own brightness, in mortar.
fn brick(along: f64, up: f64, colour: V, seed: u32) -> V {
    let course = (up / 0.1).floor();
    let along = along / 0.26 + 0.5 * course.rem_euclid(2.0);
    let level = 0.7 + 0.6 * hash([along.floor() as i64, course as i64, 0], seed);
    let mortar = along - along.floor() < 0.05 || up / 0.1 - course < 0.12;
    if mortar { [0.55, 0.53, 0.50] } else { colour.map(|v| v * level) }
}

/// `colour` made lighter and darker by noise with detail from 32 cm down to 5 mm, which is a pixel 2 m away.
fn speckled(colour: V, point: V, seed: u32) -> V {
    let mut noise = 0.0;
    for octave in 0..7 {
        let cell = 0.32 / f64::from(1 << octave);
        noise += value_noise(point.map(|v| v / cell), seed + 100 * octave) - 0.5;
    }
    colour.map(|v| v * (1.0 + 0.65 * noise).max(0.1))
}

/// The first surface on a ray, and where.
fn first(scene: &[Surface], from: V, along: V, after: f64) -> Option<(&Surface, f64)> {
    let hits = scene.iter().filter_map(|s| s.shape.hit(from, along, after).map(|t| (s, t)));
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The ray through (x, y) of the image, of length 1 along z, so that its parameter is the depth z.
fn ray(x: f64, y: f64) -> V {
    [(x - CENTRE[0]) / FOCAL, (y - CENTRE[1]) / FOCAL, 1.0]
}

/// The light that leaves the scene at the end of a ray. It does not depend on the camera: the surfaces are matt.
fn radiance(scene: &[Surface], camera: V, along: V) -> V {
    let Some((surface, z)) = first(scene, camera, along, 0.0) else { return [0.0; 3] };
    let point = add(camera, along, z);
    let to_light = add(LIGHT, point, -1.0);
    let lit = first(scene, point, to_light, 1e-6).is_none_or(|(_, t)| t > 1.0);
    let facing = dot(surface.shape.normal(point, camera), unit(to_light)).max(0.0);
    let strength = 0.5 + if lit { 0.9 * facing / (1.0 + 0.15 * dot(to_light, to_light)) } else { 0.0 };
    (surface.colour)(point).map(|v| v * strength)
}

/// The view of a camera, RGB with a gamma of 2.
fn picture(scene: &[Surface], camera_x: f64) -> Vec<u8> {
    let rows = (0..HEIGHT).into_par_iter().flat_map_iter(|y| {
        (0..WIDTH).flat_map(move |x| {
            let mut sum = [0.0; 3];
            for sample in 0..SAMPLES * SAMPLES {
                let at = |pixel: usize, i: usize| pixel as f64 + (i as f64 + 0.5) / SAMPLES as f64 - 0.5;
                let along = ray(at(x, sample % SAMPLES), at(y, sample / SAMPLES));
                sum = add(sum, radiance(scene, [camera_x, 0.0, 0.0], along), 1.0);
            }
            sum.map(|v| (255.0 * (v / (SAMPLES * SAMPLES) as f64).min(1.0).sqrt() + 0.5) as u8)
        })
    });
    rows.collect()
}

/// The disparity of each pixel's centre, by the depth of the first surface behind it.
fn disparity(scene: &[Surface], camera_x: f64) -> Vec<f64> {
    let depth = |x: usize, y: usize| first(scene, [camera_x, 0.0, 0.0], ray(x as f64, y as f64), 0.0).map(|(_, z)| z);
    (0..WIDTH * HEIGHT).map(|i| FOCAL * BASELINE / depth(i % WIDTH, i / WIDTH).unwrap_or(f64::INFINITY)).collect()
}

/// 255 for each pixel of the left image whose point the right camera sees, in a pixel of its image; 0 for the others.
fn visible_from_right(scene: &[Surface], disparity: &[f64]) -> Vec<u8> {
    let visible = |(i, &d): (usize, &f64)| {
        let x = (i % WIDTH) as f64 - d;
        let z = first(scene, [RIGHT, 0.0, 0.0], ray(x, (i / WIDTH) as f64), 0.0).map_or(0.0, |(_, z)| z);
        let inside = (-0.5..WIDTH as f64 - 0.5).contains(&x);
        if inside && z > FOCAL * BASELINE / d * (1.0 - 1e-9) { 255 } else { 0 }
    };
    disparity.iter().enumerate().map(visible).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/corridor");
    let directory = std::env::args_os().nth(1).map_or(here, Into::into);
    let scene = scene();
    let (left, right) = (disparity(&scene, LEFT), disparity(&scene, RIGHT));
    let visible = visible_from_right(&scene, &left);
    let calib = format!(
        "cam0=[{FOCAL} 0 {x}; 0 {FOCAL} {y}; 0 0 1]\ncam1=[{FOCAL} 0 {x}; 0 {FOCAL} {y}; 0 0 1]\n\
         doffs=0\nbaseline={}\nwidth={WIDTH}\nheight={HEIGHT}\nndisp=48\n",
        1000.0 * BASELINE,
        x = CENTRE[0],
        y = CENTRE[1],
    );
    let files = [
        ("left.png", png(&picture(&scene, LEFT), WIDTH, ExtendedColorType::Rgb8)?),
        ("right.png", png(&picture(&scene, RIGHT), WIDTH, ExtendedColorType::Rgb8)?),
        ("disp_left.pfm", pfm(&left, WIDTH)),
        ("disp_right.pfm", pfm(&right, WIDTH)),
        ("nonocc_left.png", png(&visible, WIDTH, ExtendedColorType::L8)?),
        ("calib.txt", calib.into_bytes()),
    ];
    std::fs::create_dir_all(&directory)?;
    for (name, bytes) in &files {
        std::fs::write(directory.join(name), bytes)?;
    }
    let (low, high) = left.iter().fold((f64::MAX, 0_f64), |(low, high), &d| (low.min(d), high.max(d)));
    println!(
        "{} files written to {}: disparities {low:.2} to {high:.2} px, {:.1} % of the left pixels seen from the right",
        files.len(),
        directory.display(),
        100.0 * visible.iter().filter(|&&v| v > 0).count() as f64 / visible.len() as f64,
    );
    Ok(())
}
