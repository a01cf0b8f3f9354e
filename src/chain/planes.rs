//! From the uploaded images to the planes that the matching cost compares.

use crate::buffers::{Frame, Pass, TEXELS, TEXTURE_ROW};
use crate::steps::Bound::{Buffer, Texture};
use crate::steps::{Builder, Output};

/// The prefiltered images: in buffers, and in textures if the kernel that takes them wants those.
pub(super) struct Planes {
    pub(super) buffers: [wgpu::Buffer; 2],
    pub(super) textures: Vec<wgpu::TextureView>,
    /// The gray images.
    pub(super) grays: Vec<wgpu::TextureView>,
}

/// The textures into which images are uploaded.
pub(super) fn sources(b: &mut Builder<'_>) -> [wgpu::Texture; 2] {
    let rows = (b.sizes.source / TEXTURE_ROW) as u32;
    ["source.left", "source.right"].map(|name| b.texture(name, TEXELS, rows, wgpu::TextureFormat::Rgba32Uint))
}

/// Stages `gray` and `prefilter` of both sides.
pub(super) fn prefiltered(b: &mut Builder<'_>, sources: &[wgpu::Texture; 2]) -> Planes {
    let Frame { height, gray_stride, left_stride, right_stride, .. } = b.sizes.frame;
    let grays = [b.buffer("gray.left", b.sizes.gray), b.buffer("gray.right", b.sizes.gray)];
    let buffers = [b.buffer("prefilter.left", b.sizes.left), b.buffer("prefilter.right", b.sizes.right)];
    let (mut textures, mut texels) = (Vec::new(), Vec::new());
    for side in 0..2 {
        let (i, pass) = (side as usize, Pass { side, mirrored: b.mirrored.into(), ..Pass::default() });
        // The pair is mirrored with its sides exchanged.
        let source = sources[if b.mirrored { 1 - i } else { i }].create_view(&wgpu::TextureViewDescriptor::default());
        b.step("gray", &[Texture(&source), Buffer(&grays[i])], pass, gray_stride, height, Output::Gray { side });
        let gray = b.copy_to_texels();
        let stride = [left_stride, right_stride][i];
        let storage = [Texture(&gray), Buffer(&buffers[i])];
        b.step("prefilter", &storage, pass, stride / 4, height, Output::Prefiltered { side });
        texels.push(gray);
        if b.sizes.small_block && !b.plan.lanes {
            textures.push(b.copy_to_texture(stride, height, wgpu::TextureFormat::R32Uint));
        }
    }
    Planes { buffers, textures, grays: texels }
}
