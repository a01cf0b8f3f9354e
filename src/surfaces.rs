//! The caller's resources that a frame is taken from and left in.

mod passes;

use crate::buffers::Frame;
use crate::{Error, PixelFormat};
pub(crate) use passes::Surfaces;
use passes::{Ours, Prepared, Theirs, Way, Work};
#[cfg(test)]
pub(crate) use passes::{SHADERS, tests::are_made};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// A texture view, and the format in which it shows its texture, which wgpu does not tell: made from a view alone, that
/// of the texture. The view is of one layer, and its texture has one mip level and the matcher's size.
#[derive(Clone, Copy, Debug)]
pub struct TypedView<'a> {
    view: &'a wgpu::TextureView,
    format: TextureFormat,
}

impl<'a> TypedView<'a> {
    /// A view that was made with a format of its own ([`wgpu::TextureViewDescriptor::format`]).
    pub fn new(view: &'a wgpu::TextureView, format: TextureFormat) -> Self {
        Self { view, format }
    }
}

impl<'a> From<&'a wgpu::TextureView> for TypedView<'a> {
    fn from(view: &'a wgpu::TextureView) -> Self {
        Self { view, format: view.texture().format() }
    }
}

/// An image in a buffer with the usage `STORAGE`: the matcher's [`PixelFormat`], 16-bit samples little endian.
#[derive(Clone, Copy, Debug)]
pub struct PixelBuffer<'a> {
    buffer: &'a wgpu::Buffer,
    offset: u64,
    bytes_per_row: u32,
}

impl<'a> PixelBuffer<'a> {
    /// An image whose first pixel is at byte `offset`, a multiple of the device's `min_storage_buffer_offset_alignment`,
    /// and whose rows begin `bytes_per_row` from each other, a multiple of 4.
    pub fn new(buffer: &'a wgpu::Buffer, offset: u64, bytes_per_row: u32) -> Self {
        Self { buffer, offset, bytes_per_row }
    }
}

/// Where [`crate::StereoMatcher::record`] takes a pair from.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum Inputs<'a> {
    /// The pair that [`crate::StereoMatcher::upload`] wrote last.
    #[default]
    Uploaded,
    /// Two textures with the usage `TEXTURE_BINDING`. [`PixelFormat::of`] tells which formats a matcher takes. Those of 16
    /// bits exist where the caller asked for the feature `TEXTURE_FORMAT_16BIT_NORM`.
    ///
    /// What counts is the bytes that a texture stores, so the maps are those of an [`crate::Image`] of these bytes: the
    /// kinds with sRGB are not made linear, and luma is the weighted sum of the stored red, green and blue (`gray` in
    /// docs/ALGORITHMS.md). Alpha is ignored.
    Textures {
        /// The left image.
        left: TypedView<'a>,
        /// The right image.
        right: TypedView<'a>,
    },
    /// Two buffers, or two places of one.
    Buffers {
        /// The left image.
        left: PixelBuffer<'a>,
        /// The right image.
        right: PixelBuffer<'a>,
    },
}

impl<'a> Inputs<'a> {
    /// [`Inputs::Textures`]: each is a view, or a [`TypedView`].
    pub fn textures(left: impl Into<TypedView<'a>>, right: impl Into<TypedView<'a>>) -> Self {
        Self::Textures { left: left.into(), right: right.into() }
    }

    /// [`Inputs::Buffers`].
    pub fn buffers(left: PixelBuffer<'a>, right: PixelBuffer<'a>) -> Self {
        Self::Buffers { left, right }
    }
}

/// Where [`crate::StereoMatcher::record`] leaves the result, beside [`crate::StereoMatcher::output`]: nowhere, until a
/// method names a place. A target is a view or a [`TypedView`].
///
/// Textures need the usage `RENDER_ATTACHMENT`; for `R32Float` and `Rgba8Unorm` `STORAGE_BINDING` does, too.
///
/// ```
/// # use gpu_stereo::{Outputs, wgpu};
/// fn both<'a>(disparity: &'a wgpu::TextureView, picture: &'a wgpu::TextureView) -> Outputs<'a> {
///     Outputs::default().disparity(disparity).color(picture)
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs<'a> {
    left: Maps<'a>,
    right: Maps<'a>,
    confidence: Option<TypedView<'a>>,
    confidence_buffer: Option<Place<'a>>,
}

/// Where the map of one view goes.
#[derive(Clone, Copy, Debug, Default)]
struct Maps<'a> {
    disparity: Option<TypedView<'a>>,
    color: Option<TypedView<'a>>,
    buffer: Option<Place<'a>>,
}

/// A place in a buffer.
#[derive(Clone, Copy, Debug)]
struct Place<'a> {
    buffer: &'a wgpu::Buffer,
    offset: u64,
}

