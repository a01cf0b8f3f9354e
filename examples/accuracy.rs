//! Measures the reference against the ground truth of data/ and, where there is one, of a larger collection.
//!
//!     cargo run --release --example accuracy -- --help
//!
//! The shaders equal the reference to the bit, so these are their figures, too.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Parser;
use comfy_table::{CellAlignment, Table, presets};
use gpu_stereo::evaluation::{FloatMap, evaluate};
use gpu_stereo::files::images::{Bits, ImagePair, read_pair};
use gpu_stereo::files::maps::{self, Encoding, EncodingOptions};
use gpu_stereo::{DisparityMap, Params, reference};
use serde::Deserialize;

/// Disparity maps of the CPU reference against ground truth.
#[derive(Parser)]
#[command(after_help = "\
Columns, in per cent and px, as docs/EVALUATION.md defines them:
  density, bad2 (bad-2 of valid pixels), bad2-all (bad-2), D1-est, D1-all, avg (the average error)")]
struct Options {
    /// Collection with a MANIFEST.json [default: ../shared/data, where it exists]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Only scenes whose name contains this
    #[arg(long)]
    scene: Option<String>,
    /// Settings to start from [default: the command's]
    #[arg(long)]
    preset: Option<String>,
    /// A setting by its name on the command line, as in p2=80; may be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
}

fn setting(text: &str) -> Result<(String, String), &'static str> {
    let (name, value) = text.split_once('=').ok_or("NAME=VALUE is needed, such as p2=80")?;
    Ok((name.into(), value.into()))
}

impl Options {
    fn params(&self, disparities: u32) -> Result<Params> {
        let preset = self.preset.iter().map(|value| ("preset", value.as_str()));
        let set = self.set.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        Ok(Params::from_options(disparities, preset.chain(set))?)
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

/// The true disparities in px; NaN where unknown.
fn read_truth(path: &Path, scale: f64) -> Result<FloatMap> {
    // Floats are in px whatever a manifest says.
    let scale = path.extension().is_none_or(|ending| ending != "pfm").then_some(scale);
    Ok(maps::read(path, Encoding { scale, ..Encoding::default() }, EncodingOptions::TRUTH)?.map)
}

/// Figures of a scene, in the order of the table's columns.
#[derive(Clone, Copy, Default)]
struct Figures([f64; 6]);

fn figures(map: &DisparityMap, truth: &FloatMap) -> Result<Figures> {
    let scores = evaluate(&map.into(), truth, None)?;
    let of_valid = |share: Option<f64>| 100.0 * share.unwrap_or_default();
    Ok(Figures([
        100.0 * scores.density(),
        of_valid(scores.bad_of_valid(2)),
        100.0 * scores.bad(2),
        of_valid(scores.d1_est()),
        100.0 * scores.d1_all(),
        scores.average().unwrap_or_default(),
    ]))
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
    let params = options.params(64)?;
    let settings = Params::OPTIONS.iter().filter(|option| option.name != "disp" && option.idle(&params).is_none());
    println!("{}", settings.map(|o| format!("{}={}", o.name, o.get(&params))).collect::<Vec<_>>().join(" "));
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
    let (mut kitti, mut middlebury) = (Vec::new(), Vec::new());
    for scene in &scenes {
        let ImagePair { left, right, .. } = read_pair(&scene.left, &scene.right, Bits::Auto)?;
        let truth = read_truth(&scene.truth, scene.scale)?;
        let map = reference::compute(&left, &right, &options.params(scene.disparities)?)?;
        let figures = figures(&map, &truth).with_context(|| scene.name.clone())?;
        if scene.name.starts_with("kitti2015") {
            kitti.push(figures);
        }
        if scene.name.ends_with("/teddy") || scene.name.ends_with("/cones") {
            middlebury.push(figures);
        }
        table.add_row(row(&scene.name, &scene.disparities.to_string(), figures));
    }
    let means =
        [(format!("mean of {} KITTI frames", kitti.len()), kitti), ("mean of Teddy and Cones".into(), middlebury)];
    for (name, figures) in means.iter().filter(|(_, figures)| figures.len() > 1) {
        table.add_row(row(name, "", mean(figures)));
    }
    println!("{table}");
    Ok(())
}
