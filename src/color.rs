//! The colours of a disparity map: the same on the host, in the command's pictures and in textures.

use std::ops::RangeInclusive;

use crate::DisparityMap;

/// The part of turbo that is used: towards its ends it becomes nearly black, which stands for no disparity.
const FIRST: f64 = 0.08;
const LAST: f64 = 0.97;

/// Red, green and blue of a share of a range in the colour map turbo, without its dark ends: 0 is blue, 1 is red; shares below
/// and above are clamped. No colour is near black.
pub fn turbo(share: f64) -> [u8; 3] {
    let color = colorous::TURBO.eval_continuous(FIRST + share.clamp(0.0, 1.0) * (LAST - FIRST));
    [color.r, color.g, color.b]
}

/// The colour of a disparity in 1/16 px; black for [`DisparityMap::INVALID`].
fn color(value: i32, first: i32, last: i32) -> [u8; 4] {
    let [red, green, blue] = match value == i32::from(DisparityMap::INVALID) {
        true => [0; 3],
        false => turbo((f64::from(value) / 16.0 - f64::from(first)) / span(first, last)),
    };
    [red, green, blue, 255]
}

fn span(first: i32, last: i32) -> f64 {
    (f64::from(last) - f64::from(first)).max(1.0)
}

/// The colours of all values from the first one of a range of disparities on; values above the last have its colour.
pub(crate) fn table(range: &RangeInclusive<i32>) -> Vec<[u8; 4]> {
    let (first, last) = (*range.start(), *range.end());
    (0..=16 * span(first, last) as i32).map(|i| color(16 * first + i, first, last)).collect()
}

impl DisparityMap {
    /// A picture of the map: red, green, blue and 255 for each pixel, in the [`turbo`] colours of its place in the range
    /// (mostly [`crate::Params::searched`]), black where there is no disparity.
    ///
    /// ```
    /// # use gpu_stereo::{DisparityMap, Params, turbo};
    /// let map = DisparityMap { width: 2, height: 1, data: vec![16 * 63, DisparityMap::INVALID] };
    /// let [red, green, blue] = turbo(1.0);
    /// assert_eq!(map.color(&Params::sgm(64).searched()), [red, green, blue, 255, 0, 0, 0, 255]);
    /// ```
    pub fn color(&self, range: &RangeInclusive<i32>) -> Vec<u8> {
        self.data.iter().flat_map(|&value| color(value.into(), *range.start(), *range.end())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_colour_is_near_that_of_no_disparity() {
        for share in 0..=1000 {
            let [red, green, blue] = turbo(f64::from(share) / 1000.0).map(f64::from);
            let luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
            assert!(red.max(green).max(blue) > 120.0 && luma > 40.0, "{share}: {red} {green} {blue}, {luma}");
        }
        assert_eq!(turbo(-1.0), turbo(0.0));
        assert_eq!(turbo(f64::INFINITY), turbo(1.0));
    }
}
