//! Basalt's calibration.json: `T_imu_cam`, `intrinsics` and `resolution` of each camera, below `value0`.

use crate::files::calibration::algebra::Pose;
use crate::files::calibration::cameras::Found;
use crate::files::calibration::content::tree::{Tree, number, whole};
use crate::files::calibration::lenses::{LensModel, of_model};
use crate::files::calibration::reading::Reading;
use crate::files::calibration::rig::{self, RigCamera, matrix_of};
use crate::files::error::{Context as _, Result, bail, ensure};

/// The cameras' models: the name, the names of the numbers of the lens, and what the model is called elsewhere.
const MODELS: [(&str, &[&str], &str); 6] = [
    ("pinhole", &[], "none"),
    ("pinhole-radtan8", &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"], "rational_polynomial"),
    ("pinhole-radtan4", &["k1", "k2", "p1", "p2"], "radtan"),
    ("kb4", &["k1", "k2", "k3", "k4"], "kannala_brandt4"),
    ("ds", &["xi", "alpha"], "ds"),
    ("eucm", &["alpha", "beta"], "eucm"),
];

/// What a name begins with: files have `value0`, as cereal writes it, or not.
fn root(tree: &Tree) -> Option<&'static str> {
    ["value0.", ""].into_iter().find(|root| tree.contains_key(&format!("{root}intrinsics.0.camera_type")))
}

pub fn is(tree: &Tree) -> bool {
    root(tree).is_some()
}

pub fn read(tree: &Tree, reading: Reading) -> Result<Found> {
    let root = root(tree).context("it has no intrinsics; calibrate again")?;
    let has = |i: &usize| tree.contains_key(&format!("{root}intrinsics.{i}.camera_type"));
    let names: Vec<_> = (0..64).take_while(has).map(|i| format!("camera {i}")).collect();
    let pair = rig::chosen(&names, &reading)?;
    let choice = if reading.lenses { reading.lens } else { LensModel::Auto };
    let [left, right] = pair.map(|i| camera(tree, root, i, choice).with_context(|| format!("its camera {i}")));
    rig::pair([left?, right?], "T_imu_cam", &reading)
}

fn camera(tree: &Tree, root: &str, i: usize, choice: LensModel) -> Result<RigCamera> {
    let value = |key: &str| -> Result<f64> {
        let values = tree.get(&format!("{root}{key}")).map(Vec::as_slice);
        match values {
            Some([value]) => number(value).with_context(|| format!("its {key}")),
            _ => bail!("it has no {key}; calibrate again"),
        }
    };
    let kind = tree.get(&format!("{root}intrinsics.{i}.camera_type")).and_then(|values| values.first());
    let kind = kind.map(String::as_str).unwrap_or_default();
    let Some((_, own, model)) = MODELS.iter().find(|(name, ..)| *name == kind) else {
        let known = MODELS.map(|(name, ..)| name).join(", ");
        bail!(
            "is of the camera_type {kind:?}, but {known} are known; calibrate with one of these (basalt_calibrate --cam-types)"
        )
    };
    let number_of = |key: &&str| value(&format!("intrinsics.{i}.intrinsics.{key}"));
    let [fx, fy, cx, cy] = [number_of(&"fx")?, number_of(&"fy")?, number_of(&"cx")?, number_of(&"cy")?];
    let bent = own.iter().map(number_of).collect::<Result<Vec<_>>>()?;
    let distortion = of_model(&bent, Some(model), choice, "intrinsics")?;
    let of_pose = |key: &str| value(&format!("T_imu_cam.{i}.{key}"));
    let turn = [of_pose("qx")?, of_pose("qy")?, of_pose("qz")?, of_pose("qw")?];
    let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
    ensure!((length - 1.0).abs() < 1e-3, "has a quaternion of the length {length}, but it must be 1; calibrate again");
    let pose = Pose::of_quaternion(turn.map(|x| x / length), [of_pose("px")?, of_pose("py")?, of_pose("pz")?]);
    // Lists of two numbers each stand one after the other.
    let sizes = tree.get(&format!("{root}resolution"));
    let size = match sizes.and_then(|all| all.get(2 * i..2 * i + 2)) {
        Some([width, height]) => Some([whole(width)?, whole(height)?]),
        _ => None,
    };
    Ok(RigCamera {
        matrix: matrix_of([fx, fy, cx, cy], &format!("camera {i}"))?,
        distortion,
        size,
        pose: pose.inverse(),
    })
}
