//! Steps that make a map.

use crate::gpu::layout::Dispatch;
use crate::gpu::recording::{Bound, Builder, Written};

/// A map of disparities by the rows of the image.
pub(super) fn by_rows<'a>(b: &Builder<'_>, map: &'a wgpu::Buffer) -> Bound<'a> {
    Bound::Rows(map, 4 * u64::from(b.sizes.frame.map_stride))
}

/// A step of a kernel that makes a map. `reads`: what it is bound to before and after the map.
pub(super) fn map_step(b: &mut Builder<'_>, kernel: &str, reads: [&[Bound<'_>]; 2], written: Written) -> wgpu::Buffer {
    let map = b.buffer(kernel, b.sizes.map);
    // Words of two pixels that an invocation makes.
    let words = match kernel {
        "weighted_median_parallel" => 1,
        "median_five_parallel" => 2,
        _ => 4,
    };
    let storage = [reads[0], &[by_rows(b, &map)], reads[1]].concat();
    b.step_rows(kernel, &storage, Dispatch::default(), b.sizes.frame.map_stride / words, 1, written);
    map
}
