//! The weights of a network on the device.

use crate::gpu::layout::{TEXELS, TEXTURE_ROW, packed, weight_places};
use crate::network::Network;

/// The weights of a network, in a texture or in a buffer. They are written once, when they are made.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    network: Network,
    pub(crate) held: Held,
    /// Bytes of all.
    pub(super) bytes: u64,
    /// The first texel of each operation's, and the one behind its last.
    pub(crate) texels: Vec<[u32; 2]>,
}

/// Where they are.
#[derive(Clone, Debug)]
pub(crate) enum Held {
    Buffer(wgpu::Buffer),
    Texture(wgpu::Texture, wgpu::TextureView),
}

impl Weights {
    /// Whether these are the weights of a network, held where a plan wants them.
    pub(super) fn are_of(&self, network: &Network, per_subgroup: bool) -> bool {
        self.network == *network && matches!(self.held, Held::Buffer(_)) == per_subgroup
    }

    /// Those of a network; with `only_planned` without the memory.
    pub(super) fn new(device: &wgpu::Device, network: &Network, per_subgroup: bool, only_planned: bool) -> Self {
        let (texels, bytes) = weight_places(network);
        let rows = (bytes / TEXTURE_ROW) as u32;
        let label = Some("gpu-stereo.network.weights");
        let held = if per_subgroup {
            Held::Buffer(device.create_buffer(&wgpu::BufferDescriptor {
                label,
                size: if only_planned { 16 } else { bytes },
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }))
        } else {
            let [width, height] = if only_planned { [1, 1] } else { [TEXELS, rows] };
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label,
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Uint,
                usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            Held::Texture(texture, view)
        };
        Self { network: network.clone(), held, bytes, texels }
    }

    pub(super) fn write(&self, queue: &wgpu::Queue) {
        let texels = packed(&self.network);
        let bytes = bytemuck::cast_slice(&texels);
        match &self.held {
            Held::Buffer(buffer) => queue.write_buffer(buffer, 0, bytes),
            Held::Texture(texture, _) => {
                let bytes_per_row = Some(TEXTURE_ROW as u32);
                let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
                queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
            }
        }
    }
}
