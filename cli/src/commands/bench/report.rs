//! The results of a data set, and `--report`: report.md, its pictures and results.json.

use super::files::put;
use super::scene::{Loaded, SceneReport};
use super::tables::{SetReport, scene_table, set_table};
use crate::engine::compute::EngineNames;
use crate::engine::images;
use crate::engine::known::KnownFile;
use crate::engine::output_files::file_name;
use crate::terminal::{self, plain};
use anyhow::Result;
use gpu_stereo::evaluation::FloatMap;
use gpu_stereo::files::{encoders, outputs};
use gpu_stereo::{Colors, DisparityMap, Params};
use image::RgbImage;
use image::imageops::{self, FilterType};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// The greatest width of the report's pictures.
const PICTURE: u32 = 480;

/// Files and a folder of a report.
pub const REPORT: &str = "report.md";
pub const RESULTS: &str = "results.json";
pub const PICTURES: &str = "pictures";

/// The results; `--json` prints them as they are.
#[derive(Serialize)]
pub struct BenchReport {
    /// The adapter and its driver.
    #[serde(flatten)]
    pub names: EngineNames,
    /// Scenes with variants.
    pub scenes: Vec<SceneReport>,
    /// Sets with variants.
    pub sets: Vec<SetReport>,
    /// What failed.
    pub failures: Vec<FailedScene>,
    /// Why maps are doubtful.
    pub warnings: Vec<String>,
}

/// A scene, or a scene with a variant, that failed.
#[derive(Serialize)]
pub struct FailedScene {
    pub scene: String,
    pub variant: Option<String>,
    pub error: String,
}

/// The name of a picture of the report.
fn picture_name(found: &SceneReport, kind: &str) -> String {
    let of = file_name(&format!("{}_{}", found.set, found.scene));
    format!("{:04}_{of}_{kind}.png", found.numbers[0])
}

/// Writes the pictures of a scene with a variant, with the first variant those of the scene, too.
pub fn write_pictures(
    report: &Path,
    found: &SceneReport,
    loaded: &Loaded,
    estimate: &DisparityMap,
    (params, colors): (&Params, Colors),
    is_first: bool,
) -> Result<Vec<KnownFile>> {
    let folder = report.join(PICTURES);
    let put = |kind: &str, picture: &RgbImage| {
        put(&folder.join(picture_name(found, kind)), &encoders::png(&scaled(picture))?)
    };
    let range = encoders::searched(params);
    let mut written = Vec::new();
    if is_first {
        written.push(put("input", &images::drawn(&*images::rectified(&loaded.left, params, 0)?))?);
        if let Some(truth) = &loaded.truth {
            written.push(put("truth", &encoders::truth_picture(&thinned(&truth.map)?, range, colors))?);
        }
    }
    let number = found.numbers[1];
    written.push(put(&format!("estimate{number}"), &encoders::picture(estimate, range, colors))?);
    // Occluded pixels are half as bright.
    if let Some(truth) = loaded.noc.as_ref().or(loaded.truth.as_ref()) {
        written.push(put(&format!("errors{number}"), &truth.error_picture(&estimate.into())?)?);
    }
    Ok(written)
}

/// The tables of a report that show its pictures, one a scene.
fn picture_tables(scenes: &[SceneReport]) -> Result<String> {
    let mut text = String::new();
    for (i, found) in scenes.iter().enumerate() {
        let has_truth = found.scores[0].is_some();
        let shown = |file: &str, kind: &str| format!("![{kind}]({PICTURES}/{})", picture_name(found, file));
        if i == 0 || scenes[i - 1].numbers[0] != found.numbers[0] {
            let truth = if has_truth { shown("truth", "truth") } else { "none".into() };
            write!(text, "\n### {}/{}\n\n", escaped(&found.set), escaped(&found.scene))?;
            let size = format!("{} x {}", found.width, found.height);
            write!(text, "| input, {size} | truth |\n|---|---|\n| {} | {truth} |\n\n", shown("input", "input"))?;
            write!(text, "| setting | estimate | errors |\n|---|---|---|\n")?;
        }
        let [estimate, errors] = ["estimate", "errors"].map(|kind| {
            let file = format!("{kind}{}", found.numbers[1]);
            shown(&file, &file)
        });
        let errors = if has_truth { errors } else { String::new() };
        writeln!(text, "| {}: {} | {estimate} | {errors} |", escaped(&found.variant), found.in_words())?;
    }
    Ok(text)
}

/// Writes report.md and results.json.
pub fn write_report(folder: &Path, found: &BenchReport) -> Result<()> {
    let mut text = String::from("# Scores of a data set\n\n");
    let EngineNames { adapter, backend, driver, .. } = &found.names;
    writeln!(text, "{}\n", escaped(&format!("{adapter}, {backend} ({driver}).")))?;
    text += "Figures are defined in docs/EVALUATION.md; ms are of a frame: upload, kernels, readback. \"noc\" is without \
                 occluded pixels. \"pooled\" is over the pixels of all scenes together, the others are means of the scenes.\n";
    if !found.failures.is_empty() {
        text += "\n## Failures\n\n";
        for FailedScene { scene, variant, error } in &found.failures {
            let variant = variant.iter().map(|variant| format!(", {variant}")).collect::<String>();
            writeln!(text, "- {}: {}", escaped(&format!("{scene}{variant}")), escaped(error))?;
        }
    }
    for (title, table) in [("Sets", set_table(&found.sets)), ("Scenes", scene_table(&found.scenes))] {
        if !table.is_empty() {
            write!(text, "\n## {title}\n\n{table}")?;
        }
    }
    text += "\n## Pictures\n\nColours over the range searched, black is unknown or invalid; in turbo, red is near and blue is far. \
                 Errors in KITTI's colours, holes filled: blue up to 3 px or 5 %, then yellow to red; half as bright where occluded.\n";
    text += &picture_tables(&found.scenes)?;
    outputs::write_in_folder(&folder.join(RESULTS), terminal::pretty_json(found)?.as_bytes())?;
    outputs::write_in_folder(&folder.join(REPORT), text.as_bytes())?;
    Ok(())
}

/// At most [`PICTURE`] pixels wide, so that a sparse map can still be seen: each pixel takes the first value of its
/// block.
fn thinned(map: &FloatMap) -> Result<FloatMap> {
    let (width, height) = (map.width() as usize, map.height() as usize);
    let new_width = width.min(PICTURE as usize);
    let new_height = (height * new_width / width).max(1);
    let block = |at: usize, old: usize, new: usize| at * old / new..(at + 1) * old / new;
    let value = |x: usize, y: usize| {
        let rows = block(y, height, new_height);
        let mut values = rows.flat_map(|row| &map.data()[row * width..][block(x, width, new_width)]);
        values.find(|value| value.is_finite()).copied().unwrap_or(f32::NAN)
    };
    let values = (0..new_height).flat_map(|y| (0..new_width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect();
    Ok(FloatMap::new(new_width as u32, new_height as u32, values)?)
}

/// At most [`PICTURE`] pixels wide.
fn scaled(picture: &RgbImage) -> RgbImage {
    let (width, height) = picture.dimensions();
    if width <= PICTURE {
        return picture.clone();
    }
    let height = (u64::from(height) * u64::from(PICTURE) / u64::from(width)).max(1) as u32;
    imageops::resize(picture, PICTURE, height, FilterType::Triangle)
}

/// A text escaped for Markdown.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in plain(text).chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            _ => {
                if "\\`*_[]|#".contains(c) {
                    escaped.push('\\');
                }
                escaped.push(c);
            }
        }
    }
    escaped
}
