//! The network that comes with the library.

use std::sync::OnceLock;

use crate::FeatureNetwork;
use crate::features::layer::{Layer, LayerKind};

/// Its layers: kind, relu, channels that are read and made.
const LAYERS: [(LayerKind, bool, usize, usize); 9] = [
    (LayerKind::Convolution, true, 1, 64),
    (LayerKind::Depthwise, false, 64, 64),
    (LayerKind::Point, true, 64, 64),
    (LayerKind::Depthwise, false, 64, 64),
    (LayerKind::Point, true, 64, 64),
    (LayerKind::Depthwise, false, 64, 64),
    (LayerKind::Point, true, 64, 64),
    (LayerKind::Depthwise, false, 64, 64),
    (LayerKind::Point, false, 64, 64),
];

/// Of each layer in turn the weights, a byte each, then biases, multipliers and shifts, four bytes each, the lowest first.
static NUMBERS: &[u8] = include_bytes!("weights.bin");

impl FeatureNetwork {
    /// The network that comes with the library: 3x3 pixels to 64 channels, then four times a depthwise layer and one of points, 64
    /// features. They depend on 11x11 pixels.
    ///
    /// # Panics
    /// Never: a test makes it.
    #[must_use]
    pub fn built_in() -> Self {
        static BUILT_IN: OnceLock<FeatureNetwork> = OnceLock::new();
        BUILT_IN
            .get_or_init(|| made().unwrap_or_else(|| unreachable!("the built-in network is checked by a test")))
            .clone()
    }
}

/// The network of [`LAYERS`] and [`NUMBERS`].
fn made() -> Option<FeatureNetwork> {
    let mut numbers = NUMBERS;
    let mut layers = Vec::new();
    for (kind, relu, inputs, outputs) in LAYERS {
        let (weights, rest) = numbers.split_at_checked(outputs * kind.weights(inputs))?;
        numbers = rest;
        let mut next = || {
            let (words, rest) = numbers.split_at_checked(4 * outputs)?;
            numbers = rest;
            Some(words.as_chunks().0.iter().map(|word| i32::from_le_bytes(*word)).collect())
        };
        let (bias, multiplier, shift) = (next()?, next()?, next()?);
        let weights = weights.iter().map(|&byte| byte as i8).collect();
        layers.push(Layer { kind, relu, inputs, outputs, weights, bias, multiplier, shift });
    }
    if !numbers.is_empty() {
        return None;
    }
    FeatureNetwork::new(layers).ok()
}
