//! Fits a calibration to the images: their size and scale, and warnings about doubtful numbers.

use super::apart::Apart;
use super::cameras::{Calibration, Cameras};
use super::reading::Unit;
use super::rectified::of_projections;
use super::scale::{Scale, in_words};
use super::stereo_rectify::stereo_rectify;
use crate::files::error::{Result, bail, ensure};
use crate::{Camera, Lens};

type Matrix = [f64; 9];

/// The cameras of images of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The rectified cameras.
    pub camera: Camera,
    /// The lenses of a pair that is to be rectified.
    pub lenses: Option<[Lens; 2]>,
}

/// The rectified cameras of those that lie apart.
fn fitted(apart: &Apart, size: [u32; 2], scale: Scale) -> Result<Fitted> {
    let cameras = apart.cameras.map(|(matrix, distortion)| (scale.of_matrix(matrix), distortion));
    let (lenses, [left, right]) = stereo_rectify(cameras, size, &apart.rotation, &apart.translation)?;
    Ok(Fitted { camera: of_projections(&left, &right, 1.0)?, lenses: Some(lenses) })
}

impl Calibration {
    /// The cameras of images of this size.
    pub fn fit(&self, width: u32, height: u32) -> Result<Fitted> {
        let scale = self.scale.unwrap_or(Scale::ONE);
        match self.size {
            Some(size) => ensure_size(size, [width, height], scale)?,
            None => self.ensure_middle([width, height])?,
        }
        let fitted = match &self.cameras {
            Cameras::Rectified(camera) => Fitted { camera: scale.of_camera(*camera), lenses: None },
            Cameras::Lenses(camera, lenses) => Fitted {
                camera: scale.of_camera(*camera),
                lenses: Some(lenses.each_ref().map(|lens| scale.of_lens(lens))),
            },
            Cameras::Apart(apart) => fitted(apart, [width, height], scale)?,
        };
        fitted.camera.validate()?;
        if matches!(self.cameras, Cameras::Lenses(..)) && self.scale.is_none() {
            ensure_inside(&fitted.camera, [width, height])?;
        }
        Ok(fitted)
    }

    /// The principal points of the given cameras, in the calibrated images.
    fn principal_points(&self) -> [[f64; 2]; 2] {
        let of = |m: &Matrix| [m[2], m[5]];
        match &self.cameras {
            Cameras::Rectified(Camera { doffs, cx, cy, .. }) => [[*cx, *cy], [cx + doffs, *cy]],
            Cameras::Lenses(_, lenses) => lenses.each_ref().map(|lens| of(&lens.matrix)),
            Cameras::Apart(apart) => apart.cameras.each_ref().map(|(matrix, _)| of(matrix)),
        }
    }

    /// Refuses a calibration that gives no image size and does not suit these images: a principal point lies far from the
    /// middle, or all of them are off it by one factor, as those of images at another size.
    fn ensure_middle(&self, images: [u32; 2]) -> Result<()> {
        let scale = self.scale.unwrap_or(Scale::ONE);
        let points = self.principal_points().map(|point| point.map(|place| scale.of_place(place)));
        // 1 is the middle, 0 and 2 are the borders.
        let shares = points.map(|point| [0, 1].map(|axis| 2.0 * (point[axis] + 0.5) / f64::from(images[axis])));
        let all = shares.as_flattened();
        let [width, height] = images;
        let [x, y] = points[0];
        if self.scale.is_some() {
            let outside = scale != Scale::ONE && all.iter().any(|share| !(0.0..=2.0).contains(share));
            ensure!(
                !outside,
                "at --calib-scale {} the principal point is ({x}, {y}), outside the {width}x{height} images; give the ratio of \
                 their size to that of the calibrated ones",
                in_words(scale.0)
            );
            return Ok(());
        }
        let mean = |axis: usize| (shares[0][axis] + shares[1][axis]) / 2.0;
        let factor = (mean(0) + mean(1)) / 2.0;
        let alike = mean(0) > 0.0 && (0.9..=1.0 / 0.9).contains(&(mean(1) / mean(0)));
        let far = all.iter().any(|share| !(0.6..=1.4).contains(share));
        let scaled = alike && !(1.0 / 1.15..=1.15).contains(&factor);
        if !far && !scaled {
            return Ok(());
        }
        let remedy = match alike {
            true => {
                format!(
                    "give --calib-scale {}, the ratio of their size to that of the calibrated ones",
                    in_words(1.0 / factor)
                )
            }
            false => {
                "use the calibration of these images, or give --calib-scale, the ratio of their size to that of the calibrated ones"
                    .into()
            }
        };
        bail!(
            "the calibration has no image size and a principal point of ({x}, {y}), but the middle of the {width}x{height} \
             images is ({}, {}); {remedy}; if it is right, give --calib-scale 1",
            f64::from(width - 1) / 2.0,
            f64::from(height - 1) / 2.0
        );
    }

