//! From the views to the map: the check of one against the other, and the filters.

use super::Views;
use crate::Median;
use crate::buffers::{Frame, Pass};
use crate::steps::Bound::{Buffer, Texture};
use crate::steps::{Builder, Output};

/// Stage `mirror`: the right view, from the left one of the mirrored pair.
pub(super) fn mirror(b: &mut Builder<'_>, left: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let mirrored = b.buffer("mirror", b.sizes.map);
    let storage = [Buffer(left), Buffer(&mirrored)];
    b.step("mirror", &storage, Pass::default(), map_stride / 4, height, Output::Mirrored);
    mirrored
}

/// Stages `lr_check` and `median`, those of them that are wanted. Returns the buffer of the map.
pub(super) fn filtered(b: &mut Builder<'_>, views: &Views) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let mut map = views.left.clone();
    if b.params.lr_check.is_some() {
        let checked = b.buffer("lr_check", b.sizes.map);
        let storage = [Buffer(&map), Buffer(&views.right), Buffer(&checked)];
        b.step("lr_check", &storage, Pass::default(), map_stride / 4, height, Output::Checked);
        map = checked;
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
