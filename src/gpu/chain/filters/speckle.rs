//! The filter of small regions.

use crate::gpu::chain::filters::map_step::by_rows;
use crate::gpu::layout::{Dispatch, Frame, Rows, cut};
use crate::gpu::plan::MOST_PARTS;
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::gpu::rounds::SEGMENT_GROUPS;
use crate::params::Filter;

/// Stage `speckle` on the map of the last step: the runs of each row, joined across borders of bands of 1, 2, 4 .. rows to
/// trees, a tree a region, which are counted at their roots.
pub(super) fn speckle(b: &mut Builder<'_>) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let texels = b.copy_to_texels();
    let trees = b.buffer("speckle.trees", b.sizes.regions);
    let filtered = b.buffer("speckle", b.sizes.map);
    let by_pixel = Bound::Rows(&trees, 8 * u64::from(map_stride));
    for rows in b.lots(&[by_pixel]) {
        let storage = [Texture(&texels), b.lot(by_pixel, rows)];
        let dispatch = Dispatch { first_row: rows.first, rows: rows.count, ..Dispatch::default() };
        b.step("speckle_rows", &storage, dispatch, rows.count, 1, Written::Part);
    }
    let storage: Vec<_> = [Texture(&texels)].into_iter().chain(parts(b, &trees)).collect();
    let mut band = 1;
    while band < height {
        let borders = (height - band).div_ceil(2 * band);
        for groups in cut(Rows { first: 0, count: map_stride / 4 }, SEGMENT_GROUPS) {
            let (first_line, lines) = (groups.first, groups.count);
            let dispatch =
                Dispatch { first_row: band - 1, row_step: 2 * band, first_line, lines, ..Dispatch::default() };
            for kernel in ["speckle_link", "speckle_flatten"] {
                b.step(kernel, &storage, dispatch, lines, borders, Written::Part);
            }
        }
        band *= 2;
    }
    let dispatch = Dispatch { rows: height, ..Dispatch::default() };
    b.step("speckle_count", &storage, dispatch, map_stride / 4, height, Written::Part);
    let (map, lots) = (by_rows(b, &filtered), b.lots(&[by_rows(b, &filtered)]));
    for (i, &rows) in lots.iter().enumerate() {
        let storage: Vec<_> = storage.iter().copied().chain([b.lot(map, rows)]).collect();
        let dispatch = Dispatch { first_row: rows.first, rows: rows.count, ..dispatch };
        b.step("speckle", &storage, dispatch, map_stride / 4, rows.count, Written::Filter(Filter::Speckle));
        b.part_of(i, lots.len());
    }
    filtered
}

/// The trees, whole or in as many parts as the kernels take; those that there are not are the last one again.
fn parts<'a>(b: &Builder<'_>, trees: &'a wgpu::Buffer) -> Vec<Bound<'a>> {
    let Some(bits) = b.sizes.part_bits else { return vec![Buffer(trees)] };
    let (part, all) = (4 << bits, b.sizes.regions);
    let part_at = |i: u64| {
        let from = part * i.min((all - 1) / part);
        Bound::Part(trees, from, part.min(all - from))
    };
    (0..MOST_PARTS.into()).map(part_at).collect()
}
