//! The contents of a calibration file.

use super::apart::Apart;
use super::reading::Unit;
use super::scale::Scale;
use crate::{Camera, Lens};

/// The cameras of a calibration, and the size and the unit that they were calibrated in.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    pub(super) cameras: Cameras,
    /// Columns and rows of the images that were calibrated, if the file gives them.
    pub(super) size: Option<[u32; 2]>,
    /// The unit that its lengths were read in; `None` if they were given in metres on the command line.
    pub(super) unit: Option<Unit>,
    pub(super) scale: Option<Scale>,
}

/// The cameras of a pair.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cameras {
    /// Of a pair that is rectified.
    Rectified(Camera),
    /// The rectified cameras, and the lenses of the given ones.
    Lenses(Camera, Box<[Lens; 2]>),
    /// The given cameras and the pose of one to the other.
    Apart(Box<Apart>),
}