    /// A warning if the cameras are doubtful.
    pub fn doubt(&self, camera: &Camera) -> Option<String> {
        let baseline = camera.baseline;
        if (0.005..=3.0).contains(&baseline) {
            return None;
        }
        let Some(unit) = self.unit else {
            return Some(format!("the baseline is {baseline} m; give --baseline in metres, such as 0.12"));
        };
        let other = [Unit::Mm, Unit::Cm, Unit::M]
            .into_iter()
            .find(|other| *other != unit && (0.02..=1.0).contains(&(baseline / unit.metres() * other.metres())));
        let remedy = match other {
            Some(other) => {
                format!("--calib-unit {} makes it {} m", other.name(), baseline / unit.metres() * other.metres())
            }
            None => "check its unit, --calib-unit, and its numbers".into(),
        };
        Some(format!("the baseline is {baseline} m, read in {}: {remedy}", unit.name()))
    }
}

/// Refuses rectified cameras that look past the images, as those of stereoRectify for larger ones do.
fn ensure_inside(camera: &Camera, [width, height]: [u32; 2]) -> Result<()> {
    let Camera { cx, cy, doffs, .. } = camera;
    let inside = |place: f64, side: u32| (-0.5..=f64::from(side) - 0.5).contains(&place);
    ensure!(
        inside(*cx, width) && inside(cx + doffs, width) && inside(*cy, height),
        "the rectified cameras have principal points of ({cx}, {cy}) and ({}, {cy}), outside the {width}x{height} images, whose size \
         rectified ones keep; pass it to stereoRectify as newImageSize; if they are right, give --calib-scale 1",
        cx + doffs
    );
    Ok(())
}

/// Refuses a calibration of images of another size.
fn ensure_size(calibrated: [u32; 2], images: [u32; 2], scale: Scale) -> Result<()> {
    if (0..2).all(|axis| scale.fits(calibrated[axis], images[axis])) {
        return Ok(());
    }
    let ([w, h], [width, height]) = (calibrated, images);
    let factor = Scale(f64::from(width) / f64::from(w));
    let scaled = match scale {
        Scale::ONE => String::new(),
        Scale(scale) => format!(", {}x{} at --calib-scale {scale}", f64::from(w) * scale, f64::from(h) * scale),
    };
    let remedy = match in_words(factor.0) {
        // Both sides by one factor.
        of if of.parse::<Scale>().is_ok_and(|of| of.fits(w, width) && of.fits(h, height)) => {
            format!("where they are the same images at another size, give --calib-scale {of}")
        }
        _ if factor.fits(h, height) => {
            format!("where they are the same images at another size, give --calib-scale {width}/{w}")
        }
        _ => "use the calibration of these images; if they were cropped, which moves the principal points, give --focal, \
              --baseline, --doffs, --cx and --cy"
            .into(),
    };
    bail!("the images are {width}x{height}, but the calibration is of {w}x{h}{scaled}; {remedy}")
}
