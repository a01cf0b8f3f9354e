//! From the bytes of the device's buffers to maps.

use crate::gpu::layout::{Frame, Sizes};
use crate::gpu::map_layout::{MapFormat, MapLayout};
use crate::{ConfidenceMap, DepthMap, DisparityMap, Labels, Matched, Params, Unrounded};

/// The bytes of the maps of a frame, in the order in which they lie in the buffer that is read back.
#[derive(Clone, Debug)]
pub(crate) struct MapBytes {
    frame: Frame,
    /// Bytes of a map.
    pub(crate) map: u64,
    /// Whether there is a right view.
    right: bool,
    /// Bytes of the confidence, if there is one.
    pub(crate) confidence: Option<u64>,
    /// Bytes of the labels, if there are any: of a map, and of what pairs of values cost, if the cost is looked up.
    pub(crate) labels: Option<[u64; 2]>,
    /// Bytes of the disparities of a network, if they are asked for, and columns a row of them.
    pub(crate) unrounded: Option<[u64; 2]>,
    /// Bytes of the depth, if there is one.
    pub(crate) depth: Option<u64>,
}

impl MapBytes {
    pub(crate) fn new(params: &Params, sizes: &Sizes) -> Self {
        let confidence = params.confidence.then_some(sizes.confidence);
        let depth = params.depth.is_some().then_some(sizes.regions);
        let table = if params.has_table() { 256 * 256 } else { 0 };
        let labels = params.has_labels().then_some([sizes.map, table]);
        let unrounded = sizes.layers.as_ref().filter(|_| params.unrounded);
        let unrounded = unrounded.map(|layers| [layers.disparities, layers.padded.width as u64]);
        Self { frame: sizes.frame, map: sizes.map, right: params.right_map, confidence, labels, unrounded, depth }
    }

    pub(crate) fn bytes(&self) -> u64 {
        let right = if self.right { self.map } else { 0 };
        let labels: u64 = self.labels.iter().flatten().sum();
        let unrounded = self.unrounded.map_or(0, |[bytes, _]| bytes);
        self.map + right + self.confidence.unwrap_or(0) + labels + unrounded + self.depth.unwrap_or(0)
    }

    pub(crate) fn matched(&self, bytes: &[u8]) -> Matched {
        let map = self.map as usize;
        let (left, rest) = bytes.split_at(map);
        let (right, rest) = rest.split_at(if self.right { map } else { 0 });
        let (confidence, rest) = rest.split_at(self.confidence.unwrap_or(0) as usize);
        let [labels, table] = self.labels.unwrap_or_default().map(|bytes| bytes as usize);
        let (labels, rest) = rest.split_at(labels);
        let (table, rest) = rest.split_at(table);
        let [unrounded_bytes, columns] = self.unrounded.unwrap_or_default().map(|number| number as usize);
        let (unrounded, depth) = rest.split_at(unrounded_bytes);
        Matched {
            map: map_of(&self.frame, left),
            right: self.right.then(|| map_of(&self.frame, right)),
            confidence: self.confidence.map(|_| confidence_of(&self.frame, confidence)),
            labels: self.labels.map(|_| labels_of(&self.frame, labels, table)),
            unrounded: self.unrounded.map(|_| unrounded_of(&self.frame, columns, unrounded)),
            depth: self.depth.map(|_| depth_of(&self.frame, depth)),
        }
    }
}

/// Labels from the bytes of their buffers.
pub(crate) fn labels_of(frame: &Frame, bytes: &[u8], table: &[u8]) -> Labels {
    let DisparityMap { width, height, data } = map_of(frame, bytes);
    Labels { width, height, data: data.into_iter().map(|label| label as u16).collect(), table: table.to_vec() }
}

/// The disparities of a network from the bytes of their buffer: what lies on the image, the last rows and the first columns.
pub(crate) fn unrounded_of(frame: &Frame, columns: usize, bytes: &[u8]) -> Unrounded {
    let Frame { width, height, .. } = *frame;
    let rows = bytes.chunks_exact(4 * columns);
    let skipped = rows.len() - height as usize;
    let row = |row: &[u8]| bytemuck::pod_collect_to_vec::<u8, f32>(&row[..4 * width as usize]);
    Unrounded { width, height, data: rows.skip(skipped).flat_map(row).collect() }
}

/// A disparity map from the bytes of its buffer.
pub(crate) fn map_of(frame: &Frame, bytes: &[u8]) -> DisparityMap {
    let layout = MapLayout::new(MapFormat::Disparity, frame);
    DisparityMap { width: frame.width, height: frame.height, data: layout.pixels(bytes, i16::from_le_bytes) }
}

/// A confidence from the bytes of its buffer.
pub(crate) fn confidence_of(frame: &Frame, bytes: &[u8]) -> ConfidenceMap {
    let layout = MapLayout::new(MapFormat::Confidence, frame);
    ConfidenceMap { width: frame.width, height: frame.height, data: layout.pixels(bytes, |[value]| value) }
}

/// A depth from the bytes of its buffer.
pub(crate) fn depth_of(frame: &Frame, bytes: &[u8]) -> DepthMap {
    let layout = MapLayout::new(MapFormat::Depth, frame);
    DepthMap { width: frame.width, height: frame.height, data: layout.pixels(bytes, u32::from_le_bytes) }
}
