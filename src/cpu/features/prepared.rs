//! A network with its weights in the order in which they are read.

use crate::FeatureNetwork;
use crate::features::{Layer, LayerKind};

/// Outputs of which the weights lie together: a layer has a multiple of them.
pub const TOGETHER: usize = 4;

/// A layer.
pub struct Prepared {
    pub kind: LayerKind,
    pub inputs: usize,
    pub outputs: usize,
    /// Of 3x3 pixels: `[outputs / TOGETHER][input][tap][TOGETHER]`, of a depthwise layer without inputs.
    pub floats: Vec<[f32; TOGETHER]>,
    /// Of points: weights of two inputs as the halves of a number, `[outputs / TOGETHER][inputs / 2][TOGETHER]`.
    pub pairs: Vec<[i32; TOGETHER]>,
    pub bias: Vec<i32>,
    pub multiplier: Vec<i32>,
    pub shift: Vec<u32>,
    /// What values are clamped to.
    pub low: i32,
    pub high: i32,
    /// Rows and columns around a pixel that later layers reach.
    pub after: usize,
}

/// The layers of a network.
pub fn prepared(network: &FeatureNetwork) -> Vec<Prepared> {
    let mut after = network.reach();
    let last = network.layers().len() - 1;
    let layer = |(at, layer): (usize, &Layer)| {
        after -= layer.kind.reach();
        let [low, high] = layer.range(at == last);
        let each = layer.kind.weights(layer.inputs);
        let together = |weight: &dyn Fn(usize, usize) -> i32, count: usize| -> Vec<[i32; TOGETHER]> {
            let of = |i: usize| std::array::from_fn(|j| weight(i / count * TOGETHER + j, i % count));
            (0..layer.outputs / TOGETHER * count).map(of).collect()
        };
        let number = |output: usize, k: usize| i32::from(layer.weights[output * each + k]);
        let pair = |output: usize, k: usize| number(output, 2 * k) & 0xffff | number(output, 2 * k + 1) << 16;
        let (floats, pairs) = match layer.kind {
            LayerKind::Point => (Vec::new(), together(&pair, each / 2)),
            LayerKind::Convolution | LayerKind::Depthwise => (together(&number, each), Vec::new()),
        };
        let floats = floats.into_iter().map(|weights| weights.map(|weight| weight as f32)).collect();
        let Layer { kind, inputs, outputs, ref bias, ref multiplier, ref shift, .. } = *layer;
        let shift = shift.iter().map(|&shift| shift as u32).collect();
        let (bias, multiplier) = (bias.clone(), multiplier.clone());
        Prepared { kind, inputs, outputs, floats, pairs, bias, multiplier, shift, low, high, after }
    };
    network.layers().iter().enumerate().map(layer).collect()
}
