//! From a file, or a file for each camera, to the calibration that is asked for.

use super::cameras::{Calibration, Cameras, Found};
use super::kinds::Source;
use super::reading::Reading;
use super::rectified::RectifiedPair;
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
        Self::of(&source, right_source.as_ref(), reading).with_context(told)
    }

    /// The calibration in one file, or in a file for each camera.
    ///
    /// # Errors
    /// If a file does not have what `reading` asks for.
    pub fn of(source: &Source, right: Option<&Source>, reading: Reading) -> Result<Self> {
        let name = source.name();
        ensure!(
            reading.pair.is_none() || source.has_named_pairs(),
            "--calib-pair is for calibrations of KITTI, but this is one of {name}; drop it"
        );
        ensure!(
            reading.cameras.is_none() || source.has_several(),
            "--calib-cams is for calibrations of several cameras, of Kalibr, Basalt or KITTI, but this is one of {name}; drop it"
        );
        reading.validate()?;
        let Found { cameras, size, unit } = source.calibration(right, reading)?;
        let cameras = match (cameras, reading.lenses) {
            (Cameras::Rectified(_), true) => {
                bail!("it has no lenses, since its pairs are rectified; give it with --calib in place of --rectify")
            }
            (Cameras::Lenses(camera, _), false) => Cameras::Rectified(camera),
            (Cameras::Apart(apart), false) => match apart.as_it_is() {
                Some(camera) => Cameras::Rectified(camera?),
                None => return not_rectified(name),
            },
            (Cameras::Sizes(_), false) => return not_rectified(name),
            (cameras, _) => cameras,
        };
        if let Cameras::Rectified(pair) | Cameras::Lenses(pair, _) = &cameras {
            pair.camera.validate()?;
        }
        ensure!(
            !matches!(cameras, Cameras::Lenses(..)) || !reading.shapes(),
            "--alpha and --rectified-size choose rectified cameras, but the file has some (R1, P1, R2, P2); drop them, or give a \
             file of R and T alone"
        );
        Ok(Self { kind: name, cameras, size, unit, reading })
    }

    /// The cameras of a rectified pair that were given as numbers.
    pub fn typed(camera: Camera) -> Self {
        let reading = Reading { scale: Some(Scale::ONE), ..Reading::default() };
        let pair = RectifiedPair { camera, vertical: None };
        Self { kind: "numbers", cameras: Cameras::Rectified(pair), size: None, unit: None, reading }
    }

    /// The kind of its file, in words.
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// Whether it rectifies.
    pub fn has_lenses(&self) -> bool {
        !matches!(self.cameras, Cameras::Rectified(_))
    }
}

fn not_rectified(name: &str) -> Result<Calibration> {
    bail!(
        "this calibration of {name} has no rectified cameras; give it with --rectify and the images as they were taken, or give \
         --focal and --baseline for rectified ones"
    )
}
