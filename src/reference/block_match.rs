use super::{Views, Volume, winner::winner_of_row};
use crate::Params;
use rayon::prelude::*;

/// The sum of absolute differences over a block, for one row: `block` neighbouring columns of [`super::sad_columns`]
/// added up, `[x][d]`. At most 51 * 51 * 255.
pub fn block_sums(columns: &Volume<u16>, y: usize, block: usize) -> Vec<u32> {
    let disparities = columns.disparities;
    let row = &columns.data[y * columns.row_len()..][..columns.row_len()];
    let width = columns.width + 1 - block;
    let mut sums = vec![0; width * disparities];
    for (x, sums) in sums.chunks_exact_mut(disparities).enumerate() {
        for column in row[x * disparities..].chunks_exact(disparities).take(block) {
            for (sum, &value) in sums.iter_mut().zip(column) {
                *sum += u32::from(value);
            }
        }
    }
    sums
}

/// Stage `block_match`: the winner of the block sums.
pub fn block_match(columns: &Volume<u16>, params: &Params) -> Views {
    let block = params.block as usize;
    let rows = (0..columns.height).into_par_iter();
    Views::from_rows(rows.map(|y| winner_of_row(&block_sums(columns, y, block), params)).collect())
}
