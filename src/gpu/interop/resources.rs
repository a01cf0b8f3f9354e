//! The caller's resources that a frame is taken from and left in.

use crate::{PixelFormat, YuvColors};
use wgpu::TextureFormat;

/// The formats of input textures, and the samples that they hold.
pub(super) const INPUTS: [(TextureFormat, PixelFormat); 7] = [
    (TextureFormat::R8Unorm, PixelFormat::Gray8),
    (TextureFormat::R16Unorm, PixelFormat::Gray16),
    (TextureFormat::Rgba8Unorm, PixelFormat::Rgba8),
    (TextureFormat::Rgba8UnormSrgb, PixelFormat::Rgba8),
    (TextureFormat::Bgra8Unorm, PixelFormat::Rgba8),
    (TextureFormat::Bgra8UnormSrgb, PixelFormat::Rgba8),
    (TextureFormat::Rgba16Unorm, PixelFormat::Rgba16),
];

/// A layer and the format in which it is seen.
pub(super) type Seen = (wgpu::Texture, u32, TextureFormat);

/// A layer of a texture. The matcher makes the view of it itself: wgpu does not say in which format a view shows its
/// texture, and a view in another format would give wrong pixels. A reference to a texture of one layer is one.
///
/// The texture is of the matcher's device and size, two-dimensional, with one mip level and one sample a pixel. An input may be a
/// rectangle of a larger one: [`TextureLayer::at`].
#[derive(Clone, Copy, Debug)]
pub struct TextureLayer<'a> {
    pub(super) texture: &'a wgpu::Texture,
    /// None where the texture must have no other.
    pub(super) layer: Option<u32>,
    /// Column and row of the first pixel; None where the texture has the matcher's size.
    pub(super) origin: Option<[u32; 2]>,
}

impl<'a> TextureLayer<'a> {
    /// Layer `layer` of an array of textures, from 0 on.
    pub fn new(texture: &'a wgpu::Texture, layer: u32) -> Self {
        Self { texture, layer: Some(layer), origin: None }
    }

    /// The rectangle of the matcher's size whose first pixel is column `x`, row `y` of the texture: an input that is a part of a
    /// larger picture, such as one half of a picture that holds both views. [`Inputs`] says what that does to disparities.
    #[must_use]
    pub fn at(mut self, x: u32, y: u32) -> Self {
        self.origin = Some([x, y]);
        self
    }

    /// A view of it in a format of the texture's bytes.
    pub(super) fn view(&self, format: TextureFormat) -> wgpu::TextureView {
        let aspect = match (self.texture.format(), format) {
            (TextureFormat::NV12, TextureFormat::R8Unorm) => wgpu::TextureAspect::Plane0,
            (TextureFormat::NV12, _) => wgpu::TextureAspect::Plane1,
            _ => wgpu::TextureAspect::All,
        };
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("gpu-stereo.interop"),
            format: Some(format),
            aspect,
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: self.layer.unwrap_or(0),
            array_layer_count: Some(1),
            ..Default::default()
        })
    }

    /// The layer in a format.
    pub(super) fn seen(&self, format: TextureFormat) -> Seen {
        (self.texture.clone(), self.layer.unwrap_or(0), format)
    }
}

impl<'a> From<&'a wgpu::Texture> for TextureLayer<'a> {
    fn from(texture: &'a wgpu::Texture) -> Self {
        Self { texture, layer: None, origin: None }
    }
}

/// An image in a buffer with the usage `STORAGE`: the matcher's [`PixelFormat`], 16-bit samples little endian.
#[derive(Clone, Copy, Debug)]
pub struct PixelBuffer<'a> {
    pub(super) buffer: &'a wgpu::Buffer,
    pub(super) offset: u64,
    pub(super) bytes_per_row: u32,
    /// Column and row of the first pixel.
    pub(super) origin: [u32; 2],
}

impl<'a> PixelBuffer<'a> {
    /// An image whose first pixel is at byte `offset`, a multiple of the device's `min_storage_buffer_offset_alignment`,
    /// and whose rows begin `bytes_per_row` from each other, a multiple of 4.
    pub fn new(buffer: &'a wgpu::Buffer, offset: u64, bytes_per_row: u32) -> Self {
        Self { buffer, offset, bytes_per_row, origin: [0, 0] }
    }

    /// The rectangle of the matcher's size whose first pixel is column `x`, row `y` of the image that begins at the buffer's offset: as
    /// [`TextureLayer::at`].
    #[must_use]
    pub fn at(mut self, x: u32, y: u32) -> Self {
        self.origin = [x, y];
        self
    }
}

