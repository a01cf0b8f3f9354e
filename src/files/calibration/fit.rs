//! Fits a calibration to the images: their size and scale, and warnings about doubtful numbers.

use super::algebra::Matrix;
use super::apart::Apart;
use super::cameras::{Calibration, Cameras, OfSize};
use super::reading::Unit;
use super::rectified::{RectifiedPair, of_projections};
use super::rectifying::{Rectified, Wanted, stereo_rectify};
use super::scale::{Scale, in_words};
use crate::files::error::{Result, bail, ensure};
use crate::{Camera, Lens};

/// The cameras of images of one size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fitted {
    /// The rectified cameras. Where they lie one above the other, `doffs` is the row of the right principal point less that of
    /// the left one.
    pub camera: Camera,
    /// The lenses of a pair that is to be rectified.
    pub lenses: Option<[Lens; 2]>,
    /// Columns and rows of the rectified images.
    pub size: [u32; 2],
    /// Whether the cameras lie one above the other, the upper one in the place of the left one.
    pub vertical: bool,
}

impl Calibration {
    /// The cameras of images of this size.
    ///
    /// # Errors
    /// If the calibration is of images of another size, or of none that can be rectified.
    pub fn fit(&self, width: u32, height: u32) -> Result<Fitted> {
        let (scale, given) = (self.scale(), [width, height]);
        match self.size {
            Some(size) => ensure_size(size, given, scale)?,
            None if matches!(self.cameras, Cameras::Sizes(_)) => {}
            None => self.ensure_middle(&self.principal_points(), given)?,
        }
        let upright = |pair: &RectifiedPair, lenses: Option<[Lens; 2]>| -> Result<Fitted> {
            let camera = scale.of_camera(pair.camera);
            Ok(Fitted { camera, lenses, size: given, vertical: self.vertical(pair.vertical)? })
        };
        let fitted = match &self.cameras {
            Cameras::Rectified(pair) => upright(pair, None)?,
            Cameras::Lenses(pair, lenses) => upright(pair, Some(lenses.each_ref().map(|lens| scale.of_lens(lens))))?,
            Cameras::Apart(apart) => self.rectify(apart, given)?,
            Cameras::Sizes(sizes) => self.rectify(&self.of_size(sizes, given)?.apart, given)?,
        };
        fitted.camera.validate()?;
        if matches!(self.cameras, Cameras::Lenses(..)) && self.reading.scale.is_none() {
            ensure_inside(&fitted.camera, given)?;
        }
        Ok(fitted)
    }

    pub(super) fn scale(&self) -> Scale {
        self.reading.scale.unwrap_or(Scale::ONE)
    }

    /// Whether the cameras lie one above the other, by the file or by what was asked for.
    fn vertical(&self, told: Option<bool>) -> Result<bool> {
        ensure!(
            told != Some(false) || !self.reading.vertical,
            "its cameras lie side by side, but --vertical is given; drop it, or give the calibration of these images"
        );
        Ok(told.unwrap_or(self.reading.vertical))
    }

    /// The rectified cameras of those that lie apart.
    fn rectify(&self, apart: &Apart, given: [u32; 2]) -> Result<Fitted> {
        let scale = self.scale();
        let cameras = apart.cameras.map(|(matrix, distortion)| (scale.of_matrix(matrix), distortion));
        let wanted = Wanted { alpha: self.reading.alpha, size: self.reading.rectified_size };
        let Rectified { lenses, projections: [left, right], size } =
            stereo_rectify(cameras, given, &apart.rotation, &apart.translation, &wanted)?;
        let RectifiedPair { camera, vertical } = of_projections(&left, &right, 1.0)?;
        Ok(Fitted { camera, lenses: Some(lenses), size, vertical: self.vertical(vertical)? })
    }

    /// The cameras of images of this size: by the size that the name of each tells, else the only ones whose principal points
    /// lie in the middle.
    pub(super) fn of_size<'a>(&self, sizes: &'a [OfSize], given: [u32; 2]) -> Result<&'a OfSize> {
        let scale = self.scale();
        let fits = |of: &&OfSize| of.size.is_some_and(|size| ensure_size(size, given, scale).is_ok());
        if let Some(found) = sizes.iter().find(fits) {
            return Ok(found);
        }
        let middle = |of: &&OfSize| self.ensure_middle(&of.apart.principal_points(), given).is_ok();
        let mut suited = sizes.iter().filter(middle);
        match (suited.next(), suited.next()) {
            (Some(found), None) => Ok(found),
            _ => {
                let name = |of: &OfSize| match of.size {
                    Some([width, height]) => format!("{} ({width}x{height})", of.name),
                    None => of.name.clone(),
                };
                let names = sizes.iter().map(name).collect::<Vec<_>>().join(", ");
                bail!(
                    "the images are {}x{}, but the calibration is of the resolutions {names}; where they are the same images at \
                     another size, give --calib-scale, the ratio of their size to one of these",
                    given[0],
                    given[1]
                )
            }
        }
    }

    /// The principal points of the given cameras, in the calibrated images.
    fn principal_points(&self) -> [[f64; 2]; 2] {
        let of = |m: &Matrix| [m[2], m[5]];
        match &self.cameras {
            Cameras::Rectified(RectifiedPair { camera, vertical }) => {
                let Camera { doffs, cx, cy, .. } = *camera;
                let right = if *vertical == Some(true) { [cx, cy + doffs] } else { [cx + doffs, cy] };
                [[cx, cy], right]
            }
            Cameras::Lenses(_, lenses) => lenses.each_ref().map(|lens| of(&lens.matrix)),
            Cameras::Apart(apart) => apart.principal_points(),
            Cameras::Sizes(sizes) => sizes[0].apart.principal_points(),
        }
    }

    /// Refuses a calibration that gives no image size and does not suit these images: a principal point lies far from the
    /// middle, or all of them are off it by one factor, as those of images at another size.
    fn ensure_middle(&self, points: &[[f64; 2]; 2], images: [u32; 2]) -> Result<()> {
        let scale = self.scale();
        let points = points.map(|point| point.map(|place| scale.of_place(place)));
        // 1 is the middle, 0 and 2 are the borders.
        let shares = points.map(|point| [0, 1].map(|axis| 2.0 * (point[axis] + 0.5) / f64::from(images[axis])));
        let all = shares.as_flattened();
        let [width, height] = images;
        let [x, y] = points[0];
        if self.reading.scale.is_some() {
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
