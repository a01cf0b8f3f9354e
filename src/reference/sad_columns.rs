use super::{Plane, Volume};
use crate::Params;
use rayon::prelude::*;

/// Stage `sad_columns`: sums of absolute differences over a column as high as the block.
///
/// With r = block / 2, entry (c, y, d) stands for the image column x = c - r, so that c runs over width + 2 r columns:
/// the sum over |j| <= r of |left(x, y + j) - right(x - (min_disparity + d), y + j)|, both images continued by their
/// borders. At most 51 * 255.
pub fn sad_columns(left: &Plane, right: &Plane, params: &Params) -> Volume<u16> {
    let radius = i64::from(params.radius());
    let disparities = params.disparities as usize;
    let mut columns = Volume::new(left.width + 2 * radius as usize, left.height, disparities);
    let row_len = columns.row_len();
    columns.data.par_chunks_mut(row_len).enumerate().for_each(|(y, row)| {
        for j in -radius..=radius {
            let y = y as i64 + j;
            for (c, sums) in row.chunks_exact_mut(disparities).enumerate() {
                let x = c as i64 - radius;
                let value = left.clamped(x, y);
                for (d, sum) in sums.iter_mut().enumerate() {
                    let disparity = i64::from(params.min_disparity) + d as i64;
                    *sum += value.abs_diff(right.clamped(x - disparity, y)) as u16;
                }
            }
        }
    });
    columns
}
