//! Single numbers of a rectified pair, as people write them down: the focal length, the principal point and the baseline; and the
//! settings of ORB-SLAM, which have `bf` or `Stereo.b`.

use super::opencv;
use crate::files::calibration::cameras::{Cameras, Found};
use crate::files::calibration::content::canonical;
use crate::files::calibration::content::tree::{Tree, has, number, size_of, whole};
use crate::files::calibration::reading::{Reading, Unit};
use crate::files::calibration::rectified::of_projections;
use crate::files::error::{Context as _, Result, bail, ensure};

const FOCAL: &[&str] = &["fx", "f", "focal", "focallength", "focalpx", "focallengthpx", "focalx"];
const FOCAL_Y: &[&str] = &["fy", "focaly"];
const COLUMN: &[&str] = &["cx", "ppx", "principalx", "principalpointx"];
const ROW: &[&str] = &["cy", "ppy", "principaly", "principalpointy"];
const BENT: &[&str] = &["k1", "k2", "k3", "k4", "p1", "p2"];
/// With the unit that the name says.
const BASELINE: [(&[&str], Option<Unit>); 4] = [
    (&["baseline", "stereobaseline", "stereob", "basewidth"], None),
    (&["baselinem", "baselinemeters", "baselinemetres"], Some(Unit::M)),
    (&["baselinecm"], Some(Unit::Cm)),
    (&["baselinemm"], Some(Unit::Mm)),
];
/// The baseline times the focal length.
const BF: &[&str] = &["bf", "camerabf"];

/// The name of a file's number, without the words before it, and the camera that these name.
fn parts(path: &str) -> (String, Option<usize>) {
    let plain = |text: &str| text.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
    let (before, name) = path.rsplit_once('.').unwrap_or(("", path));
    let before = plain(before);
    let is_of = |words: [&str; 3]| words.iter().any(|word| before.contains(word));
    let side =
        if is_of(["left", "camera1", "cam0"]) { Some(0) } else { is_of(["right", "camera2", "cam1"]).then_some(1) };
    let name = plain(name);
    // Stereo.b
    (if name == "b" { format!("{before}b") } else { name }, side)
}

/// The one number of these names that is of a camera, or of both.
fn find(tree: &Tree, names: &[&str], side: usize) -> Result<Option<f64>> {
    let mut found: Option<(f64, bool, &str)> = None;
    for (path, values) in tree {
        let (name, of) = parts(path);
        let ([value], true) = (&values[..], names.contains(&name.as_str()) && of.is_none_or(|of| of == side)) else {
            continue;
        };
        let value = number(value).with_context(|| format!("its {path}"))?;
        match found {
            // What is of this camera alone counts.
            Some((_, true, _)) if of.is_none() => {}
            Some((before, is_own, other)) if is_own == of.is_some() => {
                ensure!(before == value, "its {other} and its {path} differ; remove the one that is wrong");
            }
            _ => found = Some((value, of.is_some(), path)),
        }
    }
    Ok(found.map(|(value, ..)| value))
}

fn baseline(tree: &Tree, reading: &Reading) -> Result<Option<(f64, Unit)>> {
    for (names, unit) in BASELINE {
        if let Some(baseline) = find(tree, names, 0)? {
            return Ok(Some((baseline, unit.unwrap_or(reading.unit(Unit::M)))));
        }
    }
    let (bf, focal) = (find(tree, BF, 0)?, find(tree, FOCAL, 0)?);
    Ok(bf.zip(focal).map(|(bf, focal)| (bf / focal, reading.unit(Unit::M))))
}

pub fn is(tree: &Tree) -> bool {
    let lies_between = |tree: Tree| has(&tree, &["R", "T", "P1", "P2", "Q"]);
    let matrices =
        tree.iter().filter(|(_, values)| values.len() > 1).map(|(path, values)| (path.clone(), values.clone()));
    let matrices: Tree = matrices.collect();
    let there = |names: &[&str]| tree.keys().any(|path| names.contains(&parts(path).0.as_str()));
    there(FOCAL)
        && (BASELINE.iter().any(|(names, _)| there(names)) || there(BF))
        && !canonical(tree).is_ok_and(lies_between)
        && !opencv::is_of_pair(&matrices)
}

pub fn read(tree: &Tree, reading: Reading) -> Result<Found> {
    if reading.lenses {
        bail!(
            "it has a focal length, a principal point and a baseline, which are of a rectified pair; give it with --calib, or with \
             --rectify a file that has M1, D1, M2, D2, R and T"
        );
    }
    let (baseline, unit) = baseline(tree, &reading)?.context("it has no baseline")?;
    ensure!(baseline > 0.0, "its baseline is {baseline}, but must be more than 0; correct it");
    for name in BENT {
        for side in [0, 1] {
            let bent = find(tree, &[name], side)?.unwrap_or_default();
            ensure!(
                bent == 0.0,
                "its {name} is {bent}: the lenses bend, so its pair is not rectified; give a file that has M1, D1, M2, D2, R and T, \
                 with --rectify"
            );
        }
    }
    let projection = |side: usize, shift: f64| -> Result<[f64; 12]> {
        // Of a rectified pair the left camera's numbers may stand for both.
        let find =
            |names: &[&str]| find(tree, names, side)?.map_or_else(|| find(tree, names, 0), |found| Ok(Some(found)));
        let focal = find(FOCAL)?.context("it has no focal length of the left camera, nor of both")?;
        let focal_y = find(FOCAL_Y)?.unwrap_or(focal);
        let needed = |names: &[&str]| find(names)?.with_context(|| format!("it has no {}", names[0]));
        let (cx, cy) = (needed(COLUMN)?, needed(ROW)?);
        Ok([focal, 0.0, cx, shift * focal, 0.0, focal_y, cy, 0.0, 0.0, 0.0, 1.0, 0.0])
    };
    let mut pair = of_projections(&projection(0, 0.0)?, &projection(1, -baseline)?, unit.metres())?;
    if let Some(doffs) = find(tree, &["doffs"], 0)? {
        ensure!(
            pair.camera.doffs == 0.0 || pair.camera.doffs == doffs,
            "its doffs is {doffs}, but its principal points say {}; correct the one or the other",
            pair.camera.doffs
        );
        pair.camera.doffs = doffs;
    }
    let size = match [find(tree, &["width", "imagewidth"], 0)?, find(tree, &["height", "imageheight"], 0)?] {
        [Some(width), Some(height)] => Some([whole(&width.to_string())?, whole(&height.to_string())?]),
        _ => size_of(tree)?,
    };
    Ok(Found { cameras: Cameras::Rectified(pair), size, unit: Some(unit) })
}
