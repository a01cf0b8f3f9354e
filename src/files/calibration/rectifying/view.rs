//! Which part of the scene the rectified cameras show: their focal length and principal point, as OpenCV chooses them.

use super::undistort::{without_lens, without_wide};
use crate::Distortion;
use crate::files::calibration::algebra::{Matrix, turned};
use crate::files::error::{Context as _, Result};

/// What is chosen of the rectified images.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// From 0, no pixel without content, to 1, all of the given images; `None`: OpenCV's alpha of -1, and a balance of 0.
    pub alpha: Option<f64>,
    /// Columns and rows of the given images.
    pub given: [u32; 2],
    /// Columns and rows of the rectified images.
    pub size: [u32; 2],
    /// 0: the cameras lie side by side; 1: one above the other.
    pub axis: usize,
}

impl View {
    /// The rectified size relative to the given one.
    fn ratio(&self) -> [f64; 2] {
        [0, 1].map(|axis| f64::from(self.size[axis]) / f64::from(self.given[axis]))
    }
}

/// What a camera has, and how it is turned.
pub type Turned<'a> = (&'a (Matrix, Distortion), &'a Matrix);

/// Of fisheyes and the like, as `cv::fisheye::stereoRectify` with the balance alpha.
pub fn of_wide(sides: [Turned<'_>; 2], view: &View) -> Result<(f64, [f64; 2])> {
    let [left, right] = [widest(sides[0], view)?, widest(sides[1], view)?];
    let center = [0, 1].map(|axis| (left.1[axis] + right.1[axis]) * 0.5);
    Ok((left.0.min(right.0), center))
}

/// The focal length and the principal point of a rectified camera.
fn widest(((m, lens), rotation): Turned<'_>, view: &View) -> Result<(f64, [f64; 2])> {
    let [width, height] = view.given;
    let (w, h) = (f64::from(width), f64::from(height));
    let (half_w, half_h) = (f64::from(width / 2), f64::from(height / 2));
    let aspect = m[0] / m[4];
    let mut middles = [[half_w, 0.0], [w, half_h], [half_w, h], [0.0, half_h]];
    for place in &mut middles {
        let [x, y] = without_wide(*place, m, rotation, lens).context(
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
    let all =
        [0, 1].map(|axis| [sides[axis] / (center[axis] - least(axis)), sides[axis] / (most(axis) - center[axis])]);
    let near = all.as_flattened().iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let far = all.as_flattened().iter().copied().fold(f64::INFINITY, f64::min);
    let alpha = view.alpha.unwrap_or(0.0);
    let focal = alpha * far + (1.0 - alpha) * near;
    let point = [sides[0] - center[0] * focal, sides[1] - center[1] * focal];
    let ratio = view.ratio();
    Ok((focal / aspect * ratio[1], [point[0] * ratio[0], point[1] / aspect * ratio[1]]))
}

/// Of pinhole cameras, as `stereoRectify`: the mean focal length, and the principal point that has the corners of both images
/// about the middle; with alpha the zoom that shows as much as it says.
pub fn of_pinholes(sides: [Turned<'_>; 2], view: &View) -> (f64, [f64; 2]) {
    let ratio = view.ratio();
    // The focal length across the line between the cameras.
    let across = 4 * (1 - view.axis);
    let focal = (sides[0].0.0[across] + sides[1].0.0[across]) * ratio[view.axis ^ 1] / 2.0;
    let far = view.given.map(|side| f64::from(side - 1));
    let mut center = [0.0; 2];
    for side in sides {
        for corner in [[0.0, 0.0], [far[0], 0.0], [0.0, far[1]], far] {
            let [x, y] = seen(side, corner);
            // The mean of four corners of two cameras lies in the middle.
            center = [center[0] + (far[0] / 2.0 - focal * x) / 8.0, center[1] + (far[1] / 2.0 - focal * y) / 8.0];
        }
    }
    let moved = [center[0] * ratio[0], center[1] * ratio[1]];
    let Some(alpha) = view.alpha else { return (focal, moved) };
    let ends = view.size.map(|side| f64::from(side - 1));
    let (mut inner, mut outer) = (f64::NEG_INFINITY, f64::INFINITY);
    for side in sides {
        let [inside, outside] = rectangles(side, view.given, focal, center);
        let zooms = |[least, most]: &[[f64; 2]; 2]| -> [f64; 4] {
            let of = |axis: usize| {
                [moved[axis] / (center[axis] - least[axis]), (ends[axis] - moved[axis]) / (most[axis] - center[axis])]
            };
            let ([a, b], [c, d]) = (of(0), of(1));
            [a, b, c, d]
        };
        inner = zooms(&inside).into_iter().fold(inner, f64::max);
        outer = zooms(&outside).into_iter().fold(outer, f64::min);
    }
    (focal * (inner * (1.0 - alpha) + outer * alpha), moved)
}

/// Where a pixel lies for the rectified camera, at a distance of 1.
fn seen(((matrix, distortion), rotation): Turned<'_>, place: [f64; 2]) -> [f64; 2] {
    let Distortion::Pinhole(numbers) = distortion else { return [f64::NAN; 2] };
    let [x, y] = without_lens(place, matrix, numbers);
    let [x, y, z] = turned(rotation, &[x, y, 1.0]);
    [x / z, y / z]
}

/// The largest rectangle inside the given image as the rectified camera sees it, and the smallest around it, by the borders of a
/// grid of 9 x 9: the upper left corner and the lower right one of each.
fn rectangles(side: Turned<'_>, given: [u32; 2], focal: f64, center: [f64; 2]) -> [[[f64; 2]; 2]; 2] {
    const GRID: u32 = 9;
    let (none, all) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let [mut inside, mut outside] = [[all, none], [none, all]];
    for at in (0..GRID * GRID).map(|i| [i % GRID, i / GRID]) {
        let place = [0, 1].map(|axis| f64::from(at[axis]) * f64::from(given[axis] - 1) / f64::from(GRID - 1));
        let ray = seen(side, place);
        for axis in [0, 1] {
            let x = focal * ray[axis] + center[axis];
            outside[0][axis] = outside[0][axis].min(x);
            outside[1][axis] = outside[1][axis].max(x);
            if at[axis] == 0 {
                inside[0][axis] = inside[0][axis].max(x);
            } else if at[axis] == GRID - 1 {
                inside[1][axis] = inside[1][axis].min(x);
            }
        }
    }
    [inside, outside]
}
