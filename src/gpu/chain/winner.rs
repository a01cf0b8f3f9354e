//! From what the cost compares to the winner of both views.

use crate::Method;
use crate::gpu::chain::beliefs::{beliefs, own_of};
use crate::gpu::chain::cost::{Columns, Statistics};
use crate::gpu::chain::paths::{AcrossRows, across_rows};
use crate::gpu::chain::planes::Planes;
use crate::gpu::chain::view_maps::ViewMaps;
use crate::gpu::layout::{Dispatch, Frame, PathOwn, Rows, TEXTURE_ROW, cut};
use crate::gpu::plan::{ROWS_BYTES, parts_and_strip};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};

/// From what the cost compares to the winner of both views.
pub(super) fn winner(b: &mut Builder<'_>, planes: &mut Planes, views: &ViewMaps) {
    match b.params.method {
        // A network has its own winners, and does not come here.
        Method::Bm | Method::Psmnet => block_match(b, planes, views),
        Method::Sgm => {
            let across = across_rows(b, planes);
            along_rows(b, &across, views);
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
fn along_rows(b: &mut Builder<'_>, across: &AcrossRows, views: &ViewMaps) {
    let AcrossRows { along, costs, penalties, paired, unused } = across;
    let frame = b.sizes.frame;
    let most_band = b.sizes.bands.iter().map(|band| band.count).max().unwrap_or(1);
    let strip_rows = b.plan.strip(most_band, b.sizes.volume_row, ROWS_BYTES);
    let room = b.plan.strip_room(most_band, b.sizes.volume_row, ROWS_BYTES);
    let forward = b.buffer_of("sgm_aggregate.forward", b.sizes.volume(strip_rows), room.next_multiple_of(TEXTURE_ROW));
    for (band, &rows) in b.sizes.bands.iter().enumerate() {
        for strip in cut(rows, strip_rows) {
            let volume_row = strip.first - rows.first;
            let dispatch = Dispatch { first_row: strip.first, rows: strip.count, volume_row, ..Dispatch::default() };
            let along_row = Dispatch { lines: strip.count, dx: along[0].dx, dy: along[0].dy, ..dispatch };
            let written =
                Written::Paths { directions: vec![along[0]], band: strip, volume_row: 0, first: true, last: true };
            let storage = [costs[band].bound(), Buffer(&forward), Buffer(&unused[0]), Buffer(&unused[1])];
            let (storage, along_row) = penalties.bound(frame, along[0], &storage, along_row, PathOwn::default());
            b.step("sgm_aggregate", &storage, along_row, strip.count, 1, written);
            let pair = |i: usize| Buffer(&paired[i.min(paired.len() - 1)][band]);
            let ([left_map, right_map], map_row) = views.bound(b, strip);
            let storage = [costs[band].bound(), Buffer(&forward), pair(0), pair(1), pair(2), left_map, right_map];
            let written =
                Written::Views { right: views.right.clone(), last: strip.first + strip.count == frame.height };
            let dispatch = Dispatch { slot: rows.count * frame.volume_stride, map_row, ..dispatch };
            let (storage, dispatch) = penalties.bound(frame, along[1], &storage, dispatch, PathOwn::default());
            b.step("winner", &storage, dispatch, strip.count, 1, written);
        }
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
