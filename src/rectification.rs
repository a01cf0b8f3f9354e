//! Where the pixels of rectified images come from.

use std::fmt;
use std::sync::Arc;

use crate::Error;

/// A camera with its lens, and the rectified camera in its place, as OpenCV's `stereoCalibrate` and `stereoRectify` tell
/// them. Matrices are by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// The camera matrix: [fx 0 cx; 0 fy cy; 0 0 1], in pixels.
    pub matrix: [f64; 9],
    /// k1, k2, p1, p2, k3, k4, k5, k6: radial-tangential distortion; rational with the last three. 0 for those that there
    /// are not.
    pub distortion: [f64; 8],
    /// The rotation from the camera to the rectified one: `R1`, `R2`.
    pub rotation: [f64; 9],
    /// The projection of the rectified camera, its first three columns: of `P1`, `P2`.
    pub projection: [f64; 9],
}

/// Rectifies pairs of one size on their way into the matcher: for [`crate::Params::rectify`].
///
/// The rectified images have the size of the given ones. Positions are computed once, in 64-bit floats, and kept in 1/256 px.
#[derive(Clone)]
pub struct Rectification(Arc<Inner>);

#[derive(PartialEq)]
struct Inner {
    size: [u32; 2],
    lenses: [Lens; 2],
    positions: [Vec<[i32; 2]>; 2],
}

impl PartialEq for Rectification {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.size == other.0.size && self.0.lenses == other.0.lenses
    }
}

impl fmt::Debug for Rectification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Rectification").field("size", &self.0.size).field("lenses", &self.0.lenses).finish()
    }
}

impl Rectification {
    /// For pairs of `width` x `height` pixels, the left lens and the right one.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a number is not finite, a focal length not positive, or a matrix has no inverse;
    /// [`Error::Image`] for a side of 0.
    pub fn new(width: u32, height: u32, lenses: [Lens; 2]) -> Result<Self, Error> {
        if width == 0 || height == 0 {
            return Err(Error::Image(format!("the images are {width}x{height}, but each side must be at least 1")));
        }
        let refused = |given: String, allowed: &str| {
            let (allowed, remedy) = (allowed.into(), "take the matrices of stereoCalibrate and stereoRectify");
            Err(Error::Parameter { name: "rectify", given, allowed, remedy })
        };
        let mut positions = [Vec::new(), Vec::new()];
        for (lens, positions) in lenses.iter().zip(&mut positions) {
            let Lens { matrix, distortion, rotation, projection } = lens;
            let all = matrix.iter().chain(distortion).chain(rotation).chain(projection);
            if let Some(number) = all.copied().find(|number| !number.is_finite()) {
                return refused(number.to_string(), "finite numbers");
            }
            for focal in [matrix[0], matrix[4], projection[0], projection[4]] {
                if focal <= 0.0 {
                    return refused(format!("a focal length of {focal}"), "focal lengths above 0");
                }
            }
            let Some(back) = inverse(&product(projection, rotation)) else {
                return refused("a projection and a rotation without an inverse".into(), "those of a camera");
            };
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            *positions = pixels.map(|(x, y)| lens.source(&back, x, y, [width, height])).collect();
        }
        Ok(Self(Arc::new(Inner { size: [width, height], lenses, positions })))
    }

    /// Columns and rows of the images.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    /// The lens of the left camera and that of the right one.
    pub fn lenses(&self) -> &[Lens; 2] {
        &self.0.lenses
    }

    /// For each pixel of a rectified image (0: the left one) the column and the row in the given one, in 1/256 px. Those that
    /// lie outside it may be nearer than they are.
    pub fn positions(&self, side: usize) -> &[[i32; 2]] {
        &self.0.positions[side]
    }

    /// Whether images are of its size.
    pub(crate) fn accepts(&self, width: u32, height: u32) -> Result<(), Error> {
        let [w, h] = self.size();
        if (w, h) == (width, height) {
            return Ok(());
        }
        Err(Error::Image(format!(
            "the images are {width}x{height}, but the rectification is of {w}x{h}; make one for this size"
        )))
    }
}

impl Lens {
    /// The formulas of OpenCV's `initUndistortRectifyMap`, of pixel (x, y) of the rectified image.
    fn source(&self, back: &[f64; 9], x: u32, y: u32, size: [u32; 2]) -> [i32; 2] {
        let (u, v) = (f64::from(x), f64::from(y));
        let [a, b, w] = [0, 3, 6].map(|i| back[i] * u + back[i + 1] * v + back[i + 2]);
        let (x, y) = (a / w, b / w);
        let [k1, k2, p1, p2, k3, k4, k5, k6] = self.distortion;
        let (xx, yy, xy) = (x * x, y * y, x * y);
        let r2 = xx + yy;
        let radial = (1.0 + ((k3 * r2 + k2) * r2 + k1) * r2) / (1.0 + ((k6 * r2 + k5) * r2 + k4) * r2);
        let column = x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * xx);
        let row = y * radial + p1 * (r2 + 2.0 * yy) + 2.0 * p2 * xy;
        let m = &self.matrix;
        let place = [m[0] * column + m[2], m[4] * row + m[5]];
        [0, 1].map(|axis| {
            let nearest = (256.0 * place[axis] + 0.5).floor();
            match nearest.is_finite() && w > 0.0 {
                true => nearest.clamp(-512.0, 256.0 * f64::from(size[axis])) as i32,
                false => -512,
            }
        })
    }
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
