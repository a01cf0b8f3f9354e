//! The bytes that arrive, every value of them; every pipeline without a driver; and that a wrong shader is found.

mod values;
mod yuv;

use super::pipelines::{compile, filled};
use super::work::{Source, Work, WriteMethod};
use super::*;
use crate::gpu::device::Pulse;
use crate::gpu::edits::with_mutant;
use crate::gpu::kernels::tests::support;
use crate::gpu::layout::{Frame, TEXELS};
use crate::gpu::{readback, scopes};
use crate::{Image, Params, PixelFormat, Pixels, YuvColors};
use wgpu::TextureFormat;

const FORMATS: [PixelFormat; 4] = [PixelFormat::Gray8, PixelFormat::Gray16, PixelFormat::Rgba8, PixelFormat::Rgba16];

fn works() -> Vec<Work> {
    let mut works = Vec::new();
    for format in FORMATS {
        let mut sources = vec![Source::Buffer, Source::Texture { srgb: false }];
        let colors = YuvColors::Bt709;
        let yuv = [
            Source::Planes(colors),
            Source::PlaneBuffers(colors),
            Source::Packed(colors),
            Source::PackedBuffer(colors),
        ];
        match format {
            PixelFormat::Rgba8 => sources.extend([Source::Texture { srgb: true }].into_iter().chain(yuv)),
            PixelFormat::Gray8 => sources.extend(yuv),
            _ => {}
        }
        works.extend(sources.into_iter().map(|source| Work::Intake { source, format }));
    }
    works.extend(
        [TextureFormat::Rgba8Unorm, TextureFormat::Bgra8Unorm].map(|format| Work::Color(WriteMethod::Draw(format))),
    );
    works.extend([
        Work::Color(WriteMethod::Store(TextureFormat::Rgba8Unorm)),
        Work::Pixels(WriteMethod::Draw(TextureFormat::R32Float)),
        Work::Pixels(WriteMethod::Store(TextureFormat::R32Float)),
        Work::Sixteenths(WriteMethod::Draw(TextureFormat::R16Sint)),
        Work::Confidence(WriteMethod::Draw(TextureFormat::R8Unorm)),
        Work::Pixels(WriteMethod::Draw(TextureFormat::R16Float)),
        Work::Metres(WriteMethod::Draw(TextureFormat::R32Float)),
        Work::Metres(WriteMethod::Store(TextureFormat::R32Float)),
        Work::Metres(WriteMethod::Draw(TextureFormat::R16Float)),
        Work::Micrometres(WriteMethod::Draw(TextureFormat::R32Uint)),
        Work::Micrometres(WriteMethod::Store(TextureFormat::R32Uint)),
    ]);
    works
}

/// The texts of all, with the names of their first files.
pub(crate) fn texts() -> impl Iterator<Item = (&'static str, String)> {
    works().into_iter().map(|work| (work.files()[0], work.source()))
}

/// Whether wgpu accepts all pipelines on a device.
pub(crate) fn are_made(device: &wgpu::Device) -> bool {
    works().into_iter().all(|work| scopes::guarded(device, || compile(device, work)).is_ok())
}

/// With the layouts that they are bound by, and with all files of the list.
#[test]
fn pipelines_are_made_without_a_driver() {
    let (device, _) = wgpu::Device::noop(&wgpu::DeviceDescriptor::default());
    for work in works() {
        let made = scopes::guarded(&device, || compile(&device, work));
        assert!(made.is_ok(), "{work:?}: {}", made.unwrap_err());
    }
    for (file, _) in SHADERS {
        assert!(works().iter().any(|work| work.files().contains(&file)), "shaders/{file}.wgsl is used by nothing");
    }
}

