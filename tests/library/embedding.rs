//! The caller's textures and buffers: what is taken from them and left in them is what the upload and `output` give, to
//! the bit, and what does not fit is refused before anything is recorded.

#[path = "../../examples/embed.rs"]
mod embed;

use crate::support;
use gpu_stereo::{
    DisparityMap, Error, Image, Inputs, Matched, Outputs, Params, PixelBuffer, PixelFormat, Pixels, StereoMatcher,
    TextureLayer, wgpu,
};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// A device, and its queue.
pub struct Gpu {
    pub name: String,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

/// A device with 16-bit textures where the adapter has them, and one with WebGPU's default limits and no feature.
pub fn devices() -> Vec<Gpu> {
    let deep = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
    let full = support::device_with(|features, _| *features |= deep);
    let bare = support::device_with(|features, limits| {
        (*features, *limits) = (wgpu::Features::empty(), wgpu::Limits::default());
    });
    let gpu = |(adapter, device, queue): (wgpu::Adapter, _, _)| Gpu { name: adapter.get_info().name, device, queue };
    full.into_iter().chain(bare).map(gpu).collect()
}

impl Gpu {
    pub fn texture(&self, size: (u32, u32), format: TextureFormat, usage: TextureUsages) -> wgpu::Texture {
        support::texture(&self.device, size, format, usage)
    }

    /// A texture of an image's bytes.
    pub fn filled(&self, image: &Image, format: TextureFormat) -> wgpu::Texture {
        let size = (image.width(), image.height());
        let texture = self.texture(size, format, TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST);
        let mut bytes = bytes_of(image);
        if matches!(format, TextureFormat::Bgra8Unorm | TextureFormat::Bgra8UnormSrgb) {
            bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
        }
        let bytes_per_row = Some(image.width() * image.format().bytes_per_pixel());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
        texture
    }

    /// A texture to be shown something in.
    pub fn target(&self, size: (u32, u32), format: TextureFormat) -> wgpu::Texture {
        self.texture(size, format, TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC)
    }

