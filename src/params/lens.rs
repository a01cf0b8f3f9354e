//! A camera's lens: which place of its image a pixel of the rectified one comes from.

use crate::Error;

/// A camera with its lens, and the rectified camera in its place, as OpenCV's `stereoCalibrate` and `stereoRectify` give
/// them. Matrices are by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Lens {
    /// The camera matrix: [fx 0 cx; 0 fy cy; 0 0 1], in pixels.
    pub matrix: [f64; 9],
    /// How the lens distorts.
    pub distortion: Distortion,
    /// The rotation from the camera to the rectified one: `R1`, `R2`.
    pub rotation: [f64; 9],
    /// The projection of the rectified camera, its first three columns: of `P1`, `P2`.
    pub projection: [f64; 9],
}

/// How a lens distorts: OpenCV's models, and two for wide lenses.
///
/// ```
/// use gpu_stereo::Distortion;
/// let usual = Distortion::pinhole(&[-0.28, 0.09, 0.0011, -0.0004, 0.01])?;
/// let wide = Distortion::Fisheye([0.0158, -0.0197, 0.0204, -0.0072]);
/// # assert!(usual != wide && Distortion::pinhole(&[])? == Distortion::NONE);
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Distortion {
    /// The model of `calibrateCamera`: k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y, 0 for those that there
    /// are not. Radial and tangential; rational with k4 to k6, thin prism with s1 to s4, a tilted sensor with tau_x and
    /// tau_y, angles from -1.5 to 1.5.
    Pinhole([f64; 14]),
    /// The equidistant model of `cv::fisheye`: k1, k2, k3, k4. Without any it is still no pinhole.
    Fisheye([f64; 4]),
    /// The double sphere model of Basalt and Kalibr (`ds`): xi, alpha.
    DoubleSphere([f64; 2]),
    /// The extended unified model of Basalt and Kalibr (`eucm`): alpha, beta.
    ExtendedUnified([f64; 2]),
}

impl Distortion {
    /// A pinhole camera without a lens.
    pub const NONE: Self = Self::Pinhole([0.0; 14]);

    /// The numbers that a [`Distortion::Pinhole`] may have.
    pub const PINHOLE_COUNTS: [usize; 6] = [0, 4, 5, 8, 12, 14];

    /// The pinhole model of 0, 4, 5, 8, 12 or 14 numbers, in OpenCV's order.
    ///
    /// # Errors
    /// [`Error::Parameter`] for another count.
    pub fn pinhole(numbers: &[f64]) -> Result<Self, Error> {
        if !Self::PINHOLE_COUNTS.contains(&numbers.len()) {
            return refused(format!("a lens of {} numbers", numbers.len()), "0, 4, 5, 8, 12 or 14 of them");
        }
        Ok(Self::Pinhole(std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0))))
    }

    /// The numbers of the model.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Pinhole(numbers) => numbers,
            Self::Fisheye(numbers) => numbers,
            Self::DoubleSphere(numbers) | Self::ExtendedUnified(numbers) => numbers,
        }
    }
}

fn refused<T>(given: String, allowed: &str) -> Result<T, Error> {
    let (allowed, remedy) = (allowed.into(), "use the matrices of stereoCalibrate and stereoRectify");
    Err(Error::Parameter { name: "rectify", given, allowed, remedy })
}

impl Lens {
    /// Of a camera matrix, a distortion, a rotation and a projection.
    #[must_use]
    pub const fn new(matrix: [f64; 9], distortion: Distortion, rotation: [f64; 9], projection: [f64; 9]) -> Self {
        Self { matrix, distortion, rotation, projection }
    }

    /// The lens of the same camera whose rectified image, `width` pixels wide, is turned by 90 degrees against the clock: what was
    /// at (x, y) is at (y, `width` - 1 - x).
    pub(crate) fn turned(&self, width: u32) -> Self {
        let Self { rotation: r, projection: p, .. } = *self;
        let rotation = [r[3], r[4], r[5], -r[0], -r[1], -r[2], r[6], r[7], r[8]];
        let projection = [p[4], 0.0, p[5], 0.0, p[0], f64::from(width - 1) - p[2], p[6], p[7], p[8]];
        Self { rotation, projection, ..*self }
    }

