//! Disparity maps become files, whole or not at all.

use crate::facts::Facts;
pub use crate::places::{ensure_folder, ensure_no_input, make_folder, writable_place};
use crate::{depth, disk, places};
use anyhow::{Context as _, Result, bail, ensure};
use clap::ValueEnum;
use gpu_stereo::evaluation::FloatMap;
use gpu_stereo::reference::{self, Channel};
use gpu_stereo::{ConfidenceMap, DepthMap, DisparityMap, Image, Params};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _, Rgb, RgbImage};
use npyz::WriterBuilder as _;
use std::fs::{self, File};
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// 16-bit gray PNG as in the KITTI benchmark: 256 a pixel of disparity, 0 invalid, a valid 0 is written as 1.
    #[value(name = "png")]
    Kitti,
    /// Portable float map, little endian, rows from the bottom, +inf invalid.
    Pfm,
    /// NumPy array of 32-bit floats, rows x columns, NaN invalid.
    Npy,
    /// TIFF of 32-bit floats, NaN invalid.
    #[value(name = "tif", alias = "tiff")]
    Tiff,
    /// A picture: turbo colours over the searched range, invalid black.
    Color,
    /// An 8-bit gray PNG: 255 where there is a disparity, 0 where not.
    Mask,
    /// An 8-bit gray PNG: the confidence.
    Confidence,
    /// A picture: the errors.
    #[value(skip)] // a video has no truth
    ErrorMap,
    /// The depth.
    #[value(skip)]
    Depth(DepthFormat),
}

/// What a file with a depth holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthFormat {
    /// 16-bit gray PNG: millimetres, 0 without a depth and beyond what 16 bits hold.
    Png,
    /// As [`Format::Pfm`], in metres.
    Pfm,
    /// As [`Format::Npy`], in metres.
    Npy,
    /// As [`Format::Tiff`], in metres.
    Tiff,
    /// Coloured points.
    Ply,
    /// Coloured points.
    Pcd,
}

/// What is written.
pub struct Maps<'a> {
    /// The disparities.
    pub map: &'a DisparityMap,
    /// Their confidence, if it was computed.
    pub confidence: Option<&'a ConfidenceMap>,
    /// Their depth, if it was computed.
    pub depth: Option<&'a DepthMap>,
    /// The left image, for the colours of points.
    pub left: Option<&'a Image>,
    /// The picture of its errors, if there is a truth.
    pub errors: Option<&'a RgbImage>,
    /// The settings.
    pub params: &'a Params,
}

impl Format {
    /// What follows the name of a frame.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Kitti => ".png",
            Self::Pfm => ".pfm",
            Self::Npy => ".npy",
            Self::Tiff => ".tif",
            Self::Color => "_color.png",
            Self::Mask => "_mask.png",
            Self::Confidence => "_confidence.png",
            Self::Depth(DepthFormat::Png) => "_depth.png",
            Self::Depth(DepthFormat::Pfm) => "_depth.pfm",
            Self::Depth(DepthFormat::Npy) => "_depth.npy",
            Self::Depth(DepthFormat::Tiff) => "_depth.tif",
            Self::Depth(DepthFormat::Ply) => ".ply",
            Self::Depth(DepthFormat::Pcd) => ".pcd",
            Self::ErrorMap => "_errors.png",
        }
    }
}

/// What a file with a sheet holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SheetFormat {
    /// Without loss.
    Png,
    /// Small.
    Jpeg,
}

/// A file to write.
#[derive(Debug)]
pub struct Output<F = Format> {
    /// The path as it was given.
    pub path: PathBuf,
    /// What to write.
    pub format: F,
    /// The file itself, symbolic links followed.
    place: PathBuf,
}

impl Output {
    /// A file of a folder that is known to be writable, by its own name.
    pub fn at(path: PathBuf, format: Format) -> Self {
        Self { place: path.clone(), path, format }
    }
}

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

/// Where to write, each place checked.
fn places<F>(wanted: Vec<(PathBuf, F)>, inputs: &[&Path]) -> Result<Vec<Output<F>>> {
    let places = places::places(wanted.iter().map(|(path, _)| path.as_path()), inputs)?;
    Ok(wanted.into_iter().zip(places).map(|((path, format), place)| Output { path, format, place }).collect())
}