    pub fn buffer(&self, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// The bytes of a buffer that may be copied from.
    pub fn read(&self, buffer: &wgpu::Buffer) -> Vec<u8> {
        let staging = self.buffer(buffer.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        staging.get_mapped_range(..).unwrap().to_vec()
    }

    /// The bytes of a texture, row by row without padding.
    pub fn read_texture(&self, texture: &wgpu::Texture) -> Vec<u8> {
        let row = texture.width() * texture.format().block_copy_size(None).unwrap();
        let pitch = row.next_multiple_of(256);
        let buffer = self.buffer(u64::from(pitch * texture.height()), BufferUsages::COPY_SRC | BufferUsages::COPY_DST);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        let mut encoder = self.encoder();
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.queue.submit([encoder.finish()]);
        self.read(&buffer).chunks_exact(pitch as usize).flat_map(|r| &r[..row as usize]).copied().collect()
    }
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn bytes_of(image: &Image) -> Vec<u8> {
    match image.pixels() {
        Pixels::Gray8(s) | Pixels::Rgba8(s) => s.clone(),
        Pixels::Gray16(s) | Pixels::Rgba16(s) => s.iter().flat_map(|v| v.to_le_bytes()).collect(),
        other => panic!("{other:?}"),
    }
}

fn number_of(format: PixelFormat) -> u32 {
    [PixelFormat::Gray8, PixelFormat::Gray16, PixelFormat::Rgba8, PixelFormat::Rgba16]
        .iter()
        .position(|f| *f == format)
        .unwrap() as u32
}

/// A pair in the samples of a format.
fn pair(size: (u32, u32), seed: u64, format: PixelFormat) -> (Image, Image) {
    let (left, right) = support::pair(size.0, size.1, seed);
    (support::as_format(&left, number_of(format)), support::as_format(&right, number_of(format)))
}

/// The bytes of a map in the layout of `output`.
fn laid_out(map: &DisparityMap, pad: &[u8]) -> Vec<u8> {
    let pitch = (2 * map.width as usize).next_multiple_of(16);
    let mut bytes = pad.to_vec();
    for (y, row) in map.data.chunks_exact(map.width as usize).enumerate() {
        for (x, value) in row.iter().enumerate() {
            bytes[y * pitch + 2 * x..][..2].copy_from_slice(&value.to_le_bytes());
        }
    }
    bytes
}

const SIZES: [(u32, u32); 4] = [(1, 1), (33, 7), (70, 41), (1, 45)];

const TEXTURES: [TextureFormat; 7] = [
    TextureFormat::R8Unorm,
    TextureFormat::R16Unorm,
    TextureFormat::Rgba8Unorm,
    TextureFormat::Rgba8UnormSrgb,
    TextureFormat::Bgra8Unorm,
    TextureFormat::Bgra8UnormSrgb,
    TextureFormat::Rgba16Unorm,
];

/// Textures of every format: the map of the uploaded bytes.
#[test]
fn a_pair_in_textures_is_the_uploaded_pair() {
    for gpu in devices() {
        let mut taken = 0;
        for format in TEXTURES {
            if !gpu.device.features().contains(format.required_features()) {
                continue;
            }
            taken += 1;
            let samples = PixelFormat::of(format).unwrap();
            for (seed, size) in (0..).zip(SIZES) {
                let (left, right) = pair(size, seed, samples);
                let params = Params::sgm(12);
                let matcher = support::matcher(&gpu.device, &gpu.queue, size, samples, &params).unwrap();
                let expected = matcher.compute_blocking(&left, &right).unwrap().map;
                // What another frame left behind.
                let (other, _) = pair(size, seed + 100, samples);
                matcher.upload(&other, &other).unwrap();

                let views = [gpu.filled(&left, format), gpu.filled(&right, format)];
                let mut encoder = gpu.encoder();
                matcher.record(&mut encoder, &Inputs::textures(&views[0], &views[1]), &Outputs::default()).unwrap();
                gpu.queue.submit([encoder.finish()]);
                let bytes = gpu.read(matcher.output());
                let case = format!("{format:?}, {size:?}, seed {seed}, on {}", gpu.name);
                assert!(laid_out(&expected, &bytes) == bytes, "{case}");
            }
        }
        assert!(taken >= 5, "only {taken} formats on {}", gpu.name);
    }
}

/// Buffers of all four kinds of samples, both images in one, behind an offset, rows padded.
#[test]
fn a_pair_in_buffers_is_the_uploaded_pair() {
    for gpu in devices() {
        for samples in [PixelFormat::Gray8, PixelFormat::Gray16, PixelFormat::Rgba8, PixelFormat::Rgba16] {
            for (seed, size) in (10..).zip(SIZES) {
                let (left, right) = pair(size, seed, samples);
                let params = Params::sgm(12);
                let matcher = support::matcher(&gpu.device, &gpu.queue, size, samples, &params).unwrap();
                let expected = matcher.compute_blocking(&left, &right).unwrap().map;
                matcher.upload(&right, &right).unwrap();

                let row = (size.0 * samples.bytes_per_pixel()) as usize;
                for pitch in [row.next_multiple_of(4), row.next_multiple_of(4) + 12] {
                    let image = |image: &Image| {
                        let mut bytes = vec![0xa5; pitch * size.1 as usize];
                        for (to, from) in bytes.chunks_exact_mut(pitch).zip(bytes_of(image).chunks_exact(row)) {
                            to[..row].copy_from_slice(from);
                        }
                        bytes.truncate(pitch * (size.1 as usize - 1) + row.next_multiple_of(4));
                        bytes
                    };
                    let second = (pitch * size.1 as usize).next_multiple_of(256) + 256;
                    let (left, right) = (image(&left), image(&right));
                    let bytes = (second + right.len()) as u64;
                    let buffer = gpu.buffer(bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST);
                    gpu.queue.write_buffer(&buffer, 256, &left);
                    gpu.queue.write_buffer(&buffer, second as u64, &right);
                    if left.len() + 256 > second {
                        panic!("the images overlap");
                    }
                    let place = |offset: usize| PixelBuffer::new(&buffer, offset as u64, pitch as u32);
                    let mut encoder = gpu.encoder();
                    matcher
                        .record(&mut encoder, &Inputs::buffers(place(256), place(second)), &Outputs::default())
                        .unwrap();
                    gpu.queue.submit([encoder.finish()]);
                    let bytes = gpu.read(matcher.output());
                    let case = format!("{samples:?}, {size:?}, pitch {pitch}, seed {seed}, on {}", gpu.name);
                    assert!(laid_out(&expected, &bytes) == bytes, "{case}");
                }
            }
        }
    }
}

/// Textures and buffers of every kind hold the map that `compute_blocking` returns, its colours, and the confidence.
#[test]
fn every_output_is_the_map() {
    for gpu in devices() {
        for (seed, size) in (20..).zip(SIZES) {
            let mut params = Params::sgm(19);
            (params.confidence, params.right_map) = (true, true);
            params.min_disparity = -3;
            let (left, right) = pair(size, seed, PixelFormat::Gray8);
            let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Gray8, &params).unwrap();
            let Matched { map, right: right_map, confidence, .. } = matcher.compute_blocking(&left, &right).unwrap();
            let case = format!("{size:?}, seed {seed}, on {}", gpu.name);
            if size.0 > 60 {
                let valid = map.valid_fraction();
                assert!(valid > 0.2 && valid < 0.99, "the map is of no use: {valid}, {case}");
            }

            let formats = [
                TextureFormat::R32Float,
                TextureFormat::R16Sint,
                TextureFormat::Rgba8Unorm,
                TextureFormat::Bgra8Unorm,
                TextureFormat::R8Unorm,
            ];
            let [pixels, sixteenths, color, bgra, sure] = formats.map(|format| gpu.target(size, format));
            let storage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
            let [stored, stored_color] =
                [TextureFormat::R32Float, TextureFormat::Rgba8Unorm].map(|format| gpu.texture(size, format, storage));
            // The bytes of an sRGB texture, drawn to as what it is without.
            let srgb = gpu.texture(
                size,
                TextureFormat::Rgba8UnormSrgb,
                TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            );
            let pitch = u64::from((2 * size.0).next_multiple_of(16));
            let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
            let copy = gpu.buffer(12 + pitch * u64::from(size.1), usage);
            let [right_pixels, right_color] =
                [TextureFormat::R32Float, TextureFormat::Rgba8Unorm].map(|format| gpu.target(size, format));
            let right_copy = gpu.buffer(pitch * u64::from(size.1), usage);
            let sure_copy = gpu.buffer(4 + pitch / 2 * u64::from(size.1), usage);

            matcher.upload(&left, &right).unwrap();
            let mut encoder = gpu.encoder();
            for outputs in [
                Outputs::default()
                    .disparity(&pixels)
                    .color(&color)
                    .buffer(&copy, 8)
                    .confidence(&sure)
                    .confidence_buffer(&sure_copy, 4),
                Outputs::default().disparity(&sixteenths).color(&bgra),
                Outputs::default().disparity(&stored).color(&stored_color),
                Outputs::default()
                    .right_disparity(&right_pixels)
                    .right_color(&right_color)
                    .right_buffer(&right_copy, 0),
                Outputs::default().color(&srgb),
            ] {
                matcher.record(&mut encoder, &Inputs::Uploaded, &outputs).unwrap();
            }
            gpu.queue.submit([encoder.finish()]);

            let floats = |map: &DisparityMap| -> Vec<u8> {
                map.data.iter().flat_map(|&v| (f32::from(v) / 16.0).to_le_bytes()).collect()
            };
            let right_map = right_map.unwrap();
            assert!(gpu.read_texture(&right_pixels) == floats(&right_map), "right R32Float, {case}");
            let expected = right_map.color(&params.searched());
            assert!(gpu.read_texture(&right_color) == expected, "right Rgba8Unorm, {case}");
            let bytes = gpu.read(&right_copy);
            assert!(laid_out(&right_map, &bytes) == bytes, "right buffer, {case}");
            if size.0 > 60 {
                assert!(right_map != map, "both views have one map, {case}");
            }

            let expected = floats(&map);
            assert!(gpu.read_texture(&pixels) == expected, "R32Float, {case}");
            assert!(gpu.read_texture(&stored) == expected, "R32Float as storage, {case}");
            let expected: Vec<u8> = map.data.iter().flat_map(|v| v.to_le_bytes()).collect();
            assert!(gpu.read_texture(&sixteenths) == expected, "R16Sint, {case}");
            let mut expected = map.color(&params.searched());
            assert!(gpu.read_texture(&color) == expected, "Rgba8Unorm, {case}");
            assert!(gpu.read_texture(&stored_color) == expected, "Rgba8Unorm as storage, {case}");
            assert!(gpu.read_texture(&srgb) == expected, "Rgba8Unorm of Rgba8UnormSrgb, {case}");
            expected.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
            assert!(gpu.read_texture(&bgra) == expected, "Bgra8Unorm, {case}");
            let confidence = confidence.unwrap();
            assert!(gpu.read_texture(&sure) == confidence.data, "R8Unorm, {case}");

            let bytes = gpu.read(&copy);
            assert!(bytes[..8] == [0; 8] && bytes[bytes.len() - 4..] == [0; 4], "beyond its place, {case}");
            assert!(laid_out(&map, &bytes[8..]) == bytes[8..], "buffer, {case}");
            let bytes = gpu.read(&sure_copy);
            let rows = bytes[4..].chunks_exact(pitch as usize / 2);
            assert!(rows.flat_map(|row| &row[..size.0 as usize]).eq(&confidence.data), "confidence buffer, {case}");
        }
    }
}

/// Every value that a range of disparities may give has its colour, and all channels of a colour arrive.
#[test]
fn colors_follow_the_parameters() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let (left, right) = pair((90, 30), 3, PixelFormat::Gray8);
    let target = gpu.target((90, 30), TextureFormat::Rgba8Unorm);
    let mut matcher =
        StereoMatcher::new(&gpu.device, &gpu.queue, 90, 30, PixelFormat::Gray8, &Params::sgm(16)).unwrap();
    let mut seen = Vec::new();
    for (min_disparity, disparities) in [(0, 16), (-2, 16), (0, 40), (4, 1), (0, 16)] {
        let mut params = Params::sgm(disparities);
        params.min_disparity = min_disparity;
        matcher.set_params(&params).unwrap();
        let map = matcher.compute_blocking(&left, &right).unwrap().map;
        matcher.upload(&left, &right).unwrap();
        let mut encoder = gpu.encoder();
        matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default().color(&target)).unwrap();
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read_texture(&target);
        assert!(bytes == map.color(&params.searched()), "{params:?}, seed 3");
        seen.push(bytes);
    }
    assert!(seen[0] == seen[4] && seen[0] != seen[1] && seen[0] != seen[2], "all ranges have the same colours");
}

/// After a change of size the inputs and outputs are those of the new one, and a texture of the old one is refused.
#[test]
fn a_resized_matcher_takes_textures_of_its_size() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let mut matcher =
        StereoMatcher::new(&gpu.device, &gpu.queue, 70, 40, PixelFormat::Gray8, &Params::sgm(16)).unwrap();
    let mut others = Vec::new();
    for (seed, size) in (0..).zip([(70, 40), (33, 21), (90, 11), (70, 40)]) {
        matcher.resize(size.0, size.1).unwrap();
        let (left, right) = pair(size, seed, PixelFormat::Gray8);
        let expected = matcher.compute_blocking(&left, &right).unwrap().map;
        matcher.upload(&right, &right).unwrap();
        let views = [&left, &right].map(|image| gpu.filled(image, TextureFormat::R8Unorm));
        let target = gpu.target(size, TextureFormat::R16Sint);
        let mut encoder = gpu.encoder();
        let outputs = Outputs::default().disparity(&target);
        for other in others.iter().filter(|other: &&wgpu::Texture| other.size() != target.size()) {
            let error = matcher.record(&mut encoder, &Inputs::textures(other, other), &outputs).unwrap_err();
            assert!(error.to_string().contains(&format!("{}x{}", size.0, size.1)), "{error}");
        }
        matcher.record(&mut encoder, &Inputs::textures(&views[0], &views[1]), &outputs).unwrap();
        gpu.queue.submit([encoder.finish()]);
        let expected: Vec<u8> = expected.data.iter().flat_map(|v| v.to_le_bytes()).collect();
        assert!(gpu.read_texture(&target) == expected, "{size:?}, seed {seed}");
        others.extend(views);
    }
}

