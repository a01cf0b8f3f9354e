//! What people call the matrices of a pair: `K1`, `cameraMatrix1`, `mtx_l`, `left.camera_matrix` and so on become `M1`, as in
//! OpenCV's samples.

use super::tree::{Tree, number};
use crate::files::error::{Result, ensure};
use std::collections::BTreeMap;

/// Whose a value is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    /// Of one camera: its name has a number or a side.
    Camera,
    /// Of both.
    Pair,
    /// Of either.
    Any,
}

/// A value: its name here, of a camera without the number; whose it is; and its names, in small letters without what separates
/// words.
type Row = (&'static str, Of, &'static [&'static str]);

const ROWS: [Row; 24] = [
    (
        "M",
        Of::Camera,
        &[
            "m",
            "k",
            "mtx",
            "matrix",
            "cameramatrix",
            "cammatrix",
            "cammtx",
            "cameramtx",
            "kmatrix",
            "intrinsic",
            "intrinsics",
            "intrinsicmatrix",
            "intrinsicsmatrix",
            "cameraintrinsic",
            "cameraintrinsics",
            "cameraintrinsicmatrix",
        ],
    ),
    (
        "D",
        Of::Camera,
        &[
            "d",
            "dist",
            "distortion",
            "distcoeffs",
            "distcoeff",
            "distcoefs",
            "distcoef",
            "distortioncoefficients",
            "distortioncoefficient",
            "distortioncoeffs",
            "distortioncoeff",
            "distortioncoefs",
            "distortionvector",
            "distortionparams",
            "distortionparameters",
            "distvec",
            "coeffs",
        ],
    ),
    (
        "R",
        Of::Camera,
        &["r", "rect", "rectification", "rectificationmatrix", "rectmatrix", "rectmat", "rotation", "rotationmatrix"],
    ),
    ("P", Of::Camera, &["p", "proj", "projection", "projectionmatrix", "projmatrix", "projmat", "projmtx"]),
    ("T", Of::Camera, &["t", "trans", "translation", "translationvector", "tvec"]),
    (
        "R",
        Of::Pair,
        &["r", "rot", "rotation", "rotationmatrix", "rotmatrix", "rotmat", "rmat", "rvec", "rotationvector", "om"],
    ),
    ("T", Of::Pair, &["t", "trans", "translation", "translationvector", "translationmatrix", "transvec", "tvec"]),
    (
        "RT",
        Of::Pair,
        &[
            "rt",
            "extrinsics",
            "extrinsic",
            "extrinsicmatrix",
            "extrinsicsmatrix",
            "transformation",
            "transformationmatrix",
        ],
    ),
    (
        "Q",
        Of::Pair,
        &["q", "qmatrix", "qmat", "disparitytodepth", "disptodepth", "disparitytodepthmatrix", "disptodepthmatrix"],
    ),
    ("distortion_model", Of::Any, &["distortionmodel", "distortiontype", "lensmodel", "cameramodel", "model"]),
    ("image_size", Of::Any, &["imagesize", "imgsize", "size", "resolution", "framesize", "imageresolution"]),
    ("image_shape", Of::Any, &["imageshape", "imgshape", "shape"]),
    ("image_width", Of::Any, &["imagewidth", "width", "imgwidth", "imagesizewidth"]),
    ("image_height", Of::Any, &["imageheight", "height", "imgheight", "imagesizeheight"]),
    ("fx", Of::Camera, &["fx"]),
    ("fy", Of::Camera, &["fy"]),
    ("cx", Of::Camera, &["cx", "ppx"]),
    ("cy", Of::Camera, &["cy", "ppy"]),
    ("k1", Of::Camera, &["k1"]),
    ("k2", Of::Camera, &["k2"]),
    ("p1", Of::Camera, &["p1"]),
    ("p2", Of::Camera, &["p2"]),
    ("k3", Of::Camera, &["k3"]),
    ("k4", Of::Camera, &["k4"]),
];

/// Words that may stand before a name.
const FILLERS: [&str; 24] = [
    "stereo",
    "calibration",
    "calib",
    "calibrated",
    "params",
    "parameters",
    "cam",
    "camera",
    "cameras",
    "extrinsics",
    "extrinsic",
    "intrinsics",
    "intrinsic",
    "data",
    "result",
    "results",
    "opencv",
    "lens",
    "pair",
    "rectification",
    "rectify",
    "rectified",
    "value",
    "stereocalibration",
];

/// The parts of a matrix of OpenCV's.
const PARTS: [&str; 5] = ["rows", "cols", "data", "dt", "type_id"];

/// A name as it is in a file: its words in small letters.
fn words(path: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for letter in path.chars() {
        let starts = !before.is_alphanumeric()
            || before.is_lowercase() && letter.is_uppercase()
            || before.is_ascii_digit() != letter.is_ascii_digit();
        if letter.is_alphanumeric() {
            match words.last_mut().filter(|_| !starts) {
                Some(word) => word.extend(letter.to_lowercase()),
                None => words.push(letter.to_lowercase().collect()),
            }
        }
        before = letter;
    }
    words
}

/// The row of a name, without what stands before it.
fn row(words: &[String], of: Of) -> Option<&'static str> {
    for start in 0..words.len() {
        let name = words[start..].concat();
        let is = |row: &&Row| (row.1 == of || row.1 == Of::Any) && row.2.contains(&name.as_str());
        if let Some((canonical, ..)) = ROWS.iter().find(is) {
            return Some(*canonical);
        }
        if !FILLERS.contains(&words[start].as_str()) {
            return None;
        }
    }
    None
}

/// The row of a path, and the word that tells the camera, if there is one.
fn recognised(path: &str) -> Option<(&'static str, Option<String>)> {
    let words = words(path);
    let sides = |names: &[&str]| -> Vec<usize> {
        (0..words.len()).rev().filter(|i| names.contains(&words[*i].as_str())).collect()
    };
    let without = |i: usize| -> Vec<String> { [&words[..i], &words[i + 1..]].concat() };
    for i in [sides(&["left", "right"]), sides(&["0", "1", "2"]), sides(&["l", "r"])].concat() {
        if let Some(row) = row(&without(i), Of::Camera) {
            return Some((row, Some(words[i].clone())));
        }
    }
    if let Some(row) = row(&words, Of::Pair) {
        return Some((row, None));
    }
    // mtxl, distr
    let (last, rest) = words.split_last()?;
    let side = last.chars().next_back().filter(|letter| ['l', 'r'].contains(letter))?;
    let stem = [rest, &[last[..last.len() - 1].to_string()]].concat();
    row(&stem, Of::Camera).map(|row| (row, Some(side.to_string())))
}

/// The values under canonical names: `M1`, `D1`, `R1`, `P1`, `M2` .., `R`, `T`, `Q`, `distortion_model` and the size.
pub fn canonical(tree: &Tree) -> Result<Tree> {
    let root = tree.keys().next().and_then(|path| path.split_once('.')).map(|(root, _)| format!("{root}."));
    let is_root = |root: &String| {
        recognised(root.trim_end_matches('.')).is_none() && tree.keys().all(|path| path.starts_with(root.as_str()))
    };
    let root = root.filter(is_root).unwrap_or_default();
    let mut named = Vec::new();
    for (path, values) in tree {
        let path = &path[root.len()..];
        let (name, part) = match path.rsplit_once('.') {
            Some((name, part)) if PARTS.contains(&part) => (name, Some(part)),
            _ => (path, None),
        };
        if let Some((row, side)) = recognised(name) {
            named.push((row, side, part, name, values));
        }
    }
    // Cameras are counted from 0 or from 1.
    let from_zero =
        named.iter().any(|(row, side, ..)| side.as_deref() == Some("0") && ["M", "P", "D", "fx"].contains(row));
    let mut found = Tree::new();
    let mut origins: BTreeMap<String, &str> = BTreeMap::new();
    for (row, side, part, name, values) in named {
        let is_single = part.is_none() && values.len() == 1;
        let takes_single = row.len() > 1 && row != "RT";
        if part.is_none() && is_single != (takes_single && !["image_size", "image_shape"].contains(&row)) {
            continue;
        }
        let number = match side.as_deref() {
            None => "",
            Some("left" | "l" | "0") => "1",
            Some("1") if !from_zero => "1",
            Some("2") if from_zero => {
                ensure!(
                    !["M", "P"].contains(&row),
                    "it has {name} beside cameras 0 and 1: more than two cameras; leave those of the pair"
                );
                continue;
            }
            Some(_) => "2",
        };
        let number = if row.starts_with("image") || row == "distortion_model" { "" } else { number };
        let part = part.map(|part| format!(".{part}")).unwrap_or_default();
        let key = format!("{row}{number}{part}");
        if let Some(before) = found.insert(key.clone(), values.clone()) {
            let other = origins.get(&key).copied().unwrap_or_default();
            ensure!(
                alike(&before, values),
                "its {other} and its {name} mean the same, but differ; remove the one that is wrong"
            );
        }
        origins.insert(key, name);
    }
    joined(&mut found)?;
    Ok(found)
}

fn alike(a: &[String], b: &[String]) -> bool {
    let same = |(a, b): (&String, &String)| a == b || number(a).ok().is_some_and(|a| number(b).ok() == Some(a));
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// Matrices of single numbers; what the right camera alone has between it and the left one; sizes in NumPy's order.
fn joined(tree: &mut Tree) -> Result<()> {
    for side in ["1", "2"] {
        let all = |tree: &Tree, names: &[&str]| -> Option<Vec<String>> {
            names.iter().map(|name| Some(tree.get(&format!("{name}{side}"))?.first()?.clone())).collect()
        };
        let matrix = format!("M{side}");
        let four = match tree.get(&matrix) {
            Some(values) if values.len() == 4 => Some(values.clone()),
            Some(_) => None,
            None if tree.contains_key(&format!("{matrix}.data")) => None,
            None => all(tree, &["fx", "fy", "cx", "cy"]),
        };
        if let Some([fx, fy, cx, cy]) = four.as_deref() {
            let values = [fx, "0", cx, "0", fy, cy, "0", "0", "1"].map(str::to_string).to_vec();
            tree.insert(matrix, values);
        }
        let bent = format!("D{side}");
        if let Some(mut values) = all(tree, &["k1", "k2", "p1", "p2"]).filter(|_| !tree.contains_key(&bent)) {
            values.push(all(tree, &["k3"]).map_or("0".into(), |k3| k3[0].clone()));
            tree.insert(bent, values);
        }
    }
    let both = ["RT.data", "RT"].iter().find_map(|name| tree.remove(*name));
    let rows = both.as_deref().map(|numbers| numbers.as_chunks::<4>());
    let has = |tree: &Tree, name: &str| tree.contains_key(name) || tree.contains_key(&format!("{name}.data"));
    if let Some(([a, b, c, ..], [])) =
        rows.filter(|(rows, _)| (3..=4).contains(&rows.len()) && !has(tree, "R") && !has(tree, "T"))
    {
        tree.insert("R".into(), [a, b, c].map(|row| row[..3].to_vec()).concat());
        tree.insert("T".into(), [a, b, c].map(|row| row[3].clone()).to_vec());
    }
    for name in ["R", "T"] {
        let has = |tree: &Tree, name: &str| tree.keys().any(|key| key == name || key.starts_with(&format!("{name}.")));
        if !has(tree, name) && !has(tree, &format!("{name}1")) && !has(tree, "P2") {
            for part in ["", ".rows", ".cols", ".data"] {
                if let Some(values) = tree.remove(&format!("{name}2{part}")) {
                    tree.insert(format!("{name}{part}"), values);
                }
            }
        }
    }
    if let Some([height, width, ..]) = tree.remove("image_shape").as_deref() {
        // OpenCV's samples keep gray.shape[::-1] under the same name; the principal point tells.
        let middle =
            ["M1", "M1.data"].iter().find_map(|name| tree.get(*name)).and_then(|m| Some([m.get(2)?, m.get(5)?]));
        let off = |sides: [&String; 2]| -> f64 {
            let place = |i: usize| Some(number(middle?[i]).ok()? / number(sides[i]).ok()? - 0.5);
            [place(0), place(1)].into_iter().map(|place| place.map_or(0.0, f64::abs)).sum()
        };
        let sides = if off([width, height]) <= off([height, width]) { [width, height] } else { [height, width] };
        let size = sides.map(String::clone).to_vec();
        tree.entry("image_size".into()).or_insert(size);
    }
    Ok(())
}
