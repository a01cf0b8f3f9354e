//! The cameras of a run: what the options say, and the settings that follow for images of each size.

use super::range::{RangeFinder, ends, joined};
use crate::args::{self, CameraArgs, DeviceArgs, Range};
use crate::terminal::{message, warnings};
use anyhow::{Result, bail, ensure};
use gpu_stereo::files::calibration::{Calibration, Fitted, LensModel};
use gpu_stereo::files::hash;
use gpu_stereo::files::truth::Truth;
use gpu_stereo::{Camera, DepthMap, Distortion, Error, Image, Lens, Matched, Params, Rectification};
use std::collections::VecDeque;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// What the options say about the cameras.
#[derive(Clone, Debug, Default)]
pub struct Cameras {
    calibration: Option<Calibration>,
    /// Whether the principal point is to be in the middle of the image, along each axis.
    middle: [bool; 2],
    /// Whether the pair is one of an upper and a lower camera, as the options say.
    vertical: bool,
    files: Vec<PathBuf>,
    /// The part that is matched: its upper left pixel, its columns and rows.
    part: Option<[u32; 4]>,
    /// The farthest depth in micrometres.
    farthest: Option<u32>,
}

impl Cameras {
    /// Reads the calibration, if one is given.
    pub fn resolve(given: &CameraArgs) -> Result<Self> {
        let CameraArgs { calib, rectify, calib_right, optics, .. } = given;
        let part = given.crop;
        let farthest = given.max_depth.map(farthest).transpose()?;
        let files = [calib, rectify, calib_right].into_iter().flatten().cloned().collect();
        if let Some(path) = calib.as_ref().or(rectify.as_ref()) {
            // Clap does not require --rectify for --lens if --calib, which excludes it, is given.
            ensure!(
                given.reading.lens == LensModel::Auto || rectify.is_some(),
                "--lens goes with --rectify, since --calib takes a rectified pair; drop it, or give the file with --rectify"
            );
            let reading = given.reading.reading(rectify.is_some());
            let calibration = Some(Calibration::read(path, calib_right.as_deref(), reading)?);
            return Ok(Self {
                calibration,
                middle: [false; 2],
                vertical: given.reading.vertical,
                files,
                part,
                farthest,
            });
        }
        ensure!(
            given.reading.alpha.is_none() && given.reading.rectified_size.is_none(),
            "--alpha and --rectified-size go with --rectify FILE; give the calibration, or drop them"
        );
        let vertical = given.reading.vertical;
        let Some([focal, baseline]) = optics.both()? else {
            return Ok(Self { vertical, part, farthest, ..Self::default() });
        };
        let [doffs, cx, cy] = [given.doffs, given.cx, given.cy].map(Option::unwrap_or_default);
        let camera = Camera::new(focal, baseline).with_doffs(doffs).with_principal_point(cx, cy);
        camera.validate().map_err(args::by_option)?;
        let middle = [given.cx, given.cy].map(|given| given.is_none());
        Ok(Self { calibration: Some(Calibration::typed(camera)), middle, vertical, files, part, farthest })
    }

    /// The same, or else those that the images come with.
    pub fn or(mut self, others: Option<&Calibration>) -> Self {
        self.calibration = self.calibration.or_else(|| others.cloned());
        self
    }

    /// Refuses a depth without cameras (`depth`: the option that asks for one); reports cameras that nothing needs.
    pub fn ensure_fit(&self, depth: Option<&str>, needed_otherwise: bool) -> Result<()> {
        match (&self.calibration, depth) {
            (None, Some(option)) => {
                bail!("{option} needs the cameras; give --calib FILE, --rectify FILE, or --focal PX and --baseline M")
            }
            (Some(calibration), None) if !calibration.has_lenses() && !needed_otherwise => {
                message("note: the cameras have no effect without a depth or points");
            }
            _ => {}
        }
        if let (Some(_), None) = (self.farthest, depth) {
            message("note: --max-depth has no effect without a depth or points");
        }
        Ok(())
    }

    /// Whether images are rectified.
    pub fn rectify(&self) -> bool {
        self.calibration.as_ref().is_some_and(Calibration::has_lenses)
    }

    /// Whether the cameras are known.
    pub fn are_known(&self) -> bool {
        self.calibration.is_some()
    }