/// An image that holds every value of a sample in every channel.
fn all_values(format: PixelFormat, width: u32) -> Image {
    let values = if format.is_deep() { 1 << 16 } else { 1 << 8 };
    let height = values / width + 2;
    let pixels = 0..width * height;
    let byte = |v: u32| (v % 256) as u8;
    let deep = |v: u32| (v % 65536) as u16;
    let pixels = match format {
        PixelFormat::Gray8 => Pixels::Gray8(pixels.map(byte).collect()),
        PixelFormat::Gray16 => Pixels::Gray16(pixels.map(deep).collect()),
        PixelFormat::Rgba8 => {
            Pixels::Rgba8(pixels.flat_map(|i| [i, 7 * i + 1, 255 - i % 256, 11 * i + 9].map(byte)).collect())
        }
        PixelFormat::Rgba16 => {
            Pixels::Rgba16(pixels.flat_map(|i| [i, 7 * i + 1, 65535 - i % 65536, 11 * i + 9].map(deep)).collect())
        }
    };
    Image::new(width, height, pixels).unwrap()
}

/// A device and what stands in for a matcher: textures that can be read.
struct Stand {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pulse: Pulse,
    frame: Frame,
    format: PixelFormat,
    params: Params,
    sources: [wgpu::Texture; 2],
    output: wgpu::Buffer,
    depth: wgpu::Buffer,
}

fn texture(device: &wgpu::Device, size: [u32; 2], format: TextureFormat, usage: wgpu::TextureUsages) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

impl Stand {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue, width: u32, height: u32, format: PixelFormat) -> Self {
        let bytes = u64::from(width) * u64::from(height) * u64::from(format.bytes_per_pixel());
        let rows = (bytes + 256).div_ceil(16 * u64::from(TEXELS)) as u32;
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let source = || texture(device, [TEXELS, rows], TextureFormat::Rgba32Uint, usage);
        let map_stride = width.div_ceil(2).next_multiple_of(4);
        let map = |words_a_pair: u32| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: u64::from(4 * words_a_pair * map_stride * height),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            device: device.clone(),
            queue: queue.clone(),
            pulse: Pulse::new(device, queue).unwrap(),
            frame: Frame { width, height, map_stride, source_shift: TEXELS.ilog2(), ..Frame::default() },
            format,
            params: Params::sgm(16),
            sources: [source(), source()],
            output: map(1),
            depth: map(2),
        }
    }

    fn context(&self) -> Context<'_> {
        let Self { device, queue, pulse, frame, format, params, sources, output, depth } = self;
        let (right, confidence, depth) = (None, Some(output), Some(depth));
        Context { device, queue, pulse, frame, format: *format, params, sources, output, right, confidence, depth }
    }

    fn read(&self, texture: &wgpu::Texture) -> Vec<u8> {
        let row = texture.format().block_copy_size(None).unwrap() * texture.width();
        let pitch = row.next_multiple_of(256);
        let size = u64::from(pitch) * u64::from(texture.height());
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer =
            self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.queue.submit([encoder.finish()]);
        let waiter = readback::Waiter::default();
        let copy = readback::copy(&self.device, &self.queue, &waiter, &buffer, size);
        let bytes = readback::block_on(copy).unwrap();
        bytes.chunks_exact(pitch as usize).flat_map(|bytes| &bytes[..row as usize]).copied().collect()
    }

    /// What the source of the right image holds, once it was taken from a texture or a buffer: from all of it, or with an
    /// `origin` from a part of a larger one.
    fn taken(&self, image: &Image, format: Option<TextureFormat>, origin: Option<[u32; 2]>) -> Vec<u8> {
        let cache = PassCache::default();
        let pixel = image.format().bytes_per_pixel() as usize;
        let [x, y] = origin.unwrap_or_default().map(|at| at as usize);
        let around = usize::from(origin.is_some());
        let [width, height] = [x + image.width() as usize + around, y + image.height() as usize + around];
        let row = pixel * width;
        let mut bytes = vec![0x77; row * height];
        let rows = bytes.chunks_exact_mut(row).skip(y);
        for (to, from) in rows.zip(image.bytes().chunks_exact(pixel * image.width() as usize)) {
            to[pixel * x..][..from.len()].copy_from_slice(from);
        }
        let prepared = match format {
            Some(format) => {
                if matches!(format, TextureFormat::Bgra8Unorm | TextureFormat::Bgra8UnormSrgb) {
                    bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
                }
                let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
                let texture = texture(&self.device, [width as u32, height as u32], format, usage);
                let bytes_per_row = Some(row as u32);
                let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
                self.queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
                let layer = TextureLayer::from(&texture);
                let layer = if let Some([x, y]) = origin { layer.at(x, y) } else { layer };
                self.context().before(&cache, &Inputs::textures(layer, layer), &mut Regions::default())
            }
            None => {
                let pitch = row.next_multiple_of(4) + 8;
                let mut padded = vec![0x77; pitch * height];
                for (to, from) in padded.chunks_exact_mut(pitch).zip(bytes.chunks_exact(row)) {
                    to[..row].copy_from_slice(from);
                }
                let buffer = filled(&self.context(), "image", wgpu::BufferUsages::STORAGE, &padded);
                let pixels = PixelBuffer::new(&buffer, 0, pitch as u32).at(x as u32, y as u32);
                self.context().before(&cache, &Inputs::buffers(pixels, pixels), &mut Regions::default())
            }
        };
        self.submit(&prepared.unwrap());
        self.read(&self.sources[1])
    }

    /// Writes the outputs.
    fn leave(&self, outputs: &Outputs<'_>) {
        self.submit(&self.context().after(&PassCache::default(), outputs, &mut Regions::default()).unwrap());
    }

    fn submit(&self, work: &[Prepared]) {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        work.iter().for_each(|work| work.record(&mut encoder, || None));
        self.queue.submit([encoder.finish()]);
    }
}

