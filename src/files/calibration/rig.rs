//! Cameras on one body, of which a pair is taken.

use super::algebra::{Matrix, Pose};
use super::apart::Apart;
use super::cameras::{Cameras, Found};
use super::lenses::ensure_rotation;
use super::reading::{Reading, Unit};
use crate::Distortion;
use crate::files::error::{Result, ensure};

/// A camera of a rig.
pub struct RigCamera {
    pub matrix: Matrix,
    pub distortion: Distortion,
    /// Columns and rows, if they are known.
    pub size: Option<[u32; 2]>,
    /// From what all cameras of the rig share to this one, with lengths as they are in the file.
    pub pose: Pose,
}

/// The numbers of the two cameras that are wanted, of the `names` that there are.
pub fn chosen(names: &[String], reading: &Reading) -> Result<[usize; 2]> {
    let count = names.len();
    let all = names.join(", ");
    ensure!(count >= 2, "it is of one camera, {all}, but a pair needs two; calibrate both cameras together");
    let Some(pair) = reading.cameras else {
        ensure!(
            count == 2,
            "it is of {count} cameras, {all}; give --calib-cams LEFT,RIGHT, the numbers of those that took the pair, such as \
             --calib-cams 0,1"
        );
        return Ok([0, 1]);
    };
    ensure!(
        pair.iter().all(|&camera| (camera as usize) < count),
        "--calib-cams is {},{}, but it is of the cameras 0 to {} ({all}); give two of these",
        pair[0],
        pair[1],
        count - 1
    );
    Ok(pair.map(|camera| camera as usize))
}

/// The pair, the left camera first; `what`: what says where the cameras are.
pub fn pair([left, right]: [RigCamera; 2], what: &str, reading: &Reading) -> Result<Found> {
    ensure!(
        left.size == right.size,
        "its two cameras differ in their resolution, {} and {}; use two cameras of one size",
        in_words(left.size),
        in_words(right.size)
    );
    let unit = reading.unit(Unit::M);
    for camera in [&left, &right] {
        ensure_rotation(&camera.pose.rotation, what)?;
    }
    let Pose { rotation, translation } = right.pose.after(&left.pose.inverse());
    let cameras = [(left.matrix, left.distortion), (right.matrix, right.distortion)];
    let apart = Apart::new(cameras, rotation, translation.map(|x| x * unit.metres()))?;
    Ok(Found { cameras: Cameras::Apart(Box::new(apart)), size: left.size, unit: Some(unit) })
}

/// A camera matrix of fx, fy, cx and cy.
pub fn matrix_of([fx, fy, cx, cy]: [f64; 4], name: &str) -> Result<Matrix> {
    ensure!(
        fx > 0.0 && fy > 0.0,
        "the focal lengths of its {name} are {fx} and {fy}, but must be more than 0; calibrate again"
    );
    Ok([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])
}

fn in_words(size: Option<[u32; 2]>) -> String {
    size.map_or("no size".into(), |[width, height]| format!("{width}x{height}"))
}
