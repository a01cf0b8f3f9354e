//! The rounds of mutual information, from small images to large ones: each is matched by a table of costs that follows from
//! the map of the round before.

use crate::gpu::chain::content::ContentBits;
use crate::gpu::chain::filters::filtered::filtered;
use crate::gpu::chain::images::{halved, values};
use crate::gpu::chain::planes::{Planes, planes_of};
use crate::gpu::chain::view_maps::ViewMaps;
use crate::gpu::chain::winner;
use crate::gpu::layout::{Dispatch, Frame, HistogramOwn, SmoothOwn};
use crate::gpu::recording::Bound::{Buffer, Texture};
use crate::gpu::recording::{Builder, Level, Written};
use crate::reference::{mi_narrowing, mi_prior};

/// All rounds but the last one, and what that one compares.
pub(super) fn planes(b: &mut Builder<'_>, sources: &[wgpu::TextureView; 2], content: Option<&ContentBits>) -> Planes {
    let (grays, values) = values(b, sources);
    let mut pyramid = vec![values];
    while pyramid.len() <= b.levels[0].halvings as usize {
        pyramid.push(halved(b, &pyramid));
    }
    let scratch = Scratch::new(b);
    b.enter(0);
    let mut planes = planes_of(b, &pyramid[b.levels[0].halvings as usize], &grays);
    scratch.table(b, &mut planes, &pyramid, None);
    for level in 1..b.levels.len() {
        let mut views = ViewMaps::new(b);
        winner::winner(b, &mut planes, &views);
        if let Some(content) = content {
            views = content.views(b, views);
        }
        let map = filtered(b, &views, &planes.grays[0], content);
        b.enter(level);
        let [before, here] = [level - 1, level].map(|level| b.levels[level].halvings);
        if before != here {
            planes = planes_of(b, &pyramid[here as usize], &grays);
        }
        scratch.table(b, &mut planes, &pyramid, Some(&map));
    }
    planes
}

/// The buffers between the kernels of the stages `mi_histogram` and `mi_table`.
struct Scratch {
    counts: wgpu::Buffer,
    /// The table smoothed along rows, then along both axes.
    joint: [wgpu::Buffer; 2],
    /// Sums of the table's rows and columns, then their smoothed logarithms.
    marginals: [wgpu::Buffer; 2],
    range: wgpu::Buffer,
    /// In place of a map where there is none yet.
    no_map: wgpu::Buffer,
}

/// Bytes of a number for each pair of values.
const TABLE_BYTES: u64 = 4 * 256 * 256;

impl Scratch {
    fn new(b: &mut Builder<'_>) -> Self {
        Self {
            counts: b.buffer("mi_histogram", TABLE_BYTES),
            joint: [(); 2].map(|()| b.buffer("mi_smooth", TABLE_BYTES)),
            marginals: [(); 2].map(|()| b.buffer("mi_marginals", 4 * 512)),
            range: b.buffer("mi_range", 8),
            no_map: b.buffer("mi_histogram.none", 4),
        }
    }

    /// Stages `mi_histogram`, by the map of the level before, and `mi_table`, whose table goes to the planes.
    fn table(
        &self,
        b: &mut Builder<'_>,
        planes: &mut Planes,
        pyramid: &[[wgpu::TextureView; 2]],
        map: Option<&wgpu::Buffer>,
    ) {
        let Frame { width, height, .. } = b.sizes.frame;
        let Level { halvings, .. } = b.levels[b.level];
        let [left, right] = &pyramid[halvings as usize];
        let (dispatch, map, rows) = match map {
            Some(map) => {
                let before = &b.levels[b.level - 1];
                let stride = before.sizes.frame.map_stride;
                let own = HistogramOwn { halvings: before.halvings - halvings };
                (Dispatch { stride, own: own.into(), ..Dispatch::default() }, map, height)
            }
            None => (Dispatch::default(), &self.no_map, 0),
        };
        let storage = [Texture(left), Texture(right), Buffer(map), Buffer(&self.counts)];
        b.step("mi_histogram", &storage, dispatch, width, rows, Written::Histogram);
        b.clear();

        let pixels = u64::from(width) * u64::from(height);
        let along = Dispatch { rows: 256, ..Dispatch::default() };
        let down = Dispatch { dy: 1, ..along };
        let [across, joint] = &self.joint;
        let [sums, marginals] = &self.marginals;
        let none = SmoothOwn::default();
        let logarithms = SmoothOwn { logarithms: 1, ..none };
        smooth(b, &self.counts, across, along, SmoothOwn { narrowing: mi_narrowing(pixels), ..none });
        smooth(b, across, joint, down, SmoothOwn { prior: mi_prior(pixels), ..none });
        b.step("mi_marginals", &[Buffer(joint), Buffer(sums)], Dispatch::default(), 512, 1, Written::Part);
        smooth(b, sums, marginals, Dispatch { rows: 2, ..Dispatch::default() }, logarithms);
        smooth(b, joint, across, along, logarithms);
        smooth(b, across, joint, down, none);
        let storage = [Buffer(joint), Buffer(marginals), Buffer(&self.range)];
        b.step("mi_range", &storage, Dispatch::default(), 256, 1, Written::Part);
        let table = b.buffer("mi_table", TABLE_BYTES / 4);
        let storage = [Buffer(joint), Buffer(marginals), Buffer(&self.range), Buffer(&table)];
        b.step("mi_table", &storage, Dispatch::default(), 256 * 64, 1, Written::Table);
        planes.table = Some(b.copy_to_texture([64, 256], 256, wgpu::TextureFormat::R32Uint));
        planes.table_bytes = Some(table);
    }
}

/// A table smoothed along one axis.
fn smooth(b: &mut Builder<'_>, from: &wgpu::Buffer, to: &wgpu::Buffer, dispatch: Dispatch, own: SmoothOwn) {
    let dispatch = Dispatch { own: own.into(), ..dispatch };
    b.step("mi_smooth", &[Buffer(from), Buffer(to)], dispatch, 64 * dispatch.rows, 1, Written::Part);
}
