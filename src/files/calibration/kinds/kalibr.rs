//! Kalibr's camchain.yaml: `cam0`, `cam1` and so on, each with its lens, and where it is: `T_cn_cnm1` from the camera before, or
//! `T_cam_imu`, `T_imu_cam` beside an inertial sensor. Basalt and OpenVINS have such files, too.

use crate::Distortion;
use crate::files::calibration::algebra::{Matrix, Pose, STRAIGHT};
use crate::files::calibration::cameras::Found;
use crate::files::calibration::content::tree::{Tree, matrix, whole};
use crate::files::calibration::lenses::{LensModel, of_model};
use crate::files::calibration::reading::Reading;
use crate::files::calibration::rig::{self, RigCamera, matrix_of};
use crate::files::error::{Context as _, Error, Result, bail};

pub fn is(tree: &Tree) -> bool {
    ["cam0.intrinsics", "cam0.camera_model", "cam1.intrinsics", "cam1.T_cn_cnm1"]
        .iter()
        .any(|key| tree.contains_key(*key))
}

pub fn read(tree: &Tree, reading: Reading) -> Result<Found> {
    let has = |name: &String| tree.contains_key(&format!("{name}.intrinsics"));
    let names: Vec<_> = (0..64).map(|i| format!("cam{i}")).take_while(has).collect();
    let pair = rig::chosen(&names, &reading)?;
    let poses = poses(tree, &names, pair)?;
    // A rectified pair needs no lenses.
    let choice = if reading.lenses { reading.lens } else { LensModel::Auto };
    let camera = |side: usize| -> Result<RigCamera> {
        let name = &names[pair[side]];
        let size = match tree.get(&format!("{name}.resolution")).map(Vec::as_slice) {
            Some([width, height]) => Some([whole(width)?, whole(height)?]),
            _ => None,
        };
        let (matrix, distortion) = lens(tree, name, choice)?;
        Ok(RigCamera { matrix, distortion, size, pose: poses[side] })
    };
    rig::pair([camera(0)?, camera(1)?], "T_cn_cnm1 or T_cam_imu", &reading)
}

/// From what both cameras share to each of them.
fn poses(tree: &Tree, names: &[String], pair: [usize; 2]) -> Result<[Pose; 2]> {
    let pose = |camera: usize, key: &str| -> Result<Option<Pose>> {
        let numbers = matrix(tree, &[&format!("{}.{key}", names[camera])], &[(4, 4)])?;
        Ok(numbers.map(|numbers| Pose::of_matrix(&std::array::from_fn(|i| numbers[i]))))
    };
    let chain =
        (1..=pair[0].max(pair[1])).map(|camera| pose(camera, "T_cn_cnm1")).collect::<Result<Option<Vec<_>>>>()?;
    if let Some(chain) = chain {
        let first = Pose { rotation: STRAIGHT, translation: [0.0; 3] };
        return Ok(pair.map(|camera| chain[..camera].iter().fold(first, |before, step| step.after(&before))));
    }
    let from_body = |camera: usize| -> Result<Option<Pose>> {
        Ok(pose(camera, "T_cam_imu")?.or(pose(camera, "T_imu_cam")?.map(|pose| pose.inverse())))
    };
    match [from_body(pair[0])?, from_body(pair[1])?] {
        [Some(left), Some(right)] => Ok([left, right]),
        _ => bail!(
            "it has neither T_cn_cnm1 nor T_cam_imu of {} and {}; calibrate both cameras together, by kalibr_calibrate_cameras",
            names[pair[0]],
            names[pair[1]]
        ),
    }
}

fn lens(tree: &Tree, name: &str, choice: LensModel) -> Result<(Matrix, Distortion)> {
    let word = |key: &str| tree.get(&format!("{name}.{key}")).and_then(|values| values.first()).map(String::as_str);
    let model = word("camera_model").unwrap_or_default();
    // What a model has before fx, fy, cx and cy.
    let own = match model {
        "pinhole" => 0,
        "ds" | "eucm" => 2,
        _ => bail!(
            "its {name} is of the camera_model {model:?}, but pinhole, ds and eucm are known; calibrate with pinhole-radtan, \
             pinhole-equi, ds-none or eucm-none"
        ),
    };
    let numbers = matrix(tree, &[&format!("{name}.intrinsics")], &[(1, 4 + own)])?
        .with_context(|| format!("its {name} has no intrinsics; calibrate again"))?;
    let camera = matrix_of(std::array::from_fn(|i| numbers[own + i]), name)?;
    let what = format!("{name}.distortion_coeffs");
    let shapes = Distortion::PINHOLE_COUNTS.map(|count| (1, count));
    // A model that is not known may have another number of numbers.
    let of = |error: Error| match word("distortion_model") {
        Some(model) => error.context(format!("its {name} is of the distortion_model {model:?}")),
        None => error,
    };
    let bent = matrix(tree, &[&what], &shapes).map_err(of)?.unwrap_or_default();
    if own > 0 {
        if bent.iter().any(|&number| number != 0.0) {
            bail!("its {what} are not 0, but a {model} camera has none; calibrate with {model}-none");
        }
        return Ok((camera, of_model(&numbers[..2], Some(model), choice, &format!("{name}.intrinsics"))?));
    }
    Ok((camera, of_model(&bent, word("distortion_model"), choice, &what)?))
}
