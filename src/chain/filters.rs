//! From the views to the map: the check of one against the other, and the filters.

use super::Views;
use crate::buffers::{Frame, Pass, Rows, SEGMENT_GROUPS, cut};
use crate::steps::Bound::{Buffer, Texture};
use crate::steps::{Builder, Output};
use crate::{Fill, Median};

/// Stages `lr_check`, `speckle`, `median` and `fill`, those of them that are wanted. Returns the buffer of the map.
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
    if b.params.fill != Fill::None {
        map = fill(b, &views.right);
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
    b.step("speckle_rows", &storage, Pass::default(), height, 1, Output::Part);
    let mut band = 1;
    while band < height {
        let borders = (height - band).div_ceil(2 * band);
        for groups in cut(Rows { first: 0, count: map_stride / 4 }, SEGMENT_GROUPS) {
            let (first_line, lines) = (groups.first, groups.count);
            let pass = Pass { first_row: band - 1, row_step: 2 * band, first_line, lines, ..Pass::default() };
            for kernel in ["speckle_link", "speckle_flatten"] {
                b.step(kernel, &[Texture(&texels), Buffer(&parents)], pass, lines, borders, Output::Part);
            }
        }
        band *= 2;
    }
    let storage = [Texture(&texels), Buffer(&counts), Buffer(&parents)];
    b.step("speckle_count", &storage, Pass::default(), map_stride / 4, height, Output::Part);
    let storage = [Texture(&texels), Buffer(&parents), Buffer(&counts), Buffer(&filtered)];
    b.step("speckle", &storage, Pass::default(), map_stride / 4, height, Output::Speckle);
    filtered
}

/// What the kernels of the stage `fill` leave each other.
struct Filling {
    /// The pixels that a right pixel's disparity leads to.
    seen: wgpu::Buffer,
    /// The nearest values along rows, and on lines that go 0, 1 and -1 columns to the right from row to row.
    along: wgpu::Buffer,
    lines: [wgpu::Buffer; 3],
}

const SLOPES: [i32; 3] = [0, 1, -1];

/// Stage `fill` on the map of the last step.
fn fill(b: &mut Builder<'_>, right: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let filling = Filling {
        seen: b.buffer("fill.seen", u64::from(map_stride) * u64::from(height)),
        along: b.buffer("fill.along", b.sizes.nearest),
        lines: SLOPES.map(|_| b.buffer("fill.lines", b.sizes.nearest)),
    };
    let occlusions = Pass { occlusions: 1, ..Pass::default() };
    let mut texels = b.copy_to_texels();
    if b.params.fill != Fill::Background {
        filling.rows(b, &texels);
        b.step(
            "fill_seen",
            &[Buffer(right), Buffer(&filling.seen)],
            Pass::default(),
            map_stride / 4,
            height,
            Output::Part,
        );
        let mut pass = occlusions;
        if b.params.fill == Fill::Rays {
            filling.between(b, &texels, &filling.along, occlusions, Output::Part);
            texels = b.copy_to_texels();
            filling.rows(b, &texels);
            pass = Pass::default();
        }
        for i in 0..SLOPES.len() {
            filling.lines(b, &texels, i);
        }
        let filled = b.buffer("fill", b.sizes.map);
        let [upright, falling, rising] = &filling.lines;
        let nearest = [&filling.along, falling, upright, rising].map(|buffer| Buffer(buffer));
        let storage: Vec<_> =
            [&[Texture(&texels)][..], &nearest[..], &[Buffer(&filling.seen), Buffer(&filled)][..]].concat();
        b.step("fill_rays", &storage, pass, map_stride / 4, height, Output::Part);
        texels = b.copy_to_texels();
    }
    filling.rows(b, &texels);
    filling.between(b, &texels, &filling.along, Pass::default(), Output::Part);
    texels = b.copy_to_texels();
    filling.lines(b, &texels, 0);
    filling.between(b, &texels, &filling.lines[0], Pass::default(), Output::Fill)
}

impl Filling {
    fn rows(&self, b: &mut Builder<'_>, map: &wgpu::TextureView) {
        let storage = [Texture(map), Buffer(&self.along), Buffer(&self.seen)];
        b.step("fill_rows", &storage, Pass::default(), b.sizes.frame.height, 2, Output::Part);
    }

    /// The lines of a slope, eight together: those that enter at the left come first, those at the right last.
    fn lines(&self, b: &mut Builder<'_>, map: &wgpu::TextureView, slope: usize) {
        let Frame { width, height, .. } = b.sizes.frame;
        let (dx, sideways) = (SLOPES[slope], SLOPES[slope].unsigned_abs() * (height - 1));
        let shift = if dx > 0 { sideways.div_ceil(8) } else { 0 };
        let lines = if dx > 0 { shift + width.div_ceil(8) } else { (width + sideways).div_ceil(8) };
        let pass = Pass { dx, shift, lines, ..Pass::default() };
        b.step("fill_lines", &[Texture(map), Buffer(&self.lines[slope])], pass, lines, 2, Output::Part);
    }

    fn between(
        &self,
        b: &mut Builder<'_>,
        map: &wgpu::TextureView,
        nearest: &wgpu::Buffer,
        pass: Pass,
        output: Output,
    ) -> wgpu::Buffer {
        let Frame { height, map_stride, .. } = b.sizes.frame;
        let filled = b.buffer("fill", b.sizes.map);
        let storage = [Texture(map), Buffer(nearest), Buffer(&self.seen), Buffer(&filled)];
        b.step("fill_between", &storage, pass, map_stride / 4, height, output);
        filled
    }
}
