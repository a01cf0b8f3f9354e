//! The cameras of a rectified pair, which turn disparities into depths.

use crate::Error;

/// The cameras of a rectified pair: they look the same way, with one focal length, and the right one is `baseline` to the
/// right of the left one.
///
/// Depths are in the unit of `baseline`; where this crate says metres, it assumes that `baseline` is in metres.
///
/// ```
/// use gpu_stereo::Camera;
/// let camera = Camera::new(994.978, 0.193).with_doffs(31.086).with_principal_point(311.193, 254.877);
/// assert!(camera.validate().is_ok() && Camera::new(0.0, 0.193).validate().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Camera {
    /// Focal length in pixels, 1 to 1,000,000.
    pub focal: f64,
    /// Distance between the cameras in metres, 10^-6 to 1000.
    pub baseline: f64,
    /// Column of the right principal point less that of the left one, in pixels: 65,536 at most to either side. With it, a
    /// disparity of -`doffs` is infinitely far away.
    pub doffs: f64,
    /// Column of the left principal point, where 0 is the centre of the first pixel: 1,000,000 at most to either side.
    pub cx: f64,
    /// Row of both principal points.
    pub cy: f64,
}

impl Camera {
    /// Cameras of this focal length in pixels and this distance in metres, whose principal points lie in one column, at (0, 0).
    #[must_use]
    pub const fn new(focal: f64, baseline: f64) -> Self {
        Self { focal, baseline, doffs: 0.0, cx: 0.0, cy: 0.0 }
    }

    /// The same with the right principal point so many pixels to the right of the left one.
    #[must_use]
    pub fn with_doffs(self, doffs: f64) -> Self {
        Self { doffs, ..self }
    }

    /// The same with the left principal point in this column and row.
    #[must_use]
    pub fn with_principal_point(self, cx: f64, cy: f64) -> Self {
        Self { cx, cy, ..self }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first number outside its range, or none at all.
    pub fn validate(&self) -> Result<(), Error> {
        let Self { focal, baseline, doffs, cx, cy } = *self;
        for (name, value, least, most, remedy) in [
            ("focal", focal, 1.0, 1e6, "give the focal length in pixels"),
            ("baseline", baseline, 1e-6, 1000.0, "give the distance between the cameras in metres"),
            ("doffs", doffs, -65_536.0, 65_536.0, "give the right principal point's column less the left one's"),
            ("cx", cx, -1e6, 1e6, "give the column of the left principal point"),
            ("cy", cy, -1e6, 1e6, "give the row of the principal points"),
        ] {
            if !(least..=most).contains(&value) {
                let allowed = format!("from {least} to {most}");
                return Err(Error::Parameter { name, given: value.to_string(), allowed, remedy });
            }
        }
        Ok(())
    }

    /// The position of what pixel (x, y) of the left image shows at a `depth` of a [`crate::DepthMap`], in metres: to the
    /// right, down and forward of the left camera.
    pub fn point(&self, x: u32, y: u32, depth: u32) -> [f64; 3] {
        let z = f64::from(depth) * 1e-6;
        [(f64::from(x) - self.cx) * z / self.focal, (f64::from(y) - self.cy) * z / self.focal, z]
    }

    /// 4096 `focal` `baseline` in millionths, at most 2^62, and `doffs` in 1/4096 px, both to the nearest.
    pub(crate) fn fixed(&self) -> (u64, i32) {
        let nearest = |value: f64| (value + 0.5).floor();
        (nearest(self.focal * self.baseline * 4.096e9) as u64, nearest(self.doffs * 4096.0) as i32)
    }
}