/// A 16-bit PNG holds what is searched: found out only in the end, all the work would be lost.
pub fn ensure_range(format: Format, path: &Path, params: &Params) -> Result<()> {
    let (first, last) = searched(params);
    ensure!(
        format != Format::Kitti || (first >= 0 && last <= 255),
        "output {path:?} is a 16-bit PNG, which holds 0 to 255.9375 px, but disparities from {first} to {last} px are \
         searched; take .pfm, .npy or .tif, or search another range"
    );
    Ok(())
}

/// The same of many files, by `--format` or by the ending of a pattern; `out`: the pattern or their folder.
pub fn ensure_ranges(formats: &[Format], out: &Path, params: &Params) -> Result<()> {
    let is_pattern = out.file_name().is_some_and(|name| name.to_string_lossy().contains('%'));
    if is_pattern && formats.is_empty() && ending(out) == "png" {
        return ensure_range(Format::Kitti, out, params);
    }
    formats.iter().try_for_each(|format| ensure_range(*format, &out.join("NAME.png"), params))
}

/// A TIFF has at most 4 GiB.
pub fn ensure_size(outputs: &[Output], width: u32, height: u32) -> Result<()> {
    let too_large = 4 * u64::from(width) * u64::from(height) >= (1 << 32) - (1 << 20);
    let of_tiff = |output: &&Output| matches!(output.format, Format::Tiff | Format::Depth(DepthFormat::Tiff));
    match outputs.iter().find(of_tiff).filter(|_| too_large) {
        Some(Output { path, .. }) => {
            bail!("output {path:?} is a TIFF, which cannot hold {width}x{height} floats; take .pfm or .npy")
        }
        None => Ok(()),
    }
}

fn default_map(params: &Params) -> (PathBuf, Format) {
    let format = default_format(params, "disparity");
    (["disparity", format.suffix()].concat().into(), format)
}

/// What a map without a format of its own becomes; said where it is not a PNG.
pub fn default_format(params: &Params, name: &str) -> Format {
    let (first, last) = searched(params);
    if first >= 0 && last <= 255 {
        return Format::Kitti;
    }
    crate::tell(&format!(
        "note: disparities from {first} to {last} px do not fit a 16-bit PNG (0 to 255); writing {name}.tif instead"
    ));
    Format::Tiff
}

/// The smallest and the largest disparity searched.
pub fn searched(params: &Params) -> (i32, i32) {
    params.searched().into_inner()
}

/// What follows the last dot of a name, in small letters.
pub fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// What the ending of a name says.
pub fn map_format(path: &Path) -> Result<Format> {
    Ok(match ending(path).as_str() {
        "png" => Format::Kitti,
        "pfm" => Format::Pfm,
        "npy" => Format::Npy,
        "tif" | "tiff" => Format::Tiff,
        "" => bail!("output {path:?} has no ending, but it tells the format; add .png, .pfm, .npy, .tif or .tiff"),
        other => bail!("output {path:?} ends in .{other}, but .png, .pfm, .npy, .tif and .tiff are known; take one"),
    })
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

/// A file that disappears unless it is renamed, with the permissions that an ordinary new file has.
pub fn temporary(folder: &Path, suffix: &str) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gpu-stereo-").suffix(suffix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666)); // less the umask
    }
    builder.tempfile_in(folder)
}

/// Writes maps to every file, or, if one cannot be written, to none. What tells whether each is still the same later.
pub fn write_maps(outputs: &[Output], maps: &Maps<'_>) -> Result<Vec<Facts>> {
    put(outputs, |format| contents(format, maps))
}

/// The same of a map, its confidence and its errors.
pub fn write(
    outputs: &[Output],
    map: &DisparityMap,
    confidence: Option<&ConfidenceMap>,
    errors: Option<&RgbImage>,
    params: &Params,
) -> Result<Vec<Facts>> {
    write_maps(outputs, &Maps { map, confidence, errors, depth: None, left: None, params })
}

/// Writes a sheet, or nothing.
pub fn write_sheet(outputs: &[Output<SheetFormat>], sheet: &RgbImage) -> Result<()> {
    put(outputs, |format| match format {
        SheetFormat::Png => png(sheet),
        SheetFormat::Jpeg => {
            let mut bytes = Cursor::new(Vec::new());
            JpegEncoder::new_with_quality(&mut bytes, 80).encode_image(sheet)?;
            Ok(bytes.into_inner())
        }
    })
    .map(drop)
}

