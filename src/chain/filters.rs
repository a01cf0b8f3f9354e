//! From the views to the map: the check of one against the other, and the filters.

use super::Views;
use crate::Median;
use crate::buffers::{Frame, Pass, Rows, SEGMENT_GROUPS, cut};
use crate::steps::Bound::{Buffer, Texture};
use crate::steps::{Builder, Output};

/// Stages `lr_check`, `speckle` and `median`, those of them that are wanted. Returns the buffer of the map.
pub(super) fn filtered(b: &mut Builder<'_>, views: &Views) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let mut map = views.left.clone();
    if b.params.lr_check.is_some() {
        let checked = b.buffer("lr_check", b.sizes.map);
        let storage = [Buffer(&map), Buffer(&views.right), Buffer(&checked)];
        b.step("lr_check", &storage, Pass::default(), map_stride / 4, height, Output::Checked);
        map = checked;
    }
    if b.params.speckle_window > 0 {
        map = speckle(b);
    }
    if b.params.median == Median::Three {
        let texels = b.copy_to_texels();
        let filtered = b.buffer("median", b.sizes.map);
        let storage = [Texture(&texels), Buffer(&filtered)];
        b.step("median", &storage, Pass::default(), map_stride / 4, height, Output::Median);
        map = filtered;
    }
    map
}

/// Stage `speckle` on the map of the last step: the runs of each row, joined across borders of bands of 1, 2, 4 .. rows to
/// trees, a tree a region, which are counted.
fn speckle(b: &mut Builder<'_>) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let texels = b.copy_to_texels();
    let [parents, counts] = ["speckle.parents", "speckle.counts"].map(|name| b.buffer(name, b.sizes.regions));
    let filtered = b.buffer("speckle", b.sizes.map);
    let storage = [Texture(&texels), Buffer(&parents), Buffer(&counts)];
    b.step("speckle_rows", &storage, Pass::default(), height, 1, Output::Temporary);
    let mut band = 1;
    while band < height {
        let borders = (height - band).div_ceil(2 * band);
        for groups in cut(Rows { first: 0, count: map_stride / 4 }, SEGMENT_GROUPS) {
            let (first_line, lines) = (groups.first, groups.count);
            let pass = Pass { first_row: band - 1, row_step: 2 * band, first_line, lines, ..Pass::default() };
            for kernel in ["speckle_link", "speckle_flatten"] {
                b.step(kernel, &[Texture(&texels), Buffer(&parents)], pass, lines, borders, Output::Temporary);
            }
        }
        band *= 2;
    }
    let storage = [Texture(&texels), Buffer(&counts), Buffer(&parents)];
    b.step("speckle_count", &storage, Pass::default(), map_stride / 4, height, Output::Temporary);
    let storage = [Texture(&texels), Buffer(&parents), Buffer(&counts), Buffer(&filtered)];
    b.step("speckle", &storage, Pass::default(), map_stride / 4, height, Output::Speckle);
    filtered
}
