//! OpenCV's `stereoRectify` with `CALIB_ZERO_DISPARITY`, and that of `cv::fisheye` with the same: from the rotation and the
//! translation between two cameras to the rectified ones. J.-Y. Bouguet's method, as in OpenCV's calib3d.

use super::view::{View, of_pinholes, of_wide};
use crate::files::calibration::algebra::{Matrix, Vector, length, rotation, times, transposed, turned};
use crate::files::calibration::apart::is_wide;
use crate::files::error::{Result, ensure};
use crate::{Distortion, Lens};

/// What may be chosen.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// OpenCV's alpha, from 0 to 1.
    pub alpha: Option<f64>,
    /// Columns and rows of the rectified images, if they are not those of the given ones.
    pub size: Option<[u32; 2]>,
}

/// Rectified cameras.
#[derive(Clone, Debug)]
pub struct Rectified {
    /// The lens of each side.
    pub lenses: [Lens; 2],
    /// The projections, 3 x 4 by rows.
    pub projections: [[f64; 12]; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

/// The other way round, for less than half a turn.
fn axis_of(r: &Matrix) -> Result<Vector> {
    let v = [r[7] - r[5], r[2] - r[6], r[3] - r[1]].map(|component| component / 2.0);
    let (sin, cos) = (length(&v), (r[0] + r[4] + r[8] - 1.0) / 2.0);
    ensure!(sin > 1e-9 || cos > 0.0, "its R turns by half a turn, but both cameras must look the same way");
    Ok(if sin > 0.0 { v.map(|component| component / sin * sin.atan2(cos)) } else { v })
}

/// The rotations from the cameras to the rectified ones, both by half of what lies between them, then level; and the axis that
/// the cameras lie along.
fn rotations(r: &Matrix, t: &Vector) -> Result<([Matrix; 2], usize)> {
    let half = rotation(axis_of(r)?.map(|component| -0.5 * component));
    let aside = turned(&half, t);
    let distance = length(&aside);
    ensure!(distance > 0.0, "its T is 0, but the cameras must lie apart");
    let axis = usize::from(aside[0].abs() <= aside[1].abs());
    let along = if aside[axis] > 0.0 { 1.0 } else { -1.0 };
    // The vector that turns `aside` into the rows, or the columns.
    let about = match axis {
        0 => [0.0, aside[2] * along, -aside[1] * along],
        _ => [-aside[2] * along, 0.0, aside[0] * along],
    };
    let sine = length(&about);
    let angle = (aside[axis].abs() / distance).min(1.0).acos();
    let level = rotation(if sine > 0.0 { about.map(|component| component / sine * angle) } else { about });
    Ok(([times(&level, &transposed(&half)), times(&level, &half)], axis))
}

/// The rectified cameras of two with their matrices and distortions, of which the right one sees `r` x + `t` where the left one
/// sees x.
pub fn stereo_rectify(
    cameras: [(Matrix, Distortion); 2],
    given: [u32; 2],
    r: &Matrix,
    t: &Vector,
    wanted: &Wanted,
) -> Result<Rectified> {
    let (rotations, axis) = rotations(r, t)?;
    let view = View { alpha: wanted.alpha, given, size: wanted.size.unwrap_or(given), axis };
    let sides = [(&cameras[0], &rotations[0]), (&cameras[1], &rotations[1])];
    let (focal, center) = match is_wide(&cameras[0].1) {
        true => of_wide(sides, &view)?,
        false => of_pinholes(sides, &view),
    };
    ensure!(
        focal > 0.0 && focal.is_finite() && center.iter().all(|place| place.is_finite()),
        "by its lenses and its R the cameras see nothing in common; correct them, or give R1, P1, R2 and P2"
    );
    let shift = turned(&rotations[1], t)[axis] * focal;
    let lenses = [0, 1].map(|side| Lens {
        matrix: cameras[side].0,
        distortion: cameras[side].1,
        rotation: rotations[side],
        projection: [focal, 0.0, center[0], 0.0, focal, center[1], 0.0, 0.0, 1.0],
    });
    let projections = [0.0, shift].map(|shift| {
        let [across, down] = if axis == 0 { [shift, 0.0] } else { [0.0, shift] };
        [focal, 0.0, center[0], across, 0.0, focal, center[1], down, 0.0, 0.0, 1.0, 0.0]
    });
    Ok(Rectified { lenses, projections, size: view.size })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::calibration::algebra::rotation;

    /// As it is without a choice.
    fn rectified(
        cameras: [(Matrix, Distortion); 2],
        size: [u32; 2],
        r: &Matrix,
        t: &Vector,
    ) -> Result<([Lens; 2], [[f64; 12]; 2])> {
        let found = stereo_rectify(cameras, size, r, t, &Wanted { alpha: None, size: None })?;
        Ok((found.lenses, found.projections))
    }

    fn matrix(fx: f64, cx: f64, fy: f64, cy: f64) -> Matrix {
        [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    }

    fn pinhole(numbers: &[f64]) -> Distortion {
        Distortion::pinhole(numbers).unwrap()
    }

    fn pinholes() -> [(Matrix, Distortion); 2] {
        let left = (matrix(500.0, 330.0, 505.0, 235.0), pinhole(&[-0.28, 0.09, 0.001, -0.0004, 0.01]));
        let right = (matrix(510.0, 310.0, 508.0, 250.0), pinhole(&[0.2, -0.1, 0.0007, 0.0009, 0.003, 0.4, -0.1, 0.02]));
        [left, right]
    }

    fn fisheyes() -> [(Matrix, Distortion); 2] {
        [
            (matrix(310.0, 330.0, 312.0, 235.0), Distortion::Fisheye([0.0158, -0.0197, 0.0204, -0.0072])),
            (matrix(315.0, 310.0, 314.0, 250.0), Distortion::Fisheye([0.02, -0.01, 0.004, -0.001])),
        ]
    }

    fn turn() -> Matrix {
        rotation([0.02, -0.03, 0.01])
    }

    const BESIDE: Vector = [-0.12, 0.003, -0.002];
    const BELOW: Vector = [0.003, -0.12, -0.002];

    fn near(found: &[f64], expected: &[f64], most: f64) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < most), "{found:?} where {expected:?}");
    }

