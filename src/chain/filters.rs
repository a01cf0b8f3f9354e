//! From the views to the map: the check of one against the other, and the filters.

use super::Views;
use crate::Median;
use crate::buffers::{Frame, Pass};
use crate::kernels;
use crate::steps::Bound::{Buffer, Texture};
use crate::steps::{Builder, Output};

/// Stages `texture`, `lr_check` and `median`, those of them that are wanted. Returns the buffer of the map.
pub(super) fn filtered(b: &mut Builder<'_>, views: &Views, gray: &wgpu::TextureView) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let mut map = views.left.clone();
    if b.params.texture > 0 {
        let columns = b.buffer("texture_columns", b.sizes.map);
        let segments = height.div_ceil(kernels::segment(&b.plan));
        let storage = [Texture(gray), Buffer(&columns)];
        b.step("texture_columns", &storage, Pass::default(), map_stride.div_ceil(8), segments, Output::Part);
        let textured = b.buffer("texture", b.sizes.map);
        let storage = [Buffer(&columns), Buffer(&map), Buffer(&textured)];
        b.step("texture", &storage, Pass::default(), map_stride / 4, height, Output::Textured);
        map = textured;
    }
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

/// Stage `confidence` of the final `map`.
pub(super) fn confidence(b: &mut Builder<'_>, views: &Views, map: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let confidence = b.buffer("confidence", b.sizes.confidence);
    let storage = [Buffer(map), Buffer(&views.right), Buffer(&confidence)];
    b.step("confidence", &storage, Pass::default(), map_stride / 4, height, Output::Confidence);
    confidence
}
