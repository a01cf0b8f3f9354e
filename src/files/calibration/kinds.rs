//! The kinds of calibrations, each by the structure of its files.

use super::cameras::Calibration;
use super::reading::Reading;
use super::tree::{self, Tree, has};
use super::{camera_info, kalibr, kitti, middlebury, opencv, zed};
use crate::files::error::{Context as _, Result, bail, ensure, error};
use std::fs;
use std::path::Path;

/// The largest file that is read.
const MAX_BYTES: u64 = 1 << 20;

/// A kind of calibration file; `T` is what its text is parsed into.
pub struct Kind<T: ?Sized + 'static> {
    name: &'static str,
    /// Whether a file has its structure.
    is: fn(&T) -> bool,
    /// The calibration in a file.
    read: fn(&T, Reading) -> Result<Calibration>,
}

/// Files of lines.
const LINES: [Kind<str>; 3] = [
    Kind { name: "Middlebury (calib.txt)", is: middlebury::is, read: middlebury::read },
    Kind { name: "ZED (SN*.conf)", is: zed::is, read: zed::read },
    Kind { name: kitti::NAME, is: kitti::is, read: kitti::read },
];

/// Files of YAML, JSON or XML.
const TREES: [Kind<Tree>; 4] = [
    Kind { name: "Kalibr (camchain.yaml)", is: kalibr::is, read: kalibr::read },
    Kind { name: "another program", is: |tree| foreign(tree).is_some(), read: refuse },
    Kind { name: "ROS (camera_info)", is: camera_info::is, read: camera_info::read },
    Kind { name: "OpenCV (YAML, XML)", is: opencv::is, read: opencv::read },
];

/// Known kinds that are not read: a key that only their files have, and what they are called.
const FOREIGN: [(&str, &str); 7] = [
    ("model_type", "camodocal or VINS"),
    ("Camera.type", "ORB-SLAM3's settings"),
    ("Camera1.fx", "ORB-SLAM3's settings"),
    ("Camera.fx", "ORB-SLAM's settings"),
    ("T_BS.data", "EuRoC (sensor.yaml)"),
    ("cameraData.intrinsicMatrix", "DepthAI"),
    ("value0.intrinsics.camera_type", "Basalt"),
];

/// The kinds that are read, in words.
pub fn names() -> String {
    let lines = LINES.iter().map(|kind| kind.name);
    let all = lines.chain(TREES.iter().map(|kind| kind.name).filter(|name| *name != TREES[1].name));
    all.collect::<Vec<_>>().join(", ")
}

fn foreign(tree: &Tree) -> Option<&'static str> {
    let readable = has(tree, opencv::READABLE);
    let found =
        FOREIGN.iter().find(|(key, _)| tree.keys().any(|name| name == key || name.ends_with(&format!(".{key}"))));
    found.filter(|_| !readable).map(|(_, name)| *name)
}

fn refuse(tree: &Tree, _: Reading) -> Result<Calibration> {
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
        let text = std::str::from_utf8(bytes)
            .map_err(|_| error!("it is not text in UTF-8; give a calibration of {}", names()))?;
        let text = text.trim_start_matches('\u{feff}');
        ensure!(!text.trim().is_empty(), "it is empty; give a calibration file");
        let is_xml = text.trim_start().starts_with('<');
        if let Some(kind) = LINES.iter().find(|kind| !is_xml && (kind.is)(text)) {
            return Ok(Self(Content::Lines(kind, text.into())));
        }
        let tree = if is_xml { tree::xml(text, &names()) } else { tree::yaml(text, &names()) }?;
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

    /// The calibration in this file, or in this one and that of the right camera.
    ///
    /// # Errors
    /// If a number is missing or wrong, or the two files do not belong together.
    pub fn calibration(self, right: Option<Self>, reading: Reading) -> Result<Calibration> {
        match (self.0, right.map(|right| right.0)) {
            (Content::Lines(kind, text), None) => (kind.read)(&text, reading),
            (Content::Tree(kind, tree), None) => (kind.read)(&tree, reading),
            (Content::Tree(a, left), Some(Content::Tree(b, right)))
                if camera_info::is(&left) && camera_info::is(&right) =>
            {
                ensure!(a.name == b.name, "one file is of {} and one of {}; give two of a kind", a.name, b.name);
                camera_info::pair(&left, &right, reading)
            }
            (Content::Tree(_, left), Some(Content::Tree(_, right))) if opencv::is(&left) && opencv::is(&right) => {
                // OpenCV's sample has a file of the lenses, and one of what lies between the cameras.
                opencv::read(&opencv::together(left, right)?, reading)
            }
            (left, Some(right)) => bail!(
                "--calib-right goes with ROS (camera_info), a file a camera, or OpenCV, a file of the lenses and one of what lies \
                 between, but these are of {} and {}; drop it",
                Self(left).name(),
                Self(right).name()
            ),
        }
    }
}
