//! The textures that the window shows.

use gpu_stereo::{Error, wgpu};

/// The pair and its map as they are drawn, all of one size.
pub struct Textures {
    pub left: wgpu::TextureView,
    pub right: wgpu::TextureView,
    /// The map in the library's colours.
    pub colours: wgpu::TextureView,
    /// The map in pixels.
    pub disparity: wgpu::TextureView,
    pub size: (u32, u32),
}

impl Textures {
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Result<Self, Error> {
        let most = device.limits().max_texture_dimension_2d;
        if width.max(height) > most {
            let told =
                format!("the images are {width}x{height}, but the device shows at most {most}x{most}; scale them");
            return Err(Error::Image(told));
        }
        let texture = |label, format, more| {
            viewed(device, label, [width, height], format, wgpu::TextureUsages::TEXTURE_BINDING | more)
        };
        use wgpu::{TextureFormat as Format, TextureUsages as Usage};
        Ok(Self {
            left: texture("viewer.left", Format::Rgba8Unorm, Usage::COPY_DST),
            right: texture("viewer.right", Format::Rgba8Unorm, Usage::COPY_DST),
            colours: texture("viewer.colours", Format::Rgba8Unorm, Usage::STORAGE_BINDING),
            disparity: texture("viewer.disparity", Format::R32Float, Usage::STORAGE_BINDING),
            size: (width, height),
        })
    }
}

/// A view of a texture of the viewer's own.
pub fn viewed(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
