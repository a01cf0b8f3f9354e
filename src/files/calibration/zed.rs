//! The factory calibration of a ZED, SN*.conf: `[LEFT_CAM_HD]`, `[RIGHT_CAM_HD]`, .. with fx, fy, cx, cy, k1, k2, p1, p2, k3, and
//! `[STEREO]` with the baseline in millimetres and the turns RX, CV (about y) and RZ.

use super::apart::Apart;
use super::cameras::{Calibration, Cameras};
use super::reading::{Reading, Unit};
use super::stereo_rectify::rotation;
use super::tree::number;
use crate::Distortion;
use crate::files::error::{Context as _, Result, bail, ensure};
use std::collections::BTreeMap;

const LEFT: &str = "LEFT_CAM_";

fn sections(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| line.trim().strip_prefix('[')?.strip_suffix(']'))
}

/// A section `[LEFT_CAM_..]`.
pub fn is(text: &str) -> bool {
    sections(text).any(|name| name.starts_with(LEFT))
}

pub fn read(text: &str, reading: Reading) -> Result<Calibration> {
    let names: Vec<_> = sections(text).filter_map(|name| name.strip_prefix(LEFT)).collect();
    // Each has numbers of its own, and none says of which size.
    let [resolution] = names[..] else {
        bail!(
            "it is of the resolutions {}, and none says which is that of the images; leave the sections of one, [LEFT_CAM_..] and \
             [RIGHT_CAM_..]",
            names.join(", ")
        )
    };
    let (mut section, mut values) = (String::new(), BTreeMap::new());
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            section = name.to_uppercase();
        } else if let Some((key, value)) = line.split_once('=') {
            values.insert(format!("{section}.{}", key.trim().to_uppercase()), value.trim());
        }
    }
    let given = |key: String| -> Result<Option<f64>> {
        let value = values.get(&key).map(|value| number(value)).transpose();
        value.with_context(|| format!("its {key}"))
    };
    let needed = |key: String| given(key.clone())?.with_context(|| format!("it has no {key}; download it again"));
    let camera = |side: &str| -> Result<([f64; 9], Distortion)> {
        let of = |key: &str| format!("{side}_CAM_{resolution}.{key}");
        let [fx, fy, cx, cy] = [needed(of("FX"))?, needed(of("FY"))?, needed(of("CX"))?, needed(of("CY"))?];
        ensure!(
            fx > 0.0 && fy > 0.0,
            "its focal lengths are {fx} and {fy}, but must be more than 0; download it again"
        );
        let mut numbers = [0.0; 5];
        for (i, key) in ["K1", "K2", "P1", "P2", "K3"].into_iter().enumerate() {
            numbers[i] = given(of(key))?.unwrap_or(0.0);
        }
        Ok(([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0], Distortion::pinhole(&numbers)?))
    };
    let turn = |key: &str| given(format!("STEREO.{key}_{resolution}")).map(Option::unwrap_or_default);
    for key in ["TY", "TZ"] {
        let all = [given(format!("STEREO.{key}"))?, given(format!("STEREO.{key}_{resolution}"))?];
        ensure!(
            all.iter().flatten().all(|&value| value == 0.0),
            "its {key} is not 0, and which way that lies is not known; save M1, D1, M2, D2, R and T to a file of OpenCV, or set it \
             to 0, which moves rows by a focal length times {key} / baseline"
        );
    }
    let unit = reading.unit(Unit::Mm);
    let baseline = needed("STEREO.BASELINE".into())? * unit.metres();
    let turned = rotation([turn("RX")?, turn("CV")?, turn("RZ")?]);
    let apart = Apart::new([camera("LEFT")?, camera("RIGHT")?], turned, [-baseline, 0.0, 0.0])?;
    Ok(Calibration { cameras: Cameras::Apart(Box::new(apart)), size: None, unit: Some(unit), scale: reading.scale })
}
