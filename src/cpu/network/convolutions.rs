//! Convolutions of images and of volumes.

use super::activation::{Activation, Source};
use super::product::{Product, Scratch, Tap, rows_at_once};
use crate::network::Convolution;
use rayon::prelude::*;

/// What follows the sums of a convolution.
#[derive(Clone, Copy)]
pub(super) struct Finish<'a> {
    pub(super) bias: &'a [f32],
    /// Added to each value.
    pub(super) add: Option<&'a Activation>,
    /// Negative values become 0.
    pub(super) relu: bool,
}

impl Finish<'_> {
    /// From the sums of a row of an output channel to its values.
    pub(super) fn row(&self, channel: usize, [plane, row]: [usize; 2], to: &mut [f32]) {
        let bias = self.bias[channel];
        match self.add.map(|add| add.row(channel, plane, row)) {
            Some(add) => to.iter_mut().zip(add).for_each(|(to, add)| *to += bias + add),
            None => to.iter_mut().for_each(|to| *to += bias),
        }
        if self.relu {
            to.iter_mut().for_each(|to| *to = to.max(0.0));
        }
    }
}

/// Stages `conv2d` and `conv3d`.
pub(super) fn convolution(
    source: Source<'_>,
    weights: &Convolution,
    [stride, dilation]: [usize; 2],
    finish: Finish<'_>,
) -> Activation {
    let shape = weights.weights.shape();
    let (channels, side) = (shape[0], shape[3]);
    let deep = if shape.len() == 5 { side } else { 1 };
    let [_, planes, rows, columns] = source.shape().map(|side| side.div_ceil(stride));
    let mut made = Activation::new([channels, planes, rows, columns]);
    let product = Product { taps: taps(shape[1], deep, side, dilation), weights: weights.weights.data(), stride };
    let at_once = rows_at_once(columns);
    let lots = made.data.par_chunks_mut(at_once * channels * columns).enumerate();
    lots.for_each_init(Scratch::default, |scratch, (lot, to)| {
        let first = lot * at_once;
        let places: Vec<[usize; 2]> =
            (first..first + to.len() / (channels * columns)).map(|row| [row / rows, row % rows]).collect();
        let sums = product.compute(source, &places, columns, scratch);
        for (i, to) in to.chunks_exact_mut(columns).enumerate() {
            let (row, channel) = (i / channels, i % channels);
            let sums = &sums[(channel * places.len() + row) * columns..][..columns];
            to.copy_from_slice(sums);
            finish.row(channel, places[row], to);
        }
    });
    made
}

/// The taps in the order of the weights.
fn taps(channels: usize, deep: usize, side: usize, dilation: usize) -> Vec<Tap> {
    let away = |tap: usize, taps: usize| (tap as isize - (taps / 2) as isize) * dilation as isize;
    let mut taps = Vec::with_capacity(channels * deep * side * side);
    for channel in 0..channels {
        for tap in 0..deep * side * side {
            let [plane, row, column] = [tap / side / side, tap / side % side, tap % side];
            taps.push(Tap { channel, plane: away(plane, deep), row: away(row, side), column: away(column, side) });
        }
    }
    taps
}
