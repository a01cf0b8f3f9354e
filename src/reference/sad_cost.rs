use super::{Volume, block_sums};
use crate::Params;
use rayon::prelude::*;

/// The factor that brings a block sum to the quantised cost: round(59 * 1550 * 2^14 / largest block sum).
///
/// 59 / 1024 for the classic block of 5x5 pixels with a cap of 31, whose largest sum is 1550; for any other block and
/// cap such that the largest sum gives the same cost. So P1 and P2 keep their meaning when the block changes.
pub fn sad_cost_scale(params: &Params) -> u32 {
    let largest = params.block * params.block * params.prefiltered_max();
    (59 * 1550 * (1 << 14) + largest / 2) / largest
}

/// Stage `sad_cost`: the matching cost in 8 bits, (block sum * scale + 2^23) >> 24, from 0 to 89.
pub fn sad_cost(columns: &Volume<u16>, params: &Params) -> Volume<u8> {
    let block = params.block as usize;
    let scale = sad_cost_scale(params);
    let mut cost = Volume::new(columns.width + 1 - block, columns.height, columns.disparities);
    let row_len = cost.row_len();
    cost.data.par_chunks_mut(row_len).enumerate().for_each(|(y, row)| {
        for (cost, sum) in row.iter_mut().zip(block_sums(columns, y, block)) {
            *cost = ((sum * scale + (1 << 23)) >> 24) as u8;
        }
    });
    cost
}
