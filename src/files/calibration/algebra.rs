//! Vectors, matrices of 3 x 3 by rows, and poses.

pub type Vector = [f64; 3];
pub type Matrix = [f64; 9];

/// No rotation.
pub const STRAIGHT: Matrix = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

pub fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| (0..3).map(|k| a[i / 3 * 3 + k] * b[k * 3 + i % 3]).sum())
}

pub fn turned(a: &Matrix, v: &Vector) -> Vector {
    std::array::from_fn(|i| (0..3).map(|k| a[3 * i + k] * v[k]).sum())
}

pub fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|i| a[i % 3 * 3 + i / 3])
}

pub fn length(v: &Vector) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Rodrigues' formula: the rotation about `v` by its length.
pub fn rotation(v: Vector) -> Matrix {
    let angle = length(&v);
    if angle == 0.0 {
        return STRAIGHT;
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

/// The angle of a rotation, in radians.
pub fn angle(r: &Matrix) -> f64 {
    let v = [r[7] - r[5], r[2] - r[6], r[3] - r[1]];
    (length(&v) / 2.0).atan2((r[0] + r[4] + r[8] - 1.0) / 2.0)
}

/// A pose: what lies at x is at `rotation` x + `translation` for another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub rotation: Matrix,
    pub translation: Vector,
}

impl Pose {
    /// Of a matrix of 4 x 4 by rows, whose last row is not read.
    pub fn of_matrix(m: &[f64; 16]) -> Self {
        let rotation = std::array::from_fn(|i| m[i / 3 * 4 + i % 3]);
        Self { rotation, translation: [m[3], m[7], m[11]] }
    }

    /// Of a unit quaternion, x, y, z and w.
    pub fn of_quaternion([x, y, z, w]: [f64; 4], translation: Vector) -> Self {
        let rotation = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ];
        Self { rotation, translation }
    }

    pub fn inverse(&self) -> Self {
        let rotation = transposed(&self.rotation);
        Self { rotation, translation: turned(&rotation, &self.translation).map(|x| -x) }
    }

    /// This pose after the first one.
    pub fn after(&self, first: &Self) -> Self {
        let moved = turned(&self.rotation, &first.translation);
        Self {
            rotation: times(&self.rotation, &first.rotation),
            translation: std::array::from_fn(|i| moved[i] + self.translation[i]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_inverted_and_joined() {
        let (half, turn) = ((0.15f64).sin(), rotation([0.0, 0.3, 0.0]));
        let pose = Pose::of_quaternion([0.0, half, 0.0, (0.15f64).cos()], [1.0, 2.0, 3.0]);
        assert!(pose.rotation.iter().zip(turn).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!((angle(&turn) - 0.3).abs() < 1e-15 && angle(&STRAIGHT) == 0.0);
        let none = pose.after(&pose.inverse());
        assert!(none.rotation.iter().zip(STRAIGHT).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!(none.translation.iter().all(|x| x.abs() < 1e-15));
    }
}
