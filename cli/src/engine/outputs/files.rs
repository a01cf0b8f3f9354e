//! The files that the command line asks for: what each holds, and where it is written.

use super::known::KnownFile;
use super::places;
use crate::args::{LookArgs, MapsArgs, Range};
use crate::engine::compute::Cameras;
use crate::engine::images;
use crate::terminal::{message, warnings};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::files::Facts;
use gpu_stereo::files::encoders::{self, Maps};
use gpu_stereo::files::encoders::{
    Format, Look, PointFormat, SampleFormat, SheetFormat, ending, ensure_range, sample_format, searched,
};
use gpu_stereo::files::outputs::{self, Output};
use gpu_stereo::{Colors, Image, Matched, Params};
use std::borrow::Cow;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The files to write, each checked: its ending is known, its folder can be written, it is neither an input nor named
/// twice. Without any file, the default ones.
pub fn resolve(
    mut wanted: Vec<(PathBuf, Format)>,
    inputs: &[&Path],
    params: &Params,
    look: Look,
) -> Result<Vec<Output>> {
    wanted.iter().try_for_each(|(path, format)| ensure_range(*format, path, params))?;
    if wanted.is_empty() {
        wanted.push(default_map(params));
        wanted.push(("disparity_color.png".into(), Format::Color(look)));
    }
    places(wanted, inputs)
}

/// The files of options that take names of maps: each name's ending tells the format, of which `of` makes what is written.
pub fn maps(paths: &[PathBuf], of: impl Fn(SampleFormat) -> Format) -> Result<Vec<(PathBuf, Format)>> {
    paths.iter().map(|path| Ok((path.clone(), of(sample_format(path)?)))).collect()
}

/// The files of `--points`.
pub fn points(paths: &[PathBuf]) -> Result<Vec<(PathBuf, Format)>> {
    let format = |path: &PathBuf| match ending(path).as_str() {
        "ply" => Ok((path.clone(), Format::Points(PointFormat::Ply))),
        "pcd" => Ok((path.clone(), Format::Points(PointFormat::Pcd))),
        _ => bail!("--points is {path:?}, but points are written as .ply or .pcd; give a name that ends so"),
    };
    paths.iter().map(format).collect()
}

/// The files of options that take the name of a picture: option, name and what it shows.
pub fn pictures(given: &[(&str, &Option<PathBuf>, Format)]) -> Result<Vec<(PathBuf, Format)>> {
    let there = given.iter().filter_map(|(option, path, format)| Some((option, path.as_ref()?, format)));
    there.map(|(option, path, format)| ensure_png(option, path).map(|()| (path.clone(), *format))).collect()
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

/// The picture of both fields of view, checked as [`resolve`] does.
pub fn resolve_fields(path: &Path, inputs: &[&Path]) -> Result<Output<()>> {
    ensure_png("output", path)?;
    places(vec![(path.into(), ())], inputs)?.pop().context("there is no output")
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
        ensure_range(Format::Disparity(SampleFormat::Png), out, params)?;
    }
    formats.iter().try_for_each(|format| ensure_range(*format, &out.join("NAME.png"), params))?;
    Ok(())
}

fn default_map(params: &Params) -> (PathBuf, Format) {
    let format = default_format(params, "disparity");
    (["disparity", format.suffix()].concat().into(), format)
}

/// The whole disparities that files of all these formats can hold; none if they hold all.
pub fn held(mut formats: impl Iterator<Item = Format>) -> Option<RangeInclusive<i32>> {
    formats.find_map(Format::holds)
}

/// What a map without a format of its own becomes; said where it is not a PNG.
pub fn default_format(params: &Params, name: &str) -> Format {
    let format = encoders::default_format(params);
    if format != SampleFormat::Png {
        let (first, last) = searched(params);
        message(&format!(
            "note: disparities from {first} to {last} px do not fit a 16-bit PNG (0 to 255); writing {name}.tif instead"
        ));
    }
    Format::Disparity(format)
}

