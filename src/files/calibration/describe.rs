//! What a calibration says, for people.

use super::algebra::{angle, length};
use super::apart::Apart;
use super::cameras::{Calibration, Cameras};
use super::reading::Unit;
use crate::{Camera, Distortion, Lens};

/// A camera as it was calibrated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DescribedCamera {
    /// Focal lengths along rows and columns, in pixels.
    pub focal: [f64; 2],
    /// Column and row of the principal point, in pixels.
    pub principal_point: [f64; 2],
    /// The model of its lens; `None` without one.
    pub model: Option<&'static str>,
    /// The numbers of the lens.
    pub lens: Vec<f64>,
}

/// What a calibration says.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Description {
    /// The kind of the file.
    pub kind: &'static str,
    /// Columns and rows of the images, if they are known.
    pub size: Option<[u32; 2]>,
    /// The name of the resolution, of files that have several.
    pub resolution: Option<String>,
    /// The unit that lengths were read in: m, cm or mm.
    pub unit: Option<&'static str>,
    /// The rectified cameras that the file has, in the images that were calibrated.
    pub rectified: Option<Camera>,
    /// The left camera and the right one as they were calibrated; none of a pair that is rectified.
    pub cameras: Vec<DescribedCamera>,
    /// The right camera sees R x + `translation` where the left one sees x, in metres; `None` where the file tells R1 and R2.
    pub translation: Option<[f64; 3]>,
    /// The angle of R, between both cameras, in degrees.
    pub rotation: Option<f64>,
}

impl Calibration {
    /// What it says, of images of a `size` where it has several.
    ///
    /// # Errors
    /// If it has several sizes, and none is of these images.
    pub fn describe(&self, size: Option<[u32; 2]>) -> crate::files::Result<Description> {
        let mut described = Description {
            kind: self.kind,
            size: self.size,
            resolution: None,
            unit: self.unit.map(Unit::name),
            rectified: None,
            cameras: Vec::new(),
            translation: None,
            rotation: None,
        };
        if let Cameras::Rectified(pair) | Cameras::Lenses(pair, _) = &self.cameras {
            described.rectified = Some(pair.camera);
        }
        match &self.cameras {
            Cameras::Rectified(_) => {}
            Cameras::Lenses(_, lenses) => {
                described.cameras =
                    lenses.iter().map(|Lens { matrix, distortion, .. }| camera(matrix, distortion)).collect();
            }
            Cameras::Apart(apart) => described.fill(apart),
            Cameras::Sizes(sizes) => {
                let of = match size {
                    Some(size) => self.of_size(sizes, size)?,
                    None => &sizes[0],
                };
                (described.size, described.resolution) = (of.size, Some(of.name.clone()));
                described.fill(&of.apart);
            }
        }
        Ok(described)
    }

    /// The size of the images that it is for, if the file and what was asked for tell it.
    pub fn image_size(&self) -> Option<[u32; 2]> {
        let size = match &self.cameras {
            Cameras::Sizes(sizes) => sizes[0].size,
            _ => self.size,
        };
        size.map(|size| self.scale().of_size(size))
    }
}

impl Description {
    fn fill(&mut self, apart: &Apart) {
        self.cameras = apart.cameras.iter().map(|(matrix, distortion)| camera(matrix, distortion)).collect();
        self.translation = Some(apart.translation);
        self.rotation = Some(angle(&apart.rotation).to_degrees());
    }

    /// The distance between the cameras in metres, if the file tells it beside rectified cameras.
    pub fn distance(&self) -> Option<f64> {
        self.translation.map(|translation| length(&translation))
    }
}

fn camera(m: &[f64; 9], distortion: &Distortion) -> DescribedCamera {
    let model = match distortion {
        _ if *distortion == Distortion::NONE => None,
        Distortion::Pinhole(_) => Some("pinhole"),
        Distortion::Fisheye(_) => Some("fisheye (equidistant)"),
        Distortion::DoubleSphere(_) => Some("double sphere"),
        Distortion::ExtendedUnified(_) => Some("extended unified"),
    };
    let numbers = distortion.numbers();
    // The zeros at the end of a pinhole's numbers are those that there are not.
    let count = match distortion {
        Distortion::Pinhole(_) => numbers.iter().rposition(|&number| number != 0.0).map_or(0, |last| last + 1),
        _ => numbers.len(),
    };
    DescribedCamera { focal: [m[0], m[4]], principal_point: [m[2], m[5]], model, lens: numbers[..count].to_vec() }
}

/// The angle between a camera and its rectified one, in degrees.
#[must_use]
pub fn turn_of(lens: &Lens) -> f64 {
    angle(&lens.rotation).to_degrees()
}
