//! OpenCV's `stereoRectify` with `CALIB_ZERO_DISPARITY` and without a zoom (alpha = -1), and that of `cv::fisheye` with the
//! same and a balance of 0: from the rotation and the translation between two cameras to the rectified ones. J.-Y. Bouguet's
//! method, as in OpenCV's calib3d.

use crate::files::error::{Context as _, Result, ensure};
use crate::{Distortion, Lens};

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
pub fn rotation(v: Vector) -> Matrix {
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
fn without_lens([u, v]: [f64; 2], m: &Matrix, numbers: &[f64; 14]) -> [f64; 2] {
    let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y] = numbers;
    let straight = [(u - m[2]) / m[0], (v - m[5]) / m[4]];
    let from = if *tau_x == 0.0 && *tau_y == 0.0 { straight } else { untilted(straight, *tau_x, *tau_y) };
    let [mut x, mut y] = from;
    for _ in 0..5 {
        let q = x * x + y * y;
        let back = (1.0 + ((k6 * q + k5) * q + k4) * q) / (1.0 + ((k3 * q + k2) * q + k1) * q);
        if back < 0.0 {
            return straight;
        }
        let aside = [
            2.0 * p1 * x * y + p2 * (q + 2.0 * x * x) + s1 * q + s2 * q * q,
            p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y + s3 * q + s4 * q * q,
        ];
        [x, y] = [(from[0] - aside[0]) * back, (from[1] - aside[1]) * back];
    }
    [x, y]
}

/// Where a place of a tilted sensor lies on one that is not.
fn untilted([x, y]: [f64; 2], tau_x: f64, tau_y: f64) -> [f64; 2] {
    let ((sin_x, cos_x), (sin_y, cos_y)) = (tau_x.sin_cos(), tau_y.sin_cos());
    let z = cos_y * cos_x;
    let (a, b) = ((x - sin_y * cos_x) / z, (y + sin_x) / z);
    let w = -sin_y * cos_x * a + sin_x * b + z;
    [(cos_y * a + sin_y) / w, (sin_y * sin_x * a + cos_x * b - cos_y * sin_x) / w]
}

/// The same of a fisheye, turned: ten rounds of Newton's at most. Nothing where they lead nowhere, or behind the camera; OpenCV
/// has a place far away there, or the opposite one.
fn without_fisheye([u, v]: [f64; 2], m: &Matrix, rotation: &Matrix, [k1, k2, k3, k4]: &[f64; 4]) -> Option<[f64; 2]> {
    let [x, y] = [(u - m[2]) / m[0], (v - m[5]) / m[4]];
    let bent = (x * x + y * y).sqrt();
    if bent > std::f64::consts::FRAC_PI_2 {
        return None;
    }
    let (mut angle, mut found, mut scale) = (bent, bent <= 1e-8, 0.0);
    if !found {
        for _ in 0..10 {
            let t = angle * angle;
            let [a, b, c, d] = [k1 * t, k2 * t * t, k3 * t * t * t, k4 * t * t * t * t];
            let step = (angle * (1.0 + a + b + c + d) - bent) / (1.0 + 3.0 * a + 5.0 * b + 7.0 * c + 9.0 * d);
            angle -= step;
            if step.abs() < 1e-8 {
                found = true;
                break;
            }
        }
        scale = angle.tan() / bent;
    }
    let [x, y, z] = turned(rotation, &[x * scale, y * scale, 1.0]);
    let ahead = found && (0.0..std::f64::consts::FRAC_PI_2).contains(&angle) && z > 0.0;
    ahead.then(|| [x / z, y / z])
}

/// The focal length and the principal point of the rectified camera that loses no more than a balance of 0 does.
fn widest(m: &Matrix, k: &[f64; 4], rotation: &Matrix, [width, height]: [u32; 2]) -> Result<(f64, [f64; 2])> {
    let (w, h) = (f64::from(width), f64::from(height));
    let (half_w, half_h) = (f64::from(width / 2), f64::from(height / 2));
    let aspect = m[0] / m[4];
    let mut middles = [[half_w, 0.0], [w, half_h], [half_w, h], [0.0, half_h]];
    for place in &mut middles {
        let [x, y] = without_fisheye(*place, m, rotation, k).context(
            "its lenses see half of all directions or more, which no rectified image holds; give R1, P1, R2 and P2 beside the \
             lenses, of what is wanted",
        )?;
        *place = [x, y * aspect];
    }
    let mean = |axis: usize| middles.iter().map(|place| place[axis]).sum::<f64>() / 4.0;
    let least = |axis: usize| middles.iter().map(|place| place[axis]).fold(f64::INFINITY, f64::min);
    let most = |axis: usize| middles.iter().map(|place| place[axis]).fold(f64::NEG_INFINITY, f64::max);
    let center = [mean(0), mean(1)];
    let sides = [w * 0.5, h * 0.5 * aspect];
    let focal = [0, 1]
        .into_iter()
        .flat_map(|axis| [sides[axis] / (center[axis] - least(axis)), sides[axis] / (most(axis) - center[axis])])
        .fold(f64::NEG_INFINITY, f64::max);
    let point = [sides[0] - center[0] * focal, sides[1] - center[1] * focal];
    Ok((focal / aspect, [point[0], point[1] / aspect]))
}