impl<'a> Outputs<'a> {
    /// The disparity into a texture: `R32Float` in pixels, -2048 where there is none; or `R16Sint` in 1/16 px, -32768
    /// where there is none.
    #[must_use]
    pub fn disparity(mut self, target: impl Into<TypedView<'a>>) -> Self {
        self.left.disparity = Some(target.into());
        self
    }

    /// The picture of the map into a texture, `Rgba8Unorm` or `Bgra8Unorm`: [`crate::DisparityMap::color`] over
    /// [`crate::Params::searched`].
    #[must_use]
    pub fn color(mut self, target: impl Into<TypedView<'a>>) -> Self {
        self.left.color = Some(target.into());
        self
    }

    /// The map into a buffer with the usage `COPY_DST`, from byte `offset` on, a multiple of 4: laid out as
    /// [`crate::StereoMatcher::output`].
    #[must_use]
    pub fn buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.left.buffer = Some(Place { buffer, offset });
        self
    }

    /// As [`Outputs::confidence`], but a copy of [`crate::StereoMatcher::confidence`] into a buffer with the usage
    /// `COPY_DST`, from byte `offset` on, a multiple of 4.
    #[must_use]
    pub fn confidence_buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.confidence_buffer = Some(Place { buffer, offset });
        self
    }

    /// As [`Outputs::disparity`], of the right view's map. The matcher needs
    /// [`crate::Params::right_map`].
    #[must_use]
    pub fn right_disparity(mut self, target: impl Into<TypedView<'a>>) -> Self {
        self.right.disparity = Some(target.into());
        self
    }

    /// As [`Outputs::color`], of the right view's map.
    #[must_use]
    pub fn right_color(mut self, target: impl Into<TypedView<'a>>) -> Self {
        self.right.color = Some(target.into());
        self
    }

    /// As [`Outputs::buffer`], of the right view's map.
    #[must_use]
    pub fn right_buffer(mut self, buffer: &'a wgpu::Buffer, offset: u64) -> Self {
        self.right.buffer = Some(Place { buffer, offset });
        self
    }

    /// The confidence into a texture, `R8Unorm`: 0 where there is no disparity. The matcher needs
    /// [`crate::Params::confidence`].
    #[must_use]
    pub fn confidence(mut self, target: impl Into<TypedView<'a>>) -> Self {
        self.confidence = Some(target.into());
        self
    }
}

/// The formats of input textures, and the samples that they hold.
const INPUTS: [(TextureFormat, PixelFormat); 7] = [
    (TextureFormat::R8Unorm, PixelFormat::Gray8),
    (TextureFormat::R16Unorm, PixelFormat::Gray16),
    (TextureFormat::Rgba8Unorm, PixelFormat::Rgba8),
    (TextureFormat::Rgba8UnormSrgb, PixelFormat::Rgba8),
    (TextureFormat::Bgra8Unorm, PixelFormat::Rgba8),
    (TextureFormat::Bgra8UnormSrgb, PixelFormat::Rgba8),
    (TextureFormat::Rgba16Unorm, PixelFormat::Rgba16),
];

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

/// What the matcher has, between the inputs and the outputs of a frame.
pub(crate) struct Middle<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) frame: &'a Frame,
    pub(crate) format: PixelFormat,
    pub(crate) params: &'a crate::Params,
    pub(crate) sources: &'a [wgpu::Texture; 2],
    pub(crate) output: &'a wgpu::Buffer,
    pub(crate) right: Option<&'a wgpu::Buffer>,
    pub(crate) confidence: Option<&'a wgpu::Buffer>,
}

fn refused(what: &str, given: &dyn std::fmt::Display, allowed: &dyn std::fmt::Display, remedy: &str) -> Error {
    Error::Image(format!("{what} {given}, but {allowed}; {remedy}"))
}

/// Formats in words.
fn listed(formats: &[TextureFormat]) -> String {
    let names: Vec<String> = formats.iter().map(|format| format!("{format:?}")).collect();
    names.join(" or ")
}

