//! Middlebury's calib.txt, vision.middlebury.edu/stereo/submit3: `cam0=[f 0 cx; 0 f cy; 0 0 1]`, `cam1`, `doffs`, `baseline`,
//! `width`, `height`.

use crate::files::calibration::cameras::{Cameras, Found};
use crate::files::calibration::content::tree::{number, whole};
use crate::files::calibration::reading::{Reading, Unit};
use crate::files::calibration::rectified::of_projections;
use crate::files::error::{Context as _, Result, ensure};
use std::collections::BTreeMap;

fn pairs(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.lines().filter_map(|line| line.split_once('=')).map(|(key, value)| (key.trim(), value.trim()))
}

/// A line `cam0=..` or `cam1=..`.
pub fn is(text: &str) -> bool {
    pairs(text).any(|(key, _)| key == "cam0" || key == "cam1")
}

pub fn read(text: &str, reading: Reading) -> Result<Found> {
    let mut values = BTreeMap::new();
    for (key, value) in pairs(text) {
        let before = values.insert(key, value);
        ensure!(before.is_none_or(|before| before == value), "it has two lines {key}=..; remove the one that is wrong");
    }
    let text = |key: &str| values.get(key).copied().with_context(|| format!("it has no {key}; add a line {key}=.."));
    let matrix = |key: &str| -> Result<Vec<f64>> {
        let given = text(key)?;
        let words = given.trim_matches(['[', ']']).split([' ', ';', ',', '\t']).filter(|word| !word.is_empty());
        let numbers =
            words.map(number).collect::<Result<Vec<_>>>().with_context(|| format!("its {key} is {given:?}"))?;
        ensure!(
            numbers.len() == 9,
            "its {key} has {} numbers, but must have 9: [f 0 cx; 0 f cy; 0 0 1]",
            numbers.len()
        );
        Ok(numbers)
    };
    let (left, right) = (matrix("cam0")?, matrix("cam1")?);
    let unit = reading.unit(Unit::Mm);
    let baseline = number(text("baseline")?).context("its baseline")?;
    let projection =
        |k: &[f64], shift: f64| vec![k[0], k[1], k[2], shift, k[3], k[4], k[5], 0.0, k[6], k[7], k[8], 0.0];
    let pair = of_projections(&projection(&left, 0.0), &projection(&right, -baseline * right[0]), unit.metres())?;
    if let Some(doffs) = values.get("doffs") {
        let doffs = number(doffs).context("its doffs")?;
        ensure!(
            (doffs - pair.camera.doffs).abs() < 0.02,
            "its doffs is {doffs}, but cam1 less cam0 says {}; correct the one or the other",
            pair.camera.doffs
        );
    }
    let size = match (values.get("width"), values.get("height")) {
        (Some(width), Some(height)) => Some([whole(width)?, whole(height)?]),
        _ => None,
    };
    Ok(Found { cameras: Cameras::Rectified(pair), size, unit: Some(unit) })
}
