//! Pictures in Y, U and V arrive as the image that src/yuv.rs makes of them.

use super::*;
use crate::Error;

const COLORS: [YuvColors; 4] = [YuvColors::Bt601, YuvColors::Bt601Full, YuvColors::Bt709, YuvColors::Bt709Full];

/// How the caller gives a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Nv12,
    Planes,
    PlaneBuffers,
    Packed,
    PackedBuffer,
}

const KINDS: [Kind; 5] = [Kind::Nv12, Kind::Planes, Kind::PlaneBuffers, Kind::Packed, Kind::PackedBuffer];

/// Bytes without order, the same each time.
fn bytes(count: u32, seed: u32) -> Vec<u8> {
    (0..count).map(|i| (i.wrapping_add(seed).wrapping_mul(0x9e37_79b9) >> 23) as u8).collect()
}

/// A picture of odd or even sides.
struct Picture {
    width: u32,
    height: u32,
    luma: Vec<u8>,
    /// For two columns and two rows, or for two columns of each row.
    chroma: [Vec<u8>; 2],
}

impl Picture {
    fn new(width: u32, height: u32) -> Self {
        let row = 2 * width.div_ceil(2);
        let chroma = [bytes(row * height.div_ceil(2), 7), bytes(row * height, 9)];
        Self { width, height, luma: bytes(width * height, 3), chroma }
    }

    /// In YUYV.
    fn packed(&self) -> Vec<u8> {
        let row = 2 * self.width.div_ceil(2) as usize;
        let mut packed = Vec::new();
        for (luma, chroma) in self.luma.chunks_exact(self.width as usize).zip(self.chroma[1].chunks_exact(row)) {
            for (x, value) in chroma.iter().enumerate() {
                packed.extend([luma.get(x).copied().unwrap_or(0x55), *value]);
            }
        }
        packed
    }

    /// The bytes of the image that arrives, of the part that a matcher takes.
    fn expected(&self, kind: Kind, colors: YuvColors, stand: &Stand, [x, y]: [u32; 2]) -> Vec<u8> {
        let Self { width, height, luma, chroma } = self;
        let colored = match kind {
            Kind::Packed | Kind::PackedBuffer => colors.yuyv(*width, *height, &self.packed()),
            _ => colors.nv12(*width, *height, luma, &chroma[0]),
        };
        let colored = colored.unwrap();
        let (pixel, samples) = match stand.format {
            PixelFormat::Gray8 => (1, &luma[..]),
            _ => (4, colored.bytes()),
        };
        let rows = samples.chunks_exact(pixel * *width as usize).skip(y as usize).take(stand.frame.height as usize);
        let part = rows.flat_map(|row| &row[pixel * x as usize..][..pixel * stand.frame.width as usize]);
        let mut expected: Vec<u8> = part.copied().collect();
        expected.resize(16 * (TEXELS * stand.sources[0].height()) as usize, 0);
        expected
    }
}

impl Stand {
    fn sampled(&self, [width, height]: [u32; 2], format: TextureFormat, bytes: &[u8]) -> wgpu::Texture {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = texture(&self.device, [width, height], format, usage);
        let bytes_per_row = Some(bytes.len() as u32 / height);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        texture
    }

    /// A buffer with rows of `row` bytes, padded by some, and the bytes of a row.
    fn rows(&self, row: u32, bytes: &[u8]) -> (wgpu::Buffer, u32) {
        let pitch = row.next_multiple_of(4) + 8;
        let mut padded = vec![0x77; pitch as usize * bytes.len() / row as usize];
        for (to, from) in padded.chunks_exact_mut(pitch as usize).zip(bytes.chunks_exact(row as usize)) {
            to[..from.len()].copy_from_slice(from);
        }
        (filled(&self.context(), "rows", wgpu::BufferUsages::STORAGE, &padded), pitch)
    }

