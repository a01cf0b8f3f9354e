//! Measures the reference against the ground truth of data/ and, where there is one, of a larger collection.
//!
//!     cargo run --release --example accuracy -- --help
//!
//! The shaders equal the reference to the bit, so these are their figures, too.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Parser;
use comfy_table::{CellAlignment, Table, presets};
use gpu_stereo::{DisparityMap, Image, Median, Params, Paths, Pixels, Prefilter, reference};
use serde::Deserialize;

/// Disparity maps of the CPU reference against ground truth.
#[derive(Parser)]
#[command(after_help = "\
Columns, in per cent of the pixels whose truth is known unless said otherwise:
  density    pixels with a disparity
  bad2       pixels with a disparity that are wrong by more than 2 px, in per cent of the pixels with one
  bad2-all   the same and the pixels without a disparity
  D1-est     pixels with a disparity wrong by more than 3 px and more than 5 %, in per cent of the pixels with one
  D1-all     the same over all pixels, holes filled: in a row with the smaller neighbour, then rows above and below
  avg        mean error in px of the pixels with a disparity")]
struct Options {
    /// Collection with a MANIFEST.json [default: ../shared/data, where it exists]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Only scenes whose name contains this
    #[arg(long)]
    scene: Option<String>,
    /// sgm or bm
    #[arg(long, default_value = "sgm")]
    method: String,
    #[arg(long)]
    p1: Option<u32>,
    #[arg(long)]
    p2: Option<u32>,
    /// Uniqueness in per cent
    #[arg(long)]
    uniqueness: Option<u32>,
    /// 3, 4 or 8
    #[arg(long)]
    paths: Option<u32>,
    /// Side of the block
    #[arg(long)]
    block: Option<u32>,
    /// xsobel, sobel or none
    #[arg(long)]
    prefilter: Option<String>,
    /// Clip of the prefilter
    #[arg(long)]
    cap: Option<u32>,
    /// Largest difference of the left-right check in px, or off
    #[arg(long, value_name = "PX")]
    lr_check: Option<String>,
    /// 3 or off
    #[arg(long)]
    median: Option<String>,
}

impl Options {
    fn params(&self, disparities: u32) -> Result<Params> {
        let mut params = match self.method.as_str() {
            "sgm" => Params::sgm(disparities),
            "bm" => Params::bm(disparities),
            other => bail!("--method is {other}, but must be sgm or bm"),
        };
        params.p1 = self.p1.unwrap_or(params.p1);
        params.p2 = self.p2.unwrap_or(params.p2);
        params.uniqueness = self.uniqueness.unwrap_or(params.uniqueness);
        params.block = self.block.unwrap_or(params.block);
        params.prefilter_cap = self.cap.unwrap_or(params.prefilter_cap);
        params.paths = match self.paths {
            None => params.paths,
            Some(3) => Paths::Three,
            Some(4) => Paths::Four,
            Some(8) => Paths::Eight,
            Some(other) => bail!("--paths is {other}, but must be 3, 4 or 8"),
        };
        params.prefilter = match self.prefilter.as_deref() {
            None => params.prefilter,
            Some("xsobel") => Prefilter::XSobel,
            Some("sobel") => Prefilter::Sobel,
            Some("none") => Prefilter::None,
            Some(other) => bail!("--prefilter is {other}, but must be xsobel, sobel or none"),
        };
        params.lr_check = match self.lr_check.as_deref() {
            None => params.lr_check,
            Some("off") => None,
            Some(px) => Some(px.parse().with_context(|| format!("--lr-check is {px}, but must be px or off"))?),
        };
        params.median = match self.median.as_deref() {
            None => params.median,
            Some("off") => Median::Off,
            Some("3") => Median::Three,
            Some(other) => bail!("--median is {other}, but must be 3 or off"),
        };
        params.validate()?;
        Ok(params)
    }
}

/// A pair with its truth.
struct Scene {
    name: String,
    left: PathBuf,
    right: PathBuf,
    truth: PathBuf,
    /// Truth sample that stands for 1 px.
    scale: f64,
    disparities: u32,
}

/// One entry of MANIFEST.json, as far as it is needed here.
#[derive(Deserialize)]
struct Entry {
    set: String,
    scene: String,
    left: PathBuf,
    right: PathBuf,
    gt: Option<PathBuf>,
    gt_scale: Option<f64>,
    max_disp: Option<f64>,
}

