//! DataSets: the scenes of a data set's folder.

use super::calibration::{Calibration, Reading};
use super::contents;
use super::error::{Context as _, Result, bail, ensure};
use super::maps::{self, Encoding};
use super::truth::TruthFile;
use crate::Camera;
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder structure of a data set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataSet {
    /// training/{colored_0,colored_1,disp_occ,disp_noc}, else image_0, image_1
    Kitti2012,
    /// training/{image_2,image_3,disp_occ_0,disp_noc_0}
    Kitti2015,
    /// trainingQ/NAME/{im0.png,im1.png,calib.txt,disp0GT.pfm,mask0nocc.png}, and H, F, test; of 2005 and 2006
    /// NAME/{view1.png,view5.png,disp1.png,dmin.txt}
    Middlebury,
    /// two_view_training/NAME with the same files
    Eth3d,
    /// SceneNN/VARIANT/frames/{rgb,depth}/{Camera_0,Camera_1}
    Vkitti2,
    /// A JSON list of scenes, MANIFEST.json in the folder or the file itself
    Manifest,
}

/// Which pixels of a truth are not occluded.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum NonOccluded {
    /// Where this image is 255.
    Mask(PathBuf),
    /// Where this map has a disparity.
    Truth(PathBuf),
}

/// Disparities to search.
#[derive(Clone, Debug)]
pub enum Range {
    /// This number.
    Known(u32),
    /// As `ndisp` in Middlebury's calib.txt.
    Calibration(PathBuf),
    /// Not given by the data set: 128.
    Unknown,
}

/// A pair of a data set.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The part of the data set.
    pub set: String,
    /// Its name there.
    pub name: String,
    /// The left image.
    pub left: PathBuf,
    /// The right image; the left one again if one file holds both views.
    pub right: PathBuf,
    /// The truth, where there is one.
    pub truth: Option<TruthFile>,
    /// Which of its pixels are not occluded, where that is known.
    pub non_occluded: Option<NonOccluded>,
    /// Disparities to search.
    pub range: Range,
    /// What is known of the cameras, which must be rectified.
    pub cameras: Option<SceneCameras>,
}

/// What a data set says of the cameras of a scene.
#[derive(Clone, Debug)]
pub enum SceneCameras {
    /// A calibration in a file.
    File(PathBuf),
    /// The same for all scenes.
    Known(Camera),
    /// Those of Middlebury 2005 and 2006, of images that were reduced by this factor. The file has the disparity, at the full size,
    /// by which the images were shifted.
    Shifted(PathBuf, u32),
}

/// Disparities to search in KITTI: more than any true one.
const KITTI: u32 = 192;
/// Disparities to search where the data set gives no number.
const USUAL: u32 = 128;
/// Virtual KITTI 2: the focal length in px times the distance of the cameras in m (its web page).
const VKITTI2: Camera = Camera { focal: 725.0087, baseline: 0.532725, doffs: 0.0, cx: 620.5, cy: 187.0 };
/// Middlebury 2005 and 2006 (their web pages): the focal length in px at the full size, and the distance of the views 1 and 5 in m.
const VIEWS: (f64, f64) = (3740.0, 0.16);
/// Rows of its images, and by what they were reduced. Truths have disparities of the full size.
const REDUCED: [(u32, u32); 3] = [(1110, 1), (555, 2), (370, 3)];

impl DataSet {
    /// The scenes below a folder, in the order of their names.
    ///
    /// # Errors
    /// If the folder cannot be read or has no scene, or its manifest is wrong.
    pub fn scenes(self, dataset: &Path) -> Result<Vec<Scene>> {
        if self == DataSet::Manifest {
            return manifest(dataset);
        }
        ensure!(dataset.is_dir(), "{dataset:?} is not a folder; give the folder of the data set");
        let (scenes, expected) = match self {
            DataSet::Kitti2015 => {
                let sides = [["image_2", "image_3"]];
                (kitti(dataset, &sides, ["disp_occ_0", "disp_noc_0"])?, "training/image_2/000000_10.png")
            }
            DataSet::Kitti2012 => {
                let sides = [["colored_0", "colored_1"], ["image_0", "image_1"]];
                (kitti(dataset, &sides, ["disp_occ", "disp_noc"])?, "training/colored_0/000000_10.png")
            }
            DataSet::Middlebury => (folders(dataset)?, "trainingQ/NAME/im0.png or NAME/view1.png"),
            DataSet::Eth3d => (folders(dataset)?, "two_view_training/NAME/im0.png"),
            _ => (vkitti2(dataset)?, "Scene01/clone/frames/rgb/Camera_0/rgb_00000.jpg"),
        };
        ensure!(
            !scenes.is_empty(),
            "{dataset:?} has no scene, such as {expected}; give its folder, or another --layout"
        );
        Ok(scenes)
    }
}

