//! A network for tests.

use crate::FeatureNetwork;
use crate::features::{Layer, LayerKind};

/// A network of every kind of layer, with relu and without.
pub(crate) fn tiny() -> FeatureNetwork {
    let mut state = 1_u32;
    let mut next = |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % below
    };
    let mut layer = |kind: LayerKind, relu, inputs: usize, outputs: usize, typical: u32| {
        let count = outputs * kind.weights(inputs);
        let weights = (0..count).map(|_| next(255) as i32 - 127).map(|weight| weight as i8).collect();
        let sums = 2920 * ((kind.weights(inputs)) as u32).isqrt();
        let multiplier = (0..outputs).map(|_| ((typical * (next(40_000) + 40_000)) / sums) as i32 + 1).collect();
        let bias = (0..outputs).map(|_| next(6000) as i32 - 3000).collect();
        Layer { kind, relu, inputs, outputs, weights, bias, multiplier, shift: vec![16; outputs] }
    };
    let layers = vec![
        layer(LayerKind::Convolution, true, 1, 12, 50),
        layer(LayerKind::Convolution, false, 12, 20, 50),
        layer(LayerKind::Depthwise, true, 20, 20, 50),
        layer(LayerKind::Point, false, 20, 12, 500),
    ];
    FeatureNetwork::new(layers).unwrap_or_else(|error| unreachable!("{error}"))
}
