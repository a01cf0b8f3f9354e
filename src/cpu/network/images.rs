//! What is done with images beside convolutions.

use super::activation::Activation;
use crate::ImageView;
use crate::network::Padded;
use crate::reference::{Values, neighbours, network_input};

/// Stage `network_input`.
pub(super) fn input(image: ImageView<'_>, padded: &Padded) -> Activation {
    stored(&network_input(image, padded))
}

/// Values of the definition, rounded and in the order of this schedule.
pub(super) fn stored(values: &Values) -> Activation {
    let [channels, planes, rows, _] = values.shape;
    let mut data = Vec::with_capacity(values.data.len());
    for (plane, row) in (0..planes).flat_map(|plane| (0..rows).map(move |row| (plane, row))) {
        for channel in 0..channels {
            data.extend(values.row(channel, plane, row).iter().map(|&value| value as f32));
        }
    }
    Activation { shape: values.shape, data }
}

/// Stage `average_pool`.
pub(super) fn average_pool(input: &Activation, side: usize) -> Activation {
    let [channels, _, rows, columns] = input.shape;
    let mut made = Activation::new([channels, 1, rows / side, columns / side]);
    let [_, _, _, columns] = made.shape;
    for (i, to) in made.data.chunks_exact_mut(columns).enumerate() {
        let (row, channel) = (i / channels, i % channels);
        for from in row * side..(row + 1) * side {
            let squares = input.row(channel, 0, from).chunks_exact(side);
            to.iter_mut().zip(squares).for_each(|(to, square)| *to += square.iter().sum::<f32>());
        }
        to.iter_mut().for_each(|to| *to /= (side * side) as f32);
    }
    made
}

/// Stage `upsample`.
pub(super) fn upsample(input: &Activation, rows: usize, columns: usize, align_corners: bool) -> Activation {
    let [channels, _, from_rows, from_columns] = input.shape;
    let mut made = Activation::new([channels, 1, rows, columns]);
    let across: Vec<_> = (0..columns).map(|x| neighbours(x, from_columns, columns, align_corners)).collect();
    for (i, to) in made.data.chunks_exact_mut(columns).enumerate() {
        let (row, channel) = (i / channels, i % channels);
        let (above, below, down) = neighbours(row, from_rows, rows, align_corners);
        let [above, below] = [above, below].map(|row| input.row(channel, 0, row));
        for (to, &(left, right, share)) in to.iter_mut().zip(&across) {
            let row = |row: &[f32]| between(row[left], row[right], share as f32);
            *to = between(row(above), row(below), down as f32);
        }
    }
    made
}

/// Between two values, at this share of the second one.
pub(super) fn between(first: f32, second: f32, share: f32) -> f32 {
    (1.0 - share) * first + share * second
}

/// All channels, one input after the other.
pub(super) fn concat(inputs: &[&Activation]) -> Activation {
    let [_, planes, rows, columns] = inputs[0].shape;
    let channels = inputs.iter().map(|input| input.shape[0]).sum();
    let mut data = Vec::with_capacity(channels * planes * rows * columns);
    for row in 0..planes * rows {
        for input in inputs {
            let each = input.shape[0] * columns;
            data.extend_from_slice(&input.data[row * each..][..each]);
        }
    }
    Activation { shape: [channels, planes, rows, columns], data }
}