    /// For each pixel of a rectified image the column and the row in the given one, in 1/256 px.
    pub(crate) fn positions(&self, given: [u32; 2], rectified: [u32; 2]) -> Result<Vec<[i32; 2]>, Error> {
        let Self { matrix, distortion, rotation, projection } = self;
        let all = matrix.iter().chain(distortion.numbers()).chain(rotation).chain(projection);
        if let Some(number) = all.copied().find(|number| !number.is_finite()) {
            return refused(number.to_string(), "finite numbers");
        }
        for focal in [matrix[0], matrix[4], projection[0], projection[4]] {
            if focal <= 0.0 {
                return refused(format!("a focal length of {focal}"), "focal lengths above 0");
            }
        }
        if [matrix[1], matrix[3], matrix[6], matrix[7], matrix[8]] != [0.0, 0.0, 0.0, 0.0, 1.0] {
            return refused(format!("a camera matrix of {matrix:?}"), "[fx 0 cx; 0 fy cy; 0 0 1]");
        }
        let Some(back) = inverse(&product(projection, rotation)) else {
            return refused("a projection and a rotation without an inverse".into(), "those of a camera");
        };
        let bent = Bent::of(distortion)?;
        let place = |x: u32, y: u32| {
            let (u, v) = (f64::from(x), f64::from(y));
            let [x, y, w] = [0, 3, 6].map(|i| back[i] * u + back[i + 1] * v + back[i + 2]);
            let Some([x, y]) = bent.ray(x / w, y / w).filter(|_| w > 0.0) else { return [-512; 2] };
            let place = [matrix[0] * x + matrix[2], matrix[4] * y + matrix[5]];
            [0, 1].map(|axis| {
                let nearest = (256.0 * place[axis] + 0.5).floor();
                match nearest.is_finite() {
                    true => nearest.clamp(-512.0, 256.0 * f64::from(given[axis])) as i32,
                    false => -512,
                }
            })
        };
        let [width, height] = rectified;
        Ok((0..height).flat_map(|y| (0..width).map(move |x| place(x, y))).collect())
    }
}

/// A distortion, ready for many rays.
#[derive(Clone, Copy)]
enum Bent {
    Pinhole([f64; 12], Option<[f64; 4]>),
    Fisheye([f64; 4]),
    DoubleSphere([f64; 2]),
    ExtendedUnified([f64; 2]),
}

impl Bent {
    fn of(distortion: &Distortion) -> Result<Self, Error> {
        match *distortion {
            Distortion::Fisheye(k) => Ok(Self::Fisheye(k)),
            Distortion::DoubleSphere(numbers) => Ok(Self::DoubleSphere(numbers)),
            Distortion::ExtendedUnified(numbers) => Ok(Self::ExtendedUnified(numbers)),
            Distortion::Pinhole(numbers) => {
                let [.., tau_x, tau_y] = numbers;
                if let Some(tau) = [tau_x, tau_y].into_iter().find(|tau| tau.abs() > 1.5) {
                    return refused(format!("a sensor's tilt of {tau}"), "from -1.5 to 1.5");
                }
                let tilt = [sine(tau_x), cosine(tau_x), sine(tau_y), cosine(tau_y)];
                let tilted = tau_x != 0.0 || tau_y != 0.0;
                Ok(Self::Pinhole(std::array::from_fn(|i| numbers[i]), tilted.then_some(tilt)))
            }
        }
    }

    /// Where the ray through (x, y) at a distance of 1 meets a sensor at a distance of 1, if it does: the formulas of OpenCV's
    /// `initUndistortRectifyMap` and of the one of `cv::fisheye`.
    fn ray(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let (xx, yy, xy) = (x * x, y * y, x * y);
        let q = xx + yy;
        match self {
            Self::Fisheye([k1, k2, k3, k4]) => {
                let r = q.sqrt();
                let angle = arc_tangent(r);
                let t = angle * angle;
                let bent = angle * (1.0 + (((k4 * t + k3) * t + k2) * t + k1) * t);
                let scale = if r == 0.0 { 1.0 } else { bent / r };
                Some([x * scale, y * scale])
            }
            Self::DoubleSphere([xi, alpha]) => {
                let far = (q + 1.0).sqrt();
                let z = xi * far + 1.0;
                let w = alpha * (q + z * z).sqrt() + (1.0 - alpha) * z;
                let ahead = w > 0.0;
                ahead.then(|| [x / w, y / w])
            }
            Self::ExtendedUnified([alpha, beta]) => {
                let w = alpha * (beta * q + 1.0).sqrt() + (1.0 - alpha);
                let ahead = w > 0.0;
                ahead.then(|| [x / w, y / w])
            }
            Self::Pinhole([k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4], tilt) => {
                let radial = (1.0 + ((k3 * q + k2) * q + k1) * q) / (1.0 + ((k6 * q + k5) * q + k4) * q);
                let column = x * radial + 2.0 * p1 * xy + p2 * (q + 2.0 * xx) + s1 * q + s2 * (q * q);
                let row = y * radial + p1 * (q + 2.0 * yy) + 2.0 * p2 * xy + s3 * q + s4 * (q * q);
                let Some([sin_x, cos_x, sin_y, cos_y]) = tilt else { return Some([column, row]) };
                let w = sin_y * column - cos_y * sin_x * row + cos_y * cos_x;
                let ahead = w > 0.0;
                ahead.then(|| [cos_x * column / w, (cos_y * row - sin_x * sin_y * column) / w])
            }
        }
    }
}

