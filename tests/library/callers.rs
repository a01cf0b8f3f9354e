//! What renderers need of a matcher on their device: depth in textures, buffers that they decode themselves or read in a shader,
//! parts of larger pictures, and timestamps in their own queries.

use std::io::Write as _;

use crate::embedding::{Gpu, devices};
use crate::support;
use gpu_stereo::{
    Camera, DepthMap, Error, Image, Inputs, MapFormat, MapLayout, Outputs, Params, PixelBuffer, PixelFormat, Pixels,
    StereoMatcher, TextureLayer, Timestamps, YuvColors, YuvPicture, wgpu,
};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Settings that compute all maps.
fn all_maps() -> Params {
    let mut params = Params::sgm(19);
    (params.confidence, params.right_map, params.min_disparity) = (true, true, -3);
    params.depth = Some(Camera::new(711.5, 0.193).with_doffs(4.25));
    params
}

const SIZES: [(u32, u32); 4] = [(1, 1), (33, 7), (70, 41), (1, 45)];

/// The depth in textures and in a buffer is that of `compute_blocking`.
#[test]
fn the_depth_leaves_as_it_is_computed() {
    for gpu in devices() {
        for (seed, size) in (40..).zip(SIZES) {
            let (left, right) = support::pair(size.0, size.1, seed);
            let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Gray8, &all_maps()).unwrap();
            let depth = matcher.compute_blocking(&left, &right).unwrap().depth.unwrap();
            let case = format!("{size:?}, seed {seed}, on {}", gpu.name);
            if size.0 > 60 {
                let deep = depth.data.iter().filter(|&&value| value != DepthMap::NONE).count();
                assert!(deep > depth.data.len() / 5 && deep < depth.data.len(), "{deep} depths, {case}");
            }
            let metres: Vec<u8> = depth.metres().iter().flat_map(|v| v.to_le_bytes()).collect();
            let micrometres: Vec<u8> = depth.data.iter().flat_map(|v| v.to_le_bytes()).collect();
            let stored = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
            let textures = [
                (gpu.target(size, TextureFormat::R32Float), &metres),
                (gpu.target(size, TextureFormat::R32Uint), &micrometres),
                (gpu.texture(size, TextureFormat::R32Float, stored), &metres),
                (gpu.texture(size, TextureFormat::R32Uint, stored), &micrometres),
            ];
            let half = gpu.target(size, TextureFormat::R16Float);
            let layout = matcher.layout(MapFormat::Depth);
            let copy = gpu.buffer(12 + layout.bytes(), BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
            matcher.upload(&left, &right).unwrap();
            let mut encoder = gpu.encoder();
            for (texture, _) in &textures {
                matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default().depth(texture)).unwrap();
            }
            let outputs = Outputs::default().depth(&half).depth_buffer(&copy, 8);
            matcher.record(&mut encoder, &Inputs::Uploaded, &outputs).unwrap();
            gpu.queue.submit([encoder.finish()]);
            for (texture, expected) in &textures {
                let usage = texture.usage();
                assert!(gpu.read_texture(texture) == **expected, "{:?} {usage:?}, {case}", texture.format());
            }
            // src/gpu/interop/tests/values.rs has every value of a half.
            let halves = gpu.read_texture(&half);
            for (bytes, metres) in halves.chunks_exact(2).zip(depth.metres()) {
                let near = f64::from(half_of(u16::from_le_bytes([bytes[0], bytes[1]]))) - f64::from(metres);
                assert!(near.abs() <= f64::from(metres) / 2048.0, "{metres} m, {case}");
            }
            let bytes = gpu.read(&copy);
            assert!(bytes[..8] == [0; 8] && bytes[bytes.len() - 4..] == [0; 4], "beyond its place, {case}");
            assert!(layout.depths(&bytes[8..]).unwrap() == depth, "buffer, {case}");
        }
    }
}

/// A 16-bit float of a normal number, or 0.
fn half_of(bits: u16) -> f32 {
    if bits == 0 { 0.0 } else { f32::from_bits((u32::from(bits) << 13) + (112 << 23)) }
}