    /// What the source of the right image holds, once a picture was taken.
    fn taken_yuv(&self, picture: &Picture, kind: Kind, colors: YuvColors, [x, y]: [u32; 2], whole: bool) -> Vec<u8> {
        let &Picture { width, height, ref luma, ref chroma } = picture;
        let half = [width, height].map(|side| side.div_ceil(2));
        let take = |picture: YuvPicture<'_>| {
            let picture = if whole { picture } else { picture.at(x, y) };
            let taken =
                self.context().before(&PassCache::default(), &Inputs::yuv(picture, picture), &mut Regions::default());
            self.submit(&taken.unwrap());
            self.read(&self.sources[1])
        };
        match kind {
            Kind::Nv12 => {
                let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
                let texture = texture(&self.device, [width, height], TextureFormat::NV12, usage);
                for (aspect, bytes, size, row) in [
                    (wgpu::TextureAspect::Plane0, luma, [width, height], width),
                    (wgpu::TextureAspect::Plane1, &chroma[0], half, 2 * half[0]),
                ] {
                    let to = wgpu::TexelCopyTextureInfo { aspect, ..texture.as_image_copy() };
                    let bytes_per_row = Some(row);
                    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
                    let size = wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 };
                    self.queue.write_texture(to, bytes, layout, size);
                }
                take(YuvPicture::nv12(&texture, colors))
            }
            Kind::Planes => {
                let luma = self.sampled([width, height], TextureFormat::R8Unorm, luma);
                let chroma = self.sampled(half, TextureFormat::Rg8Unorm, &chroma[0]);
                take(YuvPicture::planes(&luma, &chroma, colors))
            }
            Kind::Packed => {
                let packed = self.sampled([half[0], height], TextureFormat::Rgba8Unorm, &picture.packed());
                take(YuvPicture::yuyv(&packed, colors))
            }
            Kind::PlaneBuffers => {
                let [(luma, pitch), (chroma, chroma_pitch)] =
                    [self.rows(width, luma), self.rows(2 * half[0], &chroma[0])];
                let [luma, chroma] = [PixelBuffer::new(&luma, 0, pitch), PixelBuffer::new(&chroma, 0, chroma_pitch)];
                take(YuvPicture::nv12_buffers(luma, chroma, colors))
            }
            Kind::PackedBuffer => {
                let (packed, pitch) = self.rows(4 * half[0], &picture.packed());
                take(YuvPicture::yuyv_buffer(PixelBuffer::new(&packed, 0, pitch), colors))
            }
        }
    }
}

/// A device that has NV12, if there is one.
fn device() -> Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)> {
    support::device_with(|features, _| *features |= wgpu::Features::TEXTURE_FORMAT_NV12)
}

fn has_nv12() -> bool {
    use std::io::Write as _;
    let adapter = support::device_with(|_, _| ()).map(|(adapter, ..)| adapter);
    let has = adapter.is_some_and(|adapter| adapter.features().contains(wgpu::Features::TEXTURE_FORMAT_NV12));
    if !has {
        let _ = writeln!(std::io::stderr(), "NOT TESTED: textures in NV12, which the adapter has not");
    }
    has
}

#[test]
fn pictures_in_y_u_and_v_arrive_as_their_image() {
    let nv12 = has_nv12();
    let Some((adapter, device, queue)) = (if nv12 { device() } else { support::device_with(|_, _| ()) }) else {
        return;
    };
    for format in [PixelFormat::Gray8, PixelFormat::Rgba8] {
        for (width, height, origin) in
            [(64, 34, [0, 0]), (1, 1, [0, 0]), (33, 7, [0, 0]), (31, 12, [3, 5]), (30, 9, [8, 2])]
        {
            let stand = Stand::new(&device, &queue, width, height, format);
            let whole = origin == [0, 0];
            let beyond = u32::from(!whole);
            let picture = Picture::new(origin[0] + width + beyond, origin[1] + height + beyond);
            for kind in KINDS {
                // The sides of a texture in NV12 are even.
                if kind == Kind::Nv12 && !(nv12 && picture.width.is_multiple_of(2) && picture.height.is_multiple_of(2))
                {
                    continue;
                }
                for colors in COLORS {
                    let expected = picture.expected(kind, colors, &stand, origin);
                    let got = stand.taken_yuv(&picture, kind, colors, origin, whole);
                    let first = got.iter().zip(&expected).position(|(a, b)| a != b);
                    let name = adapter.get_info().name;
                    let case =
                        format!("{format:?} of {kind:?} in {colors:?}, {width}x{height} from {origin:?} on {name}");
                    assert!(first.is_none(), "byte {first:?} of {case}");
                }
            }
        }
    }
}

/// The test of the test above.
#[test]
fn a_mutated_shader_of_y_u_and_v_is_caught() {
    let Some((_, device, queue)) = support::device_with(|_, _| ()) else { return };
    let seen = || {
        let mut seen = Vec::new();
        for format in [PixelFormat::Gray8, PixelFormat::Rgba8] {
            let stand = Stand::new(&device, &queue, 31, 12, format);
            let picture = Picture::new(35, 18);
            for kind in &KINDS[1..] {
                seen.push(stand.taken_yuv(&picture, *kind, YuvColors::Bt601, [3, 5], false));
            }
        }
        seen
    };
    let right = seen();
    assert!(right == seen(), "the same twice is not the same");
    for (file, from, to) in [
        ("intake_yuv", "sum + 32768", "sum"),
        ("intake_yuv", "clamp((sum + 32768) >> 16u, 0, 255)", "(sum + 32768) >> 16u"),
        ("intake_yuv", "vec2(128)", "vec2(127)"),
        ("intake_yuv", "V_RED * chroma.y", "V_RED * chroma.x"),
        ("intake_yuv", "- V_GREEN", "+ V_GREEN"),
        ("intake_yuv", "- Y_ZERO", ""),
        ("intake_yuv", "x + dispatch.own.x", "x"),
        ("intake_planes", "at / vec2(2u)", "(at + vec2(1u)) / vec2(2u)"),
        ("intake_planes", ".x * 255.0", ".x * 254.0"),
        ("intake_plane_buffers", "(at.x & 3u) * 8u", "(at.x & 1u) * 8u"),
        ("intake_plane_buffers", "(at.x & 2u) == 2u", "(at.x & 1u) == 1u"),
        ("intake_plane_buffers", "at.y / 2u", "(at.y + 1u) / 2u"),
        ("intake_packed", "(at.x & 1u) == 1u", "false"),
        ("intake_packed", ".yw", ".wy"),
        ("intake_packed_buffer", "(at.x & 1u) == 1u", "false"),
        ("intake_packed_buffer", "at.y * dispatch.stride", "at.y * (dispatch.stride - 1u)"),
    ] {
        let text = SHADERS.iter().find(|(name, _)| *name == file).unwrap().1;
        assert!(text.contains(from), "{from:?} is no longer in shaders/{file}.wgsl");
        assert!(right != with_mutant([file, from, to], seen), "{file} with {to:?} for {from:?} went unnoticed");
    }
}

