use crate::Params;
use crate::reference::Descriptors;
use rayon::prelude::*;
use std::ops::Range;

/// What [`crate::Cost::Ncc`] needs of the block around each pixel besides the sum of products.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockStatistics {
    /// The columns that there are blocks around: the image is continued by its border.
    pub columns: Range<i64>,
    /// Row by row, for each block of n pixels with the values v: the sum s of v, and
    /// floor(sqrt(n * (sum of v^2) - s^2)). At most 361 * 255 and 46,027.
    pub data: Vec<[u32; 2]>,
}

impl BlockStatistics {
    /// Those of the block around (x, y).
    pub fn at(&self, x: i64, y: usize) -> [u32; 2] {
        let width = (self.columns.end - self.columns.start) as usize;
        self.data[y * width + (x - self.columns.start) as usize]
    }
}

/// Stage `block_statistics`: of the left blocks, and of all right ones that they are compared with.
pub fn block_statistics(left: &Descriptors, right: &Descriptors, params: &Params) -> [BlockStatistics; 2] {
    let (width, smallest) = (left.width as i64, i64::from(params.min_disparity));
    let largest = smallest + i64::from(params.disparities) - 1;
    [of_blocks(left, 0..width, params), of_blocks(right, -largest..width - smallest, params)]
}

fn of_blocks(descriptors: &Descriptors, columns: Range<i64>, params: &Params) -> BlockStatistics {
    let (radius, n) = (i64::from(params.radius()), u64::from(params.block * params.block));
    let around = |i: i64| i - radius..=i + radius;
    let block = |x: i64, y: i64| {
        let values = around(y).flat_map(|y| around(x).map(move |x| u64::from(descriptors.clamped(x, y)[0])));
        let (sum, squares) = values.fold((0, 0), |(sum, squares), v| (sum + v, squares + v * v));
        [sum as u32, (n * squares - sum * sum).isqrt() as u32]
    };
    let row = |y: i64| columns.clone().map(|x| block(x, y)).collect::<Vec<_>>();
    let data = (0..descriptors.height as i64).into_par_iter().flat_map_iter(row).collect();
    BlockStatistics { columns, data }
}
