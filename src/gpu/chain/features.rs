//! The features that a network makes of the images, for a piece of rows at a time.

use crate::FeatureNetwork;
use crate::features::{Layer, LayerKind};
use crate::gpu::chain::images::Picture;
use crate::gpu::layout::{
    Dispatch, FeatureOwn, Rows, StatisticsOwn, feature_inputs, feature_rows, feature_vectors, packed_features,
};
use crate::gpu::plan;
use crate::gpu::recording::Bound::{Buffer, Texture};
use crate::gpu::recording::{Builder, Written};

/// Rows that an invocation of `feature_depthwise` computes.
const DEPTHWISE_ROWS: u32 = 4;

/// Bins of the histogram, and pixels that are counted in full.
const BINS: u64 = 1024;
const COUNTED: u64 = 8192;

/// A network's weights, and what it makes of both sides.
pub(super) struct Features {
    network: FeatureNetwork,
    weights: wgpu::Buffer,
    /// The first texel of each layer's weights.
    firsts: Vec<u32>,
    /// Of each side.
    statistics: [wgpu::Buffer; 2],
    /// What a layer reads, and what it leaves, in turns.
    values: [wgpu::Buffer; 2],
    /// Of each side.
    pub(super) features: [wgpu::Buffer; 2],
}

impl Features {
    /// With stage `feature_statistics` of both sides; `None` where the cost compares no features.
    pub(super) fn new(b: &mut Builder<'_>, pictures: [&Picture; 2]) -> Option<Self> {
        let (network, sizes) = (b.params.feature_network()?, b.sizes.features?);
        let (words, firsts) = packed_features(&network);
        let weights = b.table("features.weights", words);
        let counts = b.buffer("feature_histogram", 4 * BINS);
        let values = [(); 2].map(|()| b.buffer("features.values", sizes.values));
        let features = ["features.left", "features.right"].map(|name| b.buffer(name, sizes.features));
        let statistics = pictures.map(|picture| statistics(b, picture, &counts));
        Some(Self { network, weights, firsts, statistics, values, features })
    }

    /// Stages `feature_layer` and `features` of some rows of a side.
    pub(super) fn compute(&self, b: &mut Builder<'_>, picture: &Picture, rows: Rows) {
        let side = picture.side;
        let vectors = feature_vectors(b.sizes.frame.width);
        let held = feature_rows(&self.network, rows, b.sizes.frame.height);
        let storage = [Texture(&picture.texels), Buffer(&self.statistics[side]), Buffer(&self.values[0])];
        let dispatch = |rows: Rows| Dispatch { first_row: rows.first, rows: rows.count, ..Dispatch::default() };
        let written = Written::FeatureLayer { side, layer: None, rows: held[0] };
        picture.step(b, "feature_input", &storage, dispatch(held[0]), [vectors, held[0].count], written);
        let mut before = held[0];
        for (at, layer) in self.network.layers().iter().enumerate() {
            let own = self.own(at, layer, before).into();
            let [from, to] = [at % 2, (at + 1) % 2].map(|i| Buffer(&self.values[i]));
            let storage = [from, Buffer(&self.weights), to];
            let written = Written::FeatureLayer { side, layer: Some(at), rows: held[at] };
            let outputs = layer.outputs as u32;
            let rows = held[at].count;
            let (kernel, lines, groups) = match layer.kind {
                LayerKind::Depthwise => ("feature_depthwise", rows.div_ceil(DEPTHWISE_ROWS), outputs / 4),
                LayerKind::Convolution if at > 0 => {
                    ("feature_convolution", rows, outputs.div_ceil(8 * plan::groups(&b.plan)))
                }
                LayerKind::Convolution | LayerKind::Point => {
                    ("feature_point", rows, outputs.div_ceil(8 * plan::groups(&b.plan)))
                }
            };
            let dispatch = Dispatch { own, ..dispatch(held[at]) };
            b.step(kernel, &storage, dispatch, vectors * lines, groups, written);
            before = held[at];
        }
        let last = &self.values[self.network.layers().len() % 2];
        let storage = [Buffer(last), Buffer(&self.features[side])];
        b.step("features", &storage, dispatch(rows), vectors, rows.count, Written::Features { side, rows });
    }

    /// What a layer is told of itself and of the rows that it reads.
    fn own(&self, at: usize, layer: &Layer, before: Rows) -> FeatureOwn {
        let is_last = at + 1 == self.network.layers().len();
        let [lowest, highest] = layer.range(is_last);
        FeatureOwn {
            in_first: before.first,
            in_rows: before.count,
            in_blocks: feature_inputs(at, layer),
            out_blocks: layer.outputs as u32 / 4,
            weights: self.firsts[at],
            lowest,
            highest,
            wide: is_last.into(),
        }
    }
}

/// Stage `feature_statistics` of an image.
fn statistics(b: &mut Builder<'_>, picture: &Picture, counts: &wgpu::Buffer) -> wgpu::Buffer {
    let (side, width, height) = (picture.side, b.sizes.frame.width, b.sizes.frame.height);
    let storage = [Texture(&picture.texels), Buffer(counts)];
    let lines = [feature_vectors(width), height];
    picture.step(b, "feature_histogram", &storage, Dispatch::default(), lines, Written::Part);
    b.clear();
    let pixels = u64::from(width) * u64::from(height);
    let shift = (0..).find(|&shift| pixels >> shift <= COUNTED).unwrap_or(0);
    let dispatch = Dispatch { own: StatisticsOwn { shift }.into(), ..Dispatch::default() };
    let statistics = b.buffer("feature_statistics", 8);
    let storage = [Buffer(counts), Buffer(&statistics)];
    picture.step(b, "feature_statistics", &storage, dispatch, [1, 1], Written::FeatureStatistics { side });
    statistics
}
