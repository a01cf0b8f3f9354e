//! The matrices of stereoCalibrate and stereoRectify, under the names of OpenCV or others: FileStorage in YAML or XML, what people
//! dump from Python as YAML, JSON or NumPy's archives.

use crate::files::calibration::algebra::{Matrix, rotation};
use crate::files::calibration::apart::Apart;
use crate::files::calibration::cameras::{Cameras, Found};
use crate::files::calibration::content::canonical;
use crate::files::calibration::content::tree::{Tree, has, matrix, size_of};
use crate::files::calibration::lenses::{
    DISTORTION, MATRIX, PROJECTION, ROTATION, camera_matrix, distortion, ensure_rotation, lens,
};
use crate::files::calibration::reading::{Reading, Unit};
use crate::files::calibration::rectified::{RectifiedPair, ensure_same, of_projections, of_q};
use crate::files::error::{Context as _, Error, Result, bail, ensure, error};

/// Whether a file has the matrices of both cameras, as no file of one camera has.
pub fn is_of_pair(tree: &Tree) -> bool {
    canonical(tree).is_ok_and(|tree| has(&tree, &["M1", "P1", "Q"]))
}

/// A matrix of a pair, or one of a name of its own.
pub fn is(tree: &Tree) -> bool {
    let matrix =
        |key: &String| key.strip_suffix(".rows").is_some_and(|name| tree.contains_key(&format!("{name}.cols")));
    tree.keys().any(matrix) || canonical(tree).map_or(true, |tree| has(&tree, &["M1", "P1", "Q", "P2", "M2", "T"]))
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
pub fn read(tree: &Tree, reading: Reading) -> Result<Found> {
    let tree = &canonical(tree)?;
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
    Ok(Found { cameras, size: size_of(tree)?, unit: Some(unit) })
}

fn not_rectified() -> Error {
    error!(
        "it has neither P1 and P2 nor Q: its cameras are not rectified; give it with --rectify and the images as they were taken"
    )
}

/// The rectified cameras; what tells of them twice must agree.
fn rectified(tree: &Tree, unit: Unit) -> Result<Option<RectifiedPair>> {
    let left = matrix(tree, PROJECTION.0[0], &[(3, 4)])?;
    let right = matrix(tree, PROJECTION.0[1], &[(3, 4)])?;
    let pair = match (&left, &right) {
        (Some(left), Some(right)) => Some(of_projections(left, right, unit.metres())?),
        _ => None,
    };
    let q = matrix(tree, &["Q"], &[(4, 4)])?;
    let q = q.map(|q| of_q(&q, unit.metres())).transpose()?;
    if let (Some(pair), Some(q)) = (&pair, &q) {
        ensure_same(&pair.camera, &q.camera, "its P1 and P2 and its Q")?;
    }
    let found = pair.or(q);
    let t = if has(tree, &["R"]) { matrix(tree, &["T"], &[(3, 1), (1, 3)]).unwrap_or(None) } else { None };
    if let (Some(RectifiedPair { camera, .. }), Some(t)) = (&found, t) {
        let apart = t.iter().map(|x| x * x).sum::<f64>().sqrt() * unit.metres();
        ensure!(
            (apart - camera.baseline).abs() <= 0.01 * apart,
            "the baseline is {} m by its P1 and P2, or Q, but {apart} m by its T; remove what is wrong",
            camera.baseline
        );
    }
    Ok(found)
}

/// `R`, or its axis times its angle.
fn between(tree: &Tree) -> Result<Matrix> {
    let numbers = matrix(tree, &["R"], &[(3, 3), (3, 1), (1, 3)])?.context("it has no R")?;
    Ok(match numbers[..] {
        [x, y, z] => rotation([x, y, z]),
        _ => std::array::from_fn(|i| numbers[i]),
    })
}

/// `M1`, `D1`, `M2`, `D2`, and `R` and `T` of OpenCV's stereoCalibrate.
fn apart(tree: &Tree, reading: Reading, unit: Unit) -> Result<Apart> {
    let r = between(tree)?;
    ensure_rotation(&r, "R")?;
    let t = matrix(tree, &["T"], &[(3, 1), (1, 3)])?.context("it has no T")?;
    let side = |side: usize| {
        let distortion = distortion(tree, DISTORTION.0[side], reading.lens)?;
        Ok::<_, Error>((camera_matrix(tree, MATRIX.0[side])?, distortion))
    };
    Apart::new([side(0)?, side(1)?], r, std::array::from_fn(|i| t[i] * unit.metres()))
}