impl Middle<'_> {
    /// The work before the chain: all is checked and made.
    pub(crate) fn before(&self, surfaces: &Surfaces, inputs: &Inputs<'_>) -> Result<Vec<Prepared>, Error> {
        let names = ["the left input", "the right input"];
        let sides: [(Theirs<'_>, Work); 2] = match inputs {
            Inputs::Uploaded => return Ok(Vec::new()),
            Inputs::Textures { left, right } => {
                self.check_input(names[0], left)?;
                self.check_input(names[1], right)?;
                [left, right].map(|&TypedView { view, format }| {
                    let work = Work::Intake { textured: true, format: self.format, srgb: format.is_srgb() };
                    (Theirs::View(view, format), work)
                })
            }
            Inputs::Buffers { left, right } => {
                let bytes = [self.check_pixels(names[0], left)?, self.check_pixels(names[1], right)?];
                let work = Work::Intake { textured: false, format: self.format, srgb: false };
                [(left, bytes[0]), (right, bytes[1])].map(|(&PixelBuffer { buffer, offset, bytes_per_row }, bytes)| {
                    (Theirs::Buffer { buffer, offset, bytes, bytes_per_row }, work)
                })
            }
        };
        let prepared =
            sides.into_iter().zip(names).zip(self.sources).map(|(((theirs, work), name), source)| {
                surfaces.prepare(self, name, work, theirs, Ours::Texture(source))
            });
        prepared.collect()
    }

    /// The work behind the chain.
    pub(crate) fn after(&self, surfaces: &Surfaces, outputs: &Outputs<'_>) -> Result<Vec<Prepared>, Error> {
        let map_bytes = 4 * u64::from(self.frame.map_stride) * u64::from(self.frame.height);
        let names = [
            ["the output disparity", "the output color", "the output buffer"],
            ["the output right_disparity", "the output right_color", "the output right_buffer"],
        ];
        let mut prepared = Vec::new();
        let maps = [(&outputs.left, Some(self.output)), (&outputs.right, self.right)];
        for ((maps, map), [disparity, color, copy]) in maps.into_iter().zip(names) {
            let there = |name| there(name, map, map_bytes, "right_map");
            if let Some(target) = maps.disparity {
                let map = there(disparity)?;
                let formats = [TextureFormat::R32Float, TextureFormat::R16Sint];
                let way = self.way(disparity, target, &formats)?;
                let work = if target.format == formats[1] { Work::Sixteenths(way) } else { Work::Pixels(way) };
                prepared.push(self.shown(surfaces, disparity, target, work, map)?);
            }
            if let Some(target) = maps.color {
                let map = there(color)?;
                let way = self.way(color, target, &[TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm])?;
                prepared.push(self.shown(surfaces, color, target, Work::Color(way), map)?);
            }
            if let Some(place) = maps.buffer {
                prepared.push(copied(copy, there(copy)?, place)?);
            }
        }
        let there = |name| there(name, self.confidence, map_bytes / 2, "confidence");
        if let Some(target) = outputs.confidence {
            let name = "the output confidence";
            let map = there(name)?;
            let way = self.way(name, target, &[TextureFormat::R8Unorm])?;
            prepared.push(self.shown(surfaces, name, target, Work::Confidence(way), map)?);
        }
        if let Some(place) = outputs.confidence_buffer {
            let name = "the output confidence_buffer";
            prepared.push(copied(name, there(name)?, place)?);
        }
        Ok(prepared)
    }

    fn shown(
        &self,
        surfaces: &Surfaces,
        name: &str,
        target: TypedView<'_>,
        work: Work,
        (map, bytes): (&wgpu::Buffer, u64),
    ) -> Result<Prepared, Error> {
        surfaces.prepare(self, name, work, Theirs::View(target.view, target.format), Ours::Buffer(map, bytes))
    }

    /// How a target is filled.
    fn way(&self, name: &str, target: TypedView<'_>, formats: &[TextureFormat]) -> Result<Way, Error> {
        self.check_texture(name, &target, formats, "use such a texture, or a view of that format")?;
        let usage = target.view.texture().usage();
        let storable = matches!(target.format, TextureFormat::R32Float | TextureFormat::Rgba8Unorm);
        if usage.contains(TextureUsages::RENDER_ATTACHMENT) {
            return Ok(Way::Draw(target.format));
        }
        if storable && usage.contains(TextureUsages::STORAGE_BINDING) {
            return Ok(Way::Store(target.format));
        }
        let needed = if storable { "RENDER_ATTACHMENT or STORAGE_BINDING" } else { "RENDER_ATTACHMENT" };
        Err(lacks(name, &usage, needed))
    }

    fn check_input(&self, name: &str, view: &TypedView<'_>) -> Result<(), Error> {
        let formats: Vec<TextureFormat> =
            INPUTS.iter().filter(|(_, samples)| *samples == self.format).map(|&(format, _)| format).collect();
        self.check_texture(name, view, &formats, "make the matcher for PixelFormat::of the texture's format")?;
        let usage = view.view.texture().usage();
        match usage.contains(TextureUsages::TEXTURE_BINDING) {
            true => Ok(()),
            false => Err(lacks(name, &usage, "TEXTURE_BINDING")),
        }
    }

    fn check_texture(
        &self,
        name: &str,
        &TypedView { view, format }: &TypedView<'_>,
        formats: &[TextureFormat],
        remedy: &str,
    ) -> Result<(), Error> {
        let Frame { width, height, .. } = *self.frame;
        let texture = view.texture();
        let flat = texture.dimension() == wgpu::TextureDimension::D2;
        if (texture.width(), texture.height()) != (width, height) || !flat {
            let given =
                format!("is a texture of {}x{} in {:?}", texture.width(), texture.height(), texture.dimension());
            let allowed = format!("the matcher has {width}x{height} in D2");
            return Err(refused(name, &given, &allowed, "make the texture of that size, or resize the matcher"));
        }
        if (texture.sample_count(), texture.mip_level_count()) != (1, 1) {
            let (samples, levels) = (texture.sample_count(), texture.mip_level_count());
            let given = format!("is a texture with {samples} samples a pixel and {levels} mip levels");
            return Err(refused(name, &given, &"must have one of each", "resolve or copy it into such a texture"));
        }
        if !formats.contains(&format) {
            let allowed = format!("must be {}", listed(formats));
            return Err(refused(name, &format!("is a view in the format {format:?}"), &allowed, remedy));
        }
        Ok(())
    }

    /// Bytes of the image, from its offset on.
    fn check_pixels(&self, name: &str, pixels: &PixelBuffer<'_>) -> Result<u64, Error> {
        let &PixelBuffer { buffer, offset, bytes_per_row } = pixels;
        let row = u64::from(self.frame.width) * u64::from(self.format.bytes_per_pixel());
        let limits = self.device.limits();
        if !buffer.usage().contains(BufferUsages::STORAGE) {
            return Err(lacks(name, &buffer.usage(), "STORAGE"));
        }
        let alignment = limits.min_storage_buffer_offset_alignment;
        if !offset.is_multiple_of(alignment.into()) {
            let allowed = format!("must begin at a multiple of {alignment}");
            return Err(refused(name, &format!("begins at byte {offset}"), &allowed, "copy it to such a place"));
        }
        if !bytes_per_row.is_multiple_of(4) || u64::from(bytes_per_row) < row {
            let allowed = format!("must have a multiple of 4, at least {row} in {:?}", self.format);
            return Err(refused(name, &format!("has {bytes_per_row} bytes a row"), &allowed, "pad the rows"));
        }
        let bytes = u64::from(self.frame.height - 1) * u64::from(bytes_per_row) + row.next_multiple_of(4);
        long_enough(name, buffer, offset, bytes)?;
        let most = limits.max_storage_buffer_binding_size;
        if bytes > most {
            let (given, allowed) = (format!("has {bytes} bytes"), format!("the device allows {most} a binding"));
            return Err(refused(name, &given, &allowed, "request larger limits, or use textures"));
        }
        Ok(bytes)
    }
}

