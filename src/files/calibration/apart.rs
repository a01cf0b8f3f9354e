//! Two cameras and the pose of one to the other.

use super::algebra::Matrix;
use super::rectified::{RectifiedPair, of_projections};
use crate::Distortion;
use crate::files::error::{Result, ensure};

/// Two cameras, of which the right one sees `rotation` x + `translation`, in metres, where the left one sees x.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    pub(super) cameras: [(Matrix, Distortion); 2],
    pub(super) rotation: Matrix,
    pub(super) translation: [f64; 3],
}

/// Whether a lens sees more than a pinhole may: then it has no polynomial of a tangent.
pub fn is_wide(distortion: &Distortion) -> bool {
    !matches!(distortion, Distortion::Pinhole(_))
}

impl Apart {
    pub fn new(cameras: [(Matrix, Distortion); 2], rotation: Matrix, translation: [f64; 3]) -> Result<Self> {
        let wide = cameras.map(|(_, distortion)| is_wide(&distortion));
        ensure!(
            wide[0] == wide[1],
            "its lenses are a pinhole and a fisheye, which OpenCV cannot rectify together; add R1, P1, R2 and P2"
        );
        Ok(Self { cameras, rotation, translation })
    }

    /// The principal points, in the calibrated images.
    pub fn principal_points(&self) -> [[f64; 2]; 2] {
        self.cameras.each_ref().map(|(m, _)| [m[2], m[5]])
    }

    /// The cameras as they are, if they are rectified: without lenses and turns.
    pub fn as_it_is(&self) -> Option<Result<RectifiedPair>> {
        let Self { cameras: [(left, a), (right, b)], rotation, translation } = self;
        let straight = rotation.iter().enumerate().all(|(i, r)| (r - f64::from(u8::from(i % 4 == 0))).abs() <= 1e-6);
        if [a, b].iter().any(|lens| **lens != Distortion::NONE) || !straight {
            return None;
        }
        let projection = |k: &Matrix, t: [f64; 3]| {
            let column: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| k[3 * i + j] * t[j]).sum());
            let row = |i: usize| [k[3 * i], k[3 * i + 1], k[3 * i + 2], column[i]];
            [row(0), row(1), row(2)].concat()
        };
        // The fourth column of a principal point off the axis is -f B alone if the cameras lie side by side.
        Some(of_projections(&projection(left, [0.0; 3]), &projection(right, *translation), 1.0))
    }
}
