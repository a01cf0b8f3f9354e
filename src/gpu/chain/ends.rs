//! Where the chain begins and ends.

use crate::DisparityMap;
use crate::gpu::layout::Sizes;

/// Both ends of the chain: the textures that it starts from, and the buffers of the maps that it leaves.
#[derive(Debug)]
pub(crate) struct Ends {
    /// The textures into which images are uploaded.
    pub(crate) sources: [wgpu::Texture; 2],
    /// The map that is read back.
    pub(crate) output: wgpu::Buffer,
    /// The right view, if it is wanted.
    pub(crate) right: Option<wgpu::Buffer>,
    /// The confidence of the map, if it is wanted.
    pub(crate) confidence: Option<wgpu::Buffer>,
    /// The labels, if they are wanted.
    pub(crate) labels: Option<LabelEnds>,
    /// The disparities of the network, if they are wanted.
    pub(crate) unrounded: Option<wgpu::Buffer>,
    /// The depth of the map, if it is wanted.
    pub(crate) depth: Option<wgpu::Buffer>,
}

/// The buffers of the labels.
#[derive(Debug)]
pub(crate) struct LabelEnds {
    /// Ends with the labels, laid out like a map.
    pub(crate) right_map: wgpu::Buffer,
    /// What pairs of values cost, if the cost is looked up.
    pub(crate) table: Option<wgpu::Buffer>,
}

impl Ends {
    /// No map is there yet: no pixel has a disparity.
    pub(crate) fn blank(&self, queue: &wgpu::Queue, sizes: &Sizes) {
        let none = |bytes: u64| DisparityMap::INVALID.to_le_bytes().repeat(bytes as usize / 2);
        for map in [Some(&self.output), self.right.as_ref()].into_iter().flatten() {
            queue.write_buffer(map, 0, &none(sizes.map));
        }
        for (other, bytes) in [(&self.confidence, sizes.confidence), (&self.depth, sizes.regions)] {
            if let Some(other) = other {
                queue.write_buffer(other, 0, &vec![0; bytes as usize]);
            }
        }
        if let Some(LabelEnds { right_map, .. }) = &self.labels {
            queue.write_buffer(right_map, sizes.right_map - sizes.map, &vec![0; sizes.map as usize]);
        }
    }
}
