//! Diagnosis: why a pair cannot be matched well, found by matching the corners of its images. It looks at the images, not at the
//! map, so that no filter hides the cause. Corners are matched in both directions and in any row, so that a pair whose rows do
//! not match is distinguished from two unrelated pictures.

mod corners;
mod evidence;
mod finding;
#[cfg(test)]
mod tests;

use anyhow::Result;
use corners::Gray;
pub use evidence::Evidence;
pub use finding::Finding;
use gpu_stereo::reference::{self, Channel};
use gpu_stereo::{DisparityMap, Image, Params};

/// The corners of a pair, rectified as `params` say.
pub fn evidence(left: &Image, right: &Image, params: &Params) -> Result<Evidence> {
    let gray = |image: &Image, side: usize| -> Result<Gray> {
        let plane = match &params.rectify {
            Some(rectification) => reference::gray(&reference::rectify(image, rectification, side)?, Channel::Luma),
            None => reference::gray(image, Channel::Luma),
        };
        Ok(Gray { width: plane.width, height: plane.height, data: plane.data })
    };
    Ok(Evidence::of(&gray(left, 0)?, &gray(right, 1)?))
}

/// A map has a share of its disparities at an end of the range, at least, if things lie beyond: it is 3 % to 60 % where the range of
/// Middlebury's motorcycle, teddy and tsukuba is a tenth too small, and at most 0.2 % where it is not.
const AT_END: f64 = 0.02;

/// Whether a map lies at an end of the range that was searched. Disparities of 0 are those of what is far away.
pub fn pressed(map: &DisparityMap, params: &Params) -> Option<Finding> {
    let searched = params.searched();
    let (first, last) = (16 * searched.start(), 16 * searched.end());
    let valid = || map.data.iter().filter(|&&value| value != DisparityMap::INVALID).map(|&value| i32::from(value));
    let all = valid().count().max(1) as f64;
    let share = |is_at_end: &dyn Fn(i32) -> bool| valid().filter(|&value| is_at_end(value)).count() as f64 / all;
    let ends = [(true, share(&|value| value > last - 8)), (false, share(&|value| first > 0 && value < first + 8))];
    let (is_last, share) = ends.into_iter().find(|(_, share)| *share >= AT_END)?;
    Some(Finding::Pressed { searched, share, is_last })
}

/// What is wrong with a pair if it is matched with `params`.
pub fn finding(left: &Image, right: &Image, params: &Params) -> Result<Option<Finding>> {
    Ok(evidence(left, right, params)?.finding(&params.searched()))
}
