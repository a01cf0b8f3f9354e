//! The factory calibration of a ZED, SN*.conf: `[LEFT_CAM_HD]`, `[RIGHT_CAM_HD]`, .. with fx, fy, cx, cy, k1, k2, p1, p2, k3, and
//! `[STEREO]` with the baseline, TY and TZ in millimetres and the turns RX, CV (about y) and RZ. Each resolution has numbers of
//! its own; the size of the images tells which.

use crate::Distortion;
use crate::files::calibration::algebra::{Matrix, rotation};
use crate::files::calibration::apart::Apart;
use crate::files::calibration::cameras::{Cameras, Found, OfSize};
use crate::files::calibration::content::tree::number;
use crate::files::calibration::reading::{Reading, Unit};
use crate::files::calibration::rig::matrix_of;
use crate::files::error::{Context as _, Result, bail};
use std::collections::BTreeMap;

const LEFT: &str = "LEFT_CAM_";

/// The names of the resolutions, and the images that they are of.
const RESOLUTIONS: [(&str, [u32; 2]); 8] = [
    ("2K", [2208, 1242]),
    ("FHD", [1920, 1080]),
    ("FHD1200", [1920, 1200]),
    ("HD", [1280, 720]),
    ("VGA", [672, 376]),
    ("SVGA", [960, 600]),
    ("QHDPLUS", [3200, 1800]),
    ("4K", [3840, 2160]),
];

fn sections(text: &str) -> impl Iterator<Item = String> {
    text.lines().filter_map(|line| Some(line.trim().strip_prefix('[')?.strip_suffix(']')?.to_uppercase()))
}

/// A section `[LEFT_CAM_..]`.
pub fn is(text: &str) -> bool {
    sections(text).any(|name| name.starts_with(LEFT))
}

/// The values by section and key, both in capitals.
struct Values<'a>(BTreeMap<String, &'a str>);

impl<'a> Values<'a> {
    fn of(text: &'a str) -> Self {
        let (mut section, mut values) = (String::new(), BTreeMap::new());
        for line in text.lines().map(str::trim) {
            if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                section = name.to_uppercase();
            } else if let Some((key, value)) = line.split_once('=') {
                values.insert(format!("{section}.{}", key.trim().to_uppercase()), value.trim());
            }
        }
        Self(values)
    }

    fn given(&self, key: &str) -> Result<Option<f64>> {
        let value = self.0.get(key).map(|value| number(value)).transpose();
        value.with_context(|| format!("its {key}"))
    }

    fn needed(&self, key: &str) -> Result<f64> {
        self.given(key)?.with_context(|| format!("it has no {key}; download it again"))
    }

    fn camera(&self, side: &str, resolution: &str) -> Result<(Matrix, Distortion)> {
        let of = |key: &str| format!("{side}_CAM_{resolution}.{key}");
        let all = [self.needed(&of("FX"))?, self.needed(&of("FY"))?, self.needed(&of("CX"))?, self.needed(&of("CY"))?];
        let mut numbers = [0.0; 8];
        for (i, key) in ["K1", "K2", "P1", "P2", "K3", "K4", "K5", "K6"].into_iter().enumerate() {
            numbers[i] = self.given(&of(key))?.unwrap_or(0.0);
        }
        Ok((matrix_of(all, &format!("{side}_CAM_{resolution}"))?, Distortion::pinhole(&numbers)?))
    }

    /// A number of `[STEREO]`, of this resolution or of all; 0 if it is not there.
    fn between(&self, key: &str, resolution: &str) -> Result<f64> {
        let own = self.given(&format!("STEREO.{key}_{resolution}"))?;
        Ok(own.or(self.given(&format!("STEREO.{key}"))?).unwrap_or(0.0))
    }

    fn apart(&self, resolution: &str, unit: Unit) -> Result<Apart> {
        let baseline = self.needed("STEREO.BASELINE")?;
        let [rx, cv, rz] =
            [self.between("RX", resolution)?, self.between("CV", resolution)?, self.between("RZ", resolution)?];
        let [ty, tz] = [self.between("TY", resolution)?, self.between("TZ", resolution)?];
        // As Stereolabs' programs take it: (baseline, TY, TZ) is the opposite of OpenCV's T.
        let translation = [-baseline, -ty, -tz].map(|x| x * unit.metres());
        Apart::new(
            [self.camera("LEFT", resolution)?, self.camera("RIGHT", resolution)?],
            rotation([rx, cv, rz]),
            translation,
        )
    }
}

pub fn read(text: &str, reading: Reading) -> Result<Found> {
    let (values, unit) = (Values::of(text), reading.unit(Unit::Mm));
    let mut all = Vec::new();
    for name in sections(text).filter_map(|name| Some(name.strip_prefix(LEFT)?.to_string())) {
        let size = RESOLUTIONS.iter().find(|(known, _)| **known == *name).map(|(_, size)| *size);
        // Not every file has numbers of every resolution.
        let is_empty = values.given(&format!("{LEFT}{name}.FX"))?.is_none_or(|focal| focal == 0.0);
        if !is_empty && !all.iter().any(|other: &OfSize| other.name == name) {
            all.push(OfSize { size, apart: values.apart(&name, unit)?, name });
        }
    }
    let cameras = match all.len() {
        0 => bail!("none of its cameras has an fx; download it again"),
        1 => Cameras::Apart(Box::new(all.remove(0).apart)),
        _ => Cameras::Sizes(all),
    };
    Ok(Found { cameras, size: None, unit: Some(unit) })
}
