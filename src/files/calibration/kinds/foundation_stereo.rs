//! FoundationStereo's K.txt: the camera matrix of a rectified pair, 9 numbers in one line, then the baseline in metres.

use crate::files::calibration::cameras::{Cameras, Found};
use crate::files::calibration::content::tree::number;
use crate::files::calibration::reading::{Reading, Unit};
use crate::files::calibration::rectified::of_projections;
use crate::files::error::{Result, ensure};

/// The ten numbers, and nothing else: a line of 9 or three of 3, then one.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let lines: Vec<Vec<f64>> = lines
        .map(|line| {
            let words = line.split([' ', '\t', ',']).filter(|word| !word.is_empty());
            words.map(|word| number(word).ok()).collect::<Option<_>>()
        })
        .collect::<Option<_>>()?;
    let counts: Vec<_> = lines.iter().map(Vec::len).collect();
    [&[9, 1][..], &[3, 3, 3, 1]].contains(&&counts[..]).then(|| lines.concat())
}

pub fn is(text: &str) -> bool {
    numbers(text).is_some()
}

pub fn read(text: &str, reading: Reading) -> Result<Found> {
    let numbers = numbers(text).unwrap_or_default();
    let (k, baseline) = (&numbers[..9], numbers[9]);
    ensure!(
        [k[3], k[6], k[7]] == [0.0; 3] && k[8] == 1.0,
        "its matrix is {k:?}, but must be fx 0 cx 0 fy cy 0 0 1, by rows; correct it"
    );
    ensure!(baseline > 0.0, "its baseline is {baseline}, but must be more than 0, in metres; correct it");
    let unit = reading.unit(Unit::M);
    let projection = |shift: f64| [k[0], k[1], k[2], shift, 0.0, k[4], k[5], 0.0, 0.0, 0.0, 1.0, 0.0];
    let camera = of_projections(&projection(0.0), &projection(-k[0] * baseline), unit.metres())?;
    Ok(Found { cameras: Cameras::Rectified(camera), size: None, unit: Some(unit) })
}