    /// Removes depths that are farther away than allowed.
    pub fn cut(&self, matched: &mut Matched) {
        let Some((farthest, depth)) = self.farthest.zip(matched.depth.as_mut()) else { return };
        depth.data.iter_mut().filter(|depth| **depth > farthest).for_each(|depth| *depth = DepthMap::NONE);
    }

    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(PathBuf::as_path)
    }

    /// A digest of all that decides about maps and depths; nothing without cameras.
    pub fn digest(&self) -> Option<String> {
        let Some(calibration) = &self.calibration else {
            let vertical = self.vertical.then(|| "vertical".to_owned());
            let part = self.part.map(|[x, y, width, height]| format!("crop {x},{y},{width},{height}"));
            return vertical.into_iter().chain(part).reduce(|a, b| format!("{a}, {b}"));
        };
        let option = match self.files.is_empty() {
            true => "focal",
            false if calibration.has_lenses() => "rectify",
            false => "calib",
        };
        let all = format!("{calibration:?} {:?} {} {:?} {:?}", self.middle, self.vertical, self.part, self.farthest);
        Some(format!("{option} {}", hash(all.as_bytes())))
    }

    /// Fits the settings to images of a size: rectification, and with `depth` the cameras that it is seen by. Returns the
    /// rectified cameras, if they are known.
    pub fn fit(&self, params: &mut Params, [width, height]: [u32; 2], depth: bool) -> Result<Option<Camera>> {
        let given = [width, height];
        let (mut camera, lenses, size, vertical) = match &self.calibration {
            Some(calibration) => {
                let Fitted { camera, lenses, size, vertical, .. } = calibration.fit(width, height)?;
                if vertical && !self.vertical {
                    message(
                        "note: by the calibration the cameras lie one above the other: LEFT is taken for the upper one",
                    );
                }
                if let Some(doubt) = calibration.doubt(&camera) {
                    warnings::warn(&doubt);
                }
                (Some(self.with_middle(camera, given)), lenses, size, vertical || self.vertical)
            }
            None => (None, None, given, self.vertical),
        };
        let (mut lenses, mut size) = (lenses, size);
        if let Some([x, y, width, height]) = self.part_of(size)? {
            lenses = Some(lenses.unwrap_or([UNCHANGED; 2]).map(|lens| shifted(lens, [x, y])));
            size = [width, height];
            if let Some(camera) = &mut camera {
                (camera.cx, camera.cy) = (camera.cx - f64::from(x), camera.cy - f64::from(y));
            }
        }
        params.rectify = match (lenses, vertical) {
            (Some(lenses), false) => Some(Rectification::of_size(given, size, lenses)?),
            (Some(lenses), true) => Some(Rectification::vertical(given, size, lenses)?),
            (None, true) => Some(Rectification::turn(given)?),
            (None, false) => None,
        };
        params.depth = camera.filter(|_| depth);
        Ok(camera)
    }

    /// The camera with its principal point in the middle of the images, where none was typed.
    fn with_middle(&self, mut camera: Camera, [width, height]: [u32; 2]) -> Camera {
        let [x, y] = self.middle;
        for (is_middle, place, side) in [(x, &mut camera.cx, width), (y, &mut camera.cy, height)] {
            if is_middle {
                *place = f64::from(side - 1) / 2.0;
            }
        }
        camera
    }

    /// The part of images of this size, if it lies within them.
    fn part_of(&self, [width, height]: [u32; 2]) -> Result<Option<[u32; 4]>> {
        let Some([x, y, w, h]) = self.part else { return Ok(None) };
        let within = |from: u32, length: u32, side: u32| from.checked_add(length).is_some_and(|end| end <= side);
        ensure!(
            within(x, w, width) && within(y, h, height),
            "--crop is {x},{y},{w},{h}, but the images have {width}x{height} pixels; give a part that lies within them"
        );
        Ok(self.part)
    }

    /// The truth of given images of a size, as far as it is of the part that is matched. `read`: reads one of a size.
    pub fn truth(&self, given: [u32; 2], read: impl FnOnce((u32, u32)) -> Result<Truth>) -> Result<Truth> {
        let size = match &self.calibration {
            Some(calibration) if calibration.has_lenses() => calibration.fit(given[0], given[1])?.size,
            _ => given,
        };
        let truth = read(size.into())?;
        Ok(match self.part_of(size)? {
            Some(part) => truth.cropped(part)?,
            None => truth,
        })
    }
}

const ONE: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// The lens of images that are rectified.
const UNCHANGED: Lens = Lens::new(ONE, Distortion::NONE, ONE, ONE);

/// A lens whose rectified images begin at a column and a row of those that they were.
fn shifted(mut lens: Lens, [x, y]: [u32; 2]) -> Lens {
    lens.projection[2] -= f64::from(x);
    lens.projection[5] -= f64::from(y);
    lens
}

