//! From the views to the map: the filters of the table, and what is made of the final map.

use crate::gpu::chain::content::ContentBits;
use crate::gpu::chain::filters::fill::fill;
use crate::gpu::chain::filters::map_step::{by_rows, map_step};
use crate::gpu::chain::filters::speckle::speckle;
use crate::gpu::chain::filters::wls::wls;
use crate::gpu::chain::view_maps::ViewMaps;
use crate::gpu::layout::{Dispatch, Frame};
use crate::gpu::plan;
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::params::{Filter, Steps};
use crate::{Median, reference};

/// The filters that are asked for, and `validity` after each that may give a pixel another disparity. Returns the buffer of
/// the map.
pub(crate) fn filtered(
    b: &mut Builder<'_>,
    views: &ViewMaps,
    gray: &wgpu::TextureView,
    content: Option<&ContentBits>,
) -> wgpu::Buffer {
    let mut map = views.left.clone();
    for &filter in Filter::ALL {
        if !filter.wanted(&b.params) {
            continue;
        }
        map = filter_step(b, filter, &map, &views.right, gray);
        if let Some(content) = content.filter(|_| filter.gives_disparities()) {
            map = content.valid(b, &map, 0);
        }
    }
    map
}

/// One filter of `map`, which the last step left. Returns the buffer of its map.
fn filter_step(
    b: &mut Builder<'_>,
    filter: Filter,
    map: &wgpu::Buffer,
    right: &wgpu::Buffer,
    gray: &wgpu::TextureView,
) -> wgpu::Buffer {
    let written = Written::Filter(filter);
    let kernel = match filter {
        Filter::Median if b.params.median == Median::Five && b.plan.per_subgroup => "median_five_parallel",
        Filter::Median if b.params.median == Median::Five => "median_five",
        Filter::WeightedMedian if b.plan.per_subgroup => "weighted_median_parallel",
        _ => filter.stage(),
    };
    match filter.steps() {
        Steps::Around => {
            let texels = b.copy_to_texels();
            map_step(b, kernel, [&[Texture(&texels)], &[]], written)
        }
        Steps::AroundWithImage => {
            let texels = b.copy_to_texels();
            map_step(b, kernel, [&[Texture(&texels)], &[Texture(gray)]], written)
        }
        Steps::BothViews => {
            let reads = [by_rows(b, map), by_rows(b, right)];
            map_step(b, kernel, [&reads, &[]], written)
        }
        Steps::Texture => {
            let columns = b.buffer("texture_columns", b.sizes.map);
            let (storage, lines) = ([Texture(gray), by_rows(b, &columns)], b.sizes.frame.map_stride.div_ceil(8));
            b.step_rows("texture_columns", &storage, Dispatch::default(), lines, plan::segment(&b.plan), Written::Part);
            let reads = [by_rows(b, &columns), by_rows(b, map)];
            map_step(b, kernel, [&reads, &[]], written)
        }
        Steps::Speckle => speckle(b),
        Steps::Fill => fill(b, right, gray),
        Steps::Wls => {
            let couplings = b.params.wls.as_ref().map_or_else(Vec::new, reference::wls_couplings);
            wls(b, gray, couplings)
        }
    }
}

/// Stage `confidence` of the final `map`.
pub(crate) fn confidence(b: &mut Builder<'_>, views: &ViewMaps, map: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let confidence = b.buffer("confidence", b.sizes.confidence);
    let storage = [Buffer(map), Buffer(&views.right), Buffer(&confidence)];
    b.step("confidence", &storage, Dispatch::default(), map_stride / 4, height, Written::Confidence);
    confidence
}

/// Stage `depth` of the final `map`.
pub(crate) fn depth(b: &mut Builder<'_>, map: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { map_stride, .. } = b.sizes.frame;
    let depth = b.buffer("depth", b.sizes.regions);
    let storage = [by_rows(b, map), Bound::Rows(&depth, 8 * u64::from(map_stride))];
    b.step_rows("depth", &storage, Dispatch::default(), map_stride / 2, 1, Written::Depth);
    depth
}