impl Scene {
    /// Set and name.
    pub fn label(&self) -> String {
        format!("{}/{}", self.set, self.name)
    }

    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let non_occluded =
            self.non_occluded.as_ref().map(|(NonOccluded::Mask(path) | NonOccluded::Truth(path))| path.as_path());
        let range = match &self.range {
            Range::Calibration(path) => Some(path.as_path()),
            _ => None,
        };
        let cameras = match &self.cameras {
            Some(SceneCameras::File(path) | SceneCameras::Shifted(path, _)) if range != Some(path) => {
                Some(path.as_path())
            }
            _ => None,
        };
        let truth = self.truth.iter().flat_map(TruthFile::files);
        [self.left.as_path(), &self.right].into_iter().chain(truth).chain(non_occluded).chain(range).chain(cameras)
    }

    /// The cameras of its images, which have this size; none where the data set does not say them.
    ///
    /// # Errors
    /// If their file cannot be read, or is of images of another size.
    pub fn calibration(&self, [width, height]: [u32; 2]) -> Result<Option<Calibration>> {
        Ok(match &self.cameras {
            None => None,
            Some(SceneCameras::File(path)) => Some(Calibration::read(path, None, Reading::default())?),
            Some(SceneCameras::Known(camera)) => Some(Calibration::typed(*camera)),
            Some(SceneCameras::Shifted(path, factor)) => {
                let bytes = contents::read_file(path, "the shift of a scene")?;
                let text = String::from_utf8_lossy(&bytes);
                let shift = text.trim().parse::<f64>().ok().filter(|shift| shift.is_finite());
                let told: String = text.trim().chars().take(40).collect();
                let shift = shift
                    .with_context(|| format!("{path:?} has {told:?}, but a number of px is needed; correct it"))?;
                let (focal, baseline) = VIEWS;
                let scale = f64::from(*factor);
                let [cx, cy] = [width, height].map(|side| (f64::from(side) - 1.0) / 2.0); // of what is not said
                let camera = Camera { focal: focal / scale, baseline, doffs: shift / scale, cx, cy };
                camera.validate().with_context(|| format!("{path:?}"))?;
                Some(Calibration::typed(camera))
            }
        })
    }

    /// Disparities to search.
    ///
    /// # Errors
    /// If the calibration that gives the number cannot be read.
    pub fn disparities(&self) -> Result<u32> {
        match &self.range {
            Range::Known(disparities) => Ok(*disparities),
            Range::Calibration(path) => Ok(ndisp(path)?.unwrap_or(USUAL)),
            Range::Unknown => Ok(USUAL),
        }
    }
}

impl NonOccluded {
    /// Which pixels are not occluded, in an image of `size`.
    ///
    /// # Errors
    /// If the file cannot be read, or is of another size.
    pub fn read(&self, size: (u32, u32)) -> Result<Vec<bool>> {
        match self {
            Self::Mask(path) => maps::read_mask(path, size),
            Self::Truth(path) => {
                let truth = TruthFile { path: path.clone(), mask: None, encoding: Encoding::default() };
                let map = truth.read(size, path)?.map;
                Ok(map.data().iter().map(|v| v.is_finite()).collect())
            }
        }
    }
}

/// The names in a folder, sorted; none if there is no such folder.
fn names(folder: &Path) -> Result<Vec<String>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let cannot = || format!("{folder:?} cannot be read; check its permissions");
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).with_context(cannot)? {
        names.extend(entry.with_context(cannot)?.file_name().into_string()); // no data set has names beyond Unicode
    }
    names.sort();
    Ok(names)
}

fn existing(path: PathBuf) -> Option<PathBuf> {
    path.exists().then_some(path)
}

