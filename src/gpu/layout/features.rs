//! Where the values and the weights of a network of features lie.

use crate::FeatureNetwork;
use crate::features::{Layer, LayerKind};
use crate::gpu::layout::request::Request;
use crate::gpu::layout::rows::Rows;

/// Bytes that the values of a layer may take: a piece of rows has no more than keeps a device busy. A piece's layers reach beyond it, so
/// that small ones are slow.
const VALUES_BYTES: u64 = 64 << 20;

/// Channels that the first layer's input has on devices: 3x3 pixels, filled up to a multiple of 4.
const FIRST_INPUTS: usize = 12;

/// Invocations a workgroup of the layers, at least.
const LAYER_LANES: u64 = 32;

/// The values of a network for pieces of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FeatureSizes {
    /// Bytes of the values of any layer.
    pub(crate) values: u64,
    /// Bytes of the features of a side.
    pub(crate) features: u64,
}

/// Vectors of four columns a row.
pub(crate) fn feature_vectors(width: u32) -> u32 {
    width.div_ceil(4)
}

/// Blocks of four bytes that a layer leaves of each pixel: the last one's values have 16 bits.
fn blocks(network: &FeatureNetwork, at: usize) -> u32 {
    let layers = network.layers();
    let words = if at + 1 == layers.len() { 2 } else { 1 };
    words * layers[at].outputs as u32 / 4
}

/// The most of them, also of the first layer's input.
fn most_blocks(network: &FeatureNetwork) -> u64 {
    let most = (0..network.layers().len()).map(|at| blocks(network, at)).max();
    most.unwrap_or(0).max(FIRST_INPUTS as u32 / 4).into()
}

/// Rows by which what any layer leaves reaches beyond a piece, on each side.
fn margin(network: &FeatureNetwork) -> u32 {
    (network.reach() - LayerKind::Convolution.reach()) as u32
}

impl FeatureSizes {
    /// For pieces of at most so many rows.
    pub(super) fn new(request: &Request<'_>, network: &FeatureNetwork, planes_rows: u32) -> Self {
        let row = 16 * u64::from(feature_vectors(request.width));
        let rows = u64::from((planes_rows + 2 * margin(network)).min(request.height));
        let features = row * u64::from(planes_rows) * network.channels() as u64 / 4;
        Self { values: row * rows * most_blocks(network), features }
    }

    /// The most rows of a piece; 0 if there is no room for one. Bytes of a row of values come second.
    pub(super) fn most_rows(request: &Request<'_>, network: &FeatureNetwork) -> (u32, u64) {
        let vectors = u64::from(feature_vectors(request.width));
        let row = 16 * vectors * most_blocks(network);
        let fit = request.binding().min(VALUES_BYTES) / row;
        let dispatched = LAYER_LANES * u64::from(request.most_side()) / vectors;
        let most = fit.min(dispatched).min(request.height.into()) as u32;
        (if most == request.height { most } else { most.saturating_sub(2 * margin(network)) }, row)
    }
}

/// The rows that each layer leaves, so that the last one leaves `rows`.
pub(crate) fn feature_rows(network: &FeatureNetwork, rows: Rows, height: u32) -> Vec<Rows> {
    let mut needed = rows;
    let mut all: Vec<Rows> = network
        .layers()
        .iter()
        .rev()
        .map(|layer| {
            let left = needed;
            let reach = layer.kind.reach() as u32;
            let first = needed.first.saturating_sub(reach);
            needed = Rows { first, count: (left.end() + reach).min(height) - first };
            left
        })
        .collect();
    all.reverse();
    all
}

/// The blocks of inputs of a layer, as kernels count them.
pub(crate) fn feature_inputs(at: usize, layer: &Layer) -> u32 {
    (if at == 0 { FIRST_INPUTS } else { layer.inputs }) as u32 / 4
}

/// The weights of a network as the kernels read them, four words a texel, and the first texel of each layer.
pub(crate) fn packed_features(network: &FeatureNetwork) -> (Vec<u32>, Vec<u32>) {
    let mut words = Vec::new();
    let firsts = network.layers().iter().enumerate().map(|(at, layer)| {
        let first = words.len() as u32 / 4;
        match (at, layer.kind) {
            (0, _) => pack_points(layer, 9, &mut words),
            (_, LayerKind::Point) => pack_points(layer, layer.inputs, &mut words),
            (_, LayerKind::Convolution) => pack_convolution(layer, &mut words),
            (_, LayerKind::Depthwise) => pack_depthwise(layer, &mut words),
        }
        first
    });
    let firsts = firsts.collect();
    (words, firsts)
}

/// Four weights in a word.
fn word(weight: impl Fn(usize) -> i8) -> u32 {
    u32::from_le_bytes([0, 1, 2, 3].map(|i| weight(i) as u8))
}

/// Of each group of eight outputs what [`numbers`] says, then a step's words of each output. Outputs beyond the last one are 0.
fn pack_groups(layer: &Layer, steps: usize, words_of: impl Fn(usize, usize) -> [u32; 4], words: &mut Vec<u32>) {
    for group in (0..layer.outputs).step_by(8) {
        for output in group..group + 8 {
            let of = |numbers: &[i32], none| numbers.get(output).copied().unwrap_or(none) as u32;
            words.extend([of(&layer.bias, 0), of(&layer.multiplier, 1), of(&layer.shift, 1), 0]);
        }
        for step in 0..steps {
            for output in group..group + 8 {
                words.extend(if output < layer.outputs { words_of(output, step) } else { [0; 4] });
            }
        }
    }
}

/// A step is sixteen inputs, four a word; those beyond the last one are 0.
fn pack_points(layer: &Layer, inputs: usize, words: &mut Vec<u32>) {
    let weight = |output: usize, input: usize| if input < inputs { layer.weights[output * inputs + input] } else { 0 };
    let step = |output, step| [0, 1, 2, 3].map(|k| word(|i| weight(output, 16 * step + 4 * k + i)));
    pack_groups(layer, inputs.div_ceil(16), step, words);
}

/// A step is a row of four inputs, a column a word.
fn pack_convolution(layer: &Layer, words: &mut Vec<u32>) {
    let words_of = |output: usize, step: usize| {
        let (block, row) = (step / 3, step % 3);
        let weight = |input: usize, column| layer.weights[((output * layer.inputs + input) * 3 + row) * 3 + column];
        [0, 1, 2, 3].map(|column| if column < 3 { word(|i| weight(4 * block + i, column)) } else { 0 })
    };
    pack_groups(layer, 3 * layer.inputs / 4, words_of, words);
}

/// Of each four channels eight texels: three rows of three words, biases, multipliers, shifts, and two that are not read.
fn pack_depthwise(layer: &Layer, words: &mut Vec<u32>) {
    for first in (0..layer.outputs).step_by(4) {
        for row in 0..3 {
            let column = |column| word(|i| layer.weights[(first + i) * 9 + 3 * row + column]);
            words.extend([column(0), column(1), column(2), 0]);
        }
        for numbers in [&layer.bias, &layer.multiplier, &layer.shift] {
            words.extend(numbers[first..first + 4].iter().map(|&number| number as u32));
        }
        words.extend([0; 8]);
    }
}
