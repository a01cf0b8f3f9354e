//! The work of a frame before and after the chain: all is checked and made before anything is recorded.

use crate::Error;
use crate::gpu::interop::cache::PassCache;
use crate::gpu::interop::checks::{long_enough, same_rows};
use crate::gpu::interop::context::Context;
use crate::gpu::interop::pipelines::{CallerResource, MatcherResource, Prepared};
use crate::gpu::interop::refusal::{lacks, refused};
use crate::gpu::interop::regions::{Region, Regions};
use crate::gpu::interop::resources::{BufferTarget, Inputs, Outputs, TextureLayer};
use crate::gpu::interop::work::{Source, Work, WriteMethod};
use crate::gpu::interop::yuv_checks::Taken;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// The formats of textures that take colours. Those with sRGB are drawn to as what they are without.
const COLORS: [TextureFormat; 4] = [
    TextureFormat::Rgba8Unorm,
    TextureFormat::Bgra8Unorm,
    TextureFormat::Rgba8UnormSrgb,
    TextureFormat::Bgra8UnormSrgb,
];

impl Context<'_> {
    /// The work before the chain: all is checked and made.
    pub(crate) fn before<'a>(
        &self,
        cache: &PassCache,
        inputs: &Inputs<'a>,
        regions: &mut Regions<'a>,
    ) -> Result<Vec<Prepared>, Error> {
        let names = ["the left input", "the right input"];
        let sides: [Taken<'a>; 2] = match *inputs {
            Inputs::Uploaded => return Ok(Vec::new()),
            Inputs::Textures { left, right } => {
                for (name, side) in names.into_iter().zip([&left, &right]) {
                    self.check_input(name, side)?;
                }
                [left, right].map(|side| {
                    let format = side.texture.format();
                    (CallerResource::Layer(side, format), None, Source::Texture { srgb: format.is_srgb() })
                })
            }
            Inputs::Buffers { left, right } => {
                let bytes = [self.check_pixels(names[0], &left)?, self.check_pixels(names[1], &right)?];
                [(left, bytes[0]), (right, bytes[1])]
                    .map(|(pixels, bytes)| (CallerResource::Buffer(pixels, bytes), None, Source::Buffer))
            }
            Inputs::Yuv { left, right } => [
                self.check_yuv([names[0], "the chroma of the left input"], &left)?,
                self.check_yuv([names[1], "the chroma of the right input"], &right)?,
            ],
        };
        same_rows(sides[0].0.is_of(&sides[1].0), [0, 1].map(|side| sides[side].0.origin()[1]))?;
        for (name, (resource, chroma, _)) in names.into_iter().zip(&sides) {
            regions.read(name, resource.region());
            chroma.iter().for_each(|chroma| regions.read(name, chroma.region()));
        }
        let prepared =
            sides.into_iter().zip(names).zip(self.sources).map(|(((resource, chroma, source), name), end)| {
                let work = Work::Intake { source, format: self.format };
                cache.prepare(self, name, work, resource, chroma, MatcherResource::Texture(end))
            });
        prepared.collect()
    }

    /// The work after the chain.
    pub(crate) fn after<'a>(
        &self,
        cache: &PassCache,
        outputs: &Outputs<'a>,
        regions: &mut Regions<'a>,
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
                let formats = [TextureFormat::R32Float, TextureFormat::R16Sint, TextureFormat::R16Float];
                let method = self.method(disparity, target, &formats)?;
                let sixteenths = target.texture.format() == formats[1];
                let work = if sixteenths { Work::Sixteenths(method) } else { Work::Pixels(method) };
                prepared.push(self.shown(cache, disparity, target, work, map, regions)?);
            }
            if let Some(target) = maps.color {
                let map = there(color)?;
                let method = self.method(color, target, &COLORS)?;
                prepared.push(self.shown(cache, color, target, Work::Color(method), map, regions)?);
            }
            if let Some(place) = maps.buffer {
                prepared.push(self.copied(copy, there(copy)?, place, regions)?);
            }
        }
        let confidence = |name| there(name, self.confidence, map_bytes / 2, "confidence");
        if let Some(target) = outputs.confidence {
            let name = "the output confidence";
            let map = confidence(name)?;
            let method = self.method(name, target, &[TextureFormat::R8Unorm])?;
            prepared.push(self.shown(cache, name, target, Work::Confidence(method), map, regions)?);
        }
        if let Some(place) = outputs.confidence_buffer {
            let name = "the output confidence_buffer";
            prepared.push(self.copied(name, confidence(name)?, place, regions)?);
        }
        let depth = |name| there(name, self.depth, 2 * map_bytes, "depth");
        if let Some(target) = outputs.depth {
            let name = "the output depth";
            let map = depth(name)?;
            let formats = [TextureFormat::R32Float, TextureFormat::R32Uint, TextureFormat::R16Float];
            let method = self.method(name, target, &formats)?;
            let whole = target.texture.format() == TextureFormat::R32Uint;
            let work = if whole { Work::Micrometres(method) } else { Work::Metres(method) };
            prepared.push(self.shown(cache, name, target, work, map, regions)?);
        }
        if let Some(place) = outputs.depth_buffer {
            let name = "the output depth_buffer";
            prepared.push(self.copied(name, depth(name)?, place, regions)?);
        }
        Ok(prepared)
    }

    fn shown<'a>(
        &self,
        cache: &PassCache,
        name: &'static str,
        target: TextureLayer<'a>,
        work: Work,
        (map, bytes): (&wgpu::Buffer, u64),
        regions: &mut Regions<'a>,
    ) -> Result<Prepared, Error> {
        regions.write(name, target.into())?;
        let most = self.device.limits().max_storage_buffer_binding_size;
        if bytes > most {
            let (given, allowed) = (format!("shows {bytes} bytes"), format!("the device allows {most} a binding"));
            return Err(refused(name, &given, &allowed, "request larger limits, or take a copy in a buffer"));
        }
        let format = target.texture.format().remove_srgb_suffix();
        let target = CallerResource::Layer(target, format);
        cache.prepare(self, name, work, target, None, MatcherResource::Buffer(map, bytes))
    }

    /// How a target is filled.
    fn method(&self, name: &str, target: TextureLayer<'_>, formats: &[TextureFormat]) -> Result<WriteMethod, Error> {
        self.check_texture(name, &target, self.pixels(), false, formats, "use a texture of such a format")?;
        let (usage, format) = (target.texture.usage(), target.texture.format().remove_srgb_suffix());
        let storable = matches!(
            target.texture.format(),
            TextureFormat::R32Float | TextureFormat::R32Uint | TextureFormat::Rgba8Unorm
        );
        if usage.contains(TextureUsages::RENDER_ATTACHMENT) {
            return Ok(WriteMethod::Draw(format));
        }
        if storable && usage.contains(TextureUsages::STORAGE_BINDING) {
            return Ok(WriteMethod::Store(format));
        }
        let needed = if storable { "RENDER_ATTACHMENT or STORAGE_BINDING" } else { "RENDER_ATTACHMENT" };
        Err(lacks(name, &usage, needed))
    }

    /// A copy of the first bytes of one of the matcher's buffers.
    fn copied<'a>(
        &self,
        name: &'static str,
        (from, bytes): (&wgpu::Buffer, u64),
        BufferTarget { buffer, offset }: BufferTarget<'a>,
        regions: &mut Regions<'a>,
    ) -> Result<Prepared, Error> {
        self.check_buffer(name, buffer, (BufferUsages::COPY_DST, "COPY_DST"))?;
        if !offset.is_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT) {
            let allowed = format!("must begin at a multiple of {}", wgpu::COPY_BUFFER_ALIGNMENT);
            return Err(refused(name, &format!("begins at byte {offset}"), &allowed, "choose such a place"));
        }
        long_enough(name, buffer, offset, bytes)?;
        regions.write(name, Region::Bytes(buffer, offset, offset + bytes))?;
        Ok(Prepared::Copy { from: from.clone(), to: buffer.clone(), offset, bytes })
    }
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
