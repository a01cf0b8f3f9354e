//! What the caller hands over is looked at before anything is made or recorded.

use super::passes::{Ours, Prepared, Theirs, Way, Work};
use super::{Inputs, Outputs, PixelBuffer, Place, Surfaces, TextureLayer, listed};
use crate::gpu::device::Pulse;
use crate::gpu::layout::Frame;
use crate::{Error, PixelFormat};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

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

/// The formats of textures that take colours. Those with sRGB are drawn to as what they are without.
const COLORS: [TextureFormat; 4] = [
    TextureFormat::Rgba8Unorm,
    TextureFormat::Bgra8Unorm,
    TextureFormat::Rgba8UnormSrgb,
    TextureFormat::Bgra8UnormSrgb,
];

/// What the matcher has, between the inputs and the outputs of a frame.
pub(crate) struct Middle<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) pulse: &'a Pulse,
    pub(crate) frame: &'a Frame,
    pub(crate) format: PixelFormat,
    pub(crate) params: &'a crate::Params,
    pub(crate) sources: &'a [wgpu::Texture; 2],
    pub(crate) output: &'a wgpu::Buffer,
    pub(crate) right: Option<&'a wgpu::Buffer>,
    pub(crate) confidence: Option<&'a wgpu::Buffer>,
    pub(crate) depth: Option<&'a wgpu::Buffer>,
}

/// What a surface covers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Spot<'a> {
    Layer(&'a wgpu::Texture, u32),
    /// From the first byte to the one behind the last.
    Bytes(&'a wgpu::Buffer, u64, u64),
}

impl Spot<'_> {
    fn overlaps(&self, other: &Self) -> bool {
        match (self, other) {
            (Spot::Layer(texture, layer), Spot::Layer(other, other_layer)) => texture == other && layer == other_layer,
            (Spot::Bytes(buffer, from, to), Spot::Bytes(other, other_from, other_to)) => {
                buffer == other && from < other_to && other_from < to
            }
            _ => false,
        }
    }
}

/// What is taken and written in a frame.
#[derive(Default)]
pub(crate) struct Spots<'a>(Vec<(&'static str, Spot<'a>)>);

impl<'a> Spots<'a> {
    fn read(&mut self, name: &'static str, spot: Spot<'a>) {
        self.0.push((name, spot));
    }

    /// A place that is written is no other's.
    fn write(&mut self, name: &'static str, spot: Spot<'a>) -> Result<(), Error> {
        match self.0.iter().find(|(_, other)| other.overlaps(&spot)) {
            Some((other, _)) => {
                let allowed = format!("that is {other}");
                Err(refused(name, &"overlaps another place", &allowed, "give each output a place of its own"))
            }
            None => {
                self.read(name, spot);
                Ok(())
            }
        }
    }
}

pub(super) fn refused(
    what: &str,
    given: &dyn std::fmt::Display,
    allowed: &dyn std::fmt::Display,
    remedy: &str,
) -> Error {
    Error::Image(format!("{what} {given}, but {allowed}; {remedy}"))
}

