//! The transposed convolution: eight convolutions, one for the outputs that are even or odd along each axis.

use super::activation::{Activation, Source};
use super::convolutions::Finish;
use super::product::{Product, Scratch, Tap, rows_at_once};
use crate::network::Convolution;
use rayon::prelude::*;

/// The taps of an even or odd output 2m or 2m + 1, each with the distance from m of what it reads.
fn taps_of(odd: usize) -> &'static [(usize, isize)] {
    [&[(1, 0)][..], &[(0, 1), (2, 0)]][odd]
}

/// The taps of outputs that are even or odd by plane, row and column, and their weights, `[output channel][tap]`.
fn part(weights: &Convolution, [plane, row, column]: [usize; 3]) -> (Vec<Tap>, Vec<f32>) {
    let shape = weights.weights.shape();
    let (mut taps, mut of_tap) = (Vec::new(), Vec::new());
    for channel in 0..shape[1] {
        for &(i, plane) in taps_of(plane) {
            for &(j, row) in taps_of(row) {
                for &(k, column) in taps_of(column) {
                    taps.push(Tap { channel, plane, row, column });
                    of_tap.push(channel * 27 + i * 9 + j * 3 + k);
                }
            }
        }
    }
    let data = weights.weights.data();
    let of_output = |output: usize| of_tap.iter().map(move |tap| data[output * shape[1] * 27 + tap]);
    let weights = (0..shape[0]).flat_map(of_output).collect();
    (taps, weights)
}

/// Stage `conv3d_transposed`.
pub(super) fn transposed(input: &Activation, weights: &Convolution, finish: Finish<'_>) -> Activation {
    let [_, planes, rows, columns] = input.shape;
    let channels = finish.bias.len();
    let mut made = Activation::new([channels, 2 * planes, 2 * rows, 2 * columns]);
    let parts: Vec<_> = (0..8).map(|i| part(weights, [i >> 2, i >> 1 & 1, i & 1])).collect();
    let at_once = rows_at_once(columns).min(rows);
    // Of a plane, pairs of rows.
    let plane_of = made.data.par_chunks_mut(2 * rows * channels * 2 * columns).enumerate();
    let lots = plane_of.flat_map(|(plane, to)| {
        to.par_chunks_mut(2 * at_once * channels * 2 * columns).enumerate().map(move |(lot, to)| (plane, lot, to))
    });
    lots.for_each_init(Scratch::default, |scratch, (plane, lot, to)| {
        let first = lot * at_once;
        let count = to.len() / (4 * channels * columns);
        let places: Vec<[usize; 2]> = (first..first + count).map(|row| [plane / 2, row]).collect();
        for i in 0..4 {
            let (odd_row, odd_column) = (i >> 1, i & 1);
            let (taps, weights) = &parts[(plane % 2) << 2 | i];
            let product = Product { taps: taps.clone(), weights, stride: 1 };
            let sums = product.compute(Source::One(input), &places, columns, scratch);
            for (j, sums) in sums.chunks_exact(columns).enumerate() {
                let (channel, row) = (j / count, 2 * (j % count) + odd_row);
                let to = &mut to[(row * channels + channel) * 2 * columns + odd_column..][..2 * columns - odd_column];
                to.iter_mut().step_by(2).zip(sums).for_each(|(to, sum)| *to = *sum);
            }
        }
        for (i, to) in to.chunks_exact_mut(2 * columns).enumerate() {
            finish.row(i % channels, [plane, 2 * first + i / channels], to);
        }
    });
    made
}
