//! The comparison of what a network of features leaves.

use crate::gpu::check::compare::Comparison;
use crate::gpu::check::expected::{Expected, LayerValues};
use crate::gpu::layout::{Rows, feature_vectors};
use crate::reference::{self, FeatureStatistics, FeatureValues};

impl Expected {
    fn feature_statistics(&self, side: usize) -> FeatureStatistics {
        let images = &self.prefiltered[side];
        reference::feature_statistics(&images.channels[0], images.unit)
    }

    /// What a layer leaves of the whole image: from that of the layer before, if that was asked for last.
    fn layer_values(&mut self, side: usize, layer: Option<usize>) -> Option<&FeatureValues> {
        let network = self.params.feature_network()?;
        let known = self.layer_values.take();
        let fits = |known: &LayerValues| known.side == side && known.layer <= layer;
        let LayerValues { layer: reached, mut values, .. } = known.filter(fits).unwrap_or_else(|| {
            let images = &self.prefiltered[side];
            let values = reference::feature_input(&images.channels[0], images.unit, self.feature_statistics(side));
            LayerValues { side, layer: None, values }
        });
        let next = reached.map_or(0, |reached| reached + 1);
        for at in next..layer.map_or(0, |layer| layer + 1) {
            let layers = network.layers();
            values = reference::feature_layer(&values, &layers[at], at + 1 == layers.len());
        }
        Some(&self.layer_values.insert(LayerValues { side, layer, values }).values)
    }
}

impl Comparison<'_> {
    pub(super) fn feature_statistics(&mut self, side: usize) {
        let FeatureStatistics { mean, deviation } = self.expected.feature_statistics(side);
        let got = bytemuck::pod_collect_to_vec::<u8, u32>(&self.bytes);
        for (i, (expected, got)) in [mean, deviation].into_iter().zip(got).enumerate() {
            self.stage.compare(i, side, None, expected.into(), got.into());
        }
    }

    /// What a layer left of some rows; the values of a pixel are told as disparities.
    pub(super) fn feature_layer(&mut self, side: usize, layer: Option<usize>, held: Rows) {
        let Some(network) = self.level.params.feature_network() else { return };
        let is_last = layer.is_some_and(|at| at + 1 == network.layers().len());
        let width = self.level.sizes.frame.width;
        let Some(expected) = self.expected.layer_values(side, layer) else { return };
        // Devices keep the 3x3 values that the first layer sums over.
        let channels = if layer.is_some() { expected.channels } else { 12 };
        let of = |channel: usize, x: i64, y: i64| match layer {
            Some(_) => expected.clamped(channel, x, y),
            None if channel < 9 => expected.clamped(0, x + channel as i64 % 3 - 1, y + channel as i64 / 3 - 1),
            None => 0,
        };
        let each = if is_last { 2 } else { 4 };
        for_each_word(&self.bytes, width, held, channels / each, |block, x, y, word| {
            let bytes = word.to_le_bytes();
            for i in 0..each {
                let got = match is_last {
                    true => i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]),
                    false => (bytes[i] as i8).into(),
                };
                let channel = block * each + i;
                self.stage.compare(x, y, Some(channel), of(channel, x as i64, y as i64).into(), got.into());
            }
        });
    }

    /// The features of some rows: the last of the descriptors.
    pub(super) fn features(&mut self, side: usize, held: Rows) {
        let (features, width) = (self.level.params.feature_planes() as usize, self.level.sizes.frame.width);
        let descriptors = &self.expected.pyramid[0][side];
        let first = descriptors.planes - features;
        for_each_word(&self.bytes, width, held, features / 4, |block, x, y, word| {
            for (i, byte) in word.to_le_bytes().into_iter().enumerate() {
                let plane = first + 4 * block + i;
                let expected = i64::from(descriptors.clamped(x as i64, y as i64)[plane]) - 128;
                self.stage.compare(x, y, Some(4 * block + i), expected, i64::from(byte as i8));
            }
        });
    }
}

/// The words of so many blocks of some rows: the block, the pixel and the word. Columns beyond the border are among them.
fn for_each_word(bytes: &[u8], width: u32, held: Rows, blocks: usize, mut work: impl FnMut(usize, usize, usize, u32)) {
    let (columns, rows) = (4 * feature_vectors(width) as usize, held.count as usize);
    let words = bytemuck::pod_collect_to_vec::<u8, u32>(bytes);
    for (i, &word) in words.iter().enumerate().take(blocks * rows * columns) {
        let (line, x) = (i / columns, i % columns);
        work(line / rows, x, held.first as usize + line % rows, word);
    }
}
