//! How a calibration is read: the settings besides its files.

use super::lenses::LensModel;
use super::scale::Scale;
use crate::files::error::{Result, ensure};

/// The unit of lengths in a calibration, of those that have no unit of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
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
#[non_exhaustive]
pub enum KittiPair {
    /// P2 and P3
    Color,
    /// P0 and P1
    Gray,
}

/// How a calibration is read.
///
/// ```
/// use gpu_stereo::files::calibration::{Reading, Unit};
/// let reading = Reading { unit: Some(Unit::Mm), lenses: true, ..Reading::default() };
/// # assert_eq!(reading.alpha, None);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// The unit of its lengths; millimetres in Middlebury's files and ZED's, else metres, if it is not given.
    pub unit: Option<Unit>,
    /// The cameras of a KITTI file; the colour pair, if it is there and nothing is given.
    pub pair: Option<KittiPair>,
    /// The numbers of the left camera and of the right one, in a file of several.
    pub cameras: Option<[u32; 2]>,
    /// The model of lenses whose file names none.
    pub lens: LensModel,
    /// The ratio of the images' size to that of the calibrated ones, if it is given.
    pub scale: Option<Scale>,
    /// Whether the lenses are wanted.
    pub lenses: bool,
    /// How much of the given images the rectified ones show, as OpenCV's alpha, where the file has no rectified cameras: from 0,
    /// where all of the rectified ones has content, to 1, where all of the given ones is seen. `None`: OpenCV's alpha of -1,
    /// the focal length as it is; of fisheyes 0.
    pub alpha: Option<f64>,
    /// Whether the cameras lie one above the other, the upper one in the place of the left one. Calibrations tell it, but for Q.
    pub vertical: bool,
    /// Columns and rows of the rectified images; those of the given ones, if it is not given.
    pub rectified_size: Option<[u32; 2]>,
}

impl Reading {
    /// Refuses what no rectification can have.
    pub(super) fn validate(&self) -> Result<()> {
        if let Some(alpha) = self.alpha {
            ensure!((0.0..=1.0).contains(&alpha), "--alpha is {alpha}, but must be from 0 to 1; give 0, 1 or between");
            ensure!(self.lenses, "--alpha goes with --rectify; give the calibration with it, or drop --alpha");
        }
        if let Some([width, height]) = self.rectified_size {
            ensure!(self.lenses, "--rectified-size goes with --rectify; give the calibration with it, or drop it");
            ensure!(
                [width, height].iter().all(|side| (1..=65_536).contains(side)),
                "--rectified-size is {width}x{height}, but each side must be from 1 to 65536; give columns and rows such as 1280x720"
            );
        }
        Ok(())
    }

    /// Whether rectified cameras are chosen by it.
    pub(super) fn shapes(&self) -> bool {
        self.alpha.is_some() || self.rectified_size.is_some()
    }

    /// Its unit, or the usual one.
    pub(super) fn unit(&self, usual: Unit) -> Unit {
        self.unit.unwrap_or(usual)
    }
}