    /// A projection of focal length f, its principal point and its shifts to the right and down.
    fn projection(f: f64, [x, y]: [f64; 2], [across, down]: [f64; 2]) -> [f64; 12] {
        [f, 0.0, x, across, 0.0, f, y, down, 0.0, 0.0, 1.0, 0.0]
    }

    // What OpenCV 5.0 gives; its points are 32-bit floats.

    #[test]
    fn pinholes_are_rectified_as_by_opencv() {
        let r = turn();
        assert!(axis_of(&r).unwrap().iter().zip([0.02, -0.03, 0.01]).all(|(a, b)| (a - b).abs() < 1e-15));
        let (lenses, projections) = rectified(pinholes(), [640, 480], &r, &BESIDE).unwrap();
        near(&lenses[0].rotation[..3], &[0.9993081907443132, -0.034944856546575996, -0.012727800763149532], 1e-14);
        near(&lenses[0].rotation[3..6], &[0.03481282985922921, 0.9993392027430874, -0.010451063965109699], 1e-14);
        near(&lenses[0].rotation[6..], &[0.013084601198338567, 0.010000743059877158, 0.9998643799784702], 1e-14);
        near(&lenses[1].rotation[..3], &[0.9995489165092576, -0.024988722912733977, 0.016659148608487773], 1e-14);
        near(&lenses[1].rotation[3..6], &[0.024817012072345806, 0.9996375415200051, 0.010435587939410155], 1e-14);
        near(&lenses[1].rotation[6..], &[-0.016913882374254514, -0.010017450325842666, 0.999806766966497], 1e-14);
        let center = [318.9935188293457, 244.63608360290527];
        near(&projections[0], &projection(506.5, center, [0.0, 0.0]), 1e-5);
        near(&projections[1], &projection(506.5, center, [-60.80742922743897, 0.0]), 1e-5);
        // A thin prism and a tilted sensor.
        let prism = [-0.28, 0.09, 0.001, -0.0004, 0.01, 0.0, 0.0, 0.0, 0.01, -0.02, 0.015, 0.003, 0.12, -0.2];
        let thin = [0.2, -0.1, 0.0007, 0.0009, 0.003, 0.4, -0.1, 0.02, 0.002, 0.001, -0.004, 0.002];
        let [left, right] = pinholes();
        let bent = [(left.0, pinhole(&prism)), (right.0, pinhole(&thin))];
        let (_, projections) = rectified(bent, [640, 480], &r, &BESIDE).unwrap();
        near(&projections[0], &projection(506.5, [345.1744689941406, 259.5338592529297], [0.0, 0.0]), 1e-4);
        assert!(rectified(pinholes(), [640, 480], &r, &[0.0; 3]).is_err());
        assert!(axis_of(&[-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]).is_err());
    }