/// Writes every file, or, if one cannot be, none: names appear only when all contents are on disk.
fn put<F: Copy>(outputs: &[Output<F>], contents: impl Fn(F) -> Result<Vec<u8>>) -> Result<Vec<Facts>> {
    let mut written = Vec::new();
    for output in outputs {
        let bytes = contents(output.format).with_context(|| format!("output {:?} cannot be written", output.path))?;
        if let Some(what) = fs::symlink_metadata(&output.place).ok().and_then(|kind| in_the_way(kind.file_type())) {
            bail!(
                "output {:?} cannot be written: {what} is in its place; remove it, or give another name",
                output.path
            );
        }
        let file = stage(folder_of(&output.place), &bytes).map_err(|error| cannot_write(&output.path, error))?;
        written.push((file, bytes));
    }
    let mut files = Vec::new();
    for ((file, bytes), output) in written.into_iter().zip(outputs) {
        let file = file.persist(&output.place).map_err(|error| {
            let error = cannot_write(&output.path, error.error);
            if files.is_empty() { error } else { error.context(kept(&outputs[..files.len()])) }
        })?;
        files.push((file, bytes));
    }
    for (i, output) in outputs.iter().enumerate() {
        let folder = folder_of(&output.place);
        if outputs[..i].iter().all(|other| folder_of(&other.place) != folder) {
            disk::sync_folder(folder).map_err(|error| cannot_write(&output.path, error))?;
        }
    }
    Ok(files.iter().map(|(file, bytes)| facts(file, bytes)).collect())
}

/// Which of several outputs have their names when another one cannot get its own.
fn kept<F>(outputs: &[Output<F>]) -> String {
    let names: Vec<_> = outputs.iter().map(|output| format!("{:?}", output.path)).collect();
    format!(
        "{} written, the rest not",
        if let [one] = &names[..] { format!("{one} was") } else { names.join(", ") + " were" }
    )
}

/// What tells later whether a file is still the same. One that was left to the system may be lost, whatever its times say.
fn facts(file: &File, bytes: &[u8]) -> Facts {
    let kind = disk::syncs().then(|| file.metadata().ok()).flatten();
    Facts::of_written(bytes, kind.as_ref())
}

/// What a file cannot take the place of. A link is no more than a name.
fn in_the_way(kind: fs::FileType) -> Option<&'static str> {
    if kind.is_symlink() { None } else { disk::other_than_file(kind) }
}

fn folder_of(place: &Path) -> &Path {
    match place.parent() {
        Some(folder) if folder != Path::new("") => folder,
        Some(_) => Path::new("."),
        None => Path::new("/"),
    }
}

/// A file without a name, its contents on the disk.
fn stage(folder: &Path, bytes: &[u8]) -> std::io::Result<NamedTempFile> {
    let mut file = temporary(folder, "")?;
    file.write_all(bytes)?;
    file.flush()?;
    disk::sync(file.as_file())?;
    Ok(file)
}

/// Writes a file of many, whole or not at all; its folder is made where it is missing. What tells whether it is still the
/// same later.
pub fn write_in_folder(path: &Path, bytes: &[u8]) -> Result<Facts> {
    let folder = folder_of(path);
    let write = || -> std::io::Result<Facts> {
        fs::create_dir_all(folder)?;
        let file = stage(folder, bytes)?.persist(path).map_err(|error| error.error)?;
        disk::sync_folder(folder)?;
        Ok(facts(&file, bytes))
    };
    write().map_err(|error| cannot_write(path, error))
}

/// The error that a file cannot be written, and what to do about it.
fn cannot_write(path: &Path, error: std::io::Error) -> anyhow::Error {
    let told = format!("output {path:?} cannot be written; {}", disk::remedy(&error));
    anyhow::Error::from(error).context(told)
}

/// A picture as PNG.
pub fn png(picture: &RgbImage) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_with_encoder(PngEncoder::new(&mut bytes))?;
    Ok(bytes.into_inner())
}

/// The contents of a file.
pub fn encode(
    format: Format,
    map: &DisparityMap,
    confidence: Option<&ConfidenceMap>,
    errors: Option<&RgbImage>,
    params: &Params,
) -> Result<Vec<u8>> {
    contents(format, &Maps { map, confidence, errors, depth: None, left: None, params })
}

