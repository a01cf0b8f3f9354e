//! The numbers of a lens in a file, and the model that they are of.

use super::content::tree::{Tree, matrix};
use crate::files::error::{Context as _, Result, bail, ensure};
use crate::{Distortion, Lens};

/// The model of lenses whose file names none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LensModel {
    /// The one that the file names, or that its numbers can only be of
    #[default]
    Auto,
    /// calibrateCamera: k1, k2, p1, p2, k3 ..
    Pinhole,
    /// cv::fisheye, equidistant: k1, k2, k3, k4
    Fisheye,
    /// Double sphere: xi, alpha
    DoubleSphere,
    /// Extended unified: alpha, beta
    ExtendedUnified,
}

impl LensModel {
    fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Pinhole => "pinhole",
            Self::Fisheye => "fisheye",
            Self::DoubleSphere => "ds",
            Self::ExtendedUnified => "eucm",
        }
    }
}

/// The models by their names in files, with the counts of numbers that they have.
const MODELS: [(&str, LensModel, &[usize]); 14] = [
    ("plumb_bob", LensModel::Pinhole, &[0, 4, 5]),
    ("rational_polynomial", LensModel::Pinhole, &[0, 8, 12, 14]),
    ("radtan", LensModel::Pinhole, &[0, 4, 5]),
    ("radial-tangential", LensModel::Pinhole, &[0, 4, 5]),
    ("pinhole", LensModel::Pinhole, &Distortion::PINHOLE_COUNTS),
    ("radial_tangential", LensModel::Pinhole, &[0, 4, 5]),
    ("none", LensModel::Pinhole, &[0]),
    ("equidistant", LensModel::Fisheye, &[4]),
    ("equi", LensModel::Fisheye, &[4]),
    ("fisheye", LensModel::Fisheye, &[4]),
    ("kannala_brandt", LensModel::Fisheye, &[4]),
    ("kannala_brandt4", LensModel::Fisheye, &[4]),
    ("ds", LensModel::DoubleSphere, &[2]),
    ("eucm", LensModel::ExtendedUnified, &[2]),
];

/// Models that are none of these, whatever --lens says.
const OTHERS: [&str; 7] = ["omni", "mei", "omni_radtan", "fov", "atan", "scaramuzza", "ocamcalib"];

/// The names under which files name the model.
const MODEL: [&str; 5] = ["distortion_model", "distortion_type", "lens_model", "camera_model", "model"];

/// What a camera's numbers are called: the left one's and the right one's by their canonical names, and in a file of ROS.
pub struct Names(pub [&'static [&'static str]; 2], pub &'static [&'static str]);

pub const MATRIX: Names = Names([&["M1"], &["M2"]], &["camera_matrix", "K", "k"]);
pub const DISTORTION: Names = Names([&["D1"], &["D2"]], &["distortion_coefficients", "D", "d"]);
pub const ROTATION: Names = Names([&["R1"], &["R2"]], &["rectification_matrix", "R", "r"]);
pub const PROJECTION: Names = Names([&["P1"], &["P2"]], &["projection_matrix", "P", "p"]);

const NEEDED: &str = "--rectify needs M1, D1, M2, D2 and either R1, P1, R2 and P2 or R and T; where the pair is rectified, give the \
    file with --calib";

/// The lens and the rectified camera of a side.
pub fn lens(tree: &Tree, choice: LensModel, names: impl Fn(&Names) -> &'static [&'static str]) -> Result<Lens> {
    let matrix = camera_matrix(tree, names(&MATRIX))?;
    let distortion = distortion(tree, names(&DISTORTION), choice)?;
    let rotation = nine(tree, names(&ROTATION))?;
    ensure_rotation(&rotation, names(&ROTATION)[0])?;
    let projection = needed(tree, names(&PROJECTION), &[(3, 4)])?;
    Ok(Lens { matrix, distortion, rotation, projection: std::array::from_fn(|i| projection[i / 3 * 4 + i % 3]) })
}

fn needed(tree: &Tree, names: &[&str], shapes: &[(usize, usize)]) -> Result<Vec<f64>> {
    matrix(tree, names, shapes)?.with_context(|| format!("it has no {}; {NEEDED}", names[0]))
}

pub fn nine(tree: &Tree, names: &[&str]) -> Result<[f64; 9]> {
    let numbers = needed(tree, names, &[(3, 3)])?;
    Ok(std::array::from_fn(|i| numbers[i]))
}