/// The scenes of the project itself.
fn own_scenes() -> [Scene; 2] {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    ["motorcycle", "corridor"].map(|name| {
        let file = |file: &str| data.join(name).join(file);
        Scene {
            name: format!("data/{name}"),
            left: file("left.png"),
            right: file("right.png"),
            truth: file("disp_left.pfm"),
            scale: 1.0,
            disparities: if name == "corridor" { 48 } else { 64 },
        }
    })
}

/// The scenes of a collection that have a truth: every one of KITTI at 128 disparities, the others at the multiple of
/// 16 that holds their largest.
fn collected_scenes(directory: &Path) -> Result<Vec<Scene>> {
    let manifest = directory.join("MANIFEST.json");
    let text = fs::read(&manifest).with_context(|| format!("{}: cannot be read", manifest.display()))?;
    let entries: Vec<Entry> =
        serde_json::from_slice(&text).with_context(|| format!("{}: not as expected", manifest.display()))?;
    let scenes = entries.into_iter().filter_map(|entry| {
        let largest = entry.max_disp.filter(|largest| largest.is_finite())?;
        let sixteens = if entry.set.starts_with("kitti") { 8 } else { (largest as u32 + 16) / 16 };
        Some(Scene {
            name: format!("{}/{}", entry.set, entry.scene),
            left: directory.join(entry.left),
            right: directory.join(entry.right),
            truth: directory.join(entry.gt?),
            scale: entry.gt_scale?,
            disparities: 16 * sixteens,
        })
    });
    Ok(scenes.collect())
}

