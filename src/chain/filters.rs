//! From the views to the map: the check of one against the other, and the filters.

use super::Views;
use super::validity::Content;
use crate::buffers::{Frame, Pass, Rows, SEGMENT_GROUPS, cut};
use crate::kernels;
use crate::steps::Bound::{self, Buffer, Texture};
use crate::steps::{Builder, Output};
use crate::{Fill, Median, reference};

/// A step of a kernel that makes a map, eight pixels an invocation. `reads`: what it is bound to before and after the map.
fn map_step(b: &mut Builder<'_>, kernel: &str, reads: [&[Bound<'_>]; 2], output: Output) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let map = b.buffer(kernel, b.sizes.map);
    let storage = [reads[0], &[Buffer(&map)], reads[1]].concat();
    b.step(kernel, &storage, Pass::default(), map_stride / 4, height, output);
    map
}

/// Stage `mirror`: the right view, from the left one of the mirrored pair.
pub(super) fn mirror(b: &mut Builder<'_>, left: &wgpu::Buffer) -> wgpu::Buffer {
    map_step(b, "mirror", [&[Buffer(left)], &[]], Output::Mirrored)
}

/// Stages `texture`, `lr_check` and the filters, those of them that are wanted, and `validity` after each that may give a
/// pixel another disparity. Returns the buffer of the map.
pub(super) fn filtered(
    b: &mut Builder<'_>,
    views: &Views,
    gray: &wgpu::TextureView,
    content: Option<&Content>,
) -> wgpu::Buffer {
    let valid = |b: &mut Builder<'_>, map: wgpu::Buffer| match content {
        Some(content) => content.valid(b, &map, 0),
        None => map,
    };
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let mut map = views.left.clone();
    if b.params.texture > 0 {
        let columns = b.buffer("texture_columns", b.sizes.map);
        let segments = height.div_ceil(kernels::segment(&b.plan));
        let storage = [Texture(gray), Buffer(&columns)];
        b.step("texture_columns", &storage, Pass::default(), map_stride.div_ceil(8), segments, Output::Part);
        map = map_step(b, "texture", [&[Buffer(&columns), Buffer(&map)], &[]], Output::Textured);
    }
    if b.params.lr_check.is_some() {
        map = map_step(b, "lr_check", [&[Buffer(&map), Buffer(&views.right)], &[]], Output::Checked);
    }
    if b.params.speckle_window > 0 {
        map = speckle(b);
    }
    let median = match b.params.median {
        Median::Off => None,
        Median::Three => Some("median"),
        Median::Five => Some("median_five"),
    };
    if let Some(median) = median {
        let texels = b.copy_to_texels();
        map = map_step(b, median, [&[Texture(&texels)], &[]], Output::Median);
        map = valid(b, map);
    }
    if b.params.fill != Fill::None {
        map = fill(b, &views.right);
        map = valid(b, map);
    }
    if b.params.weighted_median.is_some() {
        let texels = b.copy_to_texels();
        let reads: [&[_]; 2] = [&[Texture(&texels)], &[Texture(gray)]];
        map = map_step(b, "weighted_median", reads, Output::WeightedMedian);
        map = valid(b, map);
    }
    if let Some(settings) = &b.params.wls {
        let couplings = reference::wls_couplings(settings);
        map = wls(b, gray, couplings);
        map = valid(b, map);
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

/// Stage `depth` of the final `map`.
pub(super) fn depth(b: &mut Builder<'_>, map: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let depth = b.buffer("depth", b.sizes.regions);
    b.step("depth", &[Buffer(map), Buffer(&depth)], Pass::default(), map_stride / 2, height, Output::Depth);
    depth
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
        let nearest = [&filling.along, falling, upright, rising].map(Buffer);
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