/// Has all computed that files of these formats hold, but for the depth, which needs cameras.
pub fn want(params: &mut Params, formats: &[Format]) {
    params.confidence = formats.contains(&Format::Confidence);
    params.right_map = formats.iter().any(|format| matches!(format, Format::Right(_)));
}

/// Reports a look that no file has.
pub fn note_look(look: Look, formats: &[Format]) {
    if look != Look::default() && !formats.iter().any(|format| matches!(format, Format::Color(_))) {
        message("note: --colors and --scale-bar have no effect without a picture of a map");
    }
}

/// Whether files of these formats show the right image.
pub fn keeps_right(formats: &[Format]) -> bool {
    formats.iter().any(|format| format.shows_image(1))
}

/// Refuses the rectified pair where nothing rectifies.
pub fn ensure_rectified(formats: &[Format], cameras: &Cameras) -> Result<()> {
    let wanted = formats.iter().any(|format| matches!(format, Format::RectifiedLeft | Format::RectifiedRight));
    ensure!(
        !wanted || cameras.rectify(),
        "the rectified images are wanted, but nothing rectifies them; give the calibration by --rectify FILE"
    );
    Ok(())
}

/// The names of `--rectified`, split at the comma in the middle.
pub fn rectified(given: Option<&str>) -> Result<Vec<(PathBuf, Format)>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let commas: Vec<_> = given.match_indices(',').map(|(at, _)| at).collect();
    ensure!(
        commas.len() % 2 == 1,
        "--rectified is {given:?}, but the names of two images are needed, LEFT,RIGHT; put one comma between them"
    );
    let (left, right) = given.split_at(commas[commas.len() / 2]);
    pictures(&[
        ("rectified", &Some(left.into()), Format::RectifiedLeft),
        ("rectified", &Some(right[1..].into()), Format::RectifiedRight),
    ])
}

/// The option that asks for a depth, if one of the formats does.
pub fn asks_for_depth(formats: &[Format]) -> Option<&'static str> {
    let found = formats.iter().find(|format| format.needs_depth())?;
    Some(if matches!(found, Format::Depth(_)) { "a depth" } else { "a file of points" })
}

/// What decides about files of a folder besides the settings of the matcher. Defaults are not told.
pub fn decisive(cameras: &Cameras, look: &LookArgs) -> Vec<(&'static str, String)> {
    let named = Colors::ALL.iter().find(|(_, colors)| *colors == look.colors && *colors != Colors::default());
    let cameras = cameras.digest().map(|digest| ("cameras", digest));
    let colors = named.map(|(name, _)| ("colors", (*name).into()));
    let bar = look.scale_bar.then(|| ("scale-bar", "on".into()));
    [cameras, colors, bar].into_iter().flatten().collect()
}

/// The same of `--disp auto`: in place of the range, that it is left to each pair, and what the files can hold of it.
pub fn decisive_range(range: Range, held: Option<&RangeInclusive<i32>>) -> Vec<(&'static str, String)> {
    let Range::Found { min_is_given } = range else { return Vec::new() };
    let within = held.map(|held| format!(", {} to {}", held.start(), held.end())).unwrap_or_default();
    let min = (!min_is_given).then(|| ("min-disp", "auto".into()));
    [("disp", format!("auto{within}"))].into_iter().chain(min).collect()
}

/// The files of a map in a folder, one a format: NAME.png, NAME_depth.png and so on.
pub fn of_name(folder: &Path, name: &Path, formats: &[Format]) -> Vec<Output> {
    let file = |&format: &Format| {
        let mut path = folder.join(name).into_os_string();
        path.push(format.suffix());
        Output::at(path.into(), format)
    };
    formats.iter().map(file).collect()
}

/// The formats that were asked for, each once.
fn each_once(given: &[Format]) -> Result<Vec<Format>> {
    let mut formats = Vec::new();
    for &format in given {
        ensure!(!formats.contains(&format), "--format has {:?} twice; give each once", format.suffix());
        formats.push(format);
    }
    Ok(formats)
}

