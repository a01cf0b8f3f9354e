use crate::reference::Plane;
use crate::{DisparityMap, Params};
use rayon::prelude::*;

/// The weight of a pixel whose gray differs by `difference`: it halves with each `sigma`, linearly in between.
pub fn median_weight(difference: u32, sigma: u32) -> u32 {
    let halvings = (difference * median_decay(sigma)) >> 8;
    ((512 - (halvings & 255)) << 6).checked_shr(halvings >> 8).unwrap_or(0)
}

/// 1 / 65,536 of a halving for each level of difference: floor((65536 + floor(sigma / 2)) / sigma).
pub(crate) fn median_decay(sigma: u32) -> u32 {
    (65_536 + sigma / 2) / sigma
}

/// The spacing of the sampled pixels in rows and columns: half the radius, rounded up.
pub(crate) fn median_spacing(radius: u32) -> u32 {
    radius.div_ceil(2)
}

/// Stage `weighted_median`: each valid pixel takes the weighted median of the valid ones among 5x5 pixels around it, which
/// lie `median_spacing` rows and columns apart: the smallest value for which it and all smaller ones have at least half of
/// the weight.
///
/// A weight falls with the difference of the left image from the middle: Ma et al., "Constant Time Weighted Median
/// Filtering for Stereo Matching and Beyond", ICCV 2013, with other weights and a sparse window.
pub fn weighted_median(map: &DisparityMap, gray: &Plane<u8>, radius: u32, params: &Params) -> DisparityMap {
    let (width, height) = (gray.width as i64, gray.height as i64);
    let spacing = i64::from(median_spacing(radius));
    let inside = |(x, y): &(i64, i64)| (0..width).contains(x) && (0..height).contains(y);
    let middle = |x: i64, y: i64| {
        let at = |x, y| map.data[(y * width + x) as usize];
        if at(x, y) == DisparityMap::INVALID {
            return DisparityMap::INVALID;
        }
        let around = (-2..=2).flat_map(|j| (-2..=2).map(move |i| (x + i * spacing, y + j * spacing)));
        let weighted = |(u, v)| {
            let difference = gray.clamped(u, v).abs_diff(gray.clamped(x, y));
            (at(u, v), median_weight(difference, params.weighted_median_sigma))
        };
        weighted_middle(
            around.filter(inside).map(weighted).filter(|&(value, _)| value != DisparityMap::INVALID).collect(),
        )
    };
    let rows = (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| (x, y)));
    DisparityMap { data: rows.map(|(x, y)| middle(x, y)).collect(), ..*map }
}

/// The smallest value for which it and all smaller ones have at least half of the weight; of none, invalid.
pub(crate) fn weighted_middle(mut values: Vec<(i16, u32)>) -> i16 {
    values.sort_unstable();
    let total: u32 = values.iter().map(|&(_, weight)| weight).sum();
    let mut reached = 0;
    let enough = |&&(_, weight): &&(i16, u32)| {
        reached += weight;
        2 * reached >= total
    };
    values.iter().find(enough).map_or(DisparityMap::INVALID, |&(value, _)| value)
}