fn lacks(name: &str, usage: &dyn std::fmt::Debug, needed: &str) -> Error {
    refused(name, &format!("has the usages {usage:?}"), &format!("needs {needed}"), "create it with that usage")
}

/// What an output shows, which only some settings compute: the first bytes of a buffer.
fn there<'a>(
    name: &str,
    buffer: Option<&'a wgpu::Buffer>,
    bytes: u64,
    setting: &str,
) -> Result<(&'a wgpu::Buffer, u64), Error> {
    let absent =
        || refused(name, &"is asked for", &"the matcher does not compute it", &format!("set Params::{setting}"));
    buffer.map(|buffer| (buffer, bytes)).ok_or_else(absent)
}

fn long_enough(name: &str, buffer: &wgpu::Buffer, offset: u64, bytes: u64) -> Result<(), Error> {
    let size = buffer.size();
    if size.checked_sub(offset).is_some_and(|rest| rest >= bytes) {
        return Ok(());
    }
    let given = format!("is a buffer of {size} bytes");
    Err(refused(name, &given, &format!("{bytes} are needed from byte {offset} on"), "make the buffer larger"))
}

/// A copy of the first bytes of one of the matcher's buffers.
fn copied(name: &str, (from, bytes): (&wgpu::Buffer, u64), place: Place<'_>) -> Result<Prepared, Error> {
    let Place { buffer, offset } = place;
    if !buffer.usage().contains(BufferUsages::COPY_DST) {
        return Err(lacks(name, &buffer.usage(), "COPY_DST"));
    }
    if !offset.is_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT) {
        let allowed = format!("must begin at a multiple of {}", wgpu::COPY_BUFFER_ALIGNMENT);
        return Err(refused(name, &format!("begins at byte {offset}"), &allowed, "choose such a place"));
    }
    if buffer == from {
        let allowed = "must be a buffer of the caller's";
        return Err(refused(name, &"is the matcher's own buffer", &allowed, "use it as it is, or make another one"));
    }
    long_enough(name, buffer, offset, bytes)?;
    Ok(Prepared::Copy { from: from.clone(), to: buffer.clone(), offset, bytes })
}