/// The same, or the usual one if there is none.
pub fn formats(given: &[Format], look: &LookArgs, params: &Params) -> Result<Vec<Format>> {
    let mut formats = look.dressed(&each_once(given)?);
    if formats.is_empty() {
        formats.push(default_format(params, "NAME"));
    }
    Ok(formats)
}

/// Writes what was computed of a pair with these settings to every file, or, if one cannot be written, to none. The
/// images are the given ones; the right one is needed if [`keeps_right`] says so.
pub fn write(
    outputs: &[Output],
    matched: &Matched,
    (left, right): (&Image, Option<&Image>),
    params: &Params,
) -> Result<Vec<Facts>> {
    let images = images_for(outputs, [Some(left), right], params)?;
    write_all(outputs, &Maps { images: images.each_ref().map(Option::as_deref), ..Maps::all(matched, params) })
}

/// The images that these files show, rectified if `params` say so.
pub fn images_for<'a>(
    outputs: &[Output],
    given: [Option<&'a Image>; 2],
    params: &Params,
) -> Result<[Option<Cow<'a, Image>>; 2]> {
    let needed = |side: usize| outputs.iter().any(|output| output.format.shows_image(side));
    let mut images = [None, None];
    for (side, (image, given)) in images.iter_mut().zip(given).enumerate() {
        *image = given.filter(|_| needed(side)).map(|given| images::rectified(given, params, side)).transpose()?;
    }
    Ok(images)
}

/// The same of all that there is, once it is reported what the files do not hold.
pub fn write_all(outputs: &[Output], maps: &Maps<'_>) -> Result<Vec<Facts>> {
    let written = outputs::write(outputs, maps)?;
    written.doubts.iter().for_each(|doubt| warnings::warn(doubt));
    Ok(written.facts)
}

/// A folder of maps beside what a verb writes otherwise: `--maps`.
pub struct MapFolder {
    /// Where it is.
    pub folder: PathBuf,
    /// What is written of each map.
    pub formats: Vec<Format>,
}

impl MapFolder {
    /// The folder, if one is given, created if missing.
    pub fn resolve(given: &MapsArgs, look: &LookArgs) -> Result<Option<Self>> {
        given.ensure_folder()?;
        let Some(folder) = &given.maps else { return Ok(None) };
        let mut formats = look.dressed(&each_once(&given.formats.format)?);
        if formats.is_empty() {
            formats.push(Format::Disparity(SampleFormat::Png));
        }
        places::ensure_folder(folder)?;
        Ok(Some(Self { folder: folder.clone(), formats }))
    }

    /// The formats, none without a folder.
    pub fn formats(folder: Option<&Self>) -> &[Format] {
        folder.map_or(&[], |folder| &folder.formats)
    }

    /// Whether anything in it is made from the depth.
    pub fn needs_depth(&self) -> bool {
        asks_for_depth(&self.formats).is_some()
    }

    /// The files of a map, once it is sure that they can hold it.
    pub fn files(&self, name: &Path, params: &Params) -> Result<Vec<PathBuf>> {
        let outputs = of_name(&self.folder, name, &self.formats);
        outputs.iter().try_for_each(|output| ensure_range(output.format, &output.path, params))?;
        Ok(outputs.into_iter().map(|output| output.path).collect())
    }

    /// Writes a map as [`write`] does.
    pub fn write(
        &self,
        name: &Path,
        matched: &Matched,
        images: (&Image, Option<&Image>),
        params: &Params,
    ) -> Result<Vec<KnownFile>> {
        let outputs = of_name(&self.folder, name, &self.formats);
        self.folder.join(name).parent().map_or(Ok(()), places::ensure_folder)?;
        let facts = write(&outputs, matched, images, params)?;
        Ok(outputs.iter().zip(facts).map(|(output, facts)| KnownFile::new(&output.path, facts)).collect())
    }
}

/// A label as a part of a file's name.
pub fn file_name(label: &str) -> String {
    label.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect()
}