fn device() -> Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)> {
    support::device_with(|features, _| *features |= wgpu::Features::TEXTURE_FORMAT_16BIT_NORM)
}

/// The textures that hold samples of a format, and `None` for a buffer.
fn kinds(format: PixelFormat) -> Vec<Option<TextureFormat>> {
    use TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, R8Unorm, R16Unorm, Rgba8Unorm, Rgba8UnormSrgb, Rgba16Unorm};
    let all = [R8Unorm, R16Unorm, Rgba8Unorm, Rgba8UnormSrgb, Bgra8Unorm, Bgra8UnormSrgb, Rgba16Unorm];
    let textures = all.into_iter().filter(|&texture| PixelFormat::of(texture) == Some(format));
    textures.map(Some).chain([None]).collect()
}

/// All values, in all formats, byte for byte, as the upload leaves them: rows without padding, then nothing.
#[test]
fn every_value_arrives_as_it_is() {
    let Some((adapter, device, queue)) = device() else { return };
    for format in FORMATS {
        for width in if format.is_deep() { [33, 61, 255, 256] } else { [1, 3, 33, 256] } {
            let image = all_values(format, width);
            let stand = Stand::new(&device, &queue, width, image.height(), format);
            for kind in kinds(format) {
                let mut expected = image.bytes().to_vec();
                expected.resize(16 * (TEXELS * stand.sources[0].height()) as usize, 0);
                for origin in [None, Some([3, 2])] {
                    let got = stand.taken(&image, kind, origin);
                    let first = got.iter().zip(&expected).position(|(a, b)| a != b);
                    let name = adapter.get_info().name;
                    let case = format!("{format:?} from {kind:?}, {width} wide, from {origin:?} on, on {name}");
                    assert!(first.is_none(), "byte {first:?} of {case}");
                }
            }
        }
    }
}