/// The caller's shader, which reads the disparity: the near half of a range is painted by depth.
const NEAR: &str = "
    @group(0) @binding(0) var disparity: texture_2d<f32>;
    @vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
        return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
    }
    @fragment fn near(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
        return max(textureLoad(disparity, vec2<u32>(at.xy), 0).x - 4.0, 0.0);
    }";

/// Two matchers, and in between and behind them the caller's passes, in one encoder that is submitted once.
#[test]
fn matchers_and_the_callers_passes_share_an_encoder() {
    for gpu in devices() {
        let size = (50, 37);
        let (left, right) = pair(size, 8, PixelFormat::Rgba8);
        let views = [gpu.filled(&left, TextureFormat::Rgba8Unorm), gpu.filled(&right, TextureFormat::Rgba8Unorm)];
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(NEAR.into()),
        });
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(TextureFormat::R32Float.into())],
            }),
            multiview_mask: None,
            cache: None,
        });

        let chains = [Params::sgm(14), Params::bm(21)];
        let matchers = chains
            .each_ref()
            .map(|params| support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Rgba8, params).unwrap());
        let mut encoder = gpu.encoder();
        let mut drawn = Vec::new();
        // Both matchers leave their map in the same texture, one after the other.
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let disparity = gpu.texture(size, TextureFormat::R32Float, usage);
        for matcher in &matchers {
            let outputs = Outputs::default().disparity(&disparity);
            matcher.record(&mut encoder, &Inputs::textures(&views[0], &views[1]), &outputs).unwrap();
            let target = gpu.target(size, TextureFormat::R32Float);
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view(&disparity)),
                }],
            });
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view(&target),
                    depth_slice: None,
                    resolve_target: None,
                    ops: Default::default(),
                })],
                ..Default::default()
            });
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.draw(0..3, 0..1);
            drop(pass);
            drawn.push(target);
        }
        gpu.queue.submit([encoder.finish()]);

        let mut different = Vec::new();
        for ((matcher, target), params) in matchers.iter().zip(&drawn).zip(&chains) {
            let map = matcher.compute_blocking(&left, &right).unwrap().map;
            let expected: Vec<u8> =
                map.data.iter().flat_map(|&v| (f32::from(v) / 16.0 - 4.0).max(0.0).to_le_bytes()).collect();
            assert!(expected.iter().any(|&byte| byte != 0), "nothing is near, seed 8");
            assert!(gpu.read_texture(target) == expected, "{params:?}, seed 8, on {}", gpu.name);
            different.push(expected);
        }
        assert!(different[0] != different[1], "both matchers gave the same");
    }
}