/// The layouts are those of the matcher's buffers, decoders refuse what is no such map.
#[test]
fn buffers_are_decoded_by_their_layout() {
    for gpu in devices() {
        for (seed, size) in (50..).zip(SIZES) {
            let (left, right) = support::pair(size.0, size.1, seed);
            let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Gray8, &all_maps()).unwrap();
            let matched = matcher.compute_blocking(&left, &right).unwrap();
            let [map, confidence, depth] =
                [MapFormat::Disparity, MapFormat::Confidence, MapFormat::Depth].map(|format| matcher.layout(format));
            let case = format!("{size:?}, seed {seed}, on {}", gpu.name);
            for (layout, a_pixel, multiple) in [(map, 2, 16), (confidence, 1, 8), (depth, 4, 32)] {
                assert_eq!((layout.width, layout.height), size, "{case}");
                assert_eq!(layout.format.bytes_per_pixel(), a_pixel);
                assert_eq!(layout.bytes_per_row, (a_pixel * size.0).next_multiple_of(multiple), "{case}");
                assert_eq!(layout.bytes(), u64::from(layout.bytes_per_row) * u64::from(size.1), "{case}");
            }
            let output = gpu.read(matcher.output());
            assert!(map.disparities(&output).unwrap() == matched.map, "{case}");
            assert!(Some(map.disparities(&gpu.read(matcher.right().unwrap())).unwrap()) == matched.right, "{case}");
            let bytes = gpu.read(matcher.confidence().unwrap());
            assert!(Some(confidence.confidences(&bytes).unwrap()) == matched.confidence, "{case}");
            assert!(Some(depth.depths(&gpu.read(matcher.depth().unwrap())).unwrap()) == matched.depth, "{case}");

            let short = &output[..map.bytes() as usize - 1];
            for (error, says) in [
                (map.disparities(short).unwrap_err(), ["fewer", "read the whole copy"]),
                (map.depths(&output).unwrap_err(), ["Disparity", "MapFormat::Depth"]),
                (map.confidences(&output).unwrap_err(), ["Disparity", "MapFormat::Confidence"]),
                (depth.disparities(&output).unwrap_err(), ["Depth", "MapFormat::Disparity"]),
                (confidence.confidences(&[]).unwrap_err(), ["0 bytes", "a row"]),
            ] {
                let text = error.to_string();
                assert!(matches!(error, Error::Image(_)), "{error:?}");
                let says = says.map(|word| if word == "fewer" { "in all" } else { word });
                assert!(says.iter().all(|word| text.contains(word)) && !text.contains('\n'), "{text:?}: {says:?}");
            }
        }
    }
}

/// A caller's kernel that reads the buffers with [`MapLayout::WGSL`]: disparity in 1/16 px, confidence and bits of the metres of each pixel.
const READER: &str = "
    struct Rows { width: u32, height: u32, map: u32, confidence: u32, depth: u32 }
    @group(0) @binding(0) var<uniform> rows: Rows;
    @group(0) @binding(1) var<storage, read> map: array<u32>;
    @group(0) @binding(2) var<storage, read> confidence: array<u32>;
    @group(0) @binding(3) var<storage, read> depth: array<u32>;
    @group(0) @binding(4) var<storage, read_write> pixels: array<vec4<u32>>;
    @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if id.x >= rows.width || id.y >= rows.height {
            return;
        }
        let value = stereo_disparity(map[stereo_disparity_word(id.x, id.y, rows.map)], id.x);
        let sure = stereo_confidence(confidence[stereo_confidence_word(id.x, id.y, rows.confidence)], id.x);
        let metres = stereo_metres(depth[stereo_depth_word(id.x, id.y, rows.depth)]);
        let none = select(0u, 1u, value == STEREO_INVALID);
        pixels[id.y * rows.width + id.x] = vec4(bitcast<u32>(value), sure, bitcast<u32>(metres), none);
    }";

