//! Where pixels lie without their lens, at a distance of 1.

use crate::Distortion;
use crate::files::calibration::algebra::{Matrix, turned};

/// Of a pinhole camera: five rounds, as OpenCV has them.
pub fn without_lens([u, v]: [f64; 2], m: &Matrix, numbers: &[f64; 14]) -> [f64; 2] {
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

/// Of a wide lens, turned. Nothing behind the camera, where OpenCV has a place far away, or the opposite one.
pub fn without_wide([u, v]: [f64; 2], m: &Matrix, rotation: &Matrix, lens: &Distortion) -> Option<[f64; 2]> {
    let place = [(u - m[2]) / m[0], (v - m[5]) / m[4]];
    let ray = match lens {
        Distortion::Fisheye(k) => of_fisheye(place, k)?,
        Distortion::DoubleSphere(numbers) => of_double_sphere(place, *numbers)?,
        Distortion::ExtendedUnified(numbers) => of_extended_unified(place, *numbers)?,
        Distortion::Pinhole(numbers) => {
            let [x, y] = without_lens([u, v], m, numbers);
            [x, y, 1.0]
        }
    };
    let [x, y, z] = turned(rotation, &ray);
    (ray[2] > 0.0 && z > 0.0).then(|| [x / z, y / z])
}

/// Ten rounds of Newton's at most; nothing where they lead nowhere.
fn of_fisheye([x, y]: [f64; 2], [k1, k2, k3, k4]: &[f64; 4]) -> Option<[f64; 3]> {
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
    let ahead = found && (0.0..std::f64::consts::FRAC_PI_2).contains(&angle);
    ahead.then_some([x * scale, y * scale, 1.0])
}

/// V. Usenko et al., "The Double Sphere Camera Model", equations 46 to 51.
fn of_double_sphere([x, y]: [f64; 2], [xi, alpha]: [f64; 2]) -> Option<[f64; 3]> {
    let q = x * x + y * y;
    let root = 1.0 - (2.0 * alpha - 1.0) * q;
    let z = (1.0 - alpha * alpha * q) / (alpha * root.max(0.0).sqrt() + 1.0 - alpha);
    let scale = (z * xi + (z * z + (1.0 - xi * xi) * q).max(0.0).sqrt()) / (z * z + q);
    let ray = [scale * x, scale * y, scale * z - xi];
    (root >= 0.0 && ray.iter().all(|x| x.is_finite())).then_some(ray)
}

/// B. Khomutenko et al., "An Enhanced Unified Camera Model".
fn of_extended_unified([x, y]: [f64; 2], [alpha, beta]: [f64; 2]) -> Option<[f64; 3]> {
    let q = x * x + y * y;
    let root = 1.0 - (2.0 * alpha - 1.0) * beta * q;
    let z = (1.0 - beta * alpha * alpha * q) / (alpha * root.max(0.0).sqrt() + 1.0 - alpha);
    (root >= 0.0 && z.is_finite()).then_some([x, y, z])
}
