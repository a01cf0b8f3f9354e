use crate::Params;
use crate::reference::{BlockStatistics, Views, Volume, winner::winner::winner_of_row};
use rayon::prelude::*;

/// The sum of the pixel costs over a block, for one row: `block` neighbouring columns of [`crate::reference::cost_columns`] added
/// up, `[x][d]`, and narrowed to less than 2^20 by a shift (`Params::narrowing`).
pub fn block_sums(columns: &Volume<u32>, y: usize, params: &Params) -> Vec<u32> {
    let (disparities, block) = (columns.disparities, params.block as usize);
    let row = &columns.data[y * columns.row_len()..][..columns.row_len()];
    let width = columns.width + 1 - block;
    let mut sums = vec![0; width * disparities];
    for (x, sums) in sums.chunks_exact_mut(disparities).enumerate() {
        for column in row[x * disparities..].chunks_exact(disparities).take(block) {
            for (sum, &value) in sums.iter_mut().zip(column) {
                *sum += value;
            }
        }
        sums.iter_mut().for_each(|sum| *sum >>= params.narrowing());
    }
    sums
}

/// Stage `block_match`: the winner of the block sums, or with [`crate::Cost::Ncc`], which has `statistics`, of
/// `correlation_cost`.
pub fn block_match(columns: &Volume<u32>, statistics: Option<&[BlockStatistics; 2]>, params: &Params) -> Views {
    let disparities = params.disparities as usize;
    let row = |y: usize| {
        let mut costs = block_sums(columns, y, params);
        if let Some([left, right]) = statistics {
            for (i, cost) in costs.iter_mut().enumerate() {
                let (x, disparity) = ((i / disparities) as i64, params.min_disparity as i64 + (i % disparities) as i64);
                *cost = correlation_cost(*cost, left.at(x, y), right.at(x - disparity, y), params);
            }
        }
        winner_of_row(&costs, params)
    };
    Views::from_rows((0..columns.height).into_par_iter().map(row).collect())
}

/// The cost of a block by its normalised cross correlation, in 4096ths: 0 of equal blocks, 4096 of unrelated ones, 8192
/// of a block and its negative.
///
/// Of n pixels a block, with the sum of products p, and the sums s and roots a of [`crate::reference::block_statistics`]:
/// c = n p - s_left s_right, n^2 times the covariance; part = min(4096, floor(4096 |c| / (a_left a_right))), 0 if
/// a_left a_right = 0; the cost is 4096 - part if c >= 0, else 4096 + part.
pub(crate) fn correlation_cost(products: u32, left: [u32; 2], right: [u32; 2], params: &Params) -> u32 {
    let n = i64::from(params.block * params.block);
    let [[left_sum, left_root], [right_sum, right_root]] = [left, right].map(|pair| pair.map(i64::from));
    let covariance = n * i64::from(products) - left_sum * right_sum;
    let divisor = left_root * right_root;
    let part = if divisor == 0 { 0 } else { (4096 * covariance.abs() / divisor).min(4096) };
    (4096 - covariance.signum() * part) as u32
}