/// A mistake, and what its message must say.
struct Mistake<'a> {
    inputs: Inputs<'a>,
    outputs: Outputs<'a>,
    says: &'a [&'a str],
}

#[test]
fn what_does_not_fit_is_refused_and_nothing_is_recorded() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let size = (20, 10);
    let (left, right) = pair(size, 1, PixelFormat::Rgba8);
    let mut params = Params::sgm(8);
    let [all, none] = [true, false].map(|confidence| {
        params.confidence = confidence;
        StereoMatcher::new(&gpu.device, &gpu.queue, 20, 10, PixelFormat::Rgba8, &params).unwrap()
    });

    let good = gpu.filled(&left, TextureFormat::Rgba8Unorm);
    let sample = TextureUsages::TEXTURE_BINDING;
    let draw = TextureUsages::RENDER_ATTACHMENT;
    let of = |size, format, usage| gpu.texture(size, format, usage);
    let small = of((20, 9), TextureFormat::Rgba8Unorm, sample);
    let gray = of(size, TextureFormat::R8Unorm, sample);
    let unbound = of(size, TextureFormat::Rgba8Unorm, TextureUsages::COPY_DST);
    let many = |change: fn(&mut wgpu::TextureDescriptor<'_>)| {
        let mut descriptor = wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 20, height: 10, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TextureFormat::Rgba8Unorm,
            usage: sample | draw,
            view_formats: &[],
        };
        change(&mut descriptor);
        gpu.device.create_texture(&descriptor)
    };
    let mips = many(|d| d.mip_level_count = 2);
    let samples = many(|d| d.sample_count = 4);
    let layers = many(|d| d.size.depth_or_array_layers = 2); // its view is of all layers
    let solid = many(|d| (d.dimension, d.usage) = (wgpu::TextureDimension::D3, TextureUsages::TEXTURE_BINDING));
    let float = of(size, TextureFormat::R32Float, draw);
    let wide = of((21, 10), TextureFormat::R32Float, draw);
    let unwritable = of(size, TextureFormat::R32Float, sample);
    let stored_only = of(size, TextureFormat::Bgra8Unorm, sample);
    let srgb = many(|d| d.format = TextureFormat::Rgba8UnormSrgb); // with no other format for its views
    let sure = of(size, TextureFormat::R8Unorm, draw);

    let storage = gpu.buffer(20 * 4 * 10 + 256, BufferUsages::STORAGE);
    let copies = gpu.buffer(48 * 10, BufferUsages::COPY_DST);
    let nothing = gpu.buffer(4096, BufferUsages::COPY_SRC);
    let pixels = |buffer, offset, pitch| {
        Inputs::buffers(PixelBuffer::new(buffer, 0, 80), PixelBuffer::new(buffer, offset, pitch))
    };
    let textures_of = |right| Inputs::textures(&good, right);
    let textures = |right| textures_of(TextureLayer::from(right));
    let (from, to) = (Inputs::Uploaded, Outputs::default());
    let mistakes = [
        Mistake { inputs: textures(&small), outputs: to, says: &["the right input", "20x9", "20x10", "resize"] },
        Mistake { inputs: textures(&gray), outputs: to, says: &["R8Unorm", "Rgba8Unorm or", "PixelFormat::Gray8"] },
        Mistake { inputs: textures(&float), outputs: to, says: &["R32Float", "Rgba8Unorm or", "copy or draw"] },
        Mistake {
            inputs: Inputs::textures(&unbound, &good),
            outputs: to,
            says: &["the left input", "COPY_DST", "TEXTURE_BINDING"],
        },
        Mistake { inputs: textures(&mips), outputs: to, says: &["1 samples", "2 mip levels"] },
        Mistake { inputs: textures(&samples), outputs: to, says: &["4 samples", "resolve"] },
        Mistake { inputs: textures(&layers), outputs: to, says: &["the right input", "2 layers", "TextureLayer::new"] },
        Mistake {
            inputs: textures_of(TextureLayer::new(&layers, 2)),
            outputs: to,
            says: &["the right input", "layer 2", "has 2, counted from 0"],
        },
        Mistake { inputs: textures(&solid), outputs: to, says: &["D3", "D2"] },
        Mistake { inputs: pixels(&nothing, 0, 80), outputs: to, says: &["COPY_SRC", "needs STORAGE"] },
        Mistake { inputs: pixels(&storage, 100, 80), outputs: to, says: &["byte 100", "multiple of"] },
        Mistake { inputs: pixels(&storage, 0, 81), outputs: to, says: &["81 bytes a row", "multiple of 4"] },
        Mistake { inputs: pixels(&storage, 0, 76), outputs: to, says: &["76 bytes a row", "at least 80"] },
        Mistake { inputs: pixels(&storage, 512, 80), outputs: to, says: &["1056 bytes", "800 are needed", "byte 512"] },
        Mistake { inputs: pixels(&storage, 256, 84), outputs: to, says: &["1056 bytes", "836 are needed", "byte 256"] },
        Mistake { inputs: pixels(&storage, 0, !3), outputs: to, says: &["needed from byte 0"] },
        Mistake { inputs: from, outputs: to.disparity(&wide), says: &["the output disparity", "21x10", "20x10"] },
        Mistake {
            inputs: from,
            outputs: to.disparity(&good),
            says: &["Rgba8Unorm", "R32Float or R16Sint or R16Float"],
        },
        Mistake {
            inputs: from,
            outputs: to.disparity(&unwritable),
            says: &["TEXTURE_BINDING", "RENDER_ATTACHMENT or STORAGE_BINDING"],
        },
        Mistake { inputs: from, outputs: to.color(&stored_only), says: &["needs RENDER_ATTACHMENT;"] },
        Mistake { inputs: from, outputs: to.color(&sure), says: &["R8Unorm", "Rgba8Unorm or Bgra8Unorm"] },
        Mistake {
            inputs: from,
            outputs: to.color(&srgb),
            says: &["the output color was refused", "Rgba8Unorm among its view_formats"],
        },
        Mistake { inputs: from, outputs: to.color(&mips), says: &["2 mip levels"] },
        Mistake { inputs: from, outputs: to.buffer(&copies, 2), says: &["byte 2,", "multiple of 4"] },
        Mistake { inputs: from, outputs: to.buffer(&copies, 4), says: &["480 bytes", "480 are needed from byte 4 on"] },
        Mistake { inputs: from, outputs: to.buffer(&copies, u64::MAX - 3), says: &["480 are needed"] },
        Mistake { inputs: from, outputs: to.buffer(&nothing, 0), says: &["needs COPY_DST"] },
        Mistake { inputs: from, outputs: to.buffer(all.output(), 0), says: &["the matcher's own buffer"] },
        Mistake { inputs: from, outputs: to.confidence(&float), says: &["R32Float", "must be R8Unorm"] },
        Mistake { inputs: from, outputs: to.right_disparity(&float), says: &["right_disparity", "Params::right_map"] },
        Mistake { inputs: from, outputs: to.right_color(&float), says: &["right_color", "Params::right_map"] },
        Mistake { inputs: from, outputs: to.right_buffer(&copies, 0), says: &["right_buffer", "Params::right_map"] },
    ];
    let unasked = [
        Mistake { inputs: from, outputs: to.confidence(&sure), says: &["Params::confidence"] },
        Mistake { inputs: from, outputs: to.confidence_buffer(&copies, 0), says: &["Params::confidence"] },
    ];
    let cases = mistakes.iter().map(|m| (&all, m)).chain(unasked.iter().map(|m| (&none, m)));
    for (i, (matcher, Mistake { inputs, outputs, says })) in cases.enumerate() {
        matcher.upload(&left, &right).unwrap();
        let sentinel = vec![0x5a; matcher.output().size() as usize];
        gpu.queue.write_buffer(matcher.output(), 0, &sentinel);
        let mut encoder = gpu.encoder();
        // What fits beside the mistake is not recorded either.
        let error = matcher.record(&mut encoder, inputs, outputs).unwrap_err();
        gpu.queue.submit([encoder.finish()]);
        assert!(gpu.read(matcher.output()) == sentinel, "mistake {i} recorded something: {error}");
        assert!(matches!(error, Error::Image(_)), "mistake {i}: {error:?}");
        let text = error.to_string();
        assert!(!text.contains('\n') && text.contains("; "), "mistake {i}: no line, or no remedy: {text}");
        assert!(says.iter().all(|part| text.contains(part)), "mistake {i}: {text:?} does not say {says:?}");
    }
    let mut encoder = gpu.encoder();
    all.record(&mut encoder, &textures(&good), &to.disparity(&float).confidence(&sure).buffer(&copies, 0)).unwrap();
    gpu.queue.submit([encoder.finish()]);
}

