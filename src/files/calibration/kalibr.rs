//! Kalibr's camchain.yaml: `cam0` and `cam1`, each with its lens, and `T_cn_cnm1` from the first to the second.

use super::apart::Apart;
use super::cameras::{Calibration, Cameras};
use super::lenses::{LensModel, ensure_rotation, of_model};
use super::reading::{Reading, Unit};
use super::tree::{Tree, matrix, whole};
use crate::Distortion;
use crate::files::error::{Context as _, Result, ensure};

pub fn is(tree: &Tree) -> bool {
    ["cam0.intrinsics", "cam0.camera_model", "cam1.intrinsics", "cam1.T_cn_cnm1"]
        .iter()
        .any(|key| tree.contains_key(*key))
}

pub fn read(tree: &Tree, reading: Reading) -> Result<Calibration> {
    let unit = reading.unit(Unit::M);
    let size = |camera: &str| -> Result<Option<[u32; 2]>> {
        match tree.get(&format!("{camera}.resolution")).map(Vec::as_slice) {
            Some([width, height]) => Ok(Some([whole(width)?, whole(height)?])),
            _ => Ok(None),
        }
    };
    ensure!(
        size("cam0")? == size("cam1")?,
        "its cam0 and cam1 differ in their resolution; use two cameras of one size"
    );
    let between = matrix(tree, &["cam1.T_cn_cnm1"], &[(4, 4)])?
        .context("it has no T_cn_cnm1 of cam1; calibrate both cameras together, by kalibr_calibrate_cameras")?;
    let rotation = std::array::from_fn(|i| between[i / 3 * 4 + i % 3]);
    ensure_rotation(&rotation, "T_cn_cnm1")?;
    let translation = [3, 7, 11].map(|i| between[i] * unit.metres());
    // A rectified pair needs no lenses.
    let choice = if reading.lenses { reading.lens } else { LensModel::Auto };
    let cameras = [camera(tree, "cam0", choice)?, camera(tree, "cam1", choice)?];
    let cameras = Cameras::Apart(Box::new(Apart::new(cameras, rotation, translation)?));
    Ok(Calibration { cameras, size: size("cam0")?, unit: Some(unit), scale: reading.scale })
}

fn camera(tree: &Tree, name: &str, choice: LensModel) -> Result<([f64; 9], Distortion)> {
    let word = |key: &str| tree.get(&format!("{name}.{key}")).and_then(|values| values.first()).map(String::as_str);
    let model = word("camera_model").unwrap_or_default();
    ensure!(
        model == "pinhole",
        "its {name} is of the camera_model {model:?}, but pinhole is known; calibrate with pinhole-radtan or pinhole-equi"
    );
    let intrinsics = matrix(tree, &[&format!("{name}.intrinsics")], &[(1, 4)])?
        .with_context(|| format!("its {name} has no intrinsics; calibrate again"))?;
    ensure!(
        intrinsics[..2].iter().all(|&f| f > 0.0),
        "the focal lengths of its {name} must be more than 0; calibrate again"
    );
    let what = format!("{name}.distortion_coeffs");
    let shapes = Distortion::PINHOLE_COUNTS.map(|count| (1, count));
    let numbers = matrix(tree, &[&what], &shapes)?.unwrap_or_default();
    let distortion = of_model(&numbers, word("distortion_model"), choice, &what)?;
    let [fx, fy, cx, cy] = std::array::from_fn(|i| intrinsics[i]);
    Ok(([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0], distortion))
}