#[test]
fn a_shader_reads_the_buffers() {
    for gpu in devices() {
        let (seed, size) = (60, (71, 42));
        let (left, right) = support::pair(size.0, size.1, seed);
        let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Gray8, &all_maps()).unwrap();
        let matched = matcher.compute_blocking(&left, &right).unwrap();
        let source = wgpu::ShaderSource::Wgsl([READER, MapLayout::WGSL].concat().into());
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let row = |format| matcher.layout(format).bytes_per_row;
        let rows = [size.0, size.1, row(MapFormat::Disparity), row(MapFormat::Confidence), row(MapFormat::Depth)];
        let uniform = gpu.buffer(20, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        gpu.queue.write_buffer(&uniform, 0, &rows.map(u32::to_le_bytes).concat());
        let pixels = gpu.buffer(u64::from(16 * size.0 * size.1), BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let buffers = [&uniform, matcher.output(), matcher.confidence().unwrap(), matcher.depth().unwrap(), &pixels];
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = &pipeline.get_bind_group_layout(0);
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        let bind_group = gpu.device.create_bind_group(&descriptor);
        let mut encoder = gpu.encoder();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(size.0.div_ceil(8), size.1.div_ceil(8), 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        let (confidence, depth) = (matched.confidence.unwrap(), matched.depth.unwrap());
        let expected: Vec<u8> = (matched.map.data.iter())
            .zip(&confidence.data)
            .zip(depth.metres())
            .flat_map(|((&value, &sure), metres)| {
                let none = u32::from(value == gpu_stereo::DisparityMap::INVALID);
                [i32::from(value) as u32, sure.into(), metres.to_bits(), none]
            })
            .flat_map(u32::to_le_bytes)
            .collect();
        assert!(gpu.read(&pixels) == expected, "seed {seed}, on {}", gpu.name);
    }
}

/// Columns and rows of a part of an image.
fn cut(image: &Image, [x, y]: [u32; 2], (width, height): (u32, u32)) -> Image {
    let Pixels::Rgba8(samples) = image.pixels() else { panic!("made from colours") };
    let rows = samples.chunks_exact(4 * image.width() as usize).skip(y as usize).take(height as usize);
    let part = rows.flat_map(|row| &row[4 * x as usize..][..4 * width as usize]).copied().collect();
    Image::new(width, height, Pixels::Rgba8(part)).unwrap()
}

/// Parts of textures and buffers are the images that are cut out; the columns at which they begin shift disparities as documented.
#[test]
fn a_part_of_a_picture_is_a_pair() {
    for gpu in devices() {
        let (seed, whole, size) = (70, (120, 50), (70, 31));
        let (left, right) = support::pair(whole.0, whole.1, seed);
        let (left, right) = (support::as_format(&left, 2), support::as_format(&right, 2));
        let textures = [&left, &right].map(|image| gpu.filled(image, TextureFormat::Rgba8Unorm));
        let bytes = |image: &Image| match image.pixels() {
            Pixels::Rgba8(samples) => samples.clone(),
            other => panic!("{other:?}"),
        };
        let buffers = [&left, &right].map(|image| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            let buffer = gpu.buffer(u64::from(4 * whole.0 * whole.1), usage);
            gpu.queue.write_buffer(&buffer, 0, &bytes(image));
            buffer
        });
        let mut maps = Vec::new();
        for [l, r, y] in [[0, 0, 0], [33, 33, 7], [40, 29, 19], [50, 50, 19]] {
            let mut params = Params::sgm(16);
            params.min_disparity = r as i32 - l as i32;
            let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Rgba8, &params).unwrap();
            let parts = [cut(&left, [l, y], size), cut(&right, [r, y], size)];
            let expected = gpu_stereo::reference::compute(&parts[0], &parts[1], &params).unwrap();
            let layers = [TextureLayer::from(&textures[0]).at(l, y), TextureLayer::from(&textures[1]).at(r, y)];
            let pixels = [0, 1].map(|i| PixelBuffer::new(&buffers[i], 0, 4 * whole.0).at([l, r][i], y));
            let layout = matcher.layout(MapFormat::Disparity);
            for inputs in [Inputs::textures(layers[0], layers[1]), Inputs::buffers(pixels[0], pixels[1])] {
                matcher.compute_blocking(&cut(&left, [1, 1], size), &cut(&left, [9, 1], size)).unwrap();
                let mut encoder = gpu.encoder();
                matcher.record(&mut encoder, &inputs, &Outputs::default()).unwrap();
                gpu.queue.submit([encoder.finish()]);
                let got = layout.disparities(&gpu.read(matcher.output())).unwrap();
                assert!(got == expected, "{inputs:?}, seed {seed}, on {}", gpu.name);
            }
            maps.push((l, r, expected));
        }
        // A shift of the right part by 11 px takes 11 px from all disparities, but for what the border changes.
        let (l, r, shifted) = &maps[2];
        let params = Params::sgm(16);
        let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Rgba8, &params).unwrap();
        let [left, right] = [&left, &right].map(|image| cut(image, [*l, 19], size));
        let map = matcher.compute_blocking(&left, &right).unwrap().map;
        let pairs = map.data.iter().zip(&shifted.data).filter(|(a, b)| **a != i16::MIN && **b != i16::MIN);
        let (same, all) = pairs.fold((0, 0), |(same, all), (a, b)| {
            (same + u32::from(i32::from(*a) == i32::from(*b) + 16 * (*l as i32 - *r as i32)), all + 1)
        });
        assert!(all > 500 && same * 5 > all * 4, "{same} of {all} disparities, seed {seed}, on {}", gpu.name);
    }
}

