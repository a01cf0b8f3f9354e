//! Calibration files become the cameras of a pair: the structure of a file tells its kind (`kinds`), and what it says is
//! fitted to the images (`fit`).

mod camera_info;
mod fit;
mod kalibr;
mod kinds;
mod kitti;
mod lenses;
mod middlebury;
mod opencv;
mod rectified;
mod stereo_rectify;
#[cfg(test)]
mod tests;
mod tree;
mod zed;

use crate::files::error::{Context as _, Result, bail, ensure};
use crate::{Camera, Lens};
use fit::Apart;
pub use fit::{Fitted, Scale};
pub use kinds::Source;
pub use lenses::LensModel;
use std::path::Path;

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
    fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
        }
    }

    /// As `--calib-unit` takes it.
    fn name(self) -> &'static str {
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

/// What is asked of a calibration beside its file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// The unit of its lengths; millimetres in Middlebury's files and ZED's, else metres, if it is not given.
    pub unit: Option<Unit>,
    /// The cameras of a KITTI file; the colour pair, if it is there and nothing is given.
    pub pair: Option<KittiPair>,
    /// The model of lenses whose file names none.
    pub lens: LensModel,
    /// The images' size by that of the calibrated ones, if it is given.
    pub scale: Option<Scale>,
    /// Whether the lenses are wanted.
    pub lenses: bool,
}

impl Reading {
    /// Its unit, or the usual one.
    fn unit(&self, usual: Unit) -> Unit {
        self.unit.unwrap_or(usual)
    }
}

/// What a calibration says.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    cameras: Cameras,
    /// Columns and rows of the images that were calibrated, if the file tells.
    size: Option<[u32; 2]>,
    /// The unit that its lengths were taken for; none where they were typed in metres.
    unit: Option<Unit>,
    scale: Option<Scale>,
}

/// The cameras of a pair.
#[derive(Clone, Debug, PartialEq)]
enum Cameras {
    /// Of a pair that is rectified.
    Rectified(Camera),
    /// The rectified cameras, and the lenses of the given ones.
    Lenses(Camera, Box<[Lens; 2]>),
    /// The given cameras and what lies between them.
    Apart(Box<Apart>),
}

impl Calibration {
    /// A calibration of one file, or of a file for each camera.
    pub fn read(path: &Path, right: Option<&Path>, reading: Reading) -> Result<Self> {
        let (source, right_source) = (Source::read(path)?, right.map(Source::read).transpose()?);
        let told = || right.map_or(format!("{path:?}"), |right| format!("{path:?} with {right:?}"));
        Self::of(source, right_source, reading).with_context(told)
    }

    /// What one file says, or a file for each camera.
    pub fn of(source: Source, right: Option<Source>, reading: Reading) -> Result<Self> {
        let kitti = source.name() == kitti::NAME;
        ensure!(
            reading.pair.is_none() || kitti,
            "--calib-pair is for the calibrations of KITTI, and this is one of {}; drop it",
            source.name()
        );
        let name = source.name();
        let mut found = source.calibration(right, reading)?;
        found.cameras = match (found.cameras, reading.lenses) {
            (Cameras::Rectified(_), true) => {
                bail!("it has no lenses, since its pairs are rectified; give it with --calib in place of --rectify")
            }
            (Cameras::Lenses(camera, _), false) => Cameras::Rectified(camera),
            (Cameras::Apart(apart), false) => match apart.as_it_is() {
                Some(camera) => Cameras::Rectified(camera?),
                None => bail!(
                    "this calibration of {name} is of cameras that are not rectified, and of none that are; give it with \
                     --rectify and the images as they were taken, or for rectified ones --focal and --baseline"
                ),
            },
            (cameras, _) => cameras,
        };
        if let Cameras::Rectified(camera) | Cameras::Lenses(camera, _) = &found.cameras {
            camera.validate()?;
        }
        Ok(found)
    }

    /// The cameras of a rectified pair that were typed.
    pub fn typed(camera: Camera) -> Self {
        Self { cameras: Cameras::Rectified(camera), size: None, unit: None, scale: Some(Scale::ONE) }
    }

    /// Whether it rectifies.
    pub fn has_lenses(&self) -> bool {
        !matches!(self.cameras, Cameras::Rectified(_))
    }
}
