//! Which files form a pair, and what is in them.

use std::fs;
use std::path::{Path, PathBuf};

use gpu_stereo::Image;
use gpu_stereo::files::calibration::{Calibration, Reading};
use gpu_stereo::files::encoders;
use gpu_stereo::files::images::{self, Bits, ImagePair};

/// The files of the left and the right image.
pub type Paths = [PathBuf; 2];

/// A pair as it was read.
#[derive(Clone)]
pub struct Pair {
    pub left: Image,
    pub right: Image,
    /// Both as they are shown: RGBA, 8 bits each.
    pub shown: [Vec<u8>; 2],
    pub camera: Camera,
}

/// What turns disparities into depth. Where no calibration is known, the focal length is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Camera {
    /// Pixels.
    pub focal: f32,
    /// Metres.
    pub baseline: f32,
    /// Difference of the principal points, right less left, in pixels.
    pub doffs: f32,
    /// Principal point of the left image, if it is known.
    pub centre: Option<[f32; 2]>,
}

impl Camera {
    /// Metres; nothing where the disparity or the calibration says none.
    pub fn depth(&self, disparity: f32) -> Option<f32> {
        let depth = self.focal * self.baseline / (disparity + self.doffs);
        (depth.is_finite() && depth > 0.0).then_some(depth)
    }

    /// From a calibration file, if there is one of images of this size.
    fn read(path: &Path, width: u32, height: u32) -> Option<Self> {
        let fitted =
            Calibration::read(path, None, Reading::default()).and_then(|found| found.fit(width, height)).ok()?;
        let gpu_stereo::Camera { focal, baseline, doffs, cx, cy, .. } = fitted.camera;
        let [focal, baseline, doffs] = [focal, baseline, doffs].map(|value| value as f32);
        Some(Self { focal, baseline, doffs, centre: Some([cx as f32, cy as f32]) })
    }
}

/// The pairs of two files or of two folders, the left one first.
pub fn pairs(first: &Path, second: &Path) -> Result<Vec<Paths>, String> {
    let (left, right) = in_order(first, second);
    match (left.is_dir(), right.is_dir()) {
        (false, false) => Ok(vec![[left.into(), right.into()]]),
        (true, true) => sequence(left, right),
        _ => Err(format!("{left:?} and {right:?} are a file and a folder; give two files or two folders")),
    }
}

/// The same names in both folders, else as many names in each, one after the other.
fn sequence(left: &Path, right: &Path) -> Result<Vec<Paths>, String> {
    let (lefts, rights) = (pictures(left)?, pictures(right)?);
    let name = |path: &PathBuf| path.file_name().map(ToOwned::to_owned);
    let both: Vec<Paths> = lefts
        .iter()
        .filter_map(|path| Some([path.clone(), rights.iter().find(|other| name(other) == name(path))?.clone()]))
        .collect();
    match (both.len(), lefts.len(), rights.len()) {
        (0, l, r) if l == r && l > 0 => Ok(lefts.into_iter().zip(rights).map(|(l, r)| [l, r]).collect()),
        (0, l, r) => Err(format!("{left:?} has {l} images and {right:?} {r}, no name in common; give as many in each")),
        _ => Ok(both),
    }
}

/// The images of a folder by name.
fn pictures(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{folder:?} cannot be read: {error}"))?;
    let paths = entries.flatten().map(|entry| entry.path());
    let mut paths: Vec<_> = paths.filter(|path| images::has_image_ending(path)).collect();
    paths.sort();
    Ok(paths)
}

/// The left one first, if the last part that differs says which one it is: left/right, l/r, or the lower number. Else
/// as they were given.
pub fn in_order<'a>(first: &'a Path, second: &'a Path) -> (&'a Path, &'a Path) {
    let parts = |path: &Path| path.iter().map(|part| part.to_string_lossy().to_lowercase()).collect::<Vec<_>>();
    let (a, b) = (parts(first), parts(second));
    let differing = a.iter().rev().zip(b.iter().rev()).find(|(a, b)| a != b);
    let swapped = differing.is_some_and(|(a, b)| is_right_of(a, b));
    if swapped { (second, first) } else { (first, second) }
}

/// Whether the names differ in one place only, and `a` is the right one by it.
fn is_right_of(a: &str, b: &str) -> bool {
    if a.contains("right") && a.replacen("right", "left", 1) == b {
        return true;
    }
    let mut from = a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count();
    // Whole numbers, so that 10 is not taken for less than 9.
    from -= a.bytes().take(from).rev().take_while(u8::is_ascii_digit).count();
    let (Some(a), Some(b)) = (a.get(from..), b.get(from..)) else { return false };
    let number = |text: &str| text.split_once(|c: char| !c.is_ascii_digit()).map_or(text, |(n, _)| n).parse::<u64>();
    match (number(a), number(b)) {
        (Ok(x), Ok(y)) => x > y,
        _ => a.starts_with('r') && b.starts_with('l') && a[1..] == b[1..],
    }
}

/// Reads a pair, and the calibration beside it.
pub fn read([left, right]: &Paths) -> Result<Pair, String> {
    let calib = left.with_file_name("calib.txt");
    let ImagePair { left, right, .. } =
        images::read_pair(left, right, Bits::Auto).map_err(|error| error.to_string())?;
    let camera = Camera::read(&calib, left.width(), left.height()).unwrap_or_default();
    let shown = [encoders::rgba8(&left), encoders::rgba8(&right)];
    Ok(Pair { left, right, shown, camera })
}
