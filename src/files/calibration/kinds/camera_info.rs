//! ROS camera_info in YAML, a file for each camera: `camera_matrix`, `projection_matrix`, .. or `K`, `P`, ..

use super::opencv;
use crate::files::calibration::cameras::{Cameras, Found};
use crate::files::calibration::content::tree::{Tree, has, matrix, size_of};
use crate::files::calibration::lenses::{MATRIX, PROJECTION, lens};
use crate::files::calibration::reading::{Reading, Unit};
use crate::files::calibration::rectified::of_projections;
use crate::files::error::{Context as _, Result, bail, ensure};

pub fn is(tree: &Tree) -> bool {
    (has(tree, PROJECTION.1) || has(tree, MATRIX.1)) && !opencv::is_of_pair(tree)
}

pub fn read(_: &Tree, _: Reading) -> Result<Found> {
    bail!("it is the calibration of one camera; give that of the right one with --calib-right")
}

/// Both cameras.
pub fn pair(left: &Tree, right: &Tree, reading: Reading) -> Result<Found> {
    let [left_size, right_size] = [size_of(left)?, size_of(right)?];
    ensure!(
        left_size == right_size,
        "the left camera has {} and the right one {}; use two calibrations of one size",
        pixels_of(left_size),
        pixels_of(right_size)
    );
    let projection = |tree| {
        matrix(tree, PROJECTION.1, &[(3, 4)])?.context(
            "a file has no projection_matrix; calibrate both cameras as one pair (stereoCalibrate, cameracalibrator with two \
             cameras)",
        )
    };
    let unit = reading.unit(Unit::M);
    let camera = of_projections(&projection(left)?, &projection(right)?, unit.metres())?;
    let cameras = match reading.lenses {
        true => {
            let [left, right] = [left, right].map(|tree| lens(tree, reading.lens, |names| names.1));
            Cameras::Lenses(camera, Box::new([left.context("the left camera")?, right.context("the right camera")?]))
        }
        false => Cameras::Rectified(camera),
    };
    Ok(Found { cameras, size: left_size, unit: Some(unit) })
}

/// The size of an image in words.
fn pixels_of(size: Option<[u32; 2]>) -> String {
    size.map_or("no size".into(), |[width, height]| format!("{width}x{height} pixels"))
}
