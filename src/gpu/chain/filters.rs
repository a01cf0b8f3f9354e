//! From the views to the map: the check of one against the other, and the filters.

use crate::gpu::chain::content::ContentBits;
use crate::gpu::chain::view_maps::ViewMaps;
use crate::gpu::layout::{Frame, Pass, Rows, cut};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Output};
use crate::gpu::{plan, rounds};
use crate::{Fill, Median, reference};

/// A map of disparities by the rows of the image.
fn by_rows<'a>(b: &Builder<'_>, map: &'a wgpu::Buffer) -> Bound<'a> {
    Bound::Rows(map, 4 * u64::from(b.sizes.frame.map_stride))
}

/// A step of a kernel that makes a map, eight pixels an invocation. `reads`: what it is bound to before and after the map.
fn map_step(b: &mut Builder<'_>, kernel: &str, reads: [&[Bound<'_>]; 2], output: Output) -> wgpu::Buffer {
    let map = b.buffer(kernel, b.sizes.map);
    let storage = [reads[0], &[by_rows(b, &map)], reads[1]].concat();
    b.step_rows(kernel, &storage, Pass::default(), b.sizes.frame.map_stride / 4, 1, output);
    map
}

/// Stages `texture`, `lr_check` and the filters, those of them that are wanted, and `validity` after each that may give a
/// pixel another disparity. Returns the buffer of the map.
pub(super) fn filtered(
    b: &mut Builder<'_>,
    views: &ViewMaps,
    gray: &wgpu::TextureView,
    content: Option<&ContentBits>,
) -> wgpu::Buffer {
    let valid = |b: &mut Builder<'_>, map: wgpu::Buffer| match content {
        Some(content) => content.valid(b, &map, 0),
        None => map,
    };
    let mut map = views.left.clone();
    if b.params.texture > 0 {
        let columns = b.buffer("texture_columns", b.sizes.map);
        let (storage, lines) = ([Texture(gray), by_rows(b, &columns)], b.sizes.frame.map_stride.div_ceil(8));
        b.step_rows("texture_columns", &storage, Pass::default(), lines, plan::segment(&b.plan), Output::Part);
        let reads = [by_rows(b, &columns), by_rows(b, &map)];
        map = map_step(b, "texture", [&reads, &[]], Output::Textured);
    }
    if b.params.lr_check.is_some() {
        let reads = [by_rows(b, &map), by_rows(b, &views.right)];
        map = map_step(b, "lr_check", [&reads, &[]], Output::Checked);
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
pub(super) fn confidence(b: &mut Builder<'_>, views: &ViewMaps, map: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let confidence = b.buffer("confidence", b.sizes.confidence);
    let storage = [Buffer(map), Buffer(&views.right), Buffer(&confidence)];
    b.step("confidence", &storage, Pass::default(), map_stride / 4, height, Output::Confidence);
    confidence
}

/// Stage `depth` of the final `map`.
pub(super) fn depth(b: &mut Builder<'_>, map: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { map_stride, .. } = b.sizes.frame;
    let depth = b.buffer("depth", b.sizes.regions);
    let storage = [by_rows(b, map), Bound::Rows(&depth, 8 * u64::from(map_stride))];
    b.step_rows("depth", &storage, Pass::default(), map_stride / 2, 1, Output::Depth);
    depth
}

/// Stage `wls` of the map that the last step left.
fn wls(b: &mut Builder<'_>, gray: &wgpu::TextureView, couplings: Vec<u32>) -> wgpu::Buffer {
    let Frame { width, height, map_stride, volume_stride, .. } = b.sizes.frame;
    let texels = b.copy_to_texels();
    let couplings = b.table("wls.couplings", couplings);
    let pixels = u64::from(volume_stride) * u64::from(height);
    let (values, shares) = (b.buffer("wls.values", 8 * pixels), b.buffer("wls.shares", 4 * pixels));
    let carry = b.buffer("wls.carry", 16 * u64::from(width.max(height)));
    let row = u64::from(volume_stride);
    let (values_rows, shares_rows) = (Bound::Rows(&values, 8 * row), Bound::Rows(&shares, 4 * row));
    let storage = [Texture(&texels), values_rows];
    b.step_rows("wls_start", &storage, Pass::default(), map_stride / 4, 1, Output::Part);
    let lots = b.lots(&[values_rows, shares_rows]);
    for iteration in 0..3 {
        let shift = 256 * iteration;
        for &rows in &lots {
            let (lines, stride) = (rows.count, volume_stride as i32);
            let pass = Pass { first_row: rows.first, rows: width, lines, dx: 1, dy: stride, shift, ..Pass::default() };
            let own = [b.lot(values_rows, rows), b.lot(shares_rows, rows), Buffer(&carry)];
            let storage = [&own[..], &[Texture(gray), Buffer(&couplings)]].concat();
            b.step("wls_forward", &storage, pass, lines, 1, Output::Part);
            b.step("wls_backward", &own, pass, lines, 1, Output::Part);
        }
        let down = |rows: Rows| Pass {
            first_row: rows.first,
            rows: rows.count,
            lines: width,
            dx: volume_stride as i32,
            dy: 1,
            row_step: 1,
            shift,
            ..Pass::default()
        };
        for &rows in &lots {
            let pass = Pass { carried: (rows.first > 0).into(), ..down(rows) };
            let own = [b.lot(values_rows, rows), b.lot(shares_rows, rows), Buffer(&carry)];
            let storage = [&own[..], &[Texture(gray), Buffer(&couplings)]].concat();
            b.step("wls_forward", &storage, pass, width, 1, Output::Part);
        }
        for &rows in lots.iter().rev() {
            let pass = Pass { carried: (rows.end() < height).into(), ..down(rows) };
            let own = [b.lot(values_rows, rows), b.lot(shares_rows, rows), Buffer(&carry)];
            b.step("wls_backward", &own, pass, width, 1, Output::Part);
        }
    }
    let smooth = b.buffer("wls", b.sizes.map);
    let storage = [values_rows, by_rows(b, &smooth)];
    b.step_rows("wls", &storage, Pass::default(), map_stride, 1, Output::Wls);
    smooth
}

/// Stage `speckle` on the map of the last step: the runs of each row, joined across borders of bands of 1, 2, 4 .. rows to
/// trees, a tree a region, which are counted at their roots.
fn speckle(b: &mut Builder<'_>) -> wgpu::Buffer {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let texels = b.copy_to_texels();
    let trees = b.buffer("speckle.trees", b.sizes.regions);
    let filtered = b.buffer("speckle", b.sizes.map);
    let by_pixel = Bound::Rows(&trees, 8 * u64::from(map_stride));
    for rows in b.lots(&[by_pixel]) {
        let storage = [Texture(&texels), b.lot(by_pixel, rows)];
        let pass = Pass { first_row: rows.first, rows: rows.count, ..Pass::default() };
        b.step("speckle_rows", &storage, pass, rows.count, 1, Output::Part);
    }
    let storage: Vec<_> = [Texture(&texels)].into_iter().chain(parts(b, &trees)).collect();
    let mut band = 1;
    while band < height {
        let borders = (height - band).div_ceil(2 * band);
        for groups in cut(Rows { first: 0, count: map_stride / 4 }, rounds::SEGMENT_GROUPS) {
            let (first_line, lines) = (groups.first, groups.count);
            let pass = Pass { first_row: band - 1, row_step: 2 * band, first_line, lines, ..Pass::default() };
            for kernel in ["speckle_link", "speckle_flatten"] {
                b.step(kernel, &storage, pass, lines, borders, Output::Part);
            }
        }
        band *= 2;
    }
    let pass = Pass { rows: height, ..Pass::default() };
    b.step("speckle_count", &storage, pass, map_stride / 4, height, Output::Part);
    let (map, lots) = (by_rows(b, &filtered), b.lots(&[by_rows(b, &filtered)]));
    for (i, &rows) in lots.iter().enumerate() {
        let storage: Vec<_> = storage.iter().copied().chain([b.lot(map, rows)]).collect();
        let pass = Pass { first_row: rows.first, rows: rows.count, ..pass };
        b.step("speckle", &storage, pass, map_stride / 4, rows.count, Output::Speckle);
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
    (0..plan::MOST_PARTS.into()).map(part_at).collect()
}

/// What the kernels of the stage `fill` leave each other.
struct Filling {
    /// The pixels that a right pixel's disparity leads to.
    seen: wgpu::Buffer,
    /// The nearest values along rows, and on lines that go 0, 1 and -1 columns to the right from row to row.
    along: wgpu::Buffer,
    lines: [wgpu::Buffer; 3],
    /// What the lines found in the rows before a lot of them.
    carry: wgpu::Buffer,
}

const SLOPES: [i32; 3] = [0, 1, -1];

/// Stage `fill` on the map of the last step.
fn fill(b: &mut Builder<'_>, right: &wgpu::Buffer) -> wgpu::Buffer {
    let Frame { width, height, map_stride, .. } = b.sizes.frame;
    let lines = u64::from(width.div_ceil(8)) + u64::from(height.div_ceil(8)) + 2;
    let filling = Filling {
        seen: b.buffer("fill.seen", u64::from(map_stride) * u64::from(height)),
        along: b.buffer("fill.along", b.sizes.nearest),
        lines: SLOPES.map(|_| b.buffer("fill.lines", b.sizes.nearest)),
        carry: b.buffer("fill.carry", 2 * 16 * lines),
    };
    let occlusions = Pass { occlusions: 1, ..Pass::default() };
    let mut texels = b.copy_to_texels();
    if b.params.fill != Fill::Background {
        filling.rows(b, &texels);
        let storage = [by_rows(b, right), Buffer(&filling.seen)];
        b.step_rows("fill_seen", &storage, Pass::default(), map_stride / 4, 1, Output::Part);
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
        let nearest = [&filling.along, falling, upright, rising].map(|nearest| nearest_rows(b, nearest));
        let storage: Vec<_> =
            [&[Texture(&texels)][..], &nearest[..], &[Buffer(&filling.seen), by_rows(b, &filled)][..]].concat();
        b.step_rows("fill_rays", &storage, pass, map_stride / 4, 1, Output::Part);
        texels = b.copy_to_texels();
    }
    filling.rows(b, &texels);
    filling.between(b, &texels, &filling.along, Pass::default(), Output::Part);
    texels = b.copy_to_texels();
    filling.lines(b, &texels, 0);
    filling.between(b, &texels, &filling.lines[0], Pass::default(), Output::Fill)
}

/// Nearest values by the rows of the image.
fn nearest_rows<'a>(b: &Builder<'_>, nearest: &'a wgpu::Buffer) -> Bound<'a> {
    Bound::Rows(nearest, 32 * u64::from(b.sizes.frame.map_stride / 4 + 1))
}

impl Filling {
    fn rows(&self, b: &mut Builder<'_>, map: &wgpu::TextureView) {
        let storage = [Texture(map), nearest_rows(b, &self.along), Buffer(&self.seen)];
        let lots = b.lots(&storage);
        for &rows in &lots {
            let storage = storage.map(|bound| b.lot(bound, rows));
            let pass = Pass { first_row: rows.first, rows: rows.count, ..Pass::default() };
            b.step("fill_rows", &storage, pass, rows.count, 2, Output::Part);
        }
    }

    /// The lines of a slope, eight together: those that enter at the left come first, those at the right last.
    fn lines(&self, b: &mut Builder<'_>, map: &wgpu::TextureView, slope: usize) {
        let Frame { width, height, .. } = b.sizes.frame;
        let (dx, sideways) = (SLOPES[slope], SLOPES[slope].unsigned_abs() * (height - 1));
        let shift = if dx > 0 { sideways.div_ceil(8) } else { 0 };
        let lines = if dx > 0 { shift + width.div_ceil(8) } else { (width + sideways).div_ceil(8) };
        let nearest = nearest_rows(b, &self.lines[slope]);
        let lots = b.lots(&[nearest]);
        // Both ways at once, or down and then up.
        let ways = if lots.len() == 1 { 0..1 } else { 0..2 };
        let at_once = 2 / ways.len() as u32;
        for way in ways {
            for nth in 0..lots.len() {
                let rows = if way == 0 { lots[nth] } else { lots[lots.len() - 1 - nth] };
                let pass = Pass { dx, shift, lines, first_row: rows.first, rows: rows.count, ..Pass::default() };
                let pass = Pass { entry: way, carried: (nth > 0).into(), ..pass };
                let storage = [Texture(map), b.lot(nearest, rows), Buffer(&self.carry)];
                b.step("fill_lines", &storage, pass, lines, at_once, Output::Part);
            }
        }
    }

    fn between(
        &self,
        b: &mut Builder<'_>,
        map: &wgpu::TextureView,
        nearest: &wgpu::Buffer,
        pass: Pass,
        output: Output,
    ) -> wgpu::Buffer {
        let filled = b.buffer("fill", b.sizes.map);
        let storage = [Texture(map), nearest_rows(b, nearest), Buffer(&self.seen), by_rows(b, &filled)];
        b.step_rows("fill_between", &storage, pass, b.sizes.frame.map_stride / 4, 1, output);
        filled
    }
}