/// Both views in one texture, side by side and one above the other.
#[test]
fn both_views_in_one_texture_are_a_pair() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let (seed, size) = (75, (40, 21));
    let (left, right) = support::pair(size.0, size.1, seed);
    let images = [support::as_format(&left, 2), support::as_format(&right, 2)];
    let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Rgba8, &Params::sgm(16)).unwrap();
    let expected = matcher.compute_blocking(&images[0], &images[1]).unwrap().map;
    for (whole, origins) in [((80, 21), [[0, 0], [40, 0]]), ((40, 42), [[0, 21], [0, 0]])] {
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let texture = gpu.texture(whole, TextureFormat::Bgra8UnormSrgb, usage);
        for (image, [x, y]) in images.iter().zip(origins) {
            let Pixels::Rgba8(samples) = image.pixels() else { panic!("made from colours") };
            let bytes: Vec<u8> = samples.chunks_exact(4).flat_map(|p| [p[2], p[1], p[0], p[3]]).collect();
            let to = wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: 0 }, ..texture.as_image_copy() };
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(160), rows_per_image: None };
            let extent = wgpu::Extent3d { width: 40, height: 21, depth_or_array_layers: 1 };
            gpu.queue.write_texture(to, &bytes, layout, extent);
        }
        let [left, right] = origins.map(|[x, y]| TextureLayer::from(&texture).at(x, y));
        let mut encoder = gpu.encoder();
        matcher.record(&mut encoder, &Inputs::textures(left, right), &Outputs::default()).unwrap();
        gpu.queue.submit([encoder.finish()]);
        let got = matcher.layout(MapFormat::Disparity).disparities(&gpu.read(matcher.output())).unwrap();
        assert!(got == expected, "{origins:?}, seed {seed}, on {}", gpu.name);
    }
}

/// A pair in NV12 and in YUYV gives the map of the images that `YuvColors` makes of it; of gray matchers, of Y.
/// src/gpu/interop/tests/yuv.rs has every kind of textures and buffers.
#[test]
fn a_pair_in_y_u_and_v_is_a_pair() {
    for gpu in devices() {
        let (seed, size, colors) = (85, (58, 30), YuvColors::Bt709);
        let (left, right) = support::pair(size.0, size.1, seed);
        let images = [left, right].map(|image| {
            let Pixels::Gray8(luma) = image.pixels().clone() else { panic!("made from gray") };
            let chroma: Vec<u8> = (0..58 * 15).map(|i| luma[i * 2] / 2 + 60).collect();
            let packed: Vec<u8> = luma.iter().zip(luma.iter().rev()).flat_map(|(y, uv)| [*y, uv / 3 + 80]).collect();
            (image, luma, chroma, packed)
        });
        let filled = |size: (u32, u32), format, bytes: &[u8]| {
            let texture = gpu.texture(size, format, TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST);
            let bytes_per_row = Some(bytes.len() as u32 / size.1);
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
            texture
        };
        let textures = images.each_ref().map(|(_, luma, chroma, packed)| {
            let luma = filled(size, TextureFormat::R8Unorm, luma);
            (
                luma,
                filled((29, 15), TextureFormat::Rg8Unorm, chroma),
                filled((29, 30), TextureFormat::Rgba8Unorm, packed),
            )
        });
        let planes = textures.each_ref().map(|(luma, chroma, _)| YuvPicture::planes(luma, chroma, colors));
        let packed = textures.each_ref().map(|(_, _, packed)| YuvPicture::yuyv(packed, colors));
        let nv12 = images.each_ref().map(|(_, luma, chroma, _)| colors.nv12(size.0, size.1, luma, chroma).unwrap());
        let yuyv = images.each_ref().map(|(_, _, _, packed)| colors.yuyv(size.0, size.1, packed).unwrap());
        let gray = images.each_ref().map(|(image, ..)| image.clone());
        let params = Params::sgm(16);
        for (pictures, [left, right]) in [(planes, &gray), (packed, &gray), (planes, &nv12), (packed, &yuyv)] {
            let expected = gpu_stereo::reference::compute(left, right, &params).unwrap();
            let matcher = support::matcher(&gpu.device, &gpu.queue, size, left.format(), &params).unwrap();
            let mut encoder = gpu.encoder();
            let inputs = Inputs::yuv(pictures[0], pictures[1]);
            matcher.record(&mut encoder, &inputs, &Outputs::default()).unwrap();
            gpu.queue.submit([encoder.finish()]);
            let got = matcher.layout(MapFormat::Disparity).disparities(&gpu.read(matcher.output())).unwrap();
            assert!(got == expected, "{inputs:?}, seed {seed}, on {}", gpu.name);
        }
    }
}

