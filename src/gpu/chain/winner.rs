//! From what the cost compares to the winner of both views.

use crate::Method;
use crate::gpu::chain::beliefs::{beliefs, own_of};
use crate::gpu::chain::cost::{Columns, Statistics};
use crate::gpu::chain::paths::{Aggregation, aggregation};
use crate::gpu::chain::planes::Planes;
use crate::gpu::chain::view_maps::ViewMaps;
use crate::gpu::layout::{Dispatch, Frame, Rows};
use crate::gpu::plan::parts_and_strip;
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};

/// From what the cost compares to the winner of both views.
pub(super) fn winner(b: &mut Builder<'_>, planes: &mut Planes, views: &ViewMaps) {
    match b.params.method {
        // A network has its own winners, and does not come here.
        Method::Bm | Method::Psmnet => block_match(b, planes, views),
        Method::Sgm => {
            let mut aggregation = aggregation(b, planes);
            if b.params.aggregates_twice() {
                aggregation.first_pass(b);
            }
            aggregation.across_rows(b);
            along_rows(b, &aggregation, views);
        }
        Method::Bp => winner_beliefs(b, planes, views),
    }
}

/// Belief propagation, and its winner, a strip of rows at a time.
fn winner_beliefs(b: &mut Builder<'_>, planes: &mut Planes, views: &ViewMaps) {
    let beliefs = beliefs(b, planes);
    let Frame { height, .. } = b.sizes.frame;
    for (band, &rows) in b.sizes.bands.iter().enumerate() {
        let (maps, map_row) = views.bound(b, rows);
        let storage = [&beliefs.bound(band)[..], &maps].concat();
        let own = own_of(&b.sizes.scales[0], band);
        let dispatch =
            Dispatch { first_row: rows.first, rows: rows.count, map_row, own: own.into(), ..Dispatch::default() };
        let written = Written::Views { right: views.right.clone(), last: rows.end() == height };
        b.step("winner_beliefs", &storage, dispatch, rows.count, 1, written);
    }
}

/// The directions along rows, which end in the stage `winner`, a strip of rows at a time.
fn along_rows(b: &mut Builder<'_>, aggregation: &Aggregation, views: &ViewMaps) {
    let Aggregation { costs, paired, forward, .. } = aggregation;
    let height = b.sizes.frame.height;
    for (band, strip) in aggregation.strips(b) {
        aggregation.rightwards(b, band, strip);
        let pair = |i: usize| Buffer(&paired[i.min(paired.len() - 1)][band]);
        let ([left_map, right_map], map_row) = views.bound(b, strip);
        let storage = [costs[band].bound(), Buffer(forward), pair(0), pair(1), pair(2), left_map, right_map];
        let written = Written::Views { right: views.right.clone(), last: strip.end() == height };
        aggregation.leftwards(b, ("winner", written), (band, strip), &storage, map_row);
    }
}

/// Stage `block_match`.
fn block_match(b: &mut Builder<'_>, planes: &mut Planes, views: &ViewMaps) {
    let Frame { height, .. } = b.sizes.frame;
    let columns = Columns::new(b);
    let statistics = b.params.correlates().then(|| Statistics::new(b));
    let sizes = b.sizes;
    let written = |rows: Rows| Written::Views { right: views.right.clone(), last: rows.end() == height };
    for piece in sizes.pieces.iter().flatten() {
        let place = planes.hold(b, piece);
        if sizes.small_block {
            let rows = piece.rows;
            let [left, right] = &planes.views[..] else { unreachable!("small blocks are matched from textures") };
            let ([left_map, right_map], map_row) = views.bound(b, rows);
            let dispatch = Dispatch { first_row: rows.first, rows: rows.count, map_row, ..place };
            let storage = [Texture(left), Texture(right), left_map, right_map];
            let (parts, strip) = parts_and_strip(b.params.disparities);
            b.step("block_match_small", &storage, dispatch, parts * rows.count.div_ceil(strip), 1, written(rows));
        }
        for &chunk in &piece.chunks {
            let dispatch = columns.compute(b, planes, chunk, place);
            if let Some(statistics) = &statistics {
                statistics.compute(b, planes, chunk, place);
            }
            let known = statistics.as_ref().map_or(&columns.buffer, |statistics| &statistics.buffer);
            let ([left_map, right_map], map_row) = views.bound(b, chunk);
            let storage = [Buffer(&columns.buffer), left_map, right_map, Buffer(known)];
            b.step("block_match", &storage, Dispatch { map_row, ..dispatch }, chunk.count, 1, written(chunk));
        }
    }
}

/// Stage `mirror`: the right view, from the left one of the mirrored pair.
pub(super) fn mirror(b: &mut Builder<'_>, left: &wgpu::Buffer) -> wgpu::Buffer {
    let map_stride = b.sizes.frame.map_stride;
    let map = b.buffer("mirror", b.sizes.map);
    let storage = [left, &map].map(|map| Bound::Rows(map, 4 * u64::from(map_stride)));
    b.step_rows("mirror", &storage, Dispatch::default(), map_stride / 4, 1, Written::Mirrored);
    map
}
