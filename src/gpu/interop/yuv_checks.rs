//! The checks of pictures in Y, U and V.

use crate::gpu::interop::context::Context;
use crate::gpu::interop::pipelines::CallerResource;
use crate::gpu::interop::refusal::refused;
use crate::gpu::interop::resources::{PixelBuffer, TextureLayer, YuvPicture, YuvPixels};
use crate::gpu::interop::work::Source;
use crate::gpu::layout::Frame;
use crate::{Error, PixelFormat};
use wgpu::TextureFormat;

/// The resource with Y or with all, that with U and V if it is another one, and what they are.
pub(super) type Taken<'a> = (CallerResource<'a>, Option<CallerResource<'a>>, Source);

impl Context<'_> {
    /// Checks a picture; `names` are its and that of its U and V.
    pub(super) fn check_yuv<'a>(&self, names: [&str; 2], picture: &YuvPicture<'a>) -> Result<Taken<'a>, Error> {
        let name = names[0];
        if !matches!(self.format, PixelFormat::Gray8 | PixelFormat::Rgba8) {
            let allowed = format!("a matcher for PixelFormat::{:?} takes none", self.format);
            let remedy = "make it for PixelFormat::Gray8, which takes Y alone, or PixelFormat::Rgba8";
            return Err(refused(name, &"is a picture in Y, U and V", &allowed, remedy));
        }
        let Frame { width, height, .. } = *self.frame;
        let colors = picture.colors;
        let [luma_format, chroma_format] = [TextureFormat::R8Unorm, TextureFormat::Rg8Unorm];
        match picture.pixels {
            YuvPixels::Nv12(layer) => {
                self.check_plane(name, &layer, [width, height], TextureFormat::NV12)?;
                let [luma, chroma] = [luma_format, chroma_format].map(|format| CallerResource::Layer(layer, format));
                Ok((luma, Some(chroma), Source::Planes(colors)))
            }
            YuvPixels::Planes([luma, chroma]) => {
                self.check_plane(name, &luma, [width, height], luma_format)?;
                let half = [luma.texture.width(), luma.texture.height()].map(|side| side.div_ceil(2));
                if chroma.origin.is_some() {
                    return Err(begins_alone(names[1]));
                }
                self.check_plane(names[1], &chroma, half, chroma_format)?;
                let [luma, chroma] = [(luma, luma_format), (chroma, chroma_format)]
                    .map(|(layer, format)| CallerResource::Layer(layer, format));
                Ok((luma, Some(chroma), Source::Planes(colors)))
            }
            YuvPixels::Packed(layer) => {
                // In texels of two columns.
                let [x, _] = layer.origin.unwrap_or_default();
                let texels = TextureLayer { origin: layer.origin.map(|[x, y]| [x / 2, y]), ..layer };
                let columns = (x % 2 + width).div_ceil(2);
                self.check_plane(name, &texels, [columns, height], TextureFormat::Rgba8Unorm)?;
                Ok((CallerResource::Layer(layer, TextureFormat::Rgba8Unorm), None, Source::Packed(colors)))
            }
            YuvPixels::PlaneBuffers([luma, chroma]) => {
                let [columns, rows] = self.ends(&luma);
                let luma_bytes = self.check_rows(name, &luma, columns, rows)?;
                if chroma.origin != [0, 0] {
                    return Err(begins_alone(names[1]));
                }
                let chroma_bytes = self.check_rows(names[1], &chroma, 2 * columns.div_ceil(2), rows.div_ceil(2))?;
                let chroma = CallerResource::Buffer(chroma, chroma_bytes);
                Ok((CallerResource::Buffer(luma, luma_bytes), Some(chroma), Source::PlaneBuffers(colors)))
            }
            YuvPixels::PackedBuffer(pixels) => {
                let [columns, rows] = self.ends(&pixels);
                let bytes = self.check_rows(name, &pixels, 4 * columns.div_ceil(2), rows)?;
                Ok((CallerResource::Buffer(pixels, bytes), None, Source::PackedBuffer(colors)))
            }
        }
    }

    /// Columns and rows up to the last pixel.
    fn ends(&self, pixels: &PixelBuffer<'_>) -> [u64; 2] {
        let Frame { width, height, .. } = *self.frame;
        [0, 1].map(|axis| u64::from(pixels.origin[axis]) + u64::from([width, height][axis]))
    }

    fn check_plane(
        &self,
        name: &str,
        layer: &TextureLayer<'_>,
        size: [u32; 2],
        format: TextureFormat,
    ) -> Result<(), Error> {
        self.check_sampled(name, layer, size, &[format], "give it as what it is: YuvPicture::nv12, planes or yuyv")
    }
}

fn begins_alone(name: &str) -> Error {
    refused(name, &"has a beginning of its own", &"begins where Y does", "name it with YuvPicture::at")
}
