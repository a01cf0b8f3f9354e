use crate::reference::{Volume, margin};
use crate::{ConfidenceMap, DisparityMap, Params, Subpixel};
use rayon::prelude::*;

/// The disparity maps of both views, before any check of one against the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Views {
    /// Of the left image.
    pub left: DisparityMap,
    /// Of the right image: `right(x)` shows what `left(x + disparity)` shows; whole pixels (multiples of 16).
    pub right: DisparityMap,
    /// By how much each winner of the left map is ahead of its best rival ([`margin`]), whether it is valid or not.
    pub margins: ConfidenceMap,
    /// The index of each winner of the left map, whether it is valid or not.
    pub labels: Vec<u16>,
}

/// One row of [`Views`].
pub(crate) type RowOfViews = (Vec<i16>, Vec<i16>, Vec<u8>, Vec<u16>);

impl Views {
    pub(crate) fn from_rows(rows: Vec<RowOfViews>) -> Self {
        let (width, height) = (rows.first().map_or(0, |row| row.0.len()) as u32, rows.len() as u32);
        let (left, right, margins, labels): (Vec<_>, Vec<_>, Vec<_>, Vec<_>) = rows.into_iter().collect();
        let map = |rows: Vec<Vec<i16>>| DisparityMap { width, height, data: rows.concat() };
        let margins = ConfidenceMap { width, height, data: margins.concat() };
        Self { left: map(left), right: map(right), margins, labels: labels.concat() }
    }
}

/// Whether `disparity` (1/16 px) at column x of the left image points into the right image: with
/// q = floor((disparity + 8) / 16), the nearest whole disparity, whether 0 <= x - q < width.
pub fn points_inside(x: i64, disparity: i16, width: usize) -> bool {
    (0..width as i64).contains(&(x - ((i64::from(disparity) + 8) >> 4)))
}

/// Stage `winner`: for each pixel the disparity of the smallest cost, and the same seen from the right image.
pub fn winner(cost: &Volume<u16>, params: &Params) -> Views {
    let rows = cost.data.par_chunks(cost.row_len());
    Views::from_rows(
        rows.map(|row| winner_of_row(&row.iter().map(|&c| u32::from(c)).collect::<Vec<_>>(), params)).collect(),
    )
}

/// One row of both views from its costs, `[x][d]`.
pub(crate) fn winner_of_row(costs: &[u32], params: &Params) -> RowOfViews {
    let n = params.disparities as usize;
    let width = costs.len() / n;
    let cost = |x: usize, d: usize| costs[x * n + d];
    let disparity = |d: usize| params.min_disparity + d as i32;
    let stereo_bm = params.chooses_as_stereo_bm();

    let left = (0..width).map(|x| {
        // Ties go to the smallest disparity, by the rules of StereoBM to the largest.
        let best = (0..n).min_by_key(|&d| (cost(x, d), if stereo_bm { n - d } else { d })).unwrap_or(0);
        // Uniqueness: every disparity but the winner and its neighbours must cost more by the given share.
        let ratio = params.uniqueness;
        let rival = (0..n).filter(|d| d.abs_diff(best) > 1).map(|d| cost(x, d)).min();
        let unique = ratio == 0
            || rival.is_none_or(|rival| match stereo_bm {
                true => rival > cost(x, best) + cost(x, best) * ratio / 100,
                // By the rules of StereoSGBM equality is enough.
                false => rival * (100 - ratio) + u32::from(params.opencv_rules) > cost(x, best) * 100,
            });
        let mut value = 16 * disparity(best);
        if params.subpixel != Subpixel::Off && best > 0 && best + 1 < n {
            // The vertex of the parabola through three costs, or the point where two lines of equal and opposite slope
            // through them meet, to the nearest 1/16 px, halves downwards: ceil(8 (before - after) / k - 1/2), where
            // k > 0 since ties go to the smallest disparity.
            let (before, here, after) = (cost(x, best - 1), cost(x, best), cost(x, best + 1));
            let difference = before as i32 - after as i32;
            if stereo_bm {
                // 128 (before - after) / k in 1/256 px, towards zero, then to 1/16 px, upwards.
                let k = (before.max(after) - here).max(1) as i32;
                value += (128 * difference / k + 15) >> 4;
            } else if params.opencv_rules {
                // The parabola of StereoSGBM, towards zero.
                let k = (before + after - 2 * here).max(1) as i32;
                value += (16 * difference + k) / (2 * k);
            } else {
                let k = match params.subpixel {
                    Subpixel::Equiangular => before.max(after) - here,
                    Subpixel::Off | Subpixel::Parabola => before + after - 2 * here,
                } as i32;
                value += (16 * difference + k - 1).div_euclid(2 * k);
            }
        }
        let valid = unique && points_inside(x as i64, value as i16, width);
        ((if valid { value as i16 } else { DisparityMap::INVALID }, margin(cost(x, best), rival)), best as u16)
    });
    let ((left, margins), labels) = left.unzip();

    // Right pixel x sees left pixel x + disparity: the costs along a diagonal of the same row.
    let right = (0..width).map(|x| {
        let seen_from = |d: usize| x as i64 + i64::from(disparity(d));
        let candidates = (0..n).filter(|&d| (0..width as i64).contains(&seen_from(d)));
        let best = candidates.min_by_key(|&d| (cost(seen_from(d) as usize, d), d));
        best.map_or(DisparityMap::INVALID, |d| 16 * disparity(d) as i16)
    });
    (left, right.collect(), margins, labels)
}