impl Middle<'_> {
    /// The work before the chain: all is checked and made.
    pub(crate) fn before<'a>(
        &self,
        surfaces: &Surfaces,
        inputs: &Inputs<'a>,
        spots: &mut Spots<'a>,
    ) -> Result<Vec<Prepared>, Error> {
        let names = ["the left input", "the right input"];
        let sides: [(Theirs<'_>, Work); 2] = match *inputs {
            Inputs::Uploaded => return Ok(Vec::new()),
            Inputs::Textures { left, right } => {
                for (name, side) in names.into_iter().zip([&left, &right]) {
                    self.check_input(name, side)?;
                    spots.read(name, side.spot());
                }
                [left, right].map(|side| {
                    let format = side.texture.format();
                    let work = Work::Intake { textured: true, format: self.format, srgb: format.is_srgb() };
                    (Theirs::Layer(side, format), work)
                })
            }
            Inputs::Buffers { left, right } => {
                let bytes = [self.check_pixels(names[0], &left)?, self.check_pixels(names[1], &right)?];
                let work = Work::Intake { textured: false, format: self.format, srgb: false };
                let side = |name, PixelBuffer { buffer, offset, bytes_per_row }: PixelBuffer<'a>, bytes| {
                    (
                        name,
                        Spot::Bytes(buffer, offset, offset + bytes),
                        Theirs::Buffer { buffer, offset, bytes, bytes_per_row },
                    )
                };
                [side(names[0], left, bytes[0]), side(names[1], right, bytes[1])].map(|(name, spot, theirs)| {
                    spots.read(name, spot);
                    (theirs, work)
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
    pub(crate) fn after<'a>(
        &self,
        surfaces: &Surfaces,
        outputs: &Outputs<'a>,
        spots: &mut Spots<'a>,
    ) -> Result<Vec<Prepared>, Error> {
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
                let sixteenths = target.texture.format() == formats[1];
                let work = if sixteenths { Work::Sixteenths(way) } else { Work::Pixels(way) };
                prepared.push(self.shown(surfaces, disparity, target, work, map, spots)?);
            }
            if let Some(target) = maps.color {
                let map = there(color)?;
                let way = self.way(color, target, &COLORS)?;
                prepared.push(self.shown(surfaces, color, target, Work::Color(way), map, spots)?);
            }
            if let Some(place) = maps.buffer {
                prepared.push(self.copied(copy, there(copy)?, place, spots)?);
            }
        }
        let there = |name| there(name, self.confidence, map_bytes / 2, "confidence");
        if let Some(target) = outputs.confidence {
            let name = "the output confidence";
            let map = there(name)?;
            let way = self.way(name, target, &[TextureFormat::R8Unorm])?;
            prepared.push(self.shown(surfaces, name, target, Work::Confidence(way), map, spots)?);
        }
        if let Some(place) = outputs.confidence_buffer {
            let name = "the output confidence_buffer";
            prepared.push(self.copied(name, there(name)?, place, spots)?);
        }
        Ok(prepared)
    }

    fn shown<'a>(
        &self,
        surfaces: &Surfaces,
        name: &'static str,
        target: TextureLayer<'a>,
        work: Work,
        (map, bytes): (&wgpu::Buffer, u64),
        spots: &mut Spots<'a>,
    ) -> Result<Prepared, Error> {
        spots.write(name, target.spot())?;
        let format = target.texture.format().remove_srgb_suffix();
        surfaces.prepare(self, name, work, Theirs::Layer(target, format), Ours::Buffer(map, bytes))
    }

    /// How a target is filled.
    fn way(&self, name: &str, target: TextureLayer<'_>, formats: &[TextureFormat]) -> Result<Way, Error> {
        self.check_texture(name, &target, formats, "use a texture of such a format")?;
        let (usage, format) = (target.texture.usage(), target.texture.format().remove_srgb_suffix());
        let storable = matches!(target.texture.format(), TextureFormat::R32Float | TextureFormat::Rgba8Unorm);
        if usage.contains(TextureUsages::RENDER_ATTACHMENT) {
            return Ok(Way::Draw(format));
        }
        if storable && usage.contains(TextureUsages::STORAGE_BINDING) {
            return Ok(Way::Store(format));
        }
        let needed = if storable { "RENDER_ATTACHMENT or STORAGE_BINDING" } else { "RENDER_ATTACHMENT" };
        Err(lacks(name, &usage, needed))
    }

    fn check_input(&self, name: &str, input: &TextureLayer<'_>) -> Result<(), Error> {
        let formats: Vec<TextureFormat> =
            INPUTS.iter().filter(|(_, samples)| *samples == self.format).map(|&(format, _)| format).collect();
        let remedy = match PixelFormat::of(input.texture.format()) {
            Some(format) => format!("make the matcher for PixelFormat::{format:?}"),
            None => "copy or draw it into a texture of such a format".into(),
        };
        self.check_texture(name, input, &formats, &remedy)?;
        let usage = input.texture.usage();
        match usage.contains(TextureUsages::TEXTURE_BINDING) {
            true => Ok(()),
            false => Err(lacks(name, &usage, "TEXTURE_BINDING")),
        }
    }

    fn check_texture(
        &self,
        name: &str,
        &TextureLayer { texture, layer }: &TextureLayer<'_>,
        formats: &[TextureFormat],
        remedy: &str,
    ) -> Result<(), Error> {
        self.check_owner(name, texture)?;
        let Frame { width, height, .. } = *self.frame;
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
        let layers = texture.depth_or_array_layers();
        match layer {
            None if layers > 1 => {
                let given = format!("is a texture of {layers} layers");
                let allowed = "one of them must be named";
                return Err(refused(name, &given, &allowed, "give a TextureLayer::new(texture, layer)"));
            }
            Some(layer) if layer >= layers => {
                let given = format!("is layer {layer} of a texture");
                let allowed = format!("that has {layers}, counted from 0");
                return Err(refused(name, &given, &allowed, "name one of those"));
            }
            _ => {}
        }
        let format = texture.format();
        if !formats.contains(&format) {
            let allowed = format!("must be {}", listed(formats));
            return Err(refused(name, &format!("is a texture in the format {format:?}"), &allowed, remedy));
        }
        Ok(())
    }

    /// Comes before all else: what is another device's may be taken for something of this one's.
    fn check_owner(&self, name: &str, thing: &dyn std::fmt::Debug) -> Result<(), Error> {
        if self.pulse.owns(thing) {
            return Ok(());
        }
        let remedy = "create it with the device that the matcher was made with, or copy it over by way of the host";
        Err(refused(name, &"is of another wgpu device", &"must be of the matcher's", remedy))
    }

    /// No place of the caller's is one of the matcher's.
    fn check_buffer(&self, name: &str, buffer: &wgpu::Buffer, needed: (BufferUsages, &str)) -> Result<(), Error> {
        self.check_owner(name, buffer)?;
        if [Some(self.output), self.right, self.confidence, self.depth].contains(&Some(buffer)) {
            let allowed = "must be a buffer of the caller's";
            return Err(refused(
                name,
                &"is the matcher's own buffer",
                &allowed,
                "use it as it is, or make another one",
            ));
        }
        match buffer.usage().contains(needed.0) {
            true => Ok(()),
            false => Err(lacks(name, &buffer.usage(), needed.1)),
        }
    }

    /// Bytes of the image, from its offset on.
    fn check_pixels(&self, name: &str, pixels: &PixelBuffer<'_>) -> Result<u64, Error> {
        let &PixelBuffer { buffer, offset, bytes_per_row } = pixels;
        let row = u64::from(self.frame.width) * u64::from(self.format.bytes_per_pixel());
        let limits = self.device.limits();
        self.check_buffer(name, buffer, (BufferUsages::STORAGE, "STORAGE"))?;
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

    /// A copy of the first bytes of one of the matcher's buffers.
    fn copied<'a>(
        &self,
        name: &'static str,
        (from, bytes): (&wgpu::Buffer, u64),
        Place { buffer, offset }: Place<'a>,
        spots: &mut Spots<'a>,
    ) -> Result<Prepared, Error> {
        self.check_buffer(name, buffer, (BufferUsages::COPY_DST, "COPY_DST"))?;
        if !offset.is_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT) {
            let allowed = format!("must begin at a multiple of {}", wgpu::COPY_BUFFER_ALIGNMENT);
            return Err(refused(name, &format!("begins at byte {offset}"), &allowed, "choose such a place"));
        }
        long_enough(name, buffer, offset, bytes)?;
        spots.write(name, Spot::Bytes(buffer, offset, offset + bytes))?;
        Ok(Prepared::Copy { from: from.clone(), to: buffer.clone(), offset, bytes })
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
