//! From the uploaded images to the planes that the matching cost compares.

use crate::buffers::{Frame, Pass, TEXELS, TEXTURE_ROW};
use crate::kernels;
use crate::steps::Bound::{self, Buffer, Texture};
use crate::steps::{Builder, Output};
use crate::{Cost, PixelFormat, Prefilter};

/// What the cost compares of each image: in buffers, and in textures if the kernel that takes them wants those.
pub(super) struct Planes {
    pub(super) buffers: [wgpu::Buffer; 2],
    pub(super) textures: Vec<wgpu::TextureView>,
    /// The gray images in 8 bits.
    pub(super) grays: Vec<wgpu::TextureView>,
    /// What pairs of values cost, if the cost is looked up.
    pub(super) table: Option<wgpu::TextureView>,
}

impl Planes {
    /// What a kernel that compares pixels is bound to: the table comes last.
    pub(super) fn with_table<'a>(&'a self, storage: &[Bound<'a>]) -> Vec<Bound<'a>> {
        storage.iter().copied().chain(self.table.as_ref().map(Texture)).collect()
    }
}

/// An image with a value a pixel: in a texture, of 8 or 16 bits.
struct Picture {
    side: usize,
    channel: usize,
    texels: wgpu::TextureView,
    deep: bool,
}

impl Picture {
    /// A step of a kernel that reads the picture: [`Builder::step`], compiled for its depth.
    fn step(
        &self,
        b: &mut Builder<'_>,
        name: &str,
        storage: &[Bound<'_>],
        pass: Pass,
        [lines, rows]: [u32; 2],
        output: Output,
    ) {
        let depth = if self.deep { PixelFormat::Gray16 } else { PixelFormat::Gray8 };
        let format = std::mem::replace(&mut b.format, depth);
        b.step(name, storage, pass, lines, rows, output);
        b.format = format;
    }
}

/// The textures into which images are uploaded.
pub(super) fn sources(b: &mut Builder<'_>) -> [wgpu::Texture; 2] {
    let rows = (b.sizes.source / TEXTURE_ROW) as u32;
    ["source.left", "source.right"].map(|name| b.texture(name, [TEXELS, rows], rows, wgpu::TextureFormat::Rgba32Uint))
}

/// Stage `rectify` of both sides, if it is wanted: the images that the chain takes.
pub(super) fn rectified(b: &mut Builder<'_>, sources: [wgpu::TextureView; 2]) -> [wgpu::TextureView; 2] {
    let Some(rectification) = b.params.rectify.clone() else { return sources };
    let rows = (b.sizes.source / TEXTURE_ROW) as u32;
    let mut side = 0;
    sources.map(|source| {
        let numbers = rectification.positions(side).iter().flatten().map(|&number| number as u32).collect();
        let positions = b.table("rectify.positions", numbers);
        let image = b.buffer("rectify", b.sizes.source);
        let storage = [Texture(&source), Buffer(&positions), Buffer(&image)];
        b.step("rectify", &storage, Pass::default(), TEXELS, rows, Output::Rectified { side });
        side += 1;
        b.copy_to_texels()
    })
}

/// Stages `gray`, `prefilter` and `features` of both sides.
pub(super) fn planes(b: &mut Builder<'_>, sources: &[wgpu::TextureView; 2]) -> Planes {
    let Frame { height, .. } = b.sizes.frame;
    let buffers = [b.buffer("features.left", b.sizes.left), b.buffer("features.right", b.sizes.right)];
    let scratch = Sums::new(b);
    let (mut textures, mut grays) = (Vec::new(), Vec::new());
    for (side, buffer) in buffers.iter().enumerate() {
        let source = source_of(b, sources, side);
        let place = place_of(b, side);
        let channels = b.params.channels();
        let planes = b.params.planes() / channels;
        let luma = gray(b, &source, side);
        grays.push(luma.clone());
        for channel in 0..channels {
            let picture = picture_of(b, &source, &luma, side, channel);
            let first_plane = channel * planes;
            let pass = Pass { first_plane, ..place };
            let (first, count) = (first_plane as usize, planes as usize);
            let output = Output::Features { side, first, count };
            if b.params.compares_values() {
                prefilter(b, &picture, &scratch, buffer, pass, output);
                continue;
            }
            let picture = match b.params.prefilter {
                Prefilter::None => picture,
                _ => filtered(b, &picture, &scratch, Output::Prefiltered { side, channel: channel as usize }),
            };
            let block = b.params.block;
            if b.params.cost == Cost::ZeroMeanSad {
                scratch.compute(
                    b,
                    &picture,
                    block,
                    Output::WindowSums { side, channel: 0, filtered: true, window: block },
                );
            }
            let storage = [Texture(&picture.texels), Buffer(&scratch.sums), Buffer(buffer)];
            picture.step(b, "features", &storage, pass, [pass.stride / 4, height], output);
        }
        if b.sizes.small_block && !b.plan.lanes {
            let rows = b.params.planes() * height;
            textures.push(b.copy_to_texture([place.stride, rows], rows, wgpu::TextureFormat::R32Uint));
        }
    }
    Planes { buffers, textures, grays, table: None }
}

/// The uploaded image of a side: a pair is mirrored with its sides exchanged.
fn source_of(b: &Builder<'_>, sources: &[wgpu::TextureView; 2], side: usize) -> wgpu::TextureView {
    sources[if b.mirrored { 1 - side } else { side }].clone()
}

/// Where the bytes of a side lie in its planes.
fn place_of(b: &Builder<'_>, side: usize) -> Pass {
    let Frame { width, min_disparity, block_radius, left_stride, right_stride, .. } = b.sizes.frame;
    let radius = block_radius as i32;
    if side == 0 {
        return Pass { lead: radius, stride: left_stride, ..Pass::default() };
    }
    let lead = width as i32 - 1 + radius - min_disparity;
    Pass { mirrored: 1, lead, stride: right_stride, ..Pass::default() }
}

/// Stages `gray` and `prefilter` of both sides, for a cost that looks values up: the gray images, and the values in 8
/// bits, laid out like those.
pub(super) fn values(
    b: &mut Builder<'_>,
    sources: &[wgpu::TextureView; 2],
) -> (Vec<wgpu::TextureView>, [wgpu::TextureView; 2]) {
    let scratch = Sums::new(b);
    let mut grays = Vec::new();
    let values = [0, 1].map(|side: usize| {
        let source = source_of(b, sources, side);
        let luma = gray(b, &source, side);
        grays.push(luma.clone());
        let picture = picture_of(b, &source, &luma, side, 0);
        if b.params.prefilter == Prefilter::None && !picture.deep {
            return luma;
        }
        filtered(b, &picture, &scratch, Output::Values { side }).texels
    });
    (grays, values)
}

/// The planes of values that [`values`] left, or that were halved.
pub(super) fn planes_of(b: &mut Builder<'_>, values: &[wgpu::TextureView; 2], grays: &[wgpu::TextureView]) -> Planes {
    let wanted = std::mem::replace(&mut b.params.prefilter, Prefilter::None);
    let buffers = [b.buffer("features.left", b.sizes.left), b.buffer("features.right", b.sizes.right)];
    let scratch = Sums::new(b);
    let mut textures = Vec::new();
    for (side, texels) in values.iter().enumerate() {
        let picture = Picture { side, channel: 0, texels: texels.clone(), deep: false };
        let (place, output) = (place_of(b, side), Output::Features { side, first: 0, count: 1 });
        prefilter(b, &picture, &scratch, &buffers[side], place, output);
        if b.sizes.small_block && !b.plan.lanes {
            let rows = b.sizes.frame.height;
            textures.push(b.copy_to_texture([place.stride, rows], rows, wgpu::TextureFormat::R32Uint));
        }
    }
    b.params.prefilter = wanted;
    Planes { buffers, textures, grays: grays.to_vec(), table: None }
}

/// What is prefiltered: luma that is there already, or [`channel_of`].
fn picture_of(
    b: &mut Builder<'_>,
    source: &wgpu::TextureView,
    luma: &wgpu::TextureView,
    side: usize,
    channel: u32,
) -> Picture {
    match (b.params.color_cost, b.format) {
        (false, PixelFormat::Gray8 | PixelFormat::Rgba8) => {
            Picture { side, channel: 0, texels: luma.clone(), deep: false }
        }
        _ => channel_of(b, source, side, channel),
    }
}

/// Stage `gray`: luma in 8 bits.
fn gray(b: &mut Builder<'_>, source: &wgpu::TextureView, side: usize) -> wgpu::TextureView {
    let Frame { height, gray_stride, .. } = b.sizes.frame;
    let gray = b.buffer("gray", b.sizes.gray);
    let output = Output::Gray { side, channel: 0, deep: false };
    let pass = Pass { reversed: b.mirrored.into(), ..Pass::default() };
    b.step("gray", &[Texture(source), Buffer(&gray)], pass, gray_stride, height, output);
    b.copy_to_texels()
}

/// The image that the cost is to compare, at the depth of its samples: luma, or a colour.
fn channel_of(b: &mut Builder<'_>, source: &wgpu::TextureView, side: usize, channel: u32) -> Picture {
    let Frame { height, gray_stride, .. } = b.sizes.frame;
    let deep = b.format.is_deep();
    let channel_number = if b.params.color_cost { channel + 1 } else { 0 };
    let pass = Pass { channel: channel_number, reversed: b.mirrored.into(), ..Pass::default() };
    let output = Output::Gray { side, channel: pass.channel as usize, deep };
    let (name, bytes, stride) = match deep {
        true => ("deep_gray", 2 * b.sizes.gray, 2 * gray_stride),
        false => ("gray", b.sizes.gray, gray_stride),
    };
    let picture = b.buffer(name, bytes);
    b.step(name, &[Texture(source), Buffer(&picture)], pass, stride, height, output);
    Picture { side, channel: channel as usize, texels: b.copy_to_texels(), deep }
}

/// The prefiltered image, laid out like a gray one.
fn filtered(b: &mut Builder<'_>, picture: &Picture, scratch: &Sums, output: Output) -> Picture {
    let filtered = b.buffer("prefilter", b.sizes.gray);
    let pass = Pass { lead: 16, stride: 4 * b.sizes.frame.gray_stride, ..Pass::default() };
    prefilter(b, picture, scratch, &filtered, pass, output);
    let Picture { side, channel, .. } = *picture;
    Picture { side, channel, texels: b.copy_to_texels(), deep: false }
}

/// Stage `prefilter`, into a place of a plane.
fn prefilter(b: &mut Builder<'_>, picture: &Picture, scratch: &Sums, to: &wgpu::Buffer, pass: Pass, output: Output) {
    let (side, channel) = (picture.side, picture.channel);
    if b.params.prefilter == Prefilter::Normalized {
        let window = b.params.prefilter_window;
        scratch.compute(b, picture, window, Output::WindowSums { side, channel, filtered: false, window });
    }
    let storage = [Texture(&picture.texels), Buffer(&scratch.sums), Buffer(to)];
    picture.step(b, "prefilter", &storage, pass, [pass.stride / 4, b.sizes.frame.height], output);
}

/// Stage `window_sums`: where it is computed, and what it is computed with. Two words if nothing needs it: the kernels
/// that may read it are bound to it all the same.
struct Sums {
    columns: wgpu::Buffer,
    sums: wgpu::Buffer,
}

impl Sums {
    fn new(b: &mut Builder<'_>) -> Self {
        let bytes = if b.params.sums_windows() { b.sizes.sums } else { 4 };
        Self { columns: b.buffer("window_columns", bytes), sums: b.buffer("window_sums", bytes) }
    }

    /// The sums over the windows around all pixels of a picture.
    fn compute(&self, b: &mut Builder<'_>, picture: &Picture, window: u32, output: Output) {
        let Frame { width, height, .. } = b.sizes.frame;
        let pass = Pass { window, ..Pass::default() };
        let segments = |side: u32| side.div_ceil(kernels::segment(&b.plan));
        let (across, down) = (segments(width), segments(height));
        let storage = [Texture(&picture.texels), Buffer(&self.columns)];
        picture.step(b, "window_columns", &storage, pass, [width.div_ceil(4), down], Output::Part);
        b.step("window_sums", &[Buffer(&self.columns), Buffer(&self.sums)], pass, height, across, output);
    }
}
