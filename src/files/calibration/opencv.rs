//! OpenCV's FileStorage in YAML or XML: what stereoCalibrate and stereoRectify give.

use super::apart::Apart;
use super::cameras::{Calibration, Cameras};
use super::lenses::{DISTORTION, MATRIX, PROJECTION, ROTATION, camera_matrix, distortion, ensure_rotation, lens, nine};
use super::reading::{Reading, Unit};
use super::rectified::{ensure_same, of_projections, of_q};
use super::tree::{Tree, has, matrix, size_of};
use crate::Camera;
use crate::files::error::{Context as _, Error, Result, bail, ensure, error};

/// Names that only these files have.
pub const READABLE: &[&str] = &[
    "M1",
    "K1",
    "cameraMatrix1",
    "camera_matrix_1",
    "LEFT.K",
    "P1",
    "projectionMatrix1",
    "projection_matrix_1",
    "LEFT.P",
    "Q",
];

/// A matrix of OpenCV's, or a name of one of its own.
pub fn is(tree: &Tree) -> bool {
    let matrix =
        |key: &String| key.strip_suffix(".rows").is_some_and(|name| tree.contains_key(&format!("{name}.cols")));
    has(tree, READABLE) || has(tree, &["P2", "disparity_to_depth", "M2", "T"]) || tree.keys().any(matrix)
}

/// Both files of one calibration.
pub fn together(mut left: Tree, right: Tree) -> Result<Tree> {
    for (name, value) in right {
        if let Some(other) = left.get(&name).filter(|other| **other != value) {
            bail!(
                "both files have {name}, of {} and {}; remove the one that is wrong",
                other.join(" "),
                value.join(" ")
            );
        }
        left.insert(name, value);
    }
    Ok(left)
}

/// `P1` and `P2`, or `Q`; with lenses `M1`, `D1`, `R1` and `M2`, `D2`, `R2`, too; or `M1`, `D1`, `M2`, `D2`, `R` and `T`.
pub fn read(tree: &Tree, reading: Reading) -> Result<Calibration> {
    let unit = reading.unit(Unit::M);
    let lies_between = has(tree, &["R"]) && has(tree, &["T"]);
    let rectifies = has(tree, ROTATION.0[0]) && has(tree, PROJECTION.0[0]);
    let has_lenses = has(tree, MATRIX.0[0]) && has(tree, MATRIX.0[1]);
    let cameras = match reading.lenses {
        true if lies_between && !rectifies => Cameras::Apart(Box::new(apart(tree, reading, unit)?)),
        true if !has_lenses && rectified(tree, unit)?.is_some() => {
            bail!(
                "it has no M1 and M2, of unrectified cameras; where the pair is rectified, give the file with --calib"
            )
        }
        true => {
            let sides = [0, 1].map(|side: usize| lens(tree, reading.lens, |names| names.0[side]));
            let [left, right] = sides;
            let lenses = Box::new([left?, right?]);
            Cameras::Lenses(rectified(tree, unit)?.context("it has no P1 and P2")?, lenses)
        }
        false => match rectified(tree, unit)? {
            Some(camera) => Cameras::Rectified(camera),
            None if lies_between && has_lenses => match apart(tree, reading, unit) {
                Ok(apart) => Cameras::Apart(Box::new(apart)),
                Err(_) => return Err(not_rectified()),
            },
            None if has_lenses => return Err(not_rectified()),
            None => bail!(
                "it has no {}; a calibration of OpenCV must have P1 and P2, or Q, as stereoRectify gives them",
                if has(tree, PROJECTION.0[0]) { "P2 and no Q" } else { "P1 and no Q" }
            ),
        },
    };
    Ok(Calibration { cameras, size: size_of(tree)?, unit: Some(unit), scale: reading.scale })
}

fn not_rectified() -> Error {
    error!(
        "it has neither P1 and P2 nor Q: its cameras are not rectified; give it with --rectify and the images as they were taken"
    )
}

/// The rectified cameras; what tells of them twice must agree.
fn rectified(tree: &Tree, unit: Unit) -> Result<Option<Camera>> {
    let left = matrix(tree, PROJECTION.0[0], &[(3, 4)])?;
    let right = matrix(tree, PROJECTION.0[1], &[(3, 4)])?;
    let pair = match (&left, &right) {
        (Some(left), Some(right)) => Some(of_projections(left, right, unit.metres())?),
        _ => None,
    };
    let q = matrix(tree, &["Q", "disparity_to_depth"], &[(4, 4)])?;
    let q = q.map(|q| of_q(&q, unit.metres())).transpose()?;
    if let (Some(pair), Some(q)) = (&pair, &q) {
        ensure_same(pair, q, "its P1 and P2 and its Q")?;
    }
    let found = pair.or(q);
    let t = if has(tree, &["R"]) { matrix(tree, &["T"], &[(3, 1), (1, 3)]).unwrap_or(None) } else { None };
    if let (Some(camera), Some(t)) = (&found, t) {
        let apart = t.iter().map(|x| x * x).sum::<f64>().sqrt() * unit.metres();
        ensure!(
            (apart - camera.baseline).abs() <= 0.01 * apart,
            "the baseline is {} m by its P1 and P2, or Q, but {apart} m by its T; remove what is wrong",
            camera.baseline
        );
    }
    Ok(found)
}

/// `M1`, `D1`, `M2`, `D2`, and `R` and `T` of OpenCV's stereoCalibrate.
fn apart(tree: &Tree, reading: Reading, unit: Unit) -> Result<Apart> {
    let r = nine(tree, &["R"])?;
    ensure_rotation(&r, "R")?;
    let t = matrix(tree, &["T"], &[(3, 1), (1, 3)])?.context("it has no T")?;
    let side = |side: usize| {
        let distortion = distortion(tree, DISTORTION.0[side], reading.lens)?;
        Ok::<_, Error>((camera_matrix(tree, MATRIX.0[side])?, distortion))
    };
    Apart::new([side(0)?, side(1)?], r, std::array::from_fn(|i| t[i] * unit.metres()))
}