fn contents(format: Format, maps: &Maps<'_>) -> Result<Vec<u8>> {
    let Maps { map, confidence, params, .. } = maps;
    let (width, height) = (map.width, map.height);
    let floats = |invalid: f32| map.data.iter().map(|&value| pixels(value).unwrap_or(invalid)).collect::<Vec<_>>();
    match format {
        Format::Kitti => png16(width, height, kitti(map)?),
        Format::Pfm => pfm(width, height, &floats(f32::INFINITY)),
        Format::Npy => npy(width, height, &floats(f32::NAN)),
        Format::Tiff => tiff(width, height, &floats(f32::NAN)),
        Format::Color => png(&picture(map, searched(params))),
        Format::Mask => {
            let samples: Vec<u8> =
                map.data.iter().map(|&value| if pixels(value).is_some() { 255 } else { 0 }).collect();
            png8(width, height, &samples)
        }
        Format::Confidence => png8(width, height, &confidence.context("no confidence was computed")?.data),
        Format::Depth(format) => {
            let (Some(found), Some(camera), Some(left)) = (maps.depth, &params.depth, maps.left) else {
                bail!("no depth was computed")
            };
            match format {
                DepthFormat::Png => {
                    let (samples, lost) = depth::millimetres(found);
                    if lost > 0 {
                        crate::warnings::warn(&format!(
                            "{lost} pixels are 65.5355 m away or farther, by a baseline of {} m, which a 16-bit PNG in \
                             millimetres cannot hold: they are 0 there; where the baseline is right, .pfm, .npy and .tif hold \
                             them",
                            camera.baseline
                        ));
                    }
                    png16(width, height, samples)
                }
                DepthFormat::Pfm => pfm(width, height, &depth::metres(found, f32::INFINITY)),
                DepthFormat::Npy => npy(width, height, &depth::metres(found, f32::NAN)),
                DepthFormat::Tiff => tiff(width, height, &depth::metres(found, f32::NAN)),
                DepthFormat::Ply => depth::ply(found, camera, left),
                DepthFormat::Pcd => depth::pcd(found, camera, left),
            }
        }
        Format::ErrorMap => png(maps.errors.context("no truth was read")?),
    }
}

fn png8(width: u32, height: u32, samples: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(samples, width, height, ExtendedColorType::L8)?;
    Ok(bytes)
}

fn png16(width: u32, height: u32, samples: Vec<u16>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let samples: Vec<u8> = samples.into_iter().flat_map(u16::to_ne_bytes).collect();
    PngEncoder::new(&mut bytes).write_image(&samples, width, height, ExtendedColorType::L16)?;
    Ok(bytes)
}

fn pfm(width: u32, height: u32, samples: &[f32]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write!(bytes, "Pf\n{width} {height}\n-1.0\n")?;
    for row in samples.chunks(width.max(1) as usize).rev() {
        for sample in row {
            bytes.write_all(&sample.to_le_bytes())?;
        }
    }
    Ok(bytes)
}

fn npy(width: u32, height: u32, samples: &[f32]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::<f32>::new().default_dtype();
    let mut npy = options.shape(&[height.into(), width.into()]).writer(&mut bytes).begin_nd()?;
    npy.extend(samples.iter().copied())?;
    npy.finish()?;
    Ok(bytes)
}

fn tiff(width: u32, height: u32, samples: &[f32]) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    tiff::encoder::TiffEncoder::new(&mut bytes)?
        .write_image::<tiff::encoder::colortype::Gray32Float>(width, height, samples)?;
    Ok(bytes.into_inner())
}

/// Disparity in pixels.
fn pixels(value: i16) -> Option<f32> {
    (value != DisparityMap::INVALID).then(|| f32::from(value) / 16.0)
}

/// 16-bit samples, 256 a pixel; a disparity is in 1/16 pixel, so this is exact.
fn kitti(map: &DisparityMap) -> Result<Vec<u16>> {
    let sample = |(i, &value): (usize, &i16)| {
        let Some(disparity) = pixels(value) else {
            return Ok(0);
        };
        u16::try_from(16 * i32::from(value)).ok().map(|sample| sample.max(1)).with_context(|| {
            let (x, y) = (i % map.width as usize, i / map.width as usize);
            format!(
                "the disparity at ({x}, {y}) is {disparity} px, but a 16-bit PNG holds 0 to {} px; take .pfm, .npy or \
                 .tif, or search another range",
                f32::from(u16::MAX >> 4) / 16.0
            )
        })
    };
    map.data.iter().enumerate().map(sample).collect()
}