    #[test]
    fn fisheyes_are_rectified_as_by_opencv() {
        let (r, larger) = (turn(), Some([800, 500]));
        let (lenses, _) = rectified(pinholes(), [640, 480], &r, &BESIDE).unwrap();
        let (wide, projections) = rectified(fisheyes(), [640, 480], &r, &BESIDE).unwrap();
        assert_eq!(wide.map(|lens| lens.rotation), lenses.map(|lens| lens.rotation));
        let (focal, center) = (251.62815524453555, [319.4435564998694, 243.50092505303041]);
        near(&projections[1], &projection(focal, center, [-30.209005412957794, 0.0]), 1e-9);
        let all_around = fisheyes().map(|(matrix, lens)| (matrix.map(|m| if m > 300.0 { 0.6 * m } else { m }), lens));
        assert!(rectified(all_around, [640, 480], &r, &[-0.12, 0.0, 0.0]).is_err());
        for (balance, size, focal, center) in [
            (0.3, None, 232.8649255435124, [319.39836593064297, 243.2684508387537]),
            (1.0, None, 189.0840562411251, [319.2929212691148, 242.72601100544145]),
            (1.0, larger, 196.96255858450533, [399.11615158639347, 252.83959479733488]),
        ] {
            let wanted = Wanted { alpha: Some(balance), size };
            let found = stereo_rectify(fisheyes(), [640, 480], &r, &BESIDE, &wanted).unwrap();
            near(&found.projections[0], &projection(focal, center, [0.0, 0.0]), 1e-9);
        }
    }

    /// Alpha, a new size, and cameras one above the other: focal length and shift.
    #[test]
    fn what_is_shown_is_chosen_as_with_opencv() {
        let (r, larger) = (turn(), Some([800, 500]));
        let beside = [[318.9935188293457, 244.63608360290527], [398.71551990509033, 255.05217711130777]];
        let below = [[320.74803161621094, 239.94278717041016], [401.3250541687012, 250.05570650100708]];
        for (t, alpha, size, focal, shift) in [
            (BESIDE, None, larger, 527.6041666666667, -63.34107211191561),
            (BESIDE, Some(0.0), None, 503.14508032496855, -60.404657182615246),
            (BESIDE, Some(0.0), larger, 628.8897436715039, -75.50082641691453),
            (BESIDE, Some(0.3), larger, 564.5859000217225, -67.78088283984368),
            (BESIDE, Some(1.0), None, 380.54173694424696, -45.685616460659425),
            (BELOW, None, None, 505.0, -60.62734799576838),
            (BELOW, None, larger, 631.25, -75.78418499471047),
            (BELOW, Some(0.3), larger, 564.7746482459772, -67.80354284830999),
            (BELOW, Some(1.0), None, 383.0947463072536, -45.99211584103063),
        ] {
            let found = stereo_rectify(pinholes(), [640, 480], &r, &t, &Wanted { alpha, size }).unwrap();
            let (centers, shifts) = if t == BESIDE { (beside, [shift, 0.0]) } else { (below, [0.0, shift]) };
            near(&found.projections[1], &projection(focal, centers[usize::from(size.is_some())], shifts), 1e-3);
            assert_eq!(found.size, size.unwrap_or([640, 480]));
        }
        let upper = stereo_rectify(pinholes(), [640, 480], &r, &BELOW, &Wanted { alpha: None, size: None }).unwrap();
        near(&upper.lenses[0].rotation[..3], &[0.9997773466778925, 0.014738563660635374, -0.015100722199097688], 1e-14);
        near(&upper.lenses[1].rotation[..3], &[0.9995771500921367, 0.024734630875364517, 0.015287872616601514], 1e-14);
    }
}
