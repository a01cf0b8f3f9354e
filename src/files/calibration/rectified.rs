//! The cameras of a rectified pair, by their projections or by Q.

use crate::Camera;
use crate::files::error::{Result, ensure};

/// Rectified cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectifiedPair {
    /// The cameras; one above the other, `doffs` counts rows.
    pub camera: Camera,
    /// Whether they lie one above the other, if that is known.
    pub vertical: Option<bool>,
}

const REMEDY: &str = "use P1 and P2 as stereoRectify gives them";

/// The cameras of two projection matrices, 3 x 4 by rows.
pub fn of_projections(left: &[f64], right: &[f64], unit: f64) -> Result<RectifiedPair> {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs().max(b.abs());
    let (focal, right_focal) = (left[0], right[0]);
    ensure!(focal > 0.0, "the focal length is {focal} px, but must be more than 0; correct the projection matrix");
    ensure!(
        same(focal, right_focal),
        "the focal lengths are {focal} and {right_focal} px, but a rectified pair has one; use its projection matrices"
    );
    for p in [left, right] {
        ensure!(
            (p[5] - focal).abs() <= 1e-3 * focal,
            "the focal length is {focal} px along rows and {} px along columns, but pixels must be square; scale the images",
            p[5]
        );
        ensure!(
            p[1].abs() <= 1e-6 * focal,
            "the projection has a skew of {}, but a rectified one has none; {REMEDY}",
            p[1]
        );
        ensure!(
            p[4].abs() <= 1e-6 * focal && same(p[10], 1.0) && [p[8], p[9]].iter().all(|z| z.abs() <= 1e-6),
            "the projection is no [f 0 cx tx; 0 f cy ty; 0 0 1 tz]; {REMEDY}"
        );
    }
    let [across, down] = [3, 7].map(|i| (left[i] - right[i]) / focal * unit);
    let ahead = (left[11] - right[11]) * unit;
    ensure!(
        across != 0.0 || down != 0.0,
        "the baseline is 0 m: both cameras are one; give the right camera's projection, whose \
         fourth number is -f B"
    );
    // KITTI's files are off by tenths of a per cent.
    let vertical = down.abs() > across.abs();
    let (along, aside) = if vertical { (down, across) } else { (across, down) };
    ensure!(
        aside.abs() <= 0.01 * along.abs() && ahead.abs() <= 0.01 * along.abs(),
        "the cameras lie {across} m apart along rows, {down} m along columns and {ahead} m in depth, but must lie side by side, or \
         one above the other; rectify the pair"
    );
    let (lines, place) = if vertical { ("columns", 2) } else { ("rows", 6) };
    ensure!(
        (left[place] - right[place]).abs() <= 0.01,
        "the principal points lie in the {lines} {} and {}, but those of a rectified pair lie in one; {REMEDY}",
        left[place],
        right[place]
    );
    let [right_lies, left_one] = if vertical { ["above", "upper"] } else { ["to the left of", "left"] };
    ensure!(
        along > 0.0,
        "the baseline is {along} m: the right camera lies {right_lies} the {left_one} one; exchange the cameras and the images, or \
         correct the sign"
    );
    let doffs = if vertical { right[6] - left[6] } else { right[2] - left[2] };
    let camera = Camera { focal, baseline: along, doffs, cx: left[2], cy: left[6] };
    Ok(RectifiedPair { camera, vertical: Some(vertical) })
}

/// Q = [1 0 0 -cx; 0 1 0 -cy; 0 0 0 f; 0 0 1 / B doffs / B] of OpenCV's stereoRectify.
///
/// It does not tell whether the cameras lie side by side or one above the other.
pub fn of_q(q: &[f64], unit: f64) -> Result<RectifiedPair> {
    let places = [
        (0, 1.0),
        (1, 0.0),
        (2, 0.0),
        (4, 0.0),
        (5, 1.0),
        (6, 0.0),
        (8, 0.0),
        (9, 0.0),
        (10, 0.0),
        (12, 0.0),
        (13, 0.0),
    ];
    for (i, is) in places {
        ensure!(
            (q[i] - is).abs() <= 1e-9,
            "its Q has {} in row {}, column {}, but must be [1 0 0 -cx; 0 1 0 -cy; 0 0 0 f; 0 0 1/B doffs/B]; save it as \
             stereoRectify gives it",
            q[i],
            i / 4 + 1,
            i % 4 + 1
        );
    }
    ensure!(
        q[14] != 0.0,
        "its Q has 0 in row 4, column 3, but must have 1 / baseline; save it as stereoRectify gives it"
    );
    let (focal, baseline) = (q[11], 1.0 / q[14]);
    let (cx, cy, doffs) = (-q[3], -q[7], q[15] * baseline);
    let left = [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    let right = [focal, 0.0, cx + doffs, -focal * baseline, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    Ok(RectifiedPair { vertical: None, ..of_projections(&left, &right, unit)? })
}

/// Refuses two descriptions of one pair of cameras that differ by more than the rounding of numbers in files.
pub fn ensure_same(a: &Camera, b: &Camera, names: &str) -> Result<()> {
    let near = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-3 * scale;
    for (what, a, b, scale) in [
        ("focal lengths in px", a.focal, b.focal, a.focal),
        ("baselines in m", a.baseline, b.baseline, a.baseline),
        ("principal points' columns", a.cx, b.cx, 50.0),
        ("principal points' rows", a.cy, b.cy, 50.0),
        ("offsets of disparities", a.doffs, b.doffs, 50.0),
    ] {
        ensure!(near(a, b, scale), "{names} give different {what}, {a} and {b}; remove the one that is wrong");
    }
    Ok(())
}