/// A map in turbo colours over the disparities `first` to `last`, invalid black.
pub fn picture(map: &DisparityMap, (first, last): (i32, i32)) -> RgbImage {
    let colors = map.color(&(first..=last));
    let mut pixels = colors.chunks_exact(4);
    RgbImage::from_fn(map.width, map.height, |_, _| Rgb(pixels.next().map_or([0; 3], |c| [c[0], c[1], c[2]])))
}

/// A truth in the colours that [`picture`] has.
pub fn truth_picture(map: &FloatMap, (first, last): (i32, i32)) -> RgbImage {
    let color = |&disparity: &f32| match disparity.is_finite() {
        false => [0; 3],
        true => gpu_stereo::turbo((f64::from(disparity) - f64::from(first)) / f64::from((last - first).max(1))),
    };
    let mut values = map.data().iter();
    RgbImage::from_fn(map.width(), map.height(), |_, _| Rgb(values.next().map_or([0; 3], color)))
}

/// An image in 8 bits a channel.
pub fn drawn(image: &Image) -> RgbImage {
    let channels = [0, 1, 2].map(|sample| reference::gray(image, Channel::Sample(sample)).data);
    let mut pixels = 0..;
    let color = |i: usize| channels.each_ref().map(|channel| channel[i]);
    RgbImage::from_fn(image.width(), image.height(), |_, _| Rgb(pixels.next().map_or([0; 3], color)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gpu_stereo::turbo;

    fn map(data: &[i16]) -> DisparityMap {
        DisparityMap { width: data.len() as u32, height: 1, data: data.into() }
    }

    #[test]
    fn kitti_samples_are_exact_and_never_wrap() {
        let samples = kitti(&map(&[DisparityMap::INVALID, 0, 1, 16, 4095])).unwrap();
        assert_eq!(samples, [0, 1, 16, 256, 65520]);
        for (value, told) in [(-1, "-0.0625 px"), (4096, "256 px"), (i16::MAX, "2047.9375 px")] {
            let error = kitti(&map(&[0, value])).unwrap_err().to_string();
            assert!(error.contains(told) && error.contains("(1, 0)") && error.contains("255.9375"), "{error}");
        }
    }

    #[test]
    fn colors_span_the_searched_range() {
        let mut params = Params::sgm(17);
        params.min_disparity = -8;
        let colors = picture(&map(&[-8 * 16, 0, 8 * 16, DisparityMap::INVALID]), searched(&params));
        let expected = [turbo(0.0), turbo(0.5), turbo(1.0), [0; 3]];
        assert!(colors.pixels().map(|color| color.0).eq(expected));
        picture(&map(&[0]), searched(&Params::sgm(1))); // a range of one disparity has no width
    }

    #[test]
    fn an_output_that_fails_last_says_which_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.npy", "b.npy", "c.npy"].map(|name| folder.path().join(name));
        let outputs = paths.each_ref().map(|path| Output::at(path.clone(), Format::Npy));
        let calls = std::cell::Cell::new(0);
        let contents = |_| {
            calls.set(calls.get() + 1);
            if calls.get() == 3 {
                fs::create_dir(&paths[1]).unwrap(); // after it was looked at
            }
            Ok(vec![calls.get()])
        };
        let error = format!("{:#}", put(&outputs, contents).unwrap_err());
        assert!(error.contains("a.npy\" was written, the rest not: output ") && error.contains("b.npy"), "{error}");
        assert_eq!((fs::read(&paths[0]).unwrap(), paths[2].exists()), (vec![1], false));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "temporary files are gone");
    }

    #[test]
    fn a_disparity_that_does_not_fit_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let paths = [folder.path().join("a.npy"), folder.path().join("b.png")];
        let outputs = resolve(&paths, &[], &[], &[], &Params::sgm(8)).unwrap();
        assert!(write(&outputs, &map(&[-16]), None, None, &Params::sgm(8)).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
