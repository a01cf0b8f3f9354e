use crate::Params;
use crate::reference::{Volume, block_sums};
use rayon::prelude::*;

/// The factor that brings a block sum to the quantised cost: with the largest block sum that the settings allow (narrowed
/// as [`block_sums`] are), round(top * 2^14 / largest), where top is 1024 times the cost that the largest sum is to have
/// (`Params::cost_top`). So P1 and P2 keep their meaning when the block or the cap changes.
pub fn matching_cost_scale(params: &Params) -> u32 {
    params.cost_scale()
}

/// Stage `matching_cost`: the matching cost in 8 bits, (block sum * scale + 2^23) >> 24, from 0 to 89.
pub fn matching_cost(columns: &Volume<u32>, params: &Params) -> Volume<u8> {
    let scale = matching_cost_scale(params);
    let mut cost = Volume::new(columns.width + 1 - params.block as usize, columns.height, columns.disparities);
    let row_len = cost.row_len();
    cost.data.par_chunks_mut(row_len).enumerate().for_each(|(y, row)| {
        for (cost, sum) in row.iter_mut().zip(block_sums(columns, y, params)) {
            *cost = ((sum * scale + (1 << 23)) >> 24) as u8;
        }
    });
    cost
}
