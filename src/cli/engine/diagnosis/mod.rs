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
use gpu_stereo::{Image, Params};

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

/// What is wrong with a pair if it is matched with `params`.
pub fn finding(left: &Image, right: &Image, params: &Params) -> Result<Option<Finding>> {
    Ok(evidence(left, right, params)?.finding(&params.searched()))
}
