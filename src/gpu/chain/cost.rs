//! From the planes to the matching cost of every disparity.

use crate::gpu::chain::planes::Planes;
use crate::gpu::layout::{Dispatch, Frame, Piece, Rows, Sizes, TEXELS, TEXTURE_ROW, feature_vectors};
use crate::gpu::plan;
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};

/// Rows of the largest chunk.
fn most_rows(b: &Builder<'_>) -> u64 {
    b.sizes.pieces.iter().flatten().flat_map(|piece| &piece.chunks).map(|chunk| chunk.count).max().unwrap_or(0).into()
}

/// Column sums for one chunk of rows at a time.
pub(super) struct Columns {
    pub(super) buffer: wgpu::Buffer,
}

impl Columns {
    pub(super) fn new(b: &mut Builder<'_>) -> Self {
        let Sizes { columns_row, columns_room, .. } = *b.sizes;
        Self { buffer: b.buffer_of("cost_columns", most_rows(b) * columns_row, columns_room) }
    }

    /// Stage `cost_columns` for the rows of `chunk`.
    pub(super) fn compute(&self, b: &mut Builder<'_>, planes: &Planes, chunk: Rows, place: Dispatch) -> Dispatch {
        let dispatch = Dispatch { first_row: chunk.first, rows: chunk.count, ..place };
        let quads = b.params.quads();
        if let Some(features) = &planes.features {
            let storage = planes.with_planes(b, features, &self.buffer);
            let invocations = (b.sizes.frame.width + 2 * b.params.radius()) * quads;
            let segments = chunk.count.div_ceil(plan::FEATURE_SEGMENT);
            b.step("cost_columns_features", &storage, dispatch, invocations, segments, Written::Columns { chunk });
            return dispatch;
        }
        let invocations = (b.sizes.frame.width + 2 * b.params.radius()) * (quads / plan::vectors(quads, &b.plan));
        let segments = chunk.count.div_ceil(plan::segment(&b.plan));
        let [left, right] = &planes.buffers;
        let storage = planes.with_table(&[Buffer(left), Buffer(right), Buffer(&self.buffer)]);
        b.step("cost_columns", &storage, dispatch, invocations, segments, Written::Columns { chunk });
        dispatch
    }
}

/// Statistics of the blocks of both sides, for one chunk of rows at a time.
pub(super) struct Statistics {
    pub(super) buffer: wgpu::Buffer,
}

impl Statistics {
    pub(super) fn new(b: &mut Builder<'_>) -> Self {
        let Sizes { statistics_row, columns_room, .. } = *b.sizes;
        Self { buffer: b.buffer_of("block_statistics", most_rows(b) * statistics_row, columns_room) }
    }

    /// Stage `block_statistics` for the rows of `chunk`.
    pub(super) fn compute(&self, b: &mut Builder<'_>, planes: &Planes, chunk: Rows, place: Dispatch) {
        let Frame { width, left_stride, right_stride, .. } = b.sizes.frame;
        let right_blocks = width + b.params.disparities - 1;
        let sides = [(0, width, left_stride), (width, right_blocks, right_stride)];
        for (side, (first_line, lines, stride)) in sides.into_iter().enumerate() {
            let dispatch = Dispatch { first_row: chunk.first, rows: chunk.count, first_line, lines, stride, ..place };
            let segments = chunk.count.div_ceil(plan::segment(&b.plan));
            let storage = [Buffer(&planes.buffers[side]), Buffer(&self.buffer)];
            let written = Written::BlockStatistics { side, chunk };
            b.step("block_statistics", &storage, dispatch, lines.div_ceil(4), segments, written);
        }
    }
}

/// Stage `matching_cost` into `computed`, a buffer a band. Returns where the cost is read: there, or from a texture that it is
/// copied into.
pub(super) fn matching_cost(b: &mut Builder<'_>, planes: &mut Planes, computed: &[wgpu::Buffer]) -> Vec<CostVolume> {
    let columns = Columns::new(b);
    let sizes = b.sizes;
    let mut costs = Vec::new();
    for (band, (&rows, pieces)) in sizes.bands.iter().zip(&sizes.pieces).enumerate() {
        let cost = &computed[band];
        for piece in pieces {
            let place = planes.hold(b, piece);
            let volume_row = piece.rows.first - rows.first;
            if sizes.small_block {
                small_cost(b, planes, piece, Dispatch { volume_row, ..place }, cost);
            }
            for &chunk in &piece.chunks {
                let volume_row = chunk.first - rows.first;
                let dispatch = Dispatch { volume_row, ..columns.compute(b, planes, chunk, place) };
                let written = Written::Cost { chunk, volume_row };
                let spans = sizes.frame.width.div_ceil(plan::span(&b.plan));
                let lines = chunk.count * b.params.quads();
                b.step("matching_cost", &[Buffer(&columns.buffer), Buffer(cost)], dispatch, lines, spans, written);
            }
        }
        costs.push(if b.plan.per_subgroup {
            CostVolume::Buffer(cost.clone())
        } else {
            let [bytes, room] = [rows, sizes.bands[0]].map(|rows| sizes.volume(rows.count));
            CostVolume::Texture(b.copy_first_to_texels(bytes, room))
        });
    }
    costs
}

/// The cost of the rows of a piece by small blocks.
fn small_cost(b: &mut Builder<'_>, planes: &Planes, piece: &Piece, place: Dispatch, cost: &wgpu::Buffer) {
    let (rows, quads) = (piece.rows, b.params.quads());
    let dispatch = Dispatch { first_row: rows.first, rows: rows.count, ..place };
    let written = Written::Cost { chunk: rows, volume_row: place.volume_row };
    if let Some(features) = &planes.features {
        let storage = planes.with_planes(b, features, cost);
        let lines = feature_vectors(b.sizes.frame.width) * quads;
        b.step("matching_cost_features", &storage, dispatch, lines, rows.count, written);
        return;
    }
    if b.plan.per_subgroup {
        let [left, right] = &planes.buffers;
        let storage = planes.with_table(&[Buffer(left), Buffer(right), Buffer(cost)]);
        let segments = rows.count.div_ceil(plan::segment(&b.plan));
        b.step("matching_cost_parallel", &storage, dispatch, b.sizes.frame.width * quads, segments, written);
        return;
    }
    let [left, right] = [0, 1].map(|side: usize| Texture(&planes.views[side]));
    let storage = planes.with_table(&[left, right, Buffer(cost)]);
    let (kernel, lines) = match b.params.block {
        1 => ("matching_cost_pixels", rows.count),
        _ => ("matching_cost_small", rows.count.div_ceil(2)),
    };
    b.step(kernel, &storage, dispatch, lines * quads, 1, written);
}

/// Where the cost of a band is read.
pub(super) enum CostVolume {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
}

impl CostVolume {
    /// Goes on with the cost that the last step left in `computed` for some rows, a band: it is copied into the texture, or the two
    /// buffers change places.
    pub(super) fn replace(&mut self, b: &mut Builder<'_>, rows: Rows, computed: &mut wgpu::Buffer) {
        match self {
            Self::Buffer(buffer) => std::mem::swap(buffer, computed),
            Self::Texture(view) => {
                let texels = (b.sizes.volume(rows.count) / TEXTURE_ROW) as u32;
                b.copy_into(view.texture(), [TEXELS, texels]);
            }
        }
    }

    pub(super) fn bound(&self) -> Bound<'_> {
        match self {
            Self::Buffer(buffer) => Buffer(buffer),
            Self::Texture(view) => Texture(view),
        }
    }
}
