use crate::features::{Layer, LayerKind};
use rayon::prelude::*;

/// What a layer makes of an image: `data[(channel * height + y) * width + x]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FeatureValues {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values of a pixel.
    pub channels: usize,
    /// The values: -127 to 127, after the last layer -2047 to 2047.
    pub data: Vec<i16>,
}

impl FeatureValues {
    /// The value of the pixel nearest to (x, y) that lies in the image.
    pub fn clamped(&self, channel: usize, x: i64, y: i64) -> i16 {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        self.data[(channel * self.height + y) * self.width + x]
    }
}

/// The rows of all channels with as many pixels around them as a layer reaches, continued by their border.
fn continued(input: &FeatureValues, reach: usize) -> FeatureValues {
    let [width, height] = [input.width, input.height].map(|side| side + 2 * reach);
    let mut data = vec![0; input.channels * height * width];
    data.par_chunks_mut(width).enumerate().for_each(|(row, values)| {
        for (x, value) in values.iter_mut().enumerate() {
            let [x, y] = [x, row % height].map(|at| at as i64 - reach as i64);
            *value = input.clamped(row / height, x, y);
        }
    });
    FeatureValues { width, height, channels: input.channels, data }
}

/// A layer of the stage `features`, its input continued by its border. For each output channel o
///
/// - acc = bias(o) + sum of w(o, c, i, j) v(c, x + i, y + j), over all input channels c, or of a depthwise layer c = o; and over i and j
///   from -1 to 1, or of a layer of points 0;
/// - the value is floor((acc m(o) + 2^(s(o) - 1)) / 2^s(o)), clamped to 0..127 with `relu`, else to -127..127, and in the last layer to
///   -2047..2047.
///
/// [`FeatureNetwork::new`](crate::FeatureNetwork::new) has checked that |acc| < 2^24 and that what is shifted fits 32 bits.
pub fn feature_layer(input: &FeatureValues, layer: &Layer, is_last: bool) -> FeatureValues {
    let FeatureValues { width, height, .. } = *input;
    let [low, high] = layer.range(is_last);
    let reach = layer.kind.reach();
    let around = continued(input, reach);
    let each = layer.kind.weights(layer.inputs);
    let mut data = vec![0; layer.outputs * height * width];
    data.par_chunks_mut(width).enumerate().for_each(|(row, values)| {
        let (output, y) = (row / height, row % height);
        let channels = match layer.kind {
            LayerKind::Depthwise => output..output + 1,
            LayerKind::Convolution | LayerKind::Point => 0..layer.inputs,
        };
        let mut weights = layer.weights[output * each..][..each].iter();
        let mut sums = vec![layer.bias[output]; width];
        for channel in channels {
            for (j, i) in (0..=2 * reach).flat_map(|j| (0..=2 * reach).map(move |i| (j, i))) {
                let Some(&weight) = weights.next() else { return };
                let values = &around.data[(channel * around.height + y + j) * around.width + i..][..width];
                for (sum, &value) in sums.iter_mut().zip(values) {
                    *sum += i32::from(weight) * i32::from(value);
                }
            }
        }
        for (value, sum) in values.iter_mut().zip(sums) {
            let half = 1 << (layer.shift[output] - 1);
            *value = ((sum * layer.multiplier[output] + half) >> layer.shift[output]).clamp(low, high) as i16;
        }
    });
    FeatureValues { width, height, channels: layer.outputs, data }
}