/// A picture in Y, U and V of 8 bits, as cameras and video decoders leave it in textures and buffers. A matcher for
/// [`PixelFormat::Gray8`] takes Y as it is stored; one for [`PixelFormat::Rgba8`] takes red, green and blue by [`YuvColors::rgb`], of
/// two columns and rows the same U and V (`Input` in docs/ALGORITHMS.md). So the maps are those of the image of
/// [`YuvColors::nv12`] or [`YuvColors::yuyv`].
#[derive(Clone, Copy, Debug)]
pub struct YuvPicture<'a> {
    pub(super) pixels: YuvPixels<'a>,
    pub(super) colors: YuvColors,
}

/// Where Y, U and V are; the beginning is that of Y.
#[derive(Clone, Copy, Debug)]
pub(super) enum YuvPixels<'a> {
    Nv12(TextureLayer<'a>),
    Planes([TextureLayer<'a>; 2]),
    Packed(TextureLayer<'a>),
    PlaneBuffers([PixelBuffer<'a>; 2]),
    PackedBuffer(PixelBuffer<'a>),
}

impl<'a> YuvPicture<'a> {
    /// A texture in wgpu's format `NV12`, which devices have with the feature `TEXTURE_FORMAT_NV12`; its sides are even.
    pub fn nv12(texture: impl Into<TextureLayer<'a>>, colors: YuvColors) -> Self {
        Self { pixels: YuvPixels::Nv12(texture.into()), colors }
    }

    /// NV12 in two textures: Y in `R8Unorm`, and U and V in `Rg8Unorm` with half the columns and rows, rounded up.
    pub fn planes(luma: impl Into<TextureLayer<'a>>, chroma: impl Into<TextureLayer<'a>>, colors: YuvColors) -> Self {
        Self { pixels: YuvPixels::Planes([luma.into(), chroma.into()]), colors }
    }

    /// YUYV (YUY2) in a texture in `Rgba8Unorm` of half the columns, rounded up: a texel is Y, U, Y and V of two columns.
    pub fn yuyv(texture: impl Into<TextureLayer<'a>>, colors: YuvColors) -> Self {
        Self { pixels: YuvPixels::Packed(texture.into()), colors }
    }

    /// NV12 in two places of buffers: Y, a byte a pixel, and U and V, two bytes for two columns and two rows.
    pub fn nv12_buffers(luma: PixelBuffer<'a>, chroma: PixelBuffer<'a>, colors: YuvColors) -> Self {
        Self { pixels: YuvPixels::PlaneBuffers([luma, chroma]), colors }
    }

    /// YUYV (YUY2) in a buffer: Y, U, Y and V of two columns, a byte each.
    pub fn yuyv_buffer(pixels: PixelBuffer<'a>, colors: YuvColors) -> Self {
        Self { pixels: YuvPixels::PackedBuffer(pixels), colors }
    }

    /// The rectangle of the matcher's size whose first pixel is column `x`, row `y` of the picture, counted in pixels: as
    /// [`TextureLayer::at`].
    #[must_use]
    pub fn at(mut self, x: u32, y: u32) -> Self {
        match &mut self.pixels {
            YuvPixels::Nv12(layer) | YuvPixels::Planes([layer, _]) | YuvPixels::Packed(layer) => {
                *layer = layer.at(x, y)
            }
            YuvPixels::PlaneBuffers([pixels, _]) | YuvPixels::PackedBuffer(pixels) => *pixels = pixels.at(x, y),
        }
        self
    }
}

/// Where [`crate::StereoMatcher::record`] takes a pair from.
///
/// **Parts of larger pictures.** With [`TextureLayer::at`] and [`PixelBuffer::at`] the pair is a rectangle of each picture, of the matcher's
/// size; nothing is copied by the caller. Both begin in the same row, unless both are parts of one picture. Their columns may differ:
/// if the left one begins at column l and the right one at r, a disparity of the whole pictures is the matcher's plus l - r. So a
/// range from m on is found with [`Params::min_disparity`](crate::Params::min_disparity) = m - (l - r), and depths are right if
/// l - r is added to [`Camera::doffs`](crate::Camera::doffs). Pixels outside the rectangles are never read: at their borders the maps
/// are those of images cut out beforehand.
///
/// ```
/// # use gpu_stereo::{Inputs, TextureLayer, wgpu};
/// /// Both views side by side in one texture of twice the matcher's width.
/// fn side_by_side(texture: &wgpu::Texture) -> Inputs<'_> {
///     let half = |x| TextureLayer::from(texture).at(x, 0);
///     Inputs::textures(half(0), half(texture.width() / 2))
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum Inputs<'a> {
    /// The pair that [`crate::StereoMatcher::upload`] wrote last before the recording. It stays there for further recordings.
    #[default]
    Uploaded,
    /// Two textures with the usage `TEXTURE_BINDING`. [`PixelFormat::of`] returns the format of a matcher that takes them. Those of 16
    /// bits exist where the caller asked for the feature `TEXTURE_FORMAT_16BIT_NORM`.
    ///
    /// What counts is the bytes that a texture stores, so the maps are those of an [`crate::Image`] of these bytes: the
    /// kinds with sRGB are not made linear, and luma is the weighted sum of the stored red, green and blue (`gray` in
    /// docs/ALGORITHMS.md). Alpha is ignored.
    Textures {
        /// The left image.
        left: TextureLayer<'a>,
        /// The right image.
        right: TextureLayer<'a>,
    },
    /// Two buffers, or two places of one.
    Buffers {
        /// The left image.
        left: PixelBuffer<'a>,
        /// The right image.
        right: PixelBuffer<'a>,
    },
    /// Two pictures in Y, U and V, in textures with the usage `TEXTURE_BINDING` or buffers with the usage `STORAGE`.
    Yuv {
        /// The left image.
        left: YuvPicture<'a>,
        /// The right image.
        right: YuvPicture<'a>,
    },
}

impl<'a> Inputs<'a> {
    /// [`Inputs::Textures`]: each is a `&wgpu::Texture` of one layer, or a [`TextureLayer`].
    pub fn textures(left: impl Into<TextureLayer<'a>>, right: impl Into<TextureLayer<'a>>) -> Self {
        Self::Textures { left: left.into(), right: right.into() }
    }

    /// [`Inputs::Buffers`].
    pub fn buffers(left: PixelBuffer<'a>, right: PixelBuffer<'a>) -> Self {
        Self::Buffers { left, right }
    }

    /// [`Inputs::Yuv`].
    ///
    /// ```
    /// # use gpu_stereo::{Inputs, YuvColors, YuvPicture, wgpu};
    /// /// Frames of two cameras: Y of each in R8Unorm, U and V in Rg8Unorm.
    /// fn frames<'a>(luma: [&'a wgpu::Texture; 2], chroma: [&'a wgpu::Texture; 2]) -> Inputs<'a> {
    ///     let [left, right] = [0, 1].map(|i| YuvPicture::planes(luma[i], chroma[i], YuvColors::Bt601));
    ///     Inputs::yuv(left, right)
    /// }
    /// ```
    pub fn yuv(left: YuvPicture<'a>, right: YuvPicture<'a>) -> Self {
        Self::Yuv { left, right }
    }
}

/// Where [`crate::StereoMatcher::record`] writes the result, in addition to [`crate::StereoMatcher::output`]: nowhere, until a
/// method names a target. A target is a `&wgpu::Texture` of one layer, or a [`TextureLayer`]. No two of them, and no input, may
/// overlap.
///
/// Textures need the usage `RENDER_ATTACHMENT`; for `R32Float`, `R32Uint` and `Rgba8Unorm` `STORAGE_BINDING` does, too. What a texture
/// holds is the same on every device, to the bit: a value that a format cannot hold is rounded by the shader, to the nearest one, of two
/// to the even one. `R16Float` can be filtered on every device, `R32Float` with wgpu's feature `FLOAT32_FILTERABLE`; a sampler
/// that filters mixes the values of pixels without a disparity with others.
///
/// ```
/// # use gpu_stereo::{Outputs, wgpu};
/// fn both<'a>(disparity: &'a wgpu::Texture, picture: &'a wgpu::Texture) -> Outputs<'a> {
///     Outputs::default().disparity(disparity).color(picture)
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs<'a> {
    pub(super) left: ViewTargets<'a>,
    pub(super) right: ViewTargets<'a>,
    pub(super) confidence: Option<TextureLayer<'a>>,
    pub(super) confidence_buffer: Option<BufferTarget<'a>>,
    pub(super) depth: Option<TextureLayer<'a>>,
    pub(super) depth_buffer: Option<BufferTarget<'a>>,
}

/// Where the map of one view goes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ViewTargets<'a> {
    pub(super) disparity: Option<TextureLayer<'a>>,
    pub(super) color: Option<TextureLayer<'a>>,
    pub(super) buffer: Option<BufferTarget<'a>>,
}

/// A place in a buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct BufferTarget<'a> {
    pub(super) buffer: &'a wgpu::Buffer,
    pub(super) offset: u64,
}

impl<'a> Outputs<'a> {
    /// The disparity into a texture: `R32Float` in pixels, -2048 where there is none; `R16Sint` in 1/16 px, -32768
    /// where there is none; or `R16Float` in pixels, which is rounded from 128 px on (to 1/8 px, from 256 px on to 1/4 px and so on), -2048
    /// where there is none.
    #[must_use]
    pub fn disparity(mut self, target: impl Into<TextureLayer<'a>>) -> Self {
        self.left.disparity = Some(target.into());
        self
    }

    /// The picture of the map into a texture, `Rgba8Unorm` or `Bgra8Unorm`: [`crate::DisparityMap::color`] over
    /// [`crate::Params::searched`]. Their kinds with sRGB hold the same bytes; such a texture is created with the kind
    /// without among its `view_formats`.
    #[must_use]
    pub fn color(mut self, target: impl Into<TextureLayer<'a>>) -> Self {
        self.left.color = Some(target.into());
        self
    }

    /// The map into a buffer with the usage `COPY_DST`, from byte `offset` on, a multiple of 4: laid out as
    /// [`crate::StereoMatcher::output`].
    #[must_use]
    pub fn buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.left.buffer = Some(BufferTarget { buffer, offset });
        self
    }

    /// As [`Outputs::confidence`], but a copy of [`crate::StereoMatcher::confidence`] into a buffer with the usage
    /// `COPY_DST`, from byte `offset` on, a multiple of 4.
    #[must_use]
    pub fn confidence_buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.confidence_buffer = Some(BufferTarget { buffer, offset });
        self
    }

    /// The depth into a texture, 0 where there is none: `R32Float` in metres, the nearest float
    /// ([`DepthMap::metres`](crate::DepthMap::metres)); `R32Uint` in micrometres, as in [`DepthMap`](crate::DepthMap); or `R16Float` in
    /// metres, the nearest number of 11 binary digits, at least 2^-14. The matcher needs [`crate::Params::depth`].
    #[must_use]
    pub fn depth(mut self, target: impl Into<TextureLayer<'a>>) -> Self {
        self.depth = Some(target.into());
        self
    }

    /// As [`Outputs::depth`], but a copy of [`crate::StereoMatcher::depth`] into a buffer with the usage `COPY_DST`, from byte
    /// `offset` on, a multiple of 4: micrometres.
    #[must_use]
    pub fn depth_buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.depth_buffer = Some(BufferTarget { buffer, offset });
        self
    }

    /// As [`Outputs::disparity`], of the right view's map. The matcher needs
    /// [`crate::Params::right_map`].
    #[must_use]
    pub fn right_disparity(mut self, target: impl Into<TextureLayer<'a>>) -> Self {
        self.right.disparity = Some(target.into());
        self
    }

    /// As [`Outputs::color`], of the right view's map.
    #[must_use]
    pub fn right_color(mut self, target: impl Into<TextureLayer<'a>>) -> Self {
        self.right.color = Some(target.into());
        self
    }

    /// As [`Outputs::buffer`], of the right view's map.
    #[must_use]
    pub fn right_buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.right.buffer = Some(BufferTarget { buffer, offset });
        self
    }

    /// The confidence into a texture, `R8Unorm`: 0 where there is no disparity. The matcher needs
    /// [`crate::Params::confidence`].
    #[must_use]
    pub fn confidence(mut self, target: impl Into<TextureLayer<'a>>) -> Self {
        self.confidence = Some(target.into());
        self
    }
}

impl PixelFormat {
    /// The format that a matcher must be made for to take textures of `format`; `None` if there is none.
    ///
    /// ```
    /// use gpu_stereo::{PixelFormat, wgpu::TextureFormat};
    /// assert_eq!(PixelFormat::of(TextureFormat::Bgra8UnormSrgb), Some(PixelFormat::Rgba8));
    /// assert_eq!(PixelFormat::of(TextureFormat::Rgba32Float), None);
    /// ```
    pub fn of(format: TextureFormat) -> Option<Self> {
        INPUTS.iter().find(|(texture, _)| *texture == format).map(|&(_, samples)| samples)
    }
}