fn read_picture(path: &Path) -> Result<Image> {
    let picture = image::open(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    let (width, height) = (picture.width(), picture.height());
    let pixels = match picture {
        image::DynamicImage::ImageLuma8(samples) => Pixels::Gray8(samples.into_raw()),
        other => Pixels::Rgba8(other.into_rgba8().into_raw()),
    };
    Ok(Image::new(width, height, pixels)?)
}

/// The true disparities in px, row by row from the top; NaN where unknown.
fn read_truth(path: &Path, scale: f64) -> Result<Vec<f64>> {
    let context = || format!("{}: cannot be read", path.display());
    if path.extension().is_some_and(|ending| ending == "pfm") {
        return read_pfm(&fs::read(path).with_context(context)?).with_context(context);
    }
    let samples = image::open(path).with_context(context)?;
    let values: Vec<f64> = match samples {
        image::DynamicImage::ImageLuma8(samples) => samples.into_raw().into_iter().map(f64::from).collect(),
        image::DynamicImage::ImageLuma16(samples) => samples.into_raw().into_iter().map(f64::from).collect(),
        _ => bail!("{}: the truth has colours, but must be gray", path.display()),
    };
    Ok(values.into_iter().map(|v| if v > 0.0 { v / scale } else { f64::NAN }).collect())
}

/// A gray PFM: three lines of text, then rows of f32 from the bottom, little endian if the third line is negative.
fn read_pfm(bytes: &[u8]) -> Result<Vec<f64>> {
    let mut parts = bytes.splitn(4, |&byte| byte == b'\n');
    let mut line = || std::str::from_utf8(parts.next().unwrap_or_default()).map(str::trim);
    let (magic, size, scale) = (line()?, line()?, line()?);
    let samples = parts.next().unwrap_or_default();
    let (width, height) = size.split_once(' ').context("no size in the second line")?;
    let (width, height): (usize, usize) = (width.parse()?, height.parse()?);
    if magic != "Pf" || width == 0 || samples.len() != 4 * width * height {
        bail!("a gray PFM of {width}x{height} pixels was expected");
    }
    let little = scale.parse::<f64>()? < 0.0;
    let values: Vec<f64> = samples
        .chunks_exact(4)
        .map(|b| [b[0], b[1], b[2], b[3]])
        .map(|b| f64::from(if little { f32::from_le_bytes(b) } else { f32::from_be_bytes(b) }))
        .map(|v| if v.is_finite() { v } else { f64::NAN })
        .collect();
    Ok(values.chunks_exact(width).rev().flatten().copied().collect())
}

/// The map in px with its holes filled as KITTI's development kit does: a gap in a row takes the smaller of its two
/// neighbours, or the only one; rows without any disparity take the nearest row that has some.
fn filled(map: &DisparityMap) -> Vec<f64> {
    let width = map.width as usize;
    let rows: Vec<Option<Vec<f64>>> = map.data.chunks_exact(width).map(filled_row).collect();
    let nearest = |y: usize| {
        let with_distance = rows.iter().enumerate().filter_map(|(other, row)| Some((other.abs_diff(y), row.as_ref()?)));
        with_distance.min_by_key(|&(distance, _)| distance).map(|(_, row)| row.clone())
    };
    (0..rows.len()).flat_map(|y| nearest(y).unwrap_or_else(|| vec![0.0; width])).collect()
}

fn filled_row(row: &[i16]) -> Option<Vec<f64>> {
    let pixel = |&v: &i16| (v != DisparityMap::INVALID).then(|| f64::from(v) / 16.0);
    let carry = |last: &mut Option<f64>, v: Option<f64>| {
        *last = v.or(*last);
        Some(*last)
    };
    let from_left: Vec<_> = row.iter().map(pixel).scan(None, carry).collect();
    let mut from_right: Vec<_> = row.iter().rev().map(pixel).scan(None, carry).collect();
    from_right.reverse();
    let smaller = |(a, b): (&Option<f64>, &Option<f64>)| a.map_or(*b, |a| Some(b.map_or(a, |b| a.min(b))));
    from_left.iter().zip(&from_right).map(smaller).collect()
}

/// Figures of a scene, in the order of the table's columns.
#[derive(Clone, Copy, Default)]
struct Figures([f64; 6]);

fn figures(map: &DisparityMap, truth: &[f64]) -> Figures {
    let filled = filled(map);
    let (mut known, mut valid, mut bad, mut d1_est, mut d1_all, mut error_sum) = (0, 0, 0, 0, 0, 0.0);
    for ((&value, &filled), &truth) in map.data.iter().zip(&filled).zip(truth).filter(|(_, truth)| !truth.is_nan()) {
        let d1 = |error: f64| u32::from(error > 3.0 && error > 0.05 * truth);
        known += 1;
        d1_all += d1((filled - truth).abs());
        if value != DisparityMap::INVALID {
            let error = (f64::from(value) / 16.0 - truth).abs();
            valid += 1;
            bad += u32::from(error > 2.0);
            d1_est += d1(error);
            error_sum += error;
        }
    }
    let percent = |part: u32, whole: u32| 100.0 * f64::from(part) / f64::from(whole.max(1));
    Figures([
        percent(valid, known),
        percent(bad, valid),
        percent(bad + known - valid, known),
        percent(d1_est, valid),
        percent(d1_all, known),
        error_sum / f64::from(valid.max(1)),
    ])
}

fn row(name: &str, disparities: &str, Figures(figures): Figures) -> Vec<String> {
    let (last, percentages) = figures.split_last().unwrap_or((&0.0, &[]));
    let percentages = percentages.iter().map(|v| format!("{v:.2}"));
    [name.to_owned(), disparities.to_owned()].into_iter().chain(percentages).chain([format!("{last:.3}")]).collect()
}

fn mean(figures: &[Figures]) -> Figures {
    Figures(std::array::from_fn(|i| figures.iter().map(|f| f.0[i]).sum::<f64>() / figures.len() as f64))
}

fn main() -> Result<()> {
    let options = Options::parse();
    println!("{:?}", options.params(64)?);
    let usual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let mut scenes: Vec<Scene> = own_scenes().into();
    match options.data.as_deref() {
        Some(directory) => scenes.extend(collected_scenes(directory)?),
        None if usual.is_dir() => scenes.extend(collected_scenes(&usual)?),
        None => println!("no collection at ../shared/data and no --data DIR: only the pairs in data/ are measured"),
    }
    scenes.retain(|scene| options.scene.as_ref().is_none_or(|part| scene.name.contains(part.as_str())));

    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(["scene", "disp", "density", "bad2", "bad2-all", "D1-est", "D1-all", "avg"]);
    table.column_iter_mut().skip(1).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let mut kitti = Vec::new();
    for scene in &scenes {
        let (left, right) = (read_picture(&scene.left)?, read_picture(&scene.right)?);
        let truth = read_truth(&scene.truth, scene.scale)?;
        if truth.len() as u64 != u64::from(left.width()) * u64::from(left.height()) {
            bail!("{}: the truth has {} pixels, the picture other", scene.name, truth.len());
        }
        let map = reference::compute(&left, &right, &options.params(scene.disparities)?)?;
        let figures = figures(&map, &truth);
        if scene.name.starts_with("kitti2015") {
            kitti.push(figures);
        }
        table.add_row(row(&scene.name, &scene.disparities.to_string(), figures));
    }
    if kitti.len() > 1 {
        table.add_row(row(&format!("mean of {} KITTI frames", kitti.len()), "", mean(&kitti)));
    }
    println!("{table}");
    Ok(())
}
