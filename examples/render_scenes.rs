//! Renders random scenes as rectified pairs with their exact ground truth, to train and to test with.
//!
//!     cargo run --release --example render_scenes -- --seed 1 --count 100 DIRECTORY
//!
//! Rooms, streets and heaps of things in the air, with many textures, highlights, mirrors, shadows, saturated skies and thin
//! poles; cameras with noise, blur, other exposures and curves on both sides, and rows that do not quite agree.
//! A seed gives a scene: seeds S to S + N - 1 are written to DIRECTORY/00000S and so on, each with left.png, right.png,
//! disp_left.pfm, disp_right.pfm, nonocc_left.png and calib.txt as in data/corridor.
//!
//! Only integer hashes, the four operations, floor and sqrt are used, which IEEE 754 defines to the bit: every platform writes
//! the same files.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Parser;
use image::ExtendedColorType;

mod caster;
mod scenes;

use caster::{pfm, png};
use scenes::{Chance, Picture, Side, View, random_scene};

/// Random scenes as rectified pairs with their exact ground truth.
#[derive(Parser)]
struct Options {
    /// Seed of the first scene
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many scenes, of the seeds that follow
    #[arg(long, default_value_t = 1)]
    count: u64,
    /// Columns of a picture
    #[arg(long, default_value_t = 480, value_parser = clap::value_parser!(u32).range(64..=4096))]
    width: u32,
    /// Rows of a picture
    #[arg(long, default_value_t = 288, value_parser = clap::value_parser!(u32).range(64..=4096))]
    height: u32,
    /// Rays along each side of a pixel
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    rays: u32,
    /// Where the scenes are written
    directory: PathBuf,
}

/// Writes the scene of a seed and returns how it is described.
fn render(options: &Options, seed: u64, directory: &Path) -> Result<String, Box<dyn Error>> {
    let mut chance = Chance::new(seed);
    let (width, height) = (options.width as usize, options.height as usize);
    let focal = options.width as f64 * chance.within(0.6, 1.5);
    let scene = random_scene(&mut chance, 1.0 / focal);
    let mut view = View { width, height, focal, baseline: 0.0 };
    // The nearest point of the left picture is to have the largest disparity.
    let depths = view.depths(&scene, 0.0);
    let nearest = depths.iter().fold(f64::MAX, |a, &b| a.min(b));
    let largest = chance.within(0.05, 0.3) * options.width as f64;
    view.baseline = largest * nearest / focal;
    let sides = Side::random_pair(&mut chance, view.baseline);
    let lights = sides.each_ref().map(|side| view.light(&scene, side, options.rays as usize));
    let mean = lights[0].iter().map(|v| (v[0] + v[1] + v[2]) / 3.0).sum::<f64>() / lights[0].len() as f64;
    let pictures = [0, 1].map(|i| {
        let side = Side { gain: sides[i].gain / mean, ..sides[i].clone() };
        let disparities = view.depths(&scene, side.x).iter().map(|z| focal * view.baseline / z).collect();
        Picture { samples: view.exposed(&lights[i], &side), disparities }
    });
    let visible = view.visible_from_right(&scene, &pictures[0].disparities);
    let most = pictures[0].disparities.iter().fold(0_f64, |a, &b| a.max(b));
    let disparities = (most as u32 + 16) / 16 * 16;
    let (x, y) = ((width - 1) as f64 / 2.0, (height - 1) as f64 / 2.0);
    let camera = format!("[{focal} 0 {x}; 0 {focal} {y}; 0 0 1]");
    let calib = format!(
        "cam0={camera}\ncam1={camera}\ndoffs=0\nbaseline={}\nwidth={width}\nheight={height}\nndisp={disparities}\n",
        1000.0 * view.baseline,
    );
    let files = [
        ("left.png", png(&pictures[0].samples, width, ExtendedColorType::Rgb8)?),
        ("right.png", png(&pictures[1].samples, width, ExtendedColorType::Rgb8)?),
        ("disp_left.pfm", pfm(&pictures[0].disparities, width)),
        ("disp_right.pfm", pfm(&pictures[1].disparities, width)),
        ("nonocc_left.png", png(&visible, width, ExtendedColorType::L8)?),
        ("calib.txt", calib.into_bytes()),
    ];
    std::fs::create_dir_all(directory)?;
    for (name, bytes) in &files {
        std::fs::write(directory.join(name), bytes)?;
    }
    let seen = visible.iter().filter(|&&v| v > 0).count() as f64 / visible.len() as f64;
    Ok(format!("disparities up to {most:.1} px, {:.1} % of the left pixels seen from the right", 100.0 * seen))
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    for seed in options.seed..options.seed + options.count {
        let directory = options.directory.join(format!("{seed:06}"));
        println!("{}: {}", directory.display(), render(&options, seed, &directory)?);
    }
    Ok(())
}
