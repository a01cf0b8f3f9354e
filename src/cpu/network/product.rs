//! A convolution as a product of matrices: the weights, a row an output channel, by what the taps read, a column an output.

use super::activation::Source;
use ndarray::{ArrayView2, ArrayViewMut2, linalg::general_mat_mul};

/// What a tap reads for an output at 0: a channel, and the distance along each axis.
#[derive(Clone, Copy)]
pub(super) struct Tap {
    pub(super) channel: usize,
    pub(super) plane: isize,
    pub(super) row: isize,
    pub(super) column: isize,
}

/// Output channels by taps.
pub(super) struct Product<'a> {
    pub(super) taps: Vec<Tap>,
    /// `[output channel][tap]`.
    pub(super) weights: &'a [f32],
    /// From one output to the next, along each axis.
    pub(super) stride: usize,
}

/// The two matrices of a thread, kept from one lot of rows to the next.
#[derive(Default)]
pub(super) struct Scratch {
    read: Vec<f32>,
    made: Vec<f32>,
}

/// About the columns of a product: enough to be worth it, few enough to stay in the second cache.
const COLUMNS: usize = 128;

/// How many rows of so many columns are computed at a time.
pub(super) fn rows_at_once(columns: usize) -> usize {
    COLUMNS.div_ceil(columns)
}

impl Product<'_> {
    /// The sums for rows of outputs, each given by its plane and row: `[output channel][row][column]`.
    pub(super) fn compute<'s>(
        &self,
        source: Source<'_>,
        rows: &[[usize; 2]],
        columns: usize,
        scratch: &'s mut Scratch,
    ) -> &'s [f32] {
        let n = rows.len() * columns;
        let (k, m) = (self.taps.len(), self.weights.len() / self.taps.len());
        scratch.read.resize(k * n, 0.0);
        scratch.made.resize(m * n, 0.0);
        let (read, made) = (&mut scratch.read[..k * n], &mut scratch.made[..m * n]);
        for (tap, line) in self.taps.iter().zip(read.chunks_exact_mut(n)) {
            for (&[plane, row], to) in rows.iter().zip(line.chunks_exact_mut(columns)) {
                self.gather(source, *tap, plane, row, to);
            }
        }
        multiply(self.weights, read, made, [m, k, n]);
        made
    }

    /// What a tap reads for a row of outputs.
    fn gather(&self, source: Source<'_>, tap: Tap, plane: usize, row: usize, to: &mut [f32]) {
        let at = |output: usize, distance: isize| (output * self.stride) as isize + distance;
        let Some(from) = source.row(tap.channel, at(plane, tap.plane), at(row, tap.row)) else { return to.fill(0.0) };
        // Output x reads values[x * stride + shift].
        let shift = tap.column - from.first as isize;
        let least = |value: isize| usize::try_from(value).unwrap_or(0).div_ceil(self.stride).min(to.len());
        let (start, end) = (least(-shift), least(from.values.len() as isize - shift));
        let start = start.min(end);
        to[..start].fill(0.0);
        to[end..].fill(0.0);
        if start == end {
            return;
        }
        let values = &from.values[((start * self.stride) as isize + shift) as usize..];
        match self.stride {
            1 => to[start..end].copy_from_slice(&values[..end - start]),
            stride => to[start..end].iter_mut().zip(values.iter().step_by(stride)).for_each(|(to, value)| *to = *value),
        }
    }
}

/// `made` becomes `weights` (m x k) times `read` (k x n).
fn multiply(weights: &[f32], read: &[f32], made: &mut [f32], [m, k, n]: [usize; 3]) {
    // A single row fills an eighth of what the library computes at a time.
    if m == 1 {
        made.fill(0.0);
        for (weight, line) in weights.iter().zip(read.chunks_exact(n)) {
            made.iter_mut().zip(line).for_each(|(to, value)| *to += weight * value);
        }
        return;
    }
    let left = ArrayView2::from_shape((m, k), weights);
    let right = ArrayView2::from_shape((k, n), read);
    let to = ArrayViewMut2::from_shape((m, n), made);
    let (Ok(left), Ok(right), Ok(mut to)) = (left, right, to) else { unreachable!("the slices have these sizes") };
    general_mat_mul(1.0, &left, &right, 0.0, &mut to);
}
