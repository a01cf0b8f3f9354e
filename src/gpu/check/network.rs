//! The comparison of the operations of a network with the definition in doubles, computed from what the device made before.

use crate::Network;
use crate::check::StageCheck;
use crate::gpu::check::compare::Comparison;
use crate::gpu::check::expected::Made;
use crate::gpu::layout::{Layers, Place};
use crate::network::{Kind, Operation, Padded};
use crate::reference::{self, Plane, Values};

/// How far a sum may be from the definition: this part of the largest that it could be if nothing in it were negative. A sum of n
/// floats of either sign is off by about the root of n times 2^-24 of that.
const TOLERANCE: f64 = 1e-6;

/// How far a disparity may be from the definition, in pixels.
const TOLERANCE_OF_DISPARITIES: f64 = 1e-3;

/// The output of an operation for a side, from the bytes of the device.
fn values_of(operation: &Operation, padded: &Padded, place: &Place, bytes: &[u8], side: usize) -> Values {
    let mut values = Values::new(operation.shape(padded));
    let [_, planes, rows, columns] = values.shape;
    let numbers: Vec<f32> = bytemuck::pod_collect_to_vec(bytes);
    let pixels = planes * rows * columns;
    for (i, value) in values.data.iter_mut().enumerate() {
        let (channel, pixel) = (i / pixels, i % pixels);
        let block = place.at as usize + channel / 4 * place.stride as usize;
        *value = numbers[4 * (block + side * pixels + pixel) + channel % 4].into();
    }
    values
}

/// The largest absolute value.
fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

/// For each channel of an operation how far values may be from the definition.
fn tolerances(network: &Network, at: usize, inputs: &[&Values], add: Option<&Values>) -> Vec<f64> {
    let operation = &network.operations()[at];
    if operation.kind == Kind::Regression {
        return vec![TOLERANCE_OF_DISPARITIES];
    }
    let read = largest(inputs.iter().flat_map(|input| &input.data)).max(1.0);
    let added = add.map_or(0.0, |add| largest(&add.data));
    let Some(convolution) = network.convolution(&operation.name) else {
        return vec![TOLERANCE * read; operation.channels];
    };
    let each = convolution.weights.data().len() / operation.channels;
    let outputs = convolution.weights.data().chunks_exact(each).zip(&convolution.bias);
    let scale = |(weights, bias): (&[f32], &f32)| {
        let sum: f64 = weights.iter().map(|&weight| f64::from(weight.abs())).sum();
        TOLERANCE * (read * sum + f64::from(bias.abs()) + added)
    };
    outputs.map(scale).collect()
}

fn compare_values(stage: &mut StageCheck, expected: &Values, got: &Values, tolerances: &[f64]) {
    let [_, planes, rows, columns] = expected.shape;
    for (i, (&expected, &got)) in expected.data.iter().zip(&got.data).enumerate() {
        let (x, y, plane) = (i % columns, i / columns % rows, i / columns / rows);
        stage.compare_close([x, y, plane], expected, got, tolerances[plane / planes]);
    }
}

impl Comparison<'_> {
    /// The output of an operation, of all sides that it has.
    pub(super) fn layer(&mut self, at: usize, texel: u32) {
        let level = self.level;
        let (Some(network), Some(layers)) = (&level.params.network, &level.sizes.layers) else { return };
        let operations = network.operations();
        let operation = &operations[at];
        let last = Operation::last_reads(operations);
        // What is joined needs no step.
        while self.expected.made.len() < at {
            let next = &operations[self.expected.made.len()];
            let joined = [0, 1].map(|side| joined(next, &layers.padded, &self.expected.made, side));
            self.expected.made.push(joined);
        }
        let mut sides = [None, None];
        for (side, to) in sides.iter_mut().enumerate().take(if operation.both_sides { 2 } else { 1 }) {
            let got = match operation.kind {
                Kind::Regression => self.disparities(operation.shape(&layers.padded)),
                _ => {
                    let place = Place { at: texel, ..layers.places[at] };
                    values_of(operation, &layers.padded, &place, &self.bytes, side)
                }
            };
            self.layer_of(network, layers, at, side, &got);
            *to = Some(got);
        }
        let made = &mut self.expected.made;
        made.push(sides);
        (0..at).filter(|&earlier| last[earlier] <= at).for_each(|earlier| made[earlier] = [None, None]);
    }

    fn layer_of(&mut self, network: &Network, layers: &Layers, at: usize, side: usize, got: &Values) {
        let operation = &network.operations()[at];
        if operation.kind == Kind::Input {
            let expected = reference::network_input(&self.expected.pair[side], &layers.padded);
            return compare_values(self.stage, &expected, got, &[3.0 * TOLERANCE; 3]);
        }
        let made = &self.expected.made;
        let inputs = inputs(operation, made, side);
        let add = operation.add.and_then(|add| made[add][side].as_ref());
        let corners = self.level.params.align_corners;
        match reference::operation(network, at, &inputs, add, &layers.padded, corners) {
            Ok(expected) => compare_values(self.stage, &expected, got, &tolerances(network, at, &inputs, add)),
            // Without an expectation nothing is right.
            Err(_) => self.stage.mismatches += got.data.len() as u64,
        }
    }

    /// The disparities of all padded pixels.
    fn disparities(&mut self, shape: [usize; 4]) -> Values {
        let numbers: Vec<f32> = bytemuck::pod_collect_to_vec(&self.bytes);
        let [_, _, rows, columns] = shape;
        let frame = &self.level.sizes.frame;
        let (width, height) = (frame.width as usize, frame.height as usize);
        let lines = numbers.chunks_exact(columns).skip(rows - height);
        let data = lines.take(height).flat_map(|line| &line[..width]).copied().collect();
        self.expected.disparities = Some(Plane { width, height, data });
        Values { shape, data: numbers[..rows * columns].iter().map(|&value| value.into()).collect() }
    }

    /// The map, from the disparities of the device.
    pub(super) fn rounded(&mut self) {
        let Some(disparities) = &self.expected.disparities else { return };
        let map = reference::round_disparities(disparities, self.level.params.disparities as usize);
        self.map(&map);
        self.expected.set_network_views(map);
    }
}

/// The channels of all inputs, one input after the other.
fn joined(operation: &Operation, padded: &Padded, made: &Made, side: usize) -> Option<Values> {
    let parts: Option<Vec<&Values>> = operation.inputs.iter().map(|&input| made[input][side].as_ref()).collect();
    let data = parts?.iter().flat_map(|part| &part.data).copied().collect();
    (operation.kind == Kind::Concat).then(|| Values { shape: operation.shape(padded), data })
}

/// What an operation reads of what the device made.
fn inputs<'a>(operation: &Operation, made: &'a Made, side: usize) -> Vec<&'a Values> {
    operation.reads(side).into_iter().filter_map(|(input, side)| made[input][side].as_ref()).collect()
}