/// Timestamps of a frame and of its stages rise, lie where the spans say, and change no bit of the map.
#[test]
fn timestamps_are_in_the_callers_queries() {
    let Some(gpu) = devices().into_iter().next() else { return };
    if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        // Past libtest's capture, which hides what a passing test prints.
        let _ = writeln!(std::io::stderr(), "NOT TESTED: timestamps, which {} has not", gpu.name);
        return;
    }
    let (seed, size) = (80, (70, 41));
    let (left, right) = support::pair(size.0, size.1, seed);
    for params in [all_maps(), Params::bm(16)] {
        let matcher = support::matcher(&gpu.device, &gpu.queue, size, PixelFormat::Gray8, &params).unwrap();
        let expected = matcher.compute_blocking(&left, &right).unwrap().map;
        let views = [&left, &right].map(|image| gpu.filled(image, TextureFormat::R8Unorm));
        let target = gpu.target(size, TextureFormat::R32Float);
        let color = gpu.target(size, TextureFormat::Rgba8Unorm);
        matcher.upload(&left, &right).unwrap();
        let inputs = [Inputs::textures(&views[0], &views[1]), Inputs::Uploaded];
        let outputs = [Outputs::default().disparity(&target).color(&color), Outputs::default()];
        for (inputs, outputs) in inputs.iter().zip(&outputs) {
            let textures = matches!(inputs, Inputs::Textures { .. });
            for stages in [false, true] {
                let (first, count) = (3, 3 + matcher.stage_queries());
                let queries = gpu.queries(count, wgpu::QueryType::Timestamp);
                let times =
                    if stages { Timestamps::stages(&queries, first) } else { Timestamps::frame(&queries, first) };
                matcher.compute_blocking(&right, &right).unwrap();
                let mut encoder = gpu.encoder();
                let spans = matcher.record_timed(&mut encoder, inputs, outputs, times).unwrap();
                let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
                let resolved = gpu.buffer(8 * u64::from(count), usage);
                let end = spans[spans.len() - 1].end;
                encoder.resolve_query_set(&queries, first..end + 1, &resolved, 0);
                gpu.queue.submit([encoder.finish()]);
                let got = matcher.layout(MapFormat::Disparity).disparities(&gpu.read(matcher.output())).unwrap();
                assert!(got == expected, "{params:?}, seed {seed}, on {}", gpu.name);

                let bytes = gpu.read(&resolved);
                let stamps: Vec<u64> =
                    bytes.chunks_exact(8).map(|stamp| u64::from_le_bytes(stamp.try_into().unwrap())).collect();
                let mut before = 1;
                for span in &spans {
                    let [begin, end] = [span.begin, span.end].map(|query| stamps[(query - first) as usize]);
                    assert!(before <= begin && begin <= end, "{spans:?} {stamps:?} on {}", gpu.name);
                    before = end;
                }
                let names: Vec<&str> = spans.iter().map(|span| span.name).collect();
                if !stages {
                    assert_eq!((names, spans[0].begin, spans[0].end), (vec!["frame"], first, first + 1));
                    continue;
                }
                assert!(end < count, "{end} of {count}");
                assert_eq!(
                    spans.iter().flat_map(|s| [s.begin, s.end]).collect::<Vec<_>>(),
                    Vec::from_iter(first..=end)
                );
                assert_eq!(names[0] == "intake", textures, "{names:?}");
                assert_eq!(names[names.len() - 1] == "outputs", textures, "{names:?}");
                let (_, timed) = matcher.compute_timed_blocking(&left, &right).unwrap();
                assert!(timed.iter().all(|stage| names.contains(&stage.name.as_str())), "{names:?} {timed:?}");
            }
        }
    }
}

