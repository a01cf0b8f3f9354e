//! A network of every kind of operation, with few channels: for tests of what computes it.

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};

use super::graph::{Extent, Kind, Operation, Parameters};
use super::network::{Convolution, Network};
use super::tensor::Tensor;

/// The list of its operations.
struct List(Vec<Operation>);

impl List {
    fn add(&mut self, kind: Kind, inputs: &[usize], channels: usize, extent: Extent) -> usize {
        let convolves =
            matches!(kind, Kind::Conv2d { .. } | Kind::VolumeConv3d | Kind::Conv3d { .. } | Kind::TransposedConv3d);
        let name = format!("operation{}", self.0.len());
        let both_sides = !matches!(extent, Extent::Volume(_)) && kind != Kind::Regression;
        let parameters = convolves.then(|| Parameters { convolution: name.clone(), norm: None });
        let inputs = inputs.to_vec();
        self.0.push(Operation { name, kind, inputs, add: None, relu: false, channels, extent, both_sides, parameters });
        self.0.len() - 1
    }

    fn plus(&mut self, add: Option<usize>, relu: bool) {
        if let Some(last) = self.0.last_mut() {
            (last.add, last.relu) = (add, relu);
        }
    }
}

fn operations() -> Vec<Operation> {
    let conv = |kernel, stride, dilation| Kind::Conv2d { kernel, stride, dilation };
    let (same, half) = (Kind::Conv3d { stride: 1 }, Kind::Conv3d { stride: 2 });
    let mut list = List(Vec::new());
    let [full, second, quarter] = [0, 1, 2].map(Extent::Image);
    let input = list.add(Kind::Input, &[], 3, full);
    let first = list.add(conv(3, 2, 1), &[input], 6, second);
    list.plus(None, true);
    let first = list.add(conv(3, 1, 1), &[first], 5, second);
    let residual = list.add(conv(1, 2, 1), &[first], 8, quarter);
    let middle = list.add(conv(3, 2, 1), &[first], 8, quarter);
    list.plus(Some(residual), false);
    let last = list.add(conv(3, 1, 2), &[middle], 8, quarter);
    list.plus(Some(middle), true);
    let mut parts = vec![middle, last];
    for side in [8, 64] {
        let pooled = list.add(Kind::AveragePool { side }, &[last], 8, Extent::Pooled(side));
        let narrow = list.add(conv(1, 1, 1), &[pooled], 4, Extent::Pooled(side));
        parts.push(list.add(Kind::Upsample, &[narrow, last], 4, quarter));
    }
    let joined = list.add(Kind::Concat, &parts, 24, quarter);
    let wide = list.add(conv(3, 1, 1), &[joined], 10, quarter);
    list.plus(None, true);
    let features = list.add(conv(1, 1, 1), &[wide], 8, quarter);
    let cost = list.add(Kind::VolumeConv3d, &[features], 6, Extent::Volume(2));
    list.plus(None, true);
    let cost = list.add(same, &[cost], 6, Extent::Volume(2));
    let down = list.add(half, &[cost], 8, Extent::Volume(3));
    list.plus(None, true);
    let bottom = list.add(half, &[down], 9, Extent::Volume(4));
    let up = list.add(Kind::TransposedConv3d, &[bottom], 8, Extent::Volume(3));
    list.plus(Some(down), true);
    let out = list.add(Kind::TransposedConv3d, &[up], 6, Extent::Volume(2));
    list.plus(Some(cost), false);
    let scores = list.add(same, &[cost], 1, Extent::Volume(2));
    let more = list.add(same, &[out], 1, Extent::Volume(2));
    list.plus(Some(scores), false);
    list.add(Kind::Regression, &[more], 1, full);
    list.0
}

/// The network, with weights from a seed.
pub(crate) fn tiny(seed: u64) -> Network {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let operations = operations();
    let mut convolutions = BTreeMap::new();
    for operation in &operations {
        let Some(shape) = operation.weights(&operations) else { continue };
        let each = shape[1..].iter().product::<usize>();
        // Values stay about as large as they are; of the last ones some planes stand out.
        let largest = if operation.channels == 1 { 8.0 } else { 2.0 } / (each as f32).sqrt();
        let data = (0..shape[0] * each).map(|_| random.random_range(-largest..largest)).collect();
        let bias = (0..shape[0]).map(|_| random.random_range(-0.3..0.3)).collect();
        let weights = Tensor::new(shape, data).unwrap();
        convolutions.insert(operation.name.clone(), Convolution { weights, bias });
    }
    Network::of(super::Architecture::Basic, operations, convolutions)
}
