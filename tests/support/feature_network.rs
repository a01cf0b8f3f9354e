use gpu_stereo::FeatureNetwork;
use gpu_stereo::features::{Layer, LayerKind};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A network of features from a seed: one to six layers of few channels, with weights that make most of the range of values.
pub fn feature_network(random: &mut ChaCha8Rng) -> FeatureNetwork {
    let count = random.random_range(1..=6);
    let mut inputs = 1;
    let layers = (0..count).map(|at| {
        let kind = if at == 0 { LayerKind::Convolution } else { LayerKind::ALL[random.random_range(0..3)] };
        // The last one has at least eight features, so that the one before a depthwise layer needs them, too.
        let outputs = if kind == LayerKind::Depthwise { inputs } else { 4 * random.random_range(2..=5) };
        let each = kind.weights(inputs);
        let weights = (0..outputs * each).map(|_| random.random_range(-127..=127)).collect();
        // Sums of about 40 * 73 * the root of their number become about 50, or 500 in the end.
        let typical = 2920.0 * f64::from(each as u32).sqrt() / if at + 1 == count { 500.0 } else { 50.0 };
        let numbers = |random: &mut ChaCha8Rng| -> (i32, i32) {
            let shift = random.random_range(9..=13);
            ((f64::from(1 << shift) / typical * random.random_range(0.5..2.0)) as i32 + 1, shift)
        };
        let (multiplier, shift) = (0..outputs).map(|_| numbers(random)).unzip();
        let bias = (0..outputs).map(|_| random.random_range(-3000..3000)).collect();
        let relu = at + 1 < count && random.random();
        let layer = Layer { kind, relu, inputs, outputs, weights, bias, multiplier, shift };
        inputs = outputs;
        layer
    });
    FeatureNetwork::new(layers.collect()).unwrap()
}