/// A query set that does not fit is an error before anything is recorded.
#[test]
fn queries_that_do_not_fit_are_refused() {
    let Some(gpu) = devices().into_iter().next() else { return };
    if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        // Past libtest's capture, which hides what a passing test prints.
        let _ = writeln!(std::io::stderr(), "NOT TESTED: timestamps, which {} has not", gpu.name);
        return;
    }
    let (left, right) = support::pair(20, 10, 1);
    let matcher = support::matcher(&gpu.device, &gpu.queue, (20, 10), PixelFormat::Gray8, &Params::sgm(8)).unwrap();
    matcher.upload(&left, &right).unwrap();
    let few = gpu.queries(4, wgpu::QueryType::Timestamp);
    let occlusion = gpu.queries(64, wgpu::QueryType::Occlusion);
    let (_, other, other_queue) = support::device().unwrap();
    let foreign =
        other.create_query_set(&wgpu::QuerySetDescriptor { label: None, ty: wgpu::QueryType::Timestamp, count: 64 });
    let sentinel = vec![0x5a; matcher.output().size() as usize];
    gpu.queue.write_buffer(matcher.output(), 0, &sentinel);
    for (timestamps, says) in [
        (Timestamps::frame(&few, 3), ["4 queries", "2 are needed from query 3 on"]),
        (Timestamps::frame(&few, u32::MAX), ["4 queries", "from query 4294967295 on"]),
        (Timestamps::stages(&few, 0), ["4 queries", "StereoMatcher::stage_queries"]),
        (Timestamps::frame(&occlusion, 0), ["Occlusion", "type Timestamp"]),
        (Timestamps::frame(&foreign, 0), ["was refused by the device", "create it with the device"]),
    ] {
        let mut encoder = gpu.encoder();
        let error = matcher.record_timed(&mut encoder, &Inputs::Uploaded, &Outputs::default(), timestamps).unwrap_err();
        gpu.queue.submit([encoder.finish()]);
        assert!(matches!(error, Error::Misuse(_)), "{error:?}");
        let text = error.to_string();
        assert!(says.iter().all(|word| text.contains(word)) && !text.contains('\n'), "{text:?} does not say {says:?}");
        assert!(gpu.read(matcher.output()) == sentinel, "something was recorded: {text}");
    }
    drop(other_queue);
}

