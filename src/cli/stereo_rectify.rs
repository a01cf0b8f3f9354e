//! OpenCV's `stereoRectify` with `CALIB_ZERO_DISPARITY` and without a zoom (alpha = -1): from the rotation and the
//! translation between two cameras to the rectified ones. J.-Y. Bouguet's method, as in OpenCV's calib3d.

use anyhow::{Result, ensure};
use gpu_stereo::Lens;

type Vector = [f64; 3];
type Matrix = [f64; 9];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| (0..3).map(|k| a[i / 3 * 3 + k] * b[k * 3 + i % 3]).sum())
}

fn turned(a: &Matrix, v: &Vector) -> Vector {
    std::array::from_fn(|i| (0..3).map(|k| a[3 * i + k] * v[k]).sum())
}

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| a[i % 3 * 3 + i / 3])
}

fn length(v: &Vector) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Rodrigues' formula: the rotation about `v` by its length.
fn rotation(v: Vector) -> Matrix {
    let angle = length(&v);
    if angle == 0.0 {
        return [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    }
    let [x, y, z] = v.map(|component| component / angle);
    let (sin, cos) = angle.sin_cos();
    let cross = [0.0, -z, y, z, 0.0, -x, -y, x, 0.0];
    let axis = [x, y, z];
    std::array::from_fn(|i| {
        let one = if i % 4 == 0 { cos } else { 0.0 };
        one + (1.0 - cos) * axis[i / 3] * axis[i % 3] + sin * cross[i]
    })
}

/// The other way round, for less than half a turn.
fn axis_of(r: &Matrix) -> Result<Vector> {
    let v = [r[7] - r[5], r[2] - r[6], r[3] - r[1]].map(|component| component / 2.0);
    let (sin, cos) = (length(&v), (r[0] + r[4] + r[8] - 1.0) / 2.0);
    ensure!(sin > 1e-9 || cos > 0.0, "its R turns by half a turn, but both cameras must look the same way");
    Ok(if sin > 0.0 { v.map(|component| component / sin * sin.atan2(cos)) } else { v })
}

/// Where a pixel lies without its lens, at a distance of 1: five rounds, as OpenCV has them.
fn without_lens([u, v]: [f64; 2], m: &Matrix, [k1, k2, p1, p2, k3, k4, k5, k6]: &[f64; 8]) -> [f64; 2] {
    let from = [(u - m[2]) / m[0], (v - m[5]) / m[4]];
    let [mut x, mut y] = from;
    for _ in 0..5 {
        let q = x * x + y * y;
        let back = (1.0 + ((k6 * q + k5) * q + k4) * q) / (1.0 + ((k3 * q + k2) * q + k1) * q);
        if back < 0.0 {
            return from;
        }
        let aside = [2.0 * p1 * x * y + p2 * (q + 2.0 * x * x), p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y];
        [x, y] = [(from[0] - aside[0]) * back, (from[1] - aside[1]) * back];
    }
    [x, y]
}

/// The lenses of cameras of one size with their matrices and distortions, of which the right one sees `rotation` x +
/// `translation` where the left one sees x; and the projections, 3 x 4 by rows.
pub fn stereo_rectify(
    cameras: [(Matrix, [f64; 8]); 2],
    [width, height]: [u32; 2],
    r: &Matrix,
    t: &Vector,
) -> Result<([Lens; 2], [[f64; 12]; 2])> {
    let half = rotation(axis_of(r)?.map(|component| -0.5 * component));
    let aside = turned(&half, t);
    let distance = length(&aside);
    ensure!(distance > 0.0, "its T is 0, but the cameras must lie apart");
    ensure!(
        aside[0].abs() > aside[1].abs(),
        "its cameras lie {:?} apart, one above the other, but must lie side by side; turn the images",
        t
    );
    let along = if aside[0] > 0.0 { 1.0 } else { -1.0 };
    // The axis that turns `aside` into the rows.
    let axis = [0.0, aside[2] * along, -aside[1] * along];
    let sine = length(&axis);
    let angle = (aside[0].abs() / distance).min(1.0).acos();
    let level = rotation(if sine > 0.0 { axis.map(|component| component / sine * angle) } else { axis });
    let rotations = [times(&level, &transposed(&half)), times(&level, &half)];
    let focal = (cameras[0].0[4] + cameras[1].0[4]) / 2.0;
    let far = [f64::from(width - 1), f64::from(height - 1)];
    let mut center = [0.0; 2];
    for ((matrix, distortion), rotation) in cameras.iter().zip(&rotations) {
        for corner in [[0.0, 0.0], [far[0], 0.0], [0.0, far[1]], far] {
            let [x, y] = without_lens(corner, matrix, distortion);
            let [x, y, z] = turned(rotation, &[x, y, 1.0]);
            // The mean of four corners of two cameras lies in the middle.
            center =
                [center[0] + (far[0] / 2.0 - focal * x / z) / 8.0, center[1] + (far[1] / 2.0 - focal * y / z) / 8.0];
        }
    }
    let shift = turned(&rotations[1], t)[0] * focal;
    let lenses = [0, 1].map(|side| Lens {
        matrix: cameras[side].0,
        distortion: cameras[side].1,
        rotation: rotations[side],
        projection: [focal, 0.0, center[0], 0.0, focal, center[1], 0.0, 0.0, 1.0],
    });
    let projections =
        [0.0, shift].map(|shift| [focal, 0.0, center[0], shift, 0.0, focal, center[1], 0.0, 0.0, 0.0, 1.0, 0.0]);
    Ok((lenses, projections))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What OpenCV 5.0 gives; its points are 32-bit floats.
    #[test]
    fn it_is_opencv_s() {
        let left =
            ([500.0, 0.0, 330.0, 0.0, 505.0, 235.0, 0.0, 0.0, 1.0], [-0.28, 0.09, 0.001, -0.0004, 0.01, 0.0, 0.0, 0.0]);
        let right = (
            [510.0, 0.0, 310.0, 0.0, 508.0, 250.0, 0.0, 0.0, 1.0],
            [0.2, -0.1, 0.0007, 0.0009, 0.003, 0.4, -0.1, 0.02],
        );
        let r = rotation([0.02, -0.03, 0.01]);
        assert!(axis_of(&r).unwrap().iter().zip([0.02, -0.03, 0.01]).all(|(a, b)| (a - b).abs() < 1e-15));
        let (lenses, projections) = stereo_rectify([left, right], [640, 480], &r, &[-0.12, 0.003, -0.002]).unwrap();
        let near = |found: &[f64], expected: &[f64], most: f64| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < most), "{found:?} where {expected:?}");
        };
        near(
            &lenses[0].rotation,
            &[
                0.9993081907443132,
                -0.034944856546575996,
                -0.012727800763149532,
                0.03481282985922921,
                0.9993392027430874,
                -0.010451063965109699,
                0.013084601198338567,
                0.010000743059877158,
                0.9998643799784702,
            ],
            1e-14,
        );
        near(
            &lenses[1].rotation,
            &[
                0.9995489165092576,
                -0.024988722912733977,
                0.016659148608487773,
                0.024817012072345806,
                0.9996375415200051,
                0.010435587939410155,
                -0.016913882374254514,
                -0.010017450325842666,
                0.999806766966497,
            ],
            1e-14,
        );
        let p = |shift| [506.5, 0.0, 318.9935188293457, shift, 0.0, 506.5, 244.63608360290527, 0.0, 0.0, 0.0, 1.0, 0.0];
        near(&projections[0], &p(0.0), 1e-5);
        near(&projections[1], &p(-60.80742922743897), 1e-5);
        assert!(stereo_rectify([left, right], [640, 480], &r, &[0.0, 0.1, 0.0]).is_err());
        assert!(stereo_rectify([left, right], [640, 480], &r, &[0.0; 3]).is_err());
        assert!(axis_of(&[-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]).is_err());
    }
}
