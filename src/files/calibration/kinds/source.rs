//! A calibration file whose kind is known.

use super::{basalt, camera_info, euroc, foundation_stereo, kalibr, kitti, middlebury, opencv, plain, zed};
use crate::files::calibration::cameras::Found;
use crate::files::calibration::content::tree::{Tree, has};
use crate::files::calibration::content::{self, is_archive};
use crate::files::calibration::lenses::DISTORTION;
use crate::files::calibration::reading::Reading;
use crate::files::error::{Context as _, Result, bail, ensure, error};
use std::fs;
use std::path::Path;

/// The largest file that is read.
const MAX_BYTES: u64 = 1 << 20;

/// The calibration in two files.
type OfTwo<T> = fn(&T, &T, Reading) -> Result<Found>;

/// A kind of calibration file; `T` is what its text is parsed into.
struct Kind<T: ?Sized + 'static> {
    name: &'static str,
    /// Whether a file has its structure.
    is: fn(&T) -> bool,
    /// The calibration in a file.
    read: fn(&T, Reading) -> Result<Found>,
    /// The same of the left camera's file and the right one's, or of two files of one calibration.
    pair: Option<OfTwo<T>>,
    /// Whether a file may have several cameras, of which `--calib-cams` takes two.
    several: bool,
}

/// Files of lines.
const LINES: [Kind<str>; 4] = [
    Kind { name: "Middlebury (calib.txt)", is: middlebury::is, read: middlebury::read, pair: None, several: false },
    Kind { name: "ZED (SN*.conf)", is: zed::is, read: zed::read, pair: None, several: false },
    Kind { name: kitti::NAME, is: kitti::is, read: kitti::read, pair: None, several: true },
    Kind {
        name: "FoundationStereo (K.txt)",
        is: foundation_stereo::is,
        read: foundation_stereo::read,
        pair: None,
        several: false,
    },
];

/// Files of YAML, JSON, XML or NumPy's.
const TREES: [Kind<Tree>; 7] = [
    Kind { name: "Kalibr (camchain.yaml)", is: kalibr::is, read: kalibr::read, pair: None, several: true },
    Kind { name: "Basalt (calibration.json)", is: basalt::is, read: basalt::read, pair: None, several: true },
    Kind { name: "EuRoC (sensor.yaml)", is: euroc::is, read: euroc::read, pair: Some(euroc::pair), several: false },
    Kind { name: PLAIN, is: plain::is, read: plain::read, pair: None, several: false },
    Kind { name: FOREIGN_KIND, is: |tree| foreign(tree).is_some(), read: refuse, pair: None, several: false },
    Kind {
        name: "ROS (camera_info)",
        is: camera_info::is,
        read: camera_info::read,
        pair: Some(camera_info::pair),
        several: false,
    },
    // OpenCV's sample has a file of the lenses, and one of what lies between the cameras.
    Kind {
        name: "OpenCV (YAML, XML, JSON, npz)",
        is: opencv::is,
        read: opencv::read,
        pair: Some(|left, right, reading| opencv::read(&opencv::together(left.clone(), right.clone())?, reading)),
        several: false,
    },
];

const FOREIGN_KIND: &str = "another program";
/// Also of ORB-SLAM.
const PLAIN: &str = "numbers of a rectified pair (fx, cx, cy, baseline)";

/// Known kinds that are not read: a key that only their files have, and what they are called.
const FOREIGN: [(&str, &str); 5] = [
    ("model_type", "camodocal or VINS"),
    ("Camera.type", "ORB-SLAM3's settings"),
    ("Camera1.fx", "ORB-SLAM3's settings"),
    ("Camera.fx", "ORB-SLAM's settings"),
    ("intrinsicMatrix", "DepthAI"),
];

/// The kinds that are read, in words.
fn names() -> String {
    let lines = LINES.iter().map(|kind| kind.name);
    let all = lines.chain(TREES.iter().map(|kind| kind.name).filter(|name| *name != FOREIGN_KIND));
    all.collect::<Vec<_>>().join(", ")
}

fn foreign(tree: &Tree) -> Option<&'static str> {
    let found =
        FOREIGN.iter().find(|(key, _)| tree.keys().any(|name| name == key || name.ends_with(&format!(".{key}"))));
    found.filter(|_| !opencv::is_of_pair(tree) && !has(tree, &["P1"])).map(|(_, name)| *name)
}

fn refuse(tree: &Tree, _: Reading) -> Result<Found> {
    bail!(
        "it is a calibration of {}, which is not supported; write its cameras to a file of OpenCV as M1, D1, M2, D2, R and T, \
         and give that with --rectify",
        foreign(tree).unwrap_or_default()
    )
}

