use super::{Views, Volume, winner::winner_of_row};
use crate::Params;
use rayon::prelude::*;

/// The sum of the pixel costs over a block, for one row: `block` neighbouring columns of [`super::cost_columns`] added
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

/// Stage `block_match`: the winner of the block sums.
pub fn block_match(columns: &Volume<u32>, params: &Params) -> Views {
    let rows = (0..columns.height).into_par_iter();
    Views::from_rows(rows.map(|y| winner_of_row(&block_sums(columns, y, params), params)).collect())
}
