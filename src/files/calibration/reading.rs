//! How a calibration is read: the settings besides its files.

use super::lenses::LensModel;
use super::scale::Scale;

/// The unit of lengths in a calibration, of those that have no unit of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres
    M,
    /// Centimetres
    Cm,
    /// Millimetres
    Mm,
}

impl Unit {
    pub(super) fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
        }
    }

    /// As `--calib-unit` takes it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
        }
    }
}

/// The cameras of a KITTI calibration that took the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KittiPair {
    /// P2 and P3
    Color,
    /// P0 and P1
    Gray,
}

/// How a calibration is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// The unit of its lengths; millimetres in Middlebury's files and ZED's, else metres, if it is not given.
    pub unit: Option<Unit>,
    /// The cameras of a KITTI file; the colour pair, if it is there and nothing is given.
    pub pair: Option<KittiPair>,
    /// The model of lenses whose file names none.
    pub lens: LensModel,
    /// The ratio of the images' size to that of the calibrated ones, if it is given.
    pub scale: Option<Scale>,
    /// Whether the lenses are wanted.
    pub lenses: bool,
}

impl Reading {
    /// Its unit, or the usual one.
    pub(super) fn unit(&self, usual: Unit) -> Unit {
        self.unit.unwrap_or(usual)
    }
}
