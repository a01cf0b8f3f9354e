//! EuRoC's sensor.yaml, a file for each camera: `T_BS` from the camera to the body, and the lens.

use crate::Distortion;
use crate::files::calibration::algebra::Pose;
use crate::files::calibration::cameras::Found;
use crate::files::calibration::content::tree::{Tree, has, matrix, whole};
use crate::files::calibration::lenses::{LensModel, of_model};
use crate::files::calibration::reading::Reading;
use crate::files::calibration::rig::{self, RigCamera, matrix_of};
use crate::files::error::{Context as _, Result, bail, ensure};

pub fn is(tree: &Tree) -> bool {
    has(tree, &["T_BS"]) && has(tree, &["intrinsics", "distortion_coefficients"])
}

pub fn read(_: &Tree, _: Reading) -> Result<Found> {
    bail!(
        "it is the calibration of one camera; give that of the right one with --calib-right, such as cam1/sensor.yaml"
    )
}

/// Both cameras.
pub fn pair(left: &Tree, right: &Tree, reading: Reading) -> Result<Found> {
    let choice = if reading.lenses { reading.lens } else { LensModel::Auto };
    let [left, right] = [left, right].map(|tree| camera(tree, choice));
    rig::pair([left.context("the left camera")?, right.context("the right camera")?], "T_BS", &reading)
}

fn camera(tree: &Tree, choice: LensModel) -> Result<RigCamera> {
    let word = |key: &str| tree.get(key).and_then(|values| values.first()).map(String::as_str);
    let model = word("camera_model").unwrap_or("pinhole");
    ensure!(model == "pinhole", "it is of the camera_model {model:?}, but pinhole is known; calibrate with that");
    let numbers = matrix(tree, &["intrinsics"], &[(1, 4)])?.context("it has no intrinsics; download it again")?;
    let matrix_3x3 = matrix_of(std::array::from_fn(|i| numbers[i]), "camera")?;
    let shapes = Distortion::PINHOLE_COUNTS.map(|count| (1, count));
    let what = "distortion_coefficients";
    let bent = matrix(tree, &[what, "distortion_coeffs"], &shapes)?.unwrap_or_default();
    let distortion = of_model(&bent, word("distortion_model").or(word("distortion_type")), choice, what)?;
    let pose = matrix(tree, &["T_BS"], &[(4, 4)])?.context("it has no T_BS; download it again")?;
    let size = match tree.get("resolution").map(Vec::as_slice) {
        Some([width, height]) => Some([whole(width)?, whole(height)?]),
        _ => None,
    };
    let pose = Pose::of_matrix(&std::array::from_fn(|i| pose[i])).inverse();
    Ok(RigCamera { matrix: matrix_3x3, distortion, size, pose })
}