/// Parts that do not lie in their pictures, or are no pair, and outputs that cannot be written.
#[test]
fn parts_and_depths_that_do_not_fit_are_refused() {
    let Some(gpu) = devices().into_iter().next() else { return };
    let size = (20, 10);
    let matcher = StereoMatcher::new(&gpu.device, &gpu.queue, 20, 10, PixelFormat::Rgba8, &all_maps()).unwrap();
    let flat = StereoMatcher::new(&gpu.device, &gpu.queue, 20, 10, PixelFormat::Rgba8, &Params::sgm(8)).unwrap();
    let sample = TextureUsages::TEXTURE_BINDING;
    let [large, other] = [(); 2].map(|()| gpu.texture((40, 12), TextureFormat::Rgba8Unorm, sample));
    let whole = TextureLayer::from(&large);
    let buffer = gpu.buffer(160 * 12, BufferUsages::STORAGE);
    let second = gpu.buffer(160 * 12, BufferUsages::STORAGE);
    let pixels = PixelBuffer::new(&buffer, 0, 160);
    let float = gpu.target(size, TextureFormat::R32Float);
    let sint = gpu.target(size, TextureFormat::R16Sint);
    let sampled = gpu.texture(size, TextureFormat::R32Uint, sample);
    let half = gpu.texture(size, TextureFormat::R16Float, sample | TextureUsages::COPY_SRC);
    let copies = gpu.buffer(96 * 10, BufferUsages::COPY_DST);
    let (from, to) = (Inputs::Uploaded, Outputs::default());
    let textures = |left, right| Inputs::textures(left, right);
    let mistakes: Vec<(&StereoMatcher, Inputs<'_>, Outputs<'_>, &[&str])> = vec![
        (&matcher, textures(whole, whole.at(20, 0)), to, &["the left input", "40x12", "TextureLayer::at"]),
        (&matcher, textures(whole.at(0, 0), whole.at(21, 0)), to, &["the right input", "column 21, row 0", "20x10"]),
        (&matcher, textures(whole.at(0, 3), whole.at(20, 0)), to, &["the left input", "row 3", "40x12"]),
        (&matcher, textures(whole.at(!0, !0), whole.at(20, 0)), to, &["the left input", "column 4294967295"]),
        (
            &matcher,
            textures(whole.at(0, 1), TextureLayer::from(&other).at(0, 2)),
            to,
            &["the right input", "begins in row 2", "row 1 of another picture", "rows in common"],
        ),
        (&matcher, Inputs::buffers(pixels, pixels.at(21, 0)), to, &["160 bytes a row", "at least 164", "column 21"]),
        (&matcher, Inputs::buffers(pixels.at(!0, 0), pixels), to, &["the left input", "column 4294967295"]),
        (&matcher, Inputs::buffers(pixels, pixels.at(0, 3)), to, &["the right input", "1920 bytes", "2000 are needed"]),
        (
            &matcher,
            Inputs::buffers(pixels, PixelBuffer::new(&second, 0, 160).at(0, 1)),
            to,
            &["the right input", "begins in row 1", "row 0 of another picture"],
        ),
        (
            &matcher,
            from,
            to.disparity(TextureLayer::from(&float).at(0, 0)),
            &["whole layer", "without TextureLayer::at"],
        ),
        (&matcher, from, to.depth(&sint), &["the output depth", "R16Sint", "R32Float or R32Uint or R16Float"]),
        (&matcher, from, to.depth(&sampled), &["TEXTURE_BINDING", "RENDER_ATTACHMENT or STORAGE_BINDING"]),
        (&matcher, from, to.depth(&half), &["needs RENDER_ATTACHMENT;"]),
        (&matcher, from, to.depth_buffer(&copies, 4), &["the output depth_buffer", "960 are needed from byte 4 on"]),
        (&matcher, from, to.depth_buffer(matcher.depth().unwrap(), 0), &["the matcher's own buffer"]),
        (&flat, from, to.depth(&float), &["the output depth", "Params::depth"]),
        (&flat, from, to.depth_buffer(&copies, 0), &["the output depth_buffer", "Params::depth"]),
        (&matcher, from, to.depth(&float).disparity(&float), &["the output depth", "overlaps", "the output disparity"]),
    ];
    for (i, (matcher, inputs, outputs, says)) in mistakes.into_iter().enumerate() {
        let sentinel = vec![0x5a; matcher.output().size() as usize];
        gpu.queue.write_buffer(matcher.output(), 0, &sentinel);
        let mut encoder = gpu.encoder();
        let error = matcher.record(&mut encoder, &inputs, &outputs).unwrap_err();
        gpu.queue.submit([encoder.finish()]);
        assert!(gpu.read(matcher.output()) == sentinel, "mistake {i} recorded something: {error}");
        assert!(matches!(error, Error::Image(_)), "mistake {i}: {error:?}");
        let text = error.to_string();
        assert!(!text.contains('\n') && text.contains("; "), "mistake {i}: no line, or no remedy: {text}");
        assert!(says.iter().all(|part| text.contains(part)), "mistake {i}: {text:?} does not say {says:?}");
    }
}

impl Gpu {
    fn queries(&self, count: u32, ty: wgpu::QueryType) -> wgpu::QuerySet {
        self.device.create_query_set(&wgpu::QuerySetDescriptor { label: None, ty, count })
    }
}
