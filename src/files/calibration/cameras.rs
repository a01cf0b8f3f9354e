//! What a calibration file says of its cameras.

use super::apart::Apart;
use super::reading::Unit;
use super::scale::Scale;
use crate::{Camera, Lens};

/// What a calibration says.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    pub(super) cameras: Cameras,
    /// Columns and rows of the images that were calibrated, if the file tells.
    pub(super) size: Option<[u32; 2]>,
    /// The unit that its lengths were taken for; none where they were typed in metres.
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
    /// The given cameras and what lies between them.
    Apart(Box<Apart>),
}