/// The arc tangent of a number from 0 on, of operations that round alike everywhere, as no library's does: atan(r) is twice
/// atan(r / (1 + sqrt(1 + r r))); after four rounds the angle is at most pi / 32, and eight terms of the series are enough.
fn arc_tangent(r: f64) -> f64 {
    let t = (0..4).fold(r, |t, _| t / (1.0 + (1.0 + t * t).sqrt()));
    let q = t * t;
    let series = (0..8).rev().fold(0.0, |sum, i| 1.0 / f64::from(2 * i + 1) - q * sum);
    16.0 * (t * series)
}

/// The sine of an angle from -1.5 to 1.5, likewise.
fn sine(angle: f64) -> f64 {
    let q = angle * angle;
    angle * (1..14).rev().fold(1.0, |sum, i| 1.0 - q / f64::from(2 * i * (2 * i + 1)) * sum)
}

fn cosine(angle: f64) -> f64 {
    let q = angle * angle;
    (1..14).rev().fold(1.0, |sum, i| 1.0 - q / f64::from(2 * i * (2 * i - 1)) * sum)
}

fn product(a: &[f64; 9], b: &[f64; 9]) -> [f64; 9] {
    std::array::from_fn(|i| a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[i % 3 + 3] + a[i / 3 * 3 + 2] * b[i % 3 + 6])
}

/// The cofactors by the determinant.
fn inverse(m: &[f64; 9]) -> Option<[f64; 9]> {
    let minor = |a: usize, b: usize, c: usize, d: usize| m[a] * m[b] - m[c] * m[d];
    let cofactors = [
        minor(4, 8, 5, 7),
        minor(2, 7, 1, 8),
        minor(1, 5, 2, 4),
        minor(5, 6, 3, 8),
        minor(0, 8, 2, 6),
        minor(2, 3, 0, 5),
        minor(3, 7, 4, 6),
        minor(1, 6, 0, 7),
        minor(0, 4, 1, 3),
    ];
    let determinant = m[0] * cofactors[0] + m[1] * cofactors[3] + m[2] * cofactors[6];
    let inverse = cofactors.map(|cofactor| cofactor / determinant);
    inverse.iter().all(|number| number.is_finite()).then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_library() {
        let near = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs().max(1e-300);
        for i in 0..20_000 {
            let r = (f64::from(i) * 1e-3).exp_m1();
            assert!(near(arc_tangent(r), r.atan()), "{r}: {} for {}", arc_tangent(r), r.atan());
            let angle = f64::from(i) * 1.5e-4 - 1.5;
            assert!(
                (sine(angle) - angle.sin()).abs() < 4e-16 && (cosine(angle) - angle.cos()).abs() < 4e-16,
                "{angle}"
            );
        }
        assert_eq!(arc_tangent(0.0), 0.0);
    }

    #[test]
    fn what_is_no_lens_is_refused() {
        let matrix = [100.0, 0.0, 8.0, 0.0, 100.0, 4.0, 0.0, 0.0, 1.0];
        let rotation = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let good = Lens { matrix, distortion: Distortion::NONE, rotation, projection: matrix };
        assert_eq!(good.positions([16, 8], [16, 8]).unwrap()[17], [256, 256]);
        let tilted = |tau: f64| Distortion::Pinhole(std::array::from_fn(|i| if i == 13 { tau } else { 0.0 }));
        let with = |i: usize, value: f64| {
            let mut lens = good;
            lens.matrix[i] = value;
            lens
        };
        for (lens, words) in [
            (Lens { distortion: tilted(1.6), ..good }, "tilt of 1.6"),
            (Lens { distortion: Distortion::Fisheye([f64::NAN; 4]), ..good }, "NaN"),
            (with(1, 0.1), "camera matrix"),
            (with(8, 2.0), "camera matrix"),
            (with(4, -1.0), "focal length of -1"),
            (Lens { rotation: [0.0; 9], ..good }, "without an inverse"),
        ] {
            let error = lens.positions([16, 8], [16, 8]).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        assert!(Distortion::pinhole(&[0.0; 6]).unwrap_err().to_string().contains("6 numbers"));
    }
}
