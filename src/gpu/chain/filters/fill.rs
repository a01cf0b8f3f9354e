//! The filling of holes.

use crate::Fill;
use crate::gpu::chain::filters::map_step::by_rows;
use crate::gpu::layout::{Dispatch, FillOwn, Frame};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::params::Filter;

/// The buffers between the kernels of the stage `fill`.
struct Filling {
    /// The pixels that a right pixel's disparity leads to.
    seen: wgpu::Buffer,
    /// The nearest values along rows, and on lines that go 0, 1 and -1 columns to the right from row to row.
    along: wgpu::Buffer,
    lines: [wgpu::Buffer; 3],
    /// What the lines carry from one lot of rows to the next.
    carry: wgpu::Buffer,
}

const SLOPES: [i32; 3] = [0, 1, -1];

/// Stage `fill` on the map of the last step.
pub(super) fn fill(b: &mut Builder<'_>, right: &wgpu::Buffer, gray: &wgpu::TextureView) -> wgpu::Buffer {
    let Frame { width, height, map_stride, .. } = b.sizes.frame;
    let lines = u64::from(width.div_ceil(8)) + u64::from(height.div_ceil(8)) + 2;
    // With gray a value takes twice the room.
    let widened = if b.params.fill == Fill::WeightedRays { 2 } else { 1 };
    let filling = Filling {
        seen: b.buffer("fill.seen", u64::from(map_stride) * u64::from(height)),
        along: b.buffer("fill.along", b.sizes.nearest),
        lines: SLOPES.map(|_| b.buffer("fill.lines", b.sizes.nearest)),
        carry: b.buffer("fill.carry", widened * 2 * 16 * lines),
    };
    let mut texels = b.copy_to_texels();
    if b.params.fill != Fill::Background {
        filling.estimates(b, &texels, right, gray);
        texels = b.copy_to_texels();
    }
    filling.rows(b, &texels);
    filling.between(b, &texels, &filling.along, Dispatch::default(), Written::Part);
    texels = b.copy_to_texels();
    filling.lines(b, &texels, 0);
    filling.between(b, &texels, &filling.lines[0], Dispatch::default(), Written::Filter(Filter::Fill))
}

/// Nearest values by the rows of the image.
fn nearest_rows<'a>(b: &Builder<'_>, nearest: &'a wgpu::Buffer) -> Bound<'a> {
    Bound::Rows(nearest, 32 * u64::from(b.sizes.frame.map_stride / 4 + 1))
}

/// The same with the gray of their pixels.
fn key_rows<'a>(b: &Builder<'_>, nearest: &'a wgpu::Buffer) -> Bound<'a> {
    Bound::Rows(nearest, 64 * u64::from(b.sizes.frame.map_stride / 4 + 1))
}

impl Filling {
    /// What occlusions and mismatches take.
    fn estimates(&self, b: &mut Builder<'_>, map: &wgpu::TextureView, right: &wgpu::Buffer, gray: &wgpu::TextureView) {
        let map_stride = b.sizes.frame.map_stride;
        let occlusions = Dispatch { own: FillOwn { occlusions: 1 }.into(), ..Dispatch::default() };
        let fill = b.params.fill;
        if fill == Fill::WeightedRays {
            self.medians(b, map)
        } else {
            self.rows(b, map)
        }
        let storage = [by_rows(b, right), Buffer(&self.seen)];
        b.step_rows("fill_seen", &storage, Dispatch::default(), map_stride / 4, 1, Written::Part);
        if fill == Fill::Hirschmuller {
            return self.rays(b, map, occlusions);
        }
        self.between(b, map, &self.along, occlusions, Written::Part);
        let texels = b.copy_to_texels();
        if fill == Fill::WeightedRays {
            return self.weighted_rays(b, &texels, gray);
        }
        self.rows(b, &texels);
        self.rays(b, &texels, Dispatch::default());
    }

    /// The median along eight rays, or what the dispatch wants of occlusions.
    fn rays(&self, b: &mut Builder<'_>, map: &wgpu::TextureView, dispatch: Dispatch) {
        for i in 0..SLOPES.len() {
            self.lines(b, map, i);
        }
        let filled = b.buffer("fill", b.sizes.map);
        let [upright, falling, rising] = &self.lines;
        let nearest = [&self.along, falling, upright, rising].map(|nearest| nearest_rows(b, nearest));
        let storage: Vec<_> =
            [&[Texture(map)][..], &nearest[..], &[Buffer(&self.seen), by_rows(b, &filled)][..]].concat();
        b.step_rows("fill_rays", &storage, dispatch, b.sizes.frame.map_stride / 4, 1, Written::Part);
    }

