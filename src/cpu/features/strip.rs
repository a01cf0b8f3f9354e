//! All layers for a part of the image, row by row.

use std::ops::Range;

use crate::cpu::aligned::Aligned;
use crate::cpu::features::input::Input;
use crate::cpu::features::prepared::Prepared;
use crate::cpu::features::row::{AT_ONCE, From, Row, To};
use crate::cpu::features::vectors::vectors;
use crate::cpu::instructions::Instructions;
use crate::features::LayerKind;

/// Columns of a strip with those that later layers reach: a few times what is computed at once.
const WIDEST: usize = 3 * AT_ONCE;

/// Columns of a strip for a network of this reach.
pub fn strip_columns(reach: usize) -> usize {
    // The first layer reaches furthest, but takes little time, and the second reads one column less.
    WIDEST - 2 * (reach.max(2) - 2)
}

/// What a layer reads: the last three rows, or one in pairs.
enum Buffer {
    Rows([Aligned<f32>; 3]),
    Pairs(Aligned<i32>),
}

/// The buffers of a thread.
pub struct Scratch {
    /// What each layer reads.
    read: Vec<Buffer>,
    /// What the last one makes.
    made: Aligned<i32>,
    stride: usize,
}

impl Scratch {
    pub fn new(layers: &[Prepared], reach: usize) -> Self {
        let stride = (strip_columns(reach) + 2 * reach + 2 + AT_ONCE).next_multiple_of(16);
        let buffer = |layer: &Prepared| match layer.kind {
            LayerKind::Point => Buffer::Pairs(Aligned::zeroed(layer.inputs / 2 * stride)),
            LayerKind::Convolution | LayerKind::Depthwise => {
                Buffer::Rows([(); 3].map(|()| Aligned::zeroed(layer.inputs * stride)))
            }
        };
        let features = layers.last().map_or(0, |layer| layer.outputs);
        Self { read: layers.iter().map(buffer).collect(), made: Aligned::zeroed(features * stride), stride }
    }
}

/// A part of the image.
pub struct Strip<'a> {
    pub input: &'a Input<'a>,
    pub layers: &'a [Prepared],
    pub reach: usize,
    pub columns: Range<usize>,
    pub rows: Range<usize>,
    pub instructions: Instructions,
}

impl Strip<'_> {
    /// Writes the features of the part: `out` begins with the first row, `[row][feature][column of the image]`.
    pub fn compute(&self, scratch: &mut Scratch, out: &mut [u8]) {
        let [width, height] = self.input.size();
        let features = self.layers.last().map_or(0, |layer| layer.outputs);
        // In each step each layer makes a row, as many rows ahead as later layers reach.
        let ahead = 2 * self.reach as i64;
        for step in self.rows.start as i64 - ahead..self.rows.end as i64 {
            let row_of = |after: usize| {
                let row = usize::try_from(step + after as i64).ok()?;
                let rows = self.rows.start.saturating_sub(after)..height.min(self.rows.end + after);
                rows.contains(&row).then_some(row)
            };
            if let Some(row) = row_of(self.reach) {
                self.take_input(row, scratch);
            }
            for (at, layer) in self.layers.iter().enumerate() {
                if let Some(row) = row_of(layer.after) {
                    self.layer(at, row, height, scratch);
                }
            }
            let Some(row) = row_of(0) else { continue };
            let out = &mut out[(row - self.rows.start) * features * width..][..features * width];
            let made = (&scratch.made[..], scratch.stride);
            let first = self.place(self.columns.start);
            let columns = self.columns.clone();
            self.instructions.run(
                #[inline(always)]
                || vectors(made, first, columns, width, out),
            );
        }
    }

    /// Where a column of the image is in the buffers.
    fn place(&self, column: usize) -> usize {
        column + self.reach + 1 - self.columns.start
    }

    /// The columns that are made for a reach of later layers.
    fn columns_of(&self, after: usize) -> Range<usize> {
        let [width, _] = self.input.size();
        self.columns.start.saturating_sub(after)..width.min(self.columns.end + after)
    }

    fn take_input(&self, row: usize, scratch: &mut Scratch) {
        let Scratch { read, stride, .. } = scratch;
        let Some(Buffer::Rows(rows)) = read.first_mut() else { return };
        let (to, columns) = (&mut rows[row % 3], self.columns_of(self.reach));
        let place = self.place(columns.start);
        let out = &mut to[place..place + columns.len()];
        self.instructions.run(
            #[inline(always)]
            || self.input.row(row, columns.start, out),
        );
        self.continue_borders(to, *stride, &columns);
    }

    /// A row of a layer, from what the one before left.
    fn layer(&self, at: usize, row: usize, height: usize, scratch: &mut Scratch) {
        let Scratch { read, made, stride } = scratch;
        let (before, next) = read.split_at_mut(at + 1);
        let from = match &before[at] {
            Buffer::Rows(rows) => {
                let rows_around = [row.saturating_sub(1), row, (row + 1).min(height - 1)];
                From::Rows(rows_around.map(|row| &rows[row % 3][..]))
            }
            Buffer::Pairs(pairs) => From::Pairs(pairs),
        };
        let layer = &self.layers[at];
        let columns = self.columns_of(layer.after);
        let to = match next.first_mut() {
            Some(Buffer::Rows(rows)) => To::Floats(&mut rows[row % 3]),
            Some(Buffer::Pairs(pairs)) => To::Pairs(pairs),
            None => To::Values(made),
        };
        let (start, end) = (self.place(columns.start), self.place(columns.end));
        self.instructions.launch(Row { layer, from, to, stride: *stride, start, end });
        if let Some(Buffer::Rows(rows)) = next.first_mut() {
            self.continue_borders(&mut rows[row % 3], *stride, &columns);
        }
    }

    /// Repeats the first and the last column of the image beyond it.
    fn continue_borders(&self, row: &mut [f32], stride: usize, columns: &Range<usize>) {
        let [width, _] = self.input.size();
        for channel in row.chunks_exact_mut(stride) {
            if columns.start == 0 {
                let first = self.place_of_first();
                channel[first - 1] = channel[first];
            }
            if columns.end == width {
                let end = self.place(width);
                channel[end] = channel[end - 1];
            }
        }
    }

    /// Where column 0 is in the buffers, if they reach it.
    fn place_of_first(&self) -> usize {
        (self.reach + 1).saturating_sub(self.columns.start).max(1)
    }
}
