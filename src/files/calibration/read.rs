//! From a file, or a file for each camera, to the calibration that is asked for.

use super::cameras::{Calibration, Cameras};
use super::kinds::Source;
use super::kitti;
use super::reading::Reading;
use super::scale::Scale;
use crate::Camera;
use crate::files::error::{Context as _, Result, bail, ensure};
use std::path::Path;

impl Calibration {
    /// Reads a calibration from one file, or from a file for each camera.
    ///
    /// # Errors
    /// If a file cannot be read, or does not have what `reading` asks for.
    pub fn read(path: &Path, right: Option<&Path>, reading: Reading) -> Result<Self> {
        let (source, right_source) = (Source::read(path)?, right.map(Source::read).transpose()?);
        let told = || right.map_or(format!("{path:?}"), |right| format!("{path:?} with {right:?}"));
        Self::of(source, right_source, reading).with_context(told)
    }

    /// The calibration in one file, or in a file for each camera.
    ///
    /// # Errors
    /// If a file does not have what `reading` asks for.
    pub fn of(source: Source, right: Option<Source>, reading: Reading) -> Result<Self> {
        let kitti = source.name() == kitti::NAME;
        ensure!(
            reading.pair.is_none() || kitti,
            "--calib-pair is for calibrations of KITTI, but this is one of {}; drop it",
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
                    "this calibration of {name} has no rectified cameras; give it with --rectify and the images as they were \
                     taken, or give --focal and --baseline for rectified ones"
                ),
            },
            (cameras, _) => cameras,
        };
        if let Cameras::Rectified(camera) | Cameras::Lenses(camera, _) = &found.cameras {
            camera.validate()?;
        }
        Ok(found)
    }

    /// The cameras of a rectified pair that were given as numbers.
    pub fn typed(camera: Camera) -> Self {
        Self { cameras: Cameras::Rectified(camera), size: None, unit: None, scale: Some(Scale::ONE) }
    }

    /// Whether it rectifies.
    pub fn has_lenses(&self) -> bool {
        !matches!(self.cameras, Cameras::Rectified(_))
    }
}