/// The test of the tests: what is wrong in a shader of this list is seen.
#[test]
fn a_mutated_shader_is_caught() {
    let Some((_, device, queue)) = device() else { return };
    let mutants: [(&str, &str, &str); 22] = [
        ("intake", "x == row", "x > row"),
        ("intake", "(i % IN_WORD * BITS)", "(i % 2u * BITS)"),
        ("intake_texture", "vec4(0.5)", "vec4(0.0)"),
        ("intake_texture", "0.0031308", "0.031308"),
        ("intake_texture", "1.0 / 2.4", "1.0 / 2.2"),
        ("intake_texture", "deep.zw, vec2((x & 1u) == 1u)", "deep.xy, vec2((x & 1u) == 1u)"),
        ("intake_buffer", ".y) * dispatch.stride", ".y) * (dispatch.stride - 1u)"),
        ("intake_buffer", "dispatch.own.x * UNITS_A_PIXEL", "dispatch.own.x * 2u"),
        ("intake_buffer", "y + dispatch.own.y", "y"),
        ("intake_texture", "+ dispatch.own.x", ""),
        ("intake_texture", "y + dispatch.own.y", "y + dispatch.own.x"),
        ("surface_pixels", "/ 16.0", "/ 17.0"),
        ("surface_values", "x / 2u", "x / 4u"),
        ("surface_color", "value == STEREO_INVALID", "false"),
        ("surface_values", "(x & 3u) * 8u", "(x & 1u) * 8u"),
        ("surface_values", "half - 1u + ((n >> dropped) & 1u)", "half"),
        ("surface_values", "half - 1u + ((n >> dropped) & 1u)", "0u"),
        ("surface_values", "second % 1000000u != 0u", "false"),
        ("surface_values", "<< 3u", "<< 2u"),
        ("surface_metres", "micrometres == 0u", "false"),
        ("surface_metres", "0.00006103515625", "0.0"),
        ("surface_micrometres", "8u * frame", "4u * frame"),
    ];
    let seen = || {
        let mut seen = Vec::new();
        for format in FORMATS {
            let image = all_values(format, 33);
            let stand = Stand::new(&device, &queue, 33, image.height(), format);
            let origins = [None, Some([3, 2])];
            let all = kinds(format).into_iter().flat_map(|kind| origins.map(|origin| (kind, origin)));
            seen.extend(all.map(|(kind, origin)| stand.taken(&image, kind, origin)));
        }
        // A map with all that one may hold, and the same bytes as a confidence.
        let stand = Stand::new(&device, &queue, 35, 9, PixelFormat::Gray8);
        let bytes: Vec<u8> = (0..stand.output.size() as u32).map(|i| (i * 37 % 256) as u8).collect();
        queue.write_buffer(&stand.output, 0, &bytes);
        queue.write_buffer(&stand.output, 4, &i16::MIN.to_le_bytes().repeat(2));
        queue.write_buffer(&stand.depth, 0, bytemuck::cast_slice(&values::depths(40 * 9 + 140_000)[..40 * 9]));
        queue.write_buffer(&stand.depth, 4 * 40 * 4, bytemuck::cast_slice(&values::depths(150_000)[5000..][..40 * 5]));
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        use TextureFormat::{R8Unorm, R16Float, R16Sint, R32Float, R32Uint, Rgba8Unorm};
        let formats = [R32Float, R16Sint, R16Float, Rgba8Unorm, R8Unorm, R32Float, R16Float, R32Uint];
        let textures = formats.map(|format| texture(&device, [35, 9], format, usage));
        let to = Outputs::default();
        stand.leave(&to.disparity(&textures[0]).color(&textures[3]).confidence(&textures[4]).depth(&textures[5]));
        stand.leave(&to.disparity(&textures[1]).depth(&textures[6]));
        stand.leave(&to.disparity(&textures[2]).depth(&textures[7]));
        seen.extend(textures.iter().map(|texture| stand.read(texture)));
        seen
    };
    let right = seen();
    assert!(right == seen(), "the same twice is not the same");
    for (file, from, to) in mutants {
        let text = SHADERS.iter().find(|(name, _)| *name == file).unwrap().1;
        assert!(text.contains(from), "{from:?} is no longer in shaders/{file}.wgsl");
        assert!(right != with_mutant([file, from, to], seen), "{file} with {to:?} for {from:?} went unnoticed");
    }
}
