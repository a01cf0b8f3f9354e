//! The files that the command line asks for: what each holds, and where it is written.

use super::places;
use crate::terminal::{message, warnings};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::files::Facts;
use gpu_stereo::files::encoders::{self, Maps};
use gpu_stereo::files::encoders::{DepthFormat, Format, SheetFormat, ending, ensure_range, map_format, searched};
use gpu_stereo::files::outputs::{self, Output};
use gpu_stereo::{Matched, Params};
use std::path::{Path, PathBuf};

/// The files to write, each checked: its ending is known, its folder can be written, it is neither an input nor named
/// twice. Pictures have an option of their own, each. Without any file, the default ones.
pub fn resolve(
    maps: &[PathBuf],
    pictures: &[(&str, &Option<PathBuf>, Format)],
    depths: &[(PathBuf, DepthFormat)],
    inputs: &[&Path],
    params: &Params,
) -> Result<Vec<Output>> {
    let depths = depths.iter().map(|(path, format)| (path.clone(), Format::Depth(*format)));
    let mut wanted: Vec<_> = depths.collect();
    for path in maps {
        let format = map_format(path)?;
        ensure_range(format, path, params)?;
        wanted.push((path.clone(), format));
    }
    for (option, path, format) in pictures {
        let Some(path) = path else { continue };
        ensure_png(option, path)?;
        wanted.push((path.clone(), *format));
    }
    if wanted.is_empty() {
        wanted.push(default_map(params));
        wanted.push(("disparity_color.png".into(), Format::Color));
    }

    places(wanted, inputs)
}

fn ensure_png(option: &str, path: &Path) -> Result<()> {
    ensure!(
        ending(path) == "png",
        "--{option} is {path:?}, but a picture is written as .png; give a name that ends in .png"
    );
    Ok(())
}

/// The picture of errors to write, checked as [`resolve`] does.
pub fn resolve_error_map(path: &Path, inputs: &[&Path]) -> Result<Output<SheetFormat>> {
    ensure_png("error-map", path)?;
    let mut places = places(vec![(path.into(), SheetFormat::Png)], inputs)?;
    places.pop().context("there is no output")
}

/// The sheet to write, checked as [`resolve`] does.
pub fn resolve_sheet(path: &Path, inputs: &[&Path]) -> Result<Vec<Output<SheetFormat>>> {
    let format = match ending(path).as_str() {
        "png" => SheetFormat::Png,
        "jpg" | "jpeg" => SheetFormat::Jpeg,
        _ => bail!("output {path:?} is a sheet, but a sheet is written as .png or .jpg; give a name that ends so"),
    };
    places(vec![(path.into(), format)], inputs)
}

/// Where to write the weights of `file`, checked as [`resolve`] does.
pub fn resolve_weights(path: &Path, file: &Path) -> Result<Output<()>> {
    ensure!(
        ending(path) == "safetensors",
        "--convert is {path:?}, but weights are written as .safetensors; give a name that ends so"
    );
    places(vec![(path.into(), ())], &[file])?.pop().context("there is no output")
}

/// Where to write, each place checked.
fn places<F>(wanted: Vec<(PathBuf, F)>, inputs: &[&Path]) -> Result<Vec<Output<F>>> {
    let places = places::places(wanted.iter().map(|(path, _)| path.as_path()), inputs)?;
    Ok(wanted.into_iter().zip(places).map(|((path, format), place)| Output::placed(path, place, format)).collect())
}

/// The same of many files, by `--format` or by the ending of a pattern; `out`: the pattern or their folder.
pub fn ensure_ranges(formats: &[Format], out: &Path, params: &Params) -> Result<()> {
    let is_pattern = out.file_name().is_some_and(|name| name.to_string_lossy().contains('%'));
    if is_pattern && formats.is_empty() && ending(out) == "png" {
        ensure_range(Format::Kitti, out, params)?;
    }
    formats.iter().try_for_each(|format| ensure_range(*format, &out.join("NAME.png"), params))?;
    Ok(())
}

fn default_map(params: &Params) -> (PathBuf, Format) {
    let format = default_format(params, "disparity");
    (["disparity", format.suffix()].concat().into(), format)
}

/// What a map without a format of its own becomes; said where it is not a PNG.
pub fn default_format(params: &Params, name: &str) -> Format {
    let format = encoders::default_format(params);
    if format != Format::Kitti {
        let (first, last) = searched(params);
        message(&format!(
            "note: disparities from {first} to {last} px do not fit a 16-bit PNG (0 to 255); writing {name}.tif instead"
        ));
    }
    format
}

/// The formats of `--depth` and `--points`.
pub fn depth_formats(depth: &[PathBuf], points: &[PathBuf]) -> Result<Vec<(PathBuf, DepthFormat)>> {
    let mut formats = Vec::new();
    for path in depth {
        let format = match map_format(path)? {
            Format::Pfm => DepthFormat::Pfm,
            Format::Npy => DepthFormat::Npy,
            Format::Tiff => DepthFormat::Tiff,
            _ => DepthFormat::Png,
        };
        formats.push((path.clone(), format));
    }
    for path in points {
        let format = match ending(path).as_str() {
            "ply" => DepthFormat::Ply,
            "pcd" => DepthFormat::Pcd,
            _ => bail!("--points is {path:?}, but points are written as .ply or .pcd; give a name that ends so"),
        };
        formats.push((path.clone(), format));
    }
    Ok(formats)
}

/// The formats that were asked for, each once.
pub fn formats(given: &[Format]) -> Result<Vec<Format>> {
    let mut formats = Vec::new();
    for &format in given {
        ensure!(!formats.contains(&format), "--format has {:?} twice; give each once", format.suffix());
        formats.push(format);
    }
    Ok(formats)
}

/// Writes a map and its confidence to every file, or, if one cannot be written, to none.
pub fn write(outputs: &[Output], matched: &Matched, params: &Params) -> Result<Vec<Facts>> {
    write_all(outputs, &Maps { confidence: matched.confidence.as_ref(), ..Maps::of(&matched.map, params) })
}

/// The same of all that there is, once it is reported what the files do not hold.
pub fn write_all(outputs: &[Output], maps: &Maps<'_>) -> Result<Vec<Facts>> {
    let written = outputs::write(outputs, maps)?;
    written.doubts.iter().for_each(|doubt| warnings::warn(doubt));
    Ok(written.facts)
}