/// A lost device is no mistake of the texture's.
#[test]
fn a_lost_device_is_told_as_such() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let (left, _) = pair((20, 10), 1, PixelFormat::Gray8);
    let matcher = StereoMatcher::new(&gpu.device, &gpu.queue, 20, 10, PixelFormat::Gray8, &Params::sgm(8)).unwrap();
    let views = [gpu.filled(&left, TextureFormat::R8Unorm), gpu.filled(&left, TextureFormat::R8Unorm)];
    let target = gpu.target((20, 10), TextureFormat::R32Float);
    let mut encoder = gpu.encoder();
    let (inputs, outputs) = (Inputs::textures(&views[0], &views[1]), Outputs::default().disparity(&target));
    matcher.record(&mut encoder, &inputs, &outputs).unwrap();
    matcher.forget_resources(); // all pipelines are there, and only bind groups are to be made
    drop(encoder);
    gpu.device.destroy();
    let mut encoder = gpu.encoder();
    let error = matcher.record(&mut encoder, &inputs, &outputs).unwrap_err();
    assert!(matches!(error, Error::Lost(_)), "{error:?}");
}

/// A layer of a texture with two is an image like any other; a pair from a headset comes so.
#[test]
fn layers_of_one_texture_are_a_pair() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let (left, right) = pair((37, 20), 5, PixelFormat::Rgba8);
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 37, height: 20, depth_or_array_layers: 2 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8UnormSrgb,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes = [bytes_of(&left), bytes_of(&right)].concat();
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * 37), rows_per_image: Some(20) };
    gpu.queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
    let layers = [0, 1].map(|layer| TextureLayer::new(&texture, layer));
    let matcher = StereoMatcher::new(&gpu.device, &gpu.queue, 37, 20, PixelFormat::Rgba8, &Params::sgm(16)).unwrap();
    let expected = matcher.compute_blocking(&left, &right).unwrap().map;
    let mut encoder = gpu.encoder();
    matcher.record(&mut encoder, &Inputs::textures(layers[0], layers[1]), &Outputs::default()).unwrap();
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read(matcher.output());
    assert!(laid_out(&expected, &bytes) == bytes, "seed 5");
}

/// The README's program is the one of the crate's documentation, which is compiled as its test.
#[test]
fn the_readme_shows_what_is_compiled() {
    let readme = include_str!("../../README.md");
    let documentation = include_str!("../../src/lib.rs");
    let block = |text: &str, from: &str, to: &str| -> String {
        let (_, rest) = text.split_once(from).unwrap_or_else(|| panic!("no {from:?}"));
        rest.split_once(to).unwrap_or_else(|| panic!("no {to:?}")).0.into()
    };
    let compiled = block(documentation, "//! ```no_run\n", "//! ```\n");
    let compiled: String = compiled
        .lines()
        .map(|line| format!("{}\n", line.strip_prefix("//! ").or(line.strip_prefix("//!")).unwrap()))
        .collect();
    assert_eq!(block(readme, "## In another program", "\n## ").matches("```rust\n").count(), 1);
    assert_eq!(block(readme, "```rust\n", "```\n"), compiled, "README.md (left) and src/lib.rs (right)");
}

#[test]
fn the_example_gets_what_it_drew() {
    if support::device().is_some() {
        embed::main().unwrap();
    }
}