/// The rotations from the cameras to the rectified ones, both by half of what lies between them, then level.
fn rotations(r: &Matrix, t: &Vector) -> Result<[Matrix; 2]> {
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
    Ok([times(&level, &transposed(&half)), times(&level, &half)])
}

/// The lenses of cameras of one size with their matrices and distortions, of which the right one sees `r` x + `t` where the left
/// one sees x; and the projections, 3 x 4 by rows.
pub fn stereo_rectify(
    cameras: [(Matrix, Distortion); 2],
    size: [u32; 2],
    r: &Matrix,
    t: &Vector,
) -> Result<([Lens; 2], [[f64; 12]; 2])> {
    let rotations = rotations(r, t)?;
    let (focal, center) = match cameras {
        [(left, Distortion::Fisheye(a)), (right, Distortion::Fisheye(b))] => {
            let sides = [widest(&left, &a, &rotations[0], size)?, widest(&right, &b, &rotations[1], size)?];
            let center = [0, 1].map(|axis| (sides[0].1[axis] + sides[1].1[axis]) * 0.5);
            (sides[0].0.min(sides[1].0), center)
        }
        _ => pinholes(&cameras, size, &rotations),
    };
    ensure!(
        focal > 0.0 && focal.is_finite() && center.iter().all(|place| place.is_finite()),
        "by its lenses and its R the cameras see nothing in common; correct them, or give R1, P1, R2 and P2"
    );
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

/// The mean focal length, and the principal point that has the corners of both images about the middle.
fn pinholes(
    cameras: &[(Matrix, Distortion); 2],
    [width, height]: [u32; 2],
    rotations: &[Matrix; 2],
) -> (f64, [f64; 2]) {
    let focal = (cameras[0].0[4] + cameras[1].0[4]) / 2.0;
    let far = [f64::from(width - 1), f64::from(height - 1)];
    let mut center = [0.0; 2];
    for ((matrix, distortion), rotation) in cameras.iter().zip(rotations) {
        let Distortion::Pinhole(numbers) = distortion else { continue };
        for corner in [[0.0, 0.0], [far[0], 0.0], [0.0, far[1]], far] {
            let [x, y] = without_lens(corner, matrix, numbers);
            let [x, y, z] = turned(rotation, &[x, y, 1.0]);
            // The mean of four corners of two cameras lies in the middle.
            center =
                [center[0] + (far[0] / 2.0 - focal * x / z) / 8.0, center[1] + (far[1] / 2.0 - focal * y / z) / 8.0];
        }
    }
    (focal, center)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What OpenCV 5.0 gives; its points are 32-bit floats.
    #[test]
    fn it_is_opencv_s() {
        let pinhole = |numbers: &[f64]| Distortion::pinhole(numbers).unwrap();
        let matrix = |fx: f64, cx: f64, fy: f64, cy: f64| [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
        let left = (matrix(500.0, 330.0, 505.0, 235.0), pinhole(&[-0.28, 0.09, 0.001, -0.0004, 0.01]));
        let right = (matrix(510.0, 310.0, 508.0, 250.0), pinhole(&[0.2, -0.1, 0.0007, 0.0009, 0.003, 0.4, -0.1, 0.02]));
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
        // A thin prism and a tilted sensor.
        let prism = [-0.28, 0.09, 0.001, -0.0004, 0.01, 0.0, 0.0, 0.0, 0.01, -0.02, 0.015, 0.003, 0.12, -0.2];
        let thin = pinhole(&[0.2, -0.1, 0.0007, 0.0009, 0.003, 0.4, -0.1, 0.02, 0.002, 0.001, -0.004, 0.002]);
        let bent = [(left.0, pinhole(&prism)), (right.0, thin)];
        let (_, projections) = stereo_rectify(bent, [640, 480], &r, &[-0.12, 0.003, -0.002]).unwrap();
        let [x, y] = [345.1744689941406, 259.5338592529297];
        near(&projections[0], &[506.5, 0.0, x, 0.0, 0.0, 506.5, y, 0.0, 0.0, 0.0, 1.0, 0.0], 1e-4);
        // Fisheyes.
        let fisheyes = [
            (matrix(310.0, 330.0, 312.0, 235.0), Distortion::Fisheye([0.0158, -0.0197, 0.0204, -0.0072])),
            (matrix(315.0, 310.0, 314.0, 250.0), Distortion::Fisheye([0.02, -0.01, 0.004, -0.001])),
        ];
        let (wide, projections) = stereo_rectify(fisheyes, [640, 480], &r, &[-0.12, 0.003, -0.002]).unwrap();
        assert_eq!(wide.map(|lens| lens.rotation), lenses.map(|lens| lens.rotation));
        let f = 251.62815524453555;
        let center = [319.4435564998694, 243.50092505303041];
        near(
            &projections[1],
            &[f, 0.0, center[0], -30.209005412957794, 0.0, f, center[1], 0.0, 0.0, 0.0, 1.0, 0.0],
            1e-9,
        );
        let all_around = fisheyes.map(|(matrix, lens)| (matrix.map(|m| if m > 300.0 { 0.6 * m } else { m }), lens));
        assert!(stereo_rectify(all_around, [640, 480], &r, &[-0.12, 0.0, 0.0]).is_err());
        assert!(stereo_rectify([left, right], [640, 480], &r, &[0.0, 0.1, 0.0]).is_err());
        assert!(stereo_rectify([left, right], [640, 480], &r, &[0.0; 3]).is_err());
        assert!(axis_of(&[-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]).is_err());
    }
}