/// `--max-depth` in micrometres.
fn farthest(metres: f64) -> Result<u32> {
    ensure!(
        metres > 0.0 && metres.is_finite(),
        "--max-depth is {metres}, but must be a number of metres above 0, such as 20; drop it for all depths"
    );
    Ok((metres * 1e6).round().min(f64::from(u32::MAX)) as u32)
}

/// So many sizes of images are kept: the positions of a rectification take 16 bytes a pixel.
const KEPT: usize = 4;

/// The settings of a run over pairs that may differ in size, and have a range each.
pub struct ParamsBySize {
    /// Those that all sizes have in common.
    pub common: Params,
    /// The cameras that they are fitted to.
    pub cameras: Cameras,
    depth: bool,
    known: Mutex<VecDeque<([u32; 2], Arc<Params>)>>,
    ranges: Option<Mutex<Ranges>>,
}

/// The ranges that each pair has of its own.
struct Ranges {
    finder: RangeFinder,
    rule: Range,
    /// What all files can hold.
    held: Option<RangeInclusive<i32>>,
    /// The smallest range that holds all so far.
    all: Option<[i32; 2]>,
}

/// The settings of a pair.
pub struct OfPair {
    /// They.
    pub params: Arc<Params>,
    /// Why its range is doubtful.
    pub doubt: Option<String>,
}

impl ParamsBySize {
    /// `depth`: whether a depth is wanted.
    pub fn new(common: Params, cameras: Cameras, depth: bool) -> Self {
        Self { common, cameras, depth, known: Mutex::default(), ranges: None }
    }

    /// With a range for each pair, if the options leave it to them. `held`: the disparities that all files can hold.
    pub fn with_ranges(self, rule: Range, held: Option<RangeInclusive<i32>>, device: &DeviceArgs) -> Self {
        let finder = RangeFinder::new(device);
        let ranges = rule.is_found().then(|| Mutex::new(Ranges { finder, rule, held, all: None }));
        Self { ranges, ..self }
    }

    /// Sets the range of all pairs.
    pub fn set_range(&mut self, [first, last]: [i32; 2]) {
        let range = (first, last.abs_diff(first) + 1);
        (self.common.min_disparity, self.common.disparities) = range;
        for (_, params) in self.known.get_mut().unwrap_or_else(PoisonError::into_inner) {
            let params = Arc::make_mut(params);
            (params.min_disparity, params.disparities) = range;
        }
    }

    /// Whether each pair has a range of its own.
    pub fn has_ranges(&self) -> bool {
        self.ranges.is_some()
    }

    /// The first and the last disparity of all that was searched, if that is known.
    pub fn searched(&self) -> Option<[i32; 2]> {
        match &self.ranges {
            Some(ranges) => ranges.lock().unwrap_or_else(PoisonError::into_inner).all,
            None => Some(ends(&self.common)),
        }
    }

    /// The settings for a pair. An error that is one of the pair alone is [`Error::Image`].
    pub fn of_pair(&self, pair: [&Image; 2]) -> Result<OfPair> {
        let params = self.of([pair[0].width(), pair[0].height()])?;
        let Some(ranges) = &self.ranges else { return Ok(OfPair { params, doubt: None }) };
        let mut ranges = ranges.lock().unwrap_or_else(PoisonError::into_inner);
        let Ranges { finder, rule, held, all } = &mut *ranges;
        let mut params = Params::clone(&params);
        let coarse = finder.coarse(pair, &params)?;
        let set = coarse.set(*rule, held.as_ref(), &mut params);
        let doubt = set.map_err(|error| Error::Image(format!("{error:#}")))?;
        let found = ends(&params);
        *all = Some(all.map_or(found, |all| joined(all, found)));
        Ok(OfPair { params: Arc::new(params), doubt })
    }

    /// Removes depths that are farther away than allowed.
    pub fn cut(&self, matched: &mut Matched) {
        self.cameras.cut(matched);
    }

    /// The settings for images of a size, but for the range of a pair's own. An error is one of the pair alone: [`Error::Image`].
    pub fn of(&self, size: [u32; 2]) -> Result<Arc<Params>> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, params)) = known.iter().find(|(other, _)| *other == size) {
            return Ok(Arc::clone(params));
        }
        let mut params = self.common.clone();
        self.cameras.fit(&mut params, size, self.depth).map_err(|error| Error::Image(format!("{error:#}")))?;
        let params = Arc::new(params);
        known.push_front((size, Arc::clone(&params)));
        known.truncate(KEPT);
        Ok(params)
    }
}