    /// The median weighted by gray.
    fn weighted_rays(&self, b: &mut Builder<'_>, map: &wgpu::TextureView, gray: &wgpu::TextureView) {
        self.along_rows(b, "fill_rows_gray", &[Texture(map), key_rows(b, &self.along), Texture(gray)]);
        for (i, lines) in self.lines.iter().enumerate() {
            let nearest = key_rows(b, lines);
            self.along_lines(b, "fill_lines_gray", i, &[Texture(map), nearest, Texture(gray), Buffer(&self.carry)]);
        }
        let filled = b.buffer("fill", b.sizes.map);
        let [upright, falling, rising] = &self.lines;
        let nearest = [&self.along, falling, upright, rising].map(|nearest| key_rows(b, nearest));
        let storage: Vec<_> = [&[Texture(map), by_rows(b, &filled), Texture(gray)][..], &nearest[..]].concat();
        let lines = b.sizes.frame.map_stride / 4;
        b.step_rows("fill_rays_weighted", &storage, Dispatch::default(), lines, 1, Written::Part);
    }

    fn rows(&self, b: &mut Builder<'_>, map: &wgpu::TextureView) {
        self.along_rows(b, "fill_rows", &[Texture(map), nearest_rows(b, &self.along), Buffer(&self.seen)]);
    }

    /// The medians of three along rows.
    fn medians(&self, b: &mut Builder<'_>, map: &wgpu::TextureView) {
        self.along_rows(b, "fill_rows_medians", &[Texture(map), nearest_rows(b, &self.along), Buffer(&self.seen)]);
    }

    fn along_rows(&self, b: &mut Builder<'_>, kernel: &str, storage: &[Bound<'_>]) {
        for rows in b.lots(storage) {
            let storage: Vec<_> = storage.iter().map(|&bound| b.lot(bound, rows)).collect();
            let dispatch = Dispatch { first_row: rows.first, rows: rows.count, ..Dispatch::default() };
            b.step(kernel, &storage, dispatch, rows.count, 2, Written::Part);
        }
    }

    fn lines(&self, b: &mut Builder<'_>, map: &wgpu::TextureView, slope: usize) {
        let nearest = nearest_rows(b, &self.lines[slope]);
        self.along_lines(b, "fill_lines", slope, &[Texture(map), nearest, Buffer(&self.carry)]);
    }

    /// The lines of a slope, eight together: those that enter at the left come first, those at the right last.
    fn along_lines(&self, b: &mut Builder<'_>, kernel: &str, slope: usize, storage: &[Bound<'_>]) {
        let Frame { width, height, .. } = b.sizes.frame;
        let (dx, sideways) = (SLOPES[slope], SLOPES[slope].unsigned_abs() * (height - 1));
        let shift = if dx > 0 { sideways.div_ceil(8) } else { 0 };
        let lines = if dx > 0 { shift + width.div_ceil(8) } else { (width + sideways).div_ceil(8) };
        let lots = b.lots(storage);
        // Downwards and upwards at once, or one after the other.
        let ways = if lots.len() == 1 { 0..1 } else { 0..2 };
        let at_once = 2 / ways.len() as u32;
        for way in ways {
            for nth in 0..lots.len() {
                let rows = if way == 0 { lots[nth] } else { lots[lots.len() - 1 - nth] };
                let dispatch =
                    Dispatch { dx, shift, lines, first_row: rows.first, rows: rows.count, ..Dispatch::default() };
                let dispatch = Dispatch { entry: way, carried: (nth > 0).into(), ..dispatch };
                let storage: Vec<_> = storage.iter().map(|&bound| b.lot(bound, rows)).collect();
                b.step(kernel, &storage, dispatch, lines, at_once, Written::Part);
            }
        }
    }

    fn between(
        &self,
        b: &mut Builder<'_>,
        map: &wgpu::TextureView,
        nearest: &wgpu::Buffer,
        dispatch: Dispatch,
        written: Written,
    ) -> wgpu::Buffer {
        let filled = b.buffer("fill", b.sizes.map);
        let storage = [Texture(map), nearest_rows(b, nearest), Buffer(&self.seen), by_rows(b, &filled)];
        b.step_rows("fill_between", &storage, dispatch, b.sizes.frame.map_stride / 4, 1, written);
        filled
    }
}