/// A picture that does not fit is an error that names it.
#[test]
fn pictures_that_do_not_fit_are_refused() {
    let Some((_, device, queue)) = support::device_with(|_, _| ()) else { return };
    let stand = Stand::new(&device, &queue, 20, 10, PixelFormat::Rgba8);
    let deep = Stand::new(&device, &queue, 20, 10, PixelFormat::Gray16);
    let usage = wgpu::TextureUsages::TEXTURE_BINDING;
    let of = |size, format| texture(&device, size, format, usage);
    let luma = of([20, 10], TextureFormat::R8Unorm);
    let large = of([26, 14], TextureFormat::R8Unorm);
    let chroma = of([10, 5], TextureFormat::Rg8Unorm);
    let packed = of([10, 10], TextureFormat::Rgba8Unorm);
    let unbound = texture(&device, [10, 5], TextureFormat::Rg8Unorm, wgpu::TextureUsages::COPY_DST);
    let buffer = filled(&stand.context(), "buffer", wgpu::BufferUsages::STORAGE, &[0; 400]);
    let pixels = PixelBuffer::new(&buffer, 0, 20);
    let colors = YuvColors::Bt709;
    let planes = |luma, chroma| YuvPicture::planes(luma, chroma, colors);
    let good = planes(&luma, &chroma);
    let mistakes: Vec<(&Stand, YuvPicture<'_>, &[&str])> = vec![
        (&deep, good, &["the right input", "Gray16", "PixelFormat::Gray8", "PixelFormat::Rgba8"]),
        (&stand, planes(&chroma, &luma), &["the right input", "10x5", "20x10"]),
        (&stand, planes(&luma, &luma), &["the chroma of the right input", "20x10", "10x5"]),
        (&stand, planes(&large, &chroma), &["the right input", "26x14"]),
        (&stand, planes(&large, &chroma).at(6, 4), &["the chroma of the right input", "10x5", "13x7"]),
        (&stand, planes(&large, &chroma).at(7, 4), &["the right input", "column 7, row 4", "26x14"]),
        (&stand, planes(&luma, &unbound), &["the chroma of the right input", "COPY_DST", "TEXTURE_BINDING"]),
        (&stand, YuvPicture::yuyv(&luma, colors), &["the right input", "20x10", "10x10"]),
        (&stand, YuvPicture::yuyv(&packed, colors).at(1, 0), &["the right input", "11x10", "10x10"]),
        (&stand, YuvPicture::nv12(&luma, colors), &["the right input", "R8Unorm", "must be NV12", "YuvPicture::"]),
        (
            &stand,
            YuvPicture::planes(&luma, TextureLayer::from(&chroma).at(0, 0), colors),
            &["the chroma of the right input", "begins where Y does"],
        ),
        (&stand, YuvPicture::yuyv_buffer(pixels, colors), &["20 bytes a row", "at least 40"]),
        (
            &stand,
            YuvPicture::nv12_buffers(pixels, PixelBuffer::new(&buffer, 256, 32), colors),
            &["the chroma of the right input", "400 bytes", "148 are needed from byte 256 on"],
        ),
        (
            &stand,
            YuvPicture::nv12_buffers(pixels, PixelBuffer::new(&buffer, 256, 16), colors),
            &["the chroma of the right input", "16 bytes a row", "at least 20"],
        ),
        (&stand, YuvPicture::nv12_buffers(pixels, pixels.at(0, 1), colors), &["begins where Y does"]),
    ];
    for (i, (stand, picture, says)) in mistakes.into_iter().enumerate() {
        let inputs = Inputs::Yuv { left: if stand.format.is_deep() { picture } else { good }, right: picture };
        let Err(error) = stand.context().before(&PassCache::default(), &inputs, &mut Regions::default()) else {
            panic!("mistake {i} was taken")
        };
        assert!(matches!(error, Error::Image(_)), "mistake {i}: {error:?}");
        let text = error.to_string();
        assert!(!text.contains('\n') && text.contains("; "), "mistake {i}: no line, or no remedy: {text}");
        let says =
            says.iter().map(|part| if stand.format.is_deep() { part.replace("right", "left") } else { (*part).into() });
        says.for_each(|part| assert!(text.contains(&part), "mistake {i}: {text:?} does not say {part:?}"));
    }
}
