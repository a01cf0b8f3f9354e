use crate::Params;
use crate::reference::Volume;
use rayon::prelude::*;

/// The largest data term of a level after the first one. What is larger changes no message: see docs/ALGORITHMS.md, "Ranges".
pub const LARGEST_TERM: u32 = 2047;

/// Stage `coarse_cost`: the data terms of the levels after the first one, from the finest to the coarsest. A level of a single pixel
/// is the last one.
pub fn coarse_cost(cost: &Volume<u8>, params: &Params) -> Vec<Volume<u16>> {
    let mut levels: Vec<Volume<u16>> = Vec::new();
    for _ in 1..params.levels(cost.width as u32, cost.height as u32) {
        let coarser = levels.last().map_or_else(|| summed(cost), summed);
        levels.push(coarser);
    }
    levels
}

/// Data terms of half the size: the sums over 2 x 2 pixels, those beyond the image left out, less the smallest of a pixel.
fn summed<T: Copy + Into<u32> + Sync>(finer: &Volume<T>) -> Volume<u16> {
    let n = finer.disparities;
    let mut coarser = Volume::new(finer.width.div_ceil(2), finer.height.div_ceil(2), n);
    let row_len = coarser.row_len();
    coarser.data.par_chunks_mut(row_len).enumerate().for_each(|(y, row)| {
        for (x, terms) in row.chunks_exact_mut(n).enumerate() {
            let mut sums = vec![0; n];
            for (u, v) in [(2 * x, 2 * y), (2 * x + 1, 2 * y), (2 * x, 2 * y + 1), (2 * x + 1, 2 * y + 1)] {
                if u < finer.width && v < finer.height {
                    let parts = &finer.data[(v * finer.width + u) * n..][..n];
                    sums.iter_mut().zip(parts).for_each(|(sum, &part)| *sum += part.into());
                }
            }
            let least = sums.iter().copied().min().unwrap_or(0);
            terms.iter_mut().zip(sums).for_each(|(term, sum)| *term = (sum - least).min(LARGEST_TERM) as u16);
        }
    });
    coarser
}
