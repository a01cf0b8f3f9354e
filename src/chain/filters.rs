//! From the views to the map: the check of one against the other, and the filters.

use super::Views;
use crate::buffers::{Frame, Pass};
use crate::kernels;
use crate::steps::Bound::{Buffer, Texture};
use crate::steps::{Builder, Output};
use crate::{Median, reference};

/// Stages `texture`, `lr_check` and the filters, those of them that are wanted. Returns the buffer of the map.
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
    let median = match b.params.median {
        Median::Off => None,
        Median::Three => Some("median"),
        Median::Five => Some("median_five"),
    };
    if let Some(median) = median {
        let texels = b.copy_to_texels();
        let filtered = b.buffer("median", b.sizes.map);
        let storage = [Texture(&texels), Buffer(&filtered)];
        b.step(median, &storage, Pass::default(), map_stride / 4, height, Output::Median);
        map = filtered;
    }
    if b.params.weighted_median.is_some() {
        let texels = b.copy_to_texels();
        let filtered = b.buffer("weighted_median", b.sizes.map);
        let storage = [Texture(&texels), Buffer(&filtered), Texture(gray)];
        b.step("weighted_median", &storage, Pass::default(), map_stride / 4, height, Output::WeightedMedian);
        map = filtered;
    }
    if let Some(settings) = &b.params.wls {
        let couplings = reference::wls_couplings(settings);
        map = wls(b, gray, couplings);
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

/// Stage `wls` of the map that the last step left.
fn wls(b: &mut Builder<'_>, gray: &wgpu::TextureView, couplings: Vec<u32>) -> wgpu::Buffer {
    let Frame { width, height, map_stride, volume_stride, .. } = b.sizes.frame;
    let texels = b.copy_to_texels();
    let couplings = b.table("wls.couplings", couplings);
    let pixels = u64::from(volume_stride) * u64::from(height);
    let (values, shares) = (b.buffer("wls.values", 8 * pixels), b.buffer("wls.shares", 4 * pixels));
    let storage = [Texture(&texels), Buffer(&values)];
    b.step("wls_start", &storage, Pass::default(), map_stride / 4, height, Output::Part);
    for iteration in 0..3 {
        let stride = volume_stride as i32;
        for (lines, rows, dx, dy) in [(height, width, 1, stride), (width, height, stride, 1)] {
            let pass = Pass { lines, rows, dx, dy, shift: 256 * iteration, ..Pass::default() };
            let storage = [Buffer(&values), Buffer(&shares), Texture(gray), Buffer(&couplings)];
            b.step("wls_forward", &storage, pass, lines, 1, Output::Part);
            b.step("wls_backward", &[Buffer(&values), Buffer(&shares)], pass, lines, 1, Output::Part);
        }
    }
    let smooth = b.buffer("wls", b.sizes.map);
    b.step("wls", &[Buffer(&values), Buffer(&smooth)], Pass::default(), map_stride, height, Output::Wls);
    smooth
}
