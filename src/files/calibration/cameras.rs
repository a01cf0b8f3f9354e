//! The contents of a calibration file.

use super::apart::Apart;
use super::reading::{Reading, Unit};
use super::rectified::RectifiedPair;
use crate::Lens;

/// The cameras of a calibration, and the size and the unit that they were calibrated in.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The kind of its file.
    pub(super) kind: &'static str,
    pub(super) cameras: Cameras,
    /// Columns and rows of the images that were calibrated, if the file gives them.
    pub(super) size: Option<[u32; 2]>,
    /// The unit that its lengths were read in; `None` if they were given in metres on the command line.
    pub(super) unit: Option<Unit>,
    /// How it was read, and how it rectifies.
    pub(super) reading: Reading,
}

/// What a file of some kind has.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    pub cameras: Cameras,
    pub size: Option<[u32; 2]>,
    pub unit: Option<Unit>,
}

/// The cameras of a pair.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cameras {
    /// Of a pair that is rectified.
    Rectified(RectifiedPair),
    /// The rectified cameras, and the lenses of the given ones.
    Lenses(RectifiedPair, Box<[Lens; 2]>),
    /// The given cameras and the pose of one to the other.
    Apart(Box<Apart>),
    /// The same of images of several sizes.
    Sizes(Vec<OfSize>),
}

/// The cameras as they take images of one size.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OfSize {
    /// What the file calls it.
    pub name: String,
    /// Columns and rows, if the name is a known one.
    pub size: Option<[u32; 2]>,
    pub apart: Apart,
}
