use crate::reference::{Descriptors, Volume};
use crate::{Cost, Params};
use rayon::prelude::*;

/// Stage `cost_columns`: sums of the pixel costs over a column as high as the block.
///
/// With r = block / 2, entry (c, y, d) stands for the image column x = c - r, so that c runs over width + 2 r columns:
/// the sum over |j| <= r of [`pixel_cost`] between left(x, y + j) and right(x - (min_disparity + d), y + j), both images
/// continued by their borders. At most 51 * 65025.
pub fn cost_columns(left: &Descriptors, right: &Descriptors, table: &[u8], params: &Params) -> Volume<u32> {
    let radius = i64::from(params.radius());
    let disparities = params.disparities as usize;
    let mut columns = Volume::new(left.width + 2 * radius as usize, left.height, disparities);
    let row_len = columns.row_len();
    columns.data.par_chunks_mut(row_len).enumerate().for_each(|(y, row)| {
        for j in -radius..=radius {
            let y = y as i64 + j;
            for (c, sums) in row.chunks_exact_mut(disparities).enumerate() {
                let x = c as i64 - radius;
                let here = left.clamped(x, y);
                for (d, sum) in sums.iter_mut().enumerate() {
                    let disparity = i64::from(params.min_disparity) + d as i64;
                    *sum += pixel_cost(here, right.clamped(x - disparity, y), table, params);
                }
            }
        }
    });
    columns
}

/// How much two vectors of features differ: 0 where they point the same way, 225 from a right angle on.
fn angle(left: &[u8], right: &[u8]) -> u32 {
    let of = |byte: &u8| i32::from(*byte) - 128;
    let dot: i32 = left.iter().zip(right).map(|(l, r)| of(l) * of(r)).sum();
    ((28900 - dot) >> 7).clamp(0, 225) as u32
}

/// How much two pixels differ, from their [`Descriptors`]: the small function in which the costs differ.
///
/// - `sad`, `zsad`: |l - r|; with three colours floor((floor((red + blue) / 2) + green) / 2) of their differences;
/// - `ssd`: (l - r)^2; `ncc`: l r;
/// - `bt`: of the values l, r and the intervals around them, the smaller of the distance of l from the right interval and
///   of r from the left one (Birchfield and Tomasi 1998, equations 1 to 3); with three colours as `sad`; `bt-gray`: the same of
///   the prefiltered image, and floor of a quarter of that of the gray one, together at most 255;
/// - `sad-xy`: the sum of the absolute differences;
/// - `census`: the number of bits that differ;
/// - `census-sobel`: twice that, and the absolute differences of both derivatives;
/// - `ad-census`: min(255, (ad_weight |l - r| + census_weight bits + 8) >> 4);
/// - `learned`: of the sum of the products of (byte - 128) of all features, dot, clamp((28900 - dot) >> 7, 0, 225);
/// - `learned-census`: min(255, (learned_weight e + census_weight e' + 32) >> 6), e as `learned`, e' as `census-sobel`;
/// - `mi`: what [`crate::reference::mi_table`] says of the values.
pub fn pixel_cost(left: &[u8], right: &[u8], table: &[u8], params: &Params) -> u32 {
    let difference = |p: usize| u32::from(left[p].abs_diff(right[p]));
    let bits = |planes: usize| -> u32 { (0..planes).map(|p| (left[p] ^ right[p]).count_ones()).sum() };
    let interval = |p: usize| {
        let outside = |v: u8, low: u8, high: u8| low.saturating_sub(v).max(v.saturating_sub(high));
        u32::from(outside(left[p], right[p + 1], right[p + 2]).min(outside(right[p], left[p + 1], left[p + 2])))
    };
    let colours = |one: &dyn Fn(usize) -> u32, planes: usize| match params.color_cost {
        true => ((one(0) + one(2 * planes)) / 2 + one(planes)) / 2,
        false => one(0),
    };
    let census_planes = params.census_planes() as usize;
    let census_sobel = || 2 * bits(census_planes) + difference(census_planes) + difference(census_planes + 1);
    match params.cost {
        Cost::Sad => colours(&difference, 1),
        Cost::ZeroMeanSad => difference(0),
        Cost::Ssd => difference(0) * difference(0),
        Cost::BirchfieldTomasi => colours(&interval, 3),
        Cost::BirchfieldTomasiGray => (interval(0) + interval(3) / 4).min(255),
        Cost::SadXy => difference(0) + difference(1),
        Cost::Census => bits(census_planes),
        Cost::CensusSobel => census_sobel(),
        Cost::AdCensus => {
            let weighted = params.ad_weight * difference(census_planes) + params.census_weight * bits(census_planes);
            ((weighted + 8) >> 4).min(255)
        }
        Cost::Learned => angle(left, right),
        Cost::LearnedCensus => {
            let of_features = angle(&left[census_planes + 2..], &right[census_planes + 2..]);
            ((params.learned_weight * of_features + params.census_weight * census_sobel() + 32) >> 6).min(255)
        }
        Cost::Ncc => u32::from(left[0]) * u32::from(right[0]),
        Cost::MutualInformation => table[usize::from(left[0]) * 256 + usize::from(right[0])].into(),
    }
}