fn name_of(folder: &Path) -> String {
    let full = folder.canonicalize().unwrap_or(folder.into());
    full.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Frames with a truth end in _10. The truth of all pixels comes first, the one of those not occluded next.
fn kitti(dataset: &Path, sides: &[[&str; 2]], [all, non_occluded]: [&str; 2]) -> Result<Vec<Scene>> {
    let mut scenes = Vec::new();
    for folder in [dataset.join("training"), dataset.join("testing"), dataset.into()] {
        let set = name_of(&folder);
        let Some([left, right]) = sides.iter().find(|[left, _]| folder.join(left).is_dir()) else { continue };
        for file in names(&folder.join(left))?.into_iter().filter(|name| name.ends_with("_10.png")) {
            let all = existing(folder.join(all).join(&file));
            let non_occluded = existing(folder.join(non_occluded).join(&file));
            let truth =
                |path| TruthFile { path, mask: None, encoding: Encoding { scale: Some(256.0), ..Encoding::default() } };
            scenes.push(Scene {
                set: set.clone(),
                name: file.trim_end_matches(".png").into(),
                left: folder.join(left).join(&file),
                right: folder.join(right).join(&file),
                truth: all.or(non_occluded.clone()).map(truth),
                non_occluded: non_occluded.map(NonOccluded::Truth),
                range: Range::Known(KITTI),
                cameras: None,
            });
        }
    }
    Ok(scenes)
}

/// A scene of Middlebury 2005 or 2006, if a folder is one.
fn views(scene: &Path, set: &str, name: &str) -> Result<Option<Scene>> {
    let [left, right] = ["view1.png", "view5.png"].map(|name| scene.join(name));
    if !left.exists() || !right.exists() {
        return Ok(None);
    }
    // An image that cannot be read is reported where it is matched.
    let rows = image::image_dimensions(&left).map_or(REDUCED[0].0, |(_, rows)| rows);
    let factor = REDUCED.iter().find(|(known, _)| *known == rows).map(|(_, factor)| *factor);
    let factor = factor.with_context(|| {
        format!(
            "{left:?} has {rows} rows, but the images of Middlebury 2005 and 2006 have 1110, 555 or 370, by which the scale of their \
             truths is known; give the others by --layout manifest with gt_scale"
        )
    })?;
    let encoding = Encoding { scale: Some(factor.into()), ..Encoding::default() };
    Ok(Some(Scene {
        set: set.into(),
        name: name.into(),
        left,
        right,
        truth: existing(scene.join("disp1.png")).map(|path| TruthFile { path, mask: None, encoding }),
        non_occluded: None,
        range: Range::Known((256 / factor).next_multiple_of(16)),
        cameras: existing(scene.join("dmin.txt")).map(|path| SceneCameras::Shifted(path, factor)),
    }))
}

/// Folders with im0.png and im1.png, or folders of such folders.
fn folders(dataset: &Path) -> Result<Vec<Scene>> {
    let mut scenes = Vec::new();
    let below = names(dataset)?.into_iter().map(|name| dataset.join(name)).filter(|path| path.is_dir());
    for folder in [dataset.to_path_buf()].into_iter().chain(below) {
        let set = name_of(&folder);
        for name in names(&folder)? {
            let scene = folder.join(&name);
            scenes.extend(views(&scene, &set, &name)?);
            let Some(left) = existing(scene.join("im0.png")) else { continue };
            let truth = |path| TruthFile { path, mask: None, encoding: Encoding::default() };
            let calibration = existing(scene.join("calib.txt"));
            scenes.push(Scene {
                set: set.clone(),
                name,
                left,
                right: scene.join("im1.png"),
                truth: existing(scene.join("disp0GT.pfm")).map(truth),
                non_occluded: existing(scene.join("mask0nocc.png")).map(NonOccluded::Mask),
                range: calibration.clone().map_or(Range::Unknown, Range::Calibration),
                cameras: calibration.map(SceneCameras::File),
            });
        }
    }
    Ok(scenes)
}

/// `ndisp=N` in Middlebury's calib.txt; `None` where it has none.
fn ndisp(path: &Path) -> Result<Option<u32>> {
    let bytes = contents::read_file(path, "a calibration")?;
    let text = String::from_utf8_lossy(&bytes);
    let Some(given) = text.lines().find_map(|line| line.trim().strip_prefix("ndisp=")) else { return Ok(None) };
    let value = given.trim().parse().ok().filter(|value: &u32| *value > 0);
    let value = value.with_context(|| {
        format!("{path:?} has ndisp={given}, but a whole number from 1 on is needed; correct it, or give --disp N")
    });
    value.map(Some)
}

fn vkitti2(dataset: &Path) -> Result<Vec<Scene>> {
    let mut scenes = Vec::new();
    for scene in names(dataset)?.into_iter().filter(|name| name.starts_with("Scene")) {
        for variant in names(&dataset.join(&scene))? {
            let frames = dataset.join(&scene).join(&variant).join("frames");
            let camera = |kind: &str, camera: u32| frames.join(kind).join(format!("Camera_{camera}"));
            for file in names(&camera("rgb", 0))? {
                let Some(number) = file.strip_prefix("rgb_").and_then(|name| name.split('.').next()) else { continue };
                let encoding = Encoding { depth: Some(VKITTI2.focal * VKITTI2.baseline), ..Encoding::default() };
                let depth = existing(camera("depth", 0).join(format!("depth_{number}.png")));
                scenes.push(Scene {
                    set: format!("{scene}/{variant}"),
                    name: number.into(),
                    left: camera("rgb", 0).join(&file),
                    right: camera("rgb", 1).join(&file),
                    truth: depth.map(|path| TruthFile { path, mask: None, encoding }),
                    non_occluded: None,
                    range: Range::Known(KITTI),
                    cameras: Some(SceneCameras::Known(VKITTI2)),
                });
            }
        }
    }
    Ok(scenes)
}

/// An entry of a manifest. Other fields are ignored.
#[derive(Deserialize)]
struct Entry {
    set: String,
    scene: String,
    /// Relative to the manifest; of a sequence with `%06d` for the number of the frame, from 0.
    left: String,
    /// None where the left image holds both views.
    right: Option<String>,
    frames: Option<u32>,
    gt: Option<String>,
    gt_scale: Option<f64>,
    gt_invalid: Option<f64>,
    max_disp: Option<f64>,
    mask: Option<Masks>,
}

#[derive(Deserialize)]
struct Masks {
    nonocc: Option<String>,
}

/// The most frames of a sequence.
const MAX_FRAMES: u32 = 1_000_000;

fn manifest(dataset: &Path) -> Result<Vec<Scene>> {
    let path = if dataset.is_dir() { dataset.join("MANIFEST.json") } else { dataset.into() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let bytes = contents::read_file(&path, "a manifest or its folder")?;
    let entries: Vec<Entry> =
        serde_json::from_slice(&bytes).with_context(|| format!("{path:?} is not a list of scenes; correct it"))?;
    let mut scenes = Vec::new();
    for entry in entries {
        let name = format!("{:?}", format!("{}/{}", entry.set, entry.scene));
        if let Some(scale) = entry.gt_scale
            && !(scale > 0.0 && scale.is_finite())
        {
            bail!("{path:?}: {name} has gt_scale {scale}, but a number above 0 is needed; correct it");
        }
        let range = match entry.max_disp {
            None => Range::Unknown,
            // The multiple of 16 that holds it.
            Some(largest @ 0.0..=100_000.0) => Range::Known((largest as u32 + 16) / 16 * 16),
            Some(largest) => bail!("{path:?}: {name} has max_disp {largest}, but 0 to 100000 is allowed; correct it"),
        };
        let encoding = Encoding { scale: entry.gt_scale, depth: None, invalid: entry.gt_invalid };
        let right = entry.right.as_ref().unwrap_or(&entry.left);
        let scene = Scene {
            set: entry.set,
            name: entry.scene,
            left: folder.join(&entry.left),
            right: folder.join(right),
            truth: entry.gt.map(|gt| TruthFile { path: folder.join(gt), mask: None, encoding }),
            non_occluded: entry.mask.and_then(|masks| masks.nonocc).map(|mask| NonOccluded::Mask(folder.join(mask))),
            range,
            cameras: None,
        };
        let Some(frames) = entry.frames else {
            scenes.push(scene);
            continue;
        };
        ensure!(
            frames <= MAX_FRAMES && scene.truth.is_none(),
            "{path:?}: {name} has {frames} frames, but a sequence has at most {MAX_FRAMES} and no gt; correct it"
        );
        for frame in 0..frames {
            scenes.push(Scene {
                name: format!("{}_{frame:06}", scene.name),
                left: folder.join(entry.left.replace("%06d", &format!("{frame:06}"))),
                right: folder.join(right.replace("%06d", &format!("{frame:06}"))),
                ..scene.clone()
            });
        }
    }
    ensure!(!scenes.is_empty(), "{path:?} lists no scene; add one");
    Ok(scenes)
}