pub fn camera_matrix(tree: &Tree, names: &[&str]) -> Result<[f64; 9]> {
    let mut m = nine(tree, names)?;
    for focal in [m[0], m[4]] {
        ensure!(focal > 0.0, "its {} has a focal length of {focal}, but it must be more than 0; correct it", names[0]);
    }
    ensure!(
        m[1].abs() <= 1e-6 * m[0],
        "its {} has a skew of {}, but OpenCV rectifies without any; calibrate without (CALIB_FIX_SKEW)",
        names[0],
        m[1]
    );
    ensure!(
        [m[3], m[6], m[7]].iter().all(|z| z.abs() <= 1e-9) && (m[8] - 1.0).abs() <= 1e-9,
        "its {} is no [fx 0 cx; 0 fy cy; 0 0 1]; save it as stereoCalibrate gives it",
        names[0]
    );
    [m[1], m[3], m[6], m[7], m[8]] = [0.0, 0.0, 0.0, 0.0, 1.0];
    Ok(m)
}

/// The distortion of a file's lens.
pub fn distortion(tree: &Tree, names: &[&str], choice: LensModel) -> Result<Distortion> {
    let counts = Distortion::PINHOLE_COUNTS.map(|count| [(1, count), (count, 1)]);
    let numbers = needed(tree, names, counts.as_flattened())?;
    let named = MODEL.iter().find_map(|key| tree.get(*key)).and_then(|value| value.first());
    of_model(&numbers, named.map(String::as_str), choice, names[0])
}

/// The distortion of these numbers, by the name of its model or what was chosen where it has none.
pub fn of_model(numbers: &[f64], named: Option<&str>, choice: LensModel, what: &str) -> Result<Distortion> {
    let named = named.map(str::trim).filter(|name| !name.is_empty());
    let known = named.and_then(|name| MODELS.iter().find(|(known, ..)| known.eq_ignore_ascii_case(name)));
    let model = match (named, known) {
        (Some(name), Some((_, model, counts))) => {
            ensure!(
                choice == LensModel::Auto || choice == *model,
                "--lens is {}, but the file says that its lenses are of the model {name}; drop --lens, or correct the file",
                choice.name()
            );
            let none = numbers.iter().all(|&number| number == 0.0) && **counts == [0];
            ensure!(
                none || counts.contains(&numbers.len()),
                "its {what} has {} numbers, but lenses of the model {name} have {}; correct the one or the other",
                numbers.len(),
                counts.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
            );
            if none {
                return Ok(Distortion::NONE);
            }
            *model
        }
        (Some(name), None) => {
            let other = OTHERS.iter().any(|other| other.eq_ignore_ascii_case(name));
            let names = MODELS.map(|(name, ..)| name).join(", ");
            ensure!(!other, "its lenses are of the model {name}, but {names} are known; calibrate with one of these");
            ensure!(
                choice != LensModel::Auto,
                "its lenses are of the model {name:?}, but {names} are known; where it is one of these by another name, give \
                 --lens pinhole or --lens fisheye"
            );
            choice
        }
        (None, _) => choice,
    };
    match (model, numbers.len()) {
        (LensModel::Auto, 4) => bail!(
            "its {what} has 4 numbers and no model: k1, k2, p1, p2 of calibrateCamera, or k1, k2, k3, k4 of cv::fisheye; give \
             --lens pinhole or --lens fisheye"
        ),
        (LensModel::Fisheye, 4) => Ok(Distortion::Fisheye(std::array::from_fn(|i| numbers[i]))),
        (LensModel::Fisheye, 0) => Ok(Distortion::Fisheye([0.0; 4])),
        (LensModel::Fisheye, count) => {
            bail!("its {what} has {count} numbers, but a fisheye has 4; give --lens pinhole, or correct the file")
        }
        (LensModel::DoubleSphere, 2) => Ok(Distortion::DoubleSphere([numbers[0], numbers[1]])),
        (LensModel::ExtendedUnified, 2) => Ok(Distortion::ExtendedUnified([numbers[0], numbers[1]])),
        (LensModel::DoubleSphere | LensModel::ExtendedUnified, count) => {
            bail!("its {what} has {count} numbers, but a lens of the model {} has 2; correct the file", model.name())
        }
        (LensModel::Auto | LensModel::Pinhole, _) => Ok(Distortion::pinhole(numbers)?),
    }
}

/// Refuses a matrix that is not a rotation, or that mirrors.
pub fn ensure_rotation(rotation: &[f64; 9], name: &str) -> Result<()> {
    let row = |i: usize| &rotation[3 * i..3 * i + 3];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
        let is = if i == j { 1.0 } else { 0.0 };
        ensure!((dot(row(i), row(j)) - is).abs() < 1e-3, "its {name} is no rotation; save it again");
    }
    let ([a, b, c], [d, e, f]) = ([rotation[0], rotation[1], rotation[2]], [rotation[3], rotation[4], rotation[5]]);
    let third = [b * f - c * e, c * d - a * f, a * e - b * d];
    ensure!(dot(&third, row(2)) > 0.0, "its {name} mirrors, but must be a rotation; save it again");
    Ok(())
}