/// A calibration file whose kind is known.
pub struct Source(Content);

enum Content {
    Lines(&'static Kind<str>, String),
    Tree(&'static Kind<Tree>, Tree),
}

impl Source {
    /// Reads a file.
    ///
    /// # Errors
    /// Where it cannot be read, or is of no known kind.
    pub fn read(path: &Path) -> Result<Self> {
        let kind = fs::metadata(path).with_context(|| format!("{path:?} cannot be read; give a calibration file"))?;
        ensure!(kind.is_file(), "{path:?} is not a regular file; give a calibration file");
        ensure!(
            kind.len() <= MAX_BYTES,
            "{path:?} has {} bytes, but a calibration has at most {MAX_BYTES}; give a calibration file",
            kind.len()
        );
        let bytes = fs::read(path).with_context(|| format!("{path:?} cannot be read; check its permissions"))?;
        Self::parse(&bytes).with_context(|| format!("{path:?}"))
    }

    /// Recognises the kind of a file by its bytes.
    ///
    /// # Errors
    /// If it is of no known kind.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        if is_archive(bytes) {
            return Self::of_tree(content::npz(bytes)?);
        }
        let text = std::str::from_utf8(bytes)
            .map_err(|_| error!("it is not text in UTF-8; give a calibration of {}", names()))?;
        let text = text.trim_start_matches('\u{feff}');
        ensure!(!text.trim().is_empty(), "it is empty; give a calibration file");
        let is_xml = text.trim_start().starts_with('<');
        if let Some(kind) = LINES.iter().find(|kind| !is_xml && (kind.is)(text)) {
            return Ok(Self(Content::Lines(kind, text.into())));
        }
        Self::of_tree(match text.trim_start().chars().next() {
            Some('<') => content::xml(text, &names())?,
            Some('{' | '[') => content::json(text, &names())?,
            _ => content::yaml(text, &names())?,
        })
    }

    fn of_tree(tree: Tree) -> Result<Self> {
        match TREES.iter().find(|kind| (kind.is)(&tree)) {
            Some(kind) => Ok(Self(Content::Tree(kind, tree))),
            None => {
                let all: Vec<_> = tree.keys().take(4).map(String::as_str).collect();
                bail!("it is a calibration of no known kind, but has {}; give one of {}", all.join(", "), names())
            }
        }
    }

    /// The kind in words.
    pub fn name(&self) -> &'static str {
        match &self.0 {
            Content::Lines(kind, _) => kind.name,
            Content::Tree(kind, _) => kind.name,
        }
    }

    /// Whether it has the numbers of lenses.
    pub fn has_lenses(&self) -> bool {
        match &self.0 {
            Content::Lines(kind, _) => (kind.name).starts_with("ZED"),
            Content::Tree(kind, _) if kind.name == PLAIN => false,
            Content::Tree(_, tree) => {
                has(tree, DISTORTION.1) || content::canonical(tree).is_ok_and(|tree| has(&tree, DISTORTION.0[0]))
            }
        }
    }

    /// Whether `--calib-pair` chooses among its cameras.
    pub(in crate::files::calibration) fn has_named_pairs(&self) -> bool {
        self.name() == kitti::NAME
    }

    /// Whether it may have several cameras.
    pub(in crate::files::calibration) fn has_several(&self) -> bool {
        match &self.0 {
            Content::Lines(kind, _) => kind.several,
            Content::Tree(kind, _) => kind.several,
        }
    }

    /// The calibration in this file, or in this one and that of the right camera.
    ///
    /// # Errors
    /// If a number is missing or wrong, or the two files do not belong together.
    pub(in crate::files::calibration) fn calibration(&self, right: Option<&Self>, reading: Reading) -> Result<Found> {
        match (&self.0, right.map(|right| &right.0)) {
            (Content::Lines(kind, text), None) => (kind.read)(text, reading),
            (Content::Tree(kind, tree), None) => (kind.read)(tree, reading),
            (Content::Tree(kind, left), Some(Content::Tree(other, right)))
                if kind.name == other.name && kind.pair.is_some() =>
            {
                kind.pair.map_or_else(|| (kind.read)(left, reading), |pair| pair(left, right, reading))
            }
            (_, Some(_)) => bail!(
                "--calib-right goes with ROS (camera_info) and EuRoC (sensor.yaml), a file a camera, or OpenCV, a file of the \
                 lenses and one of what lies between, but these are of {} and {}; drop it",
                self.name(),
                right.map(Self::name).unwrap_or_default()
            ),
        }
    }
}
