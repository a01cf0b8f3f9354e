//! From the uploaded images to the images that the cost is computed from.

use crate::gpu::layout::{Dispatch, Frame, GrayOwn, PlaneOwn, WindowOwn};
use crate::gpu::plan;
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::{PixelFormat, Prefilter};

/// An image with a value a pixel: in a texture, of 8 or 16 bits.
#[derive(Clone)]
pub(super) struct Picture {
    /// Whether it was prefiltered.
    pub(super) filtered: bool,
    pub(super) side: usize,
    pub(super) channel: usize,
    pub(super) texels: wgpu::TextureView,
    pub(super) deep: bool,
}

impl Picture {
    /// A step of a kernel that reads the picture: [`Builder::step`], compiled for its depth.
    pub(super) fn step(
        &self,
        b: &mut Builder<'_>,
        name: &str,
        storage: &[Bound<'_>],
        dispatch: Dispatch,
        [lines, rows]: [u32; 2],
        written: Written,
    ) {
        let depth = if self.deep { PixelFormat::Gray16 } else { PixelFormat::Gray8 };
        let format = std::mem::replace(&mut b.format, depth);
        b.step(name, storage, dispatch, lines, rows, written);
        b.format = format;
    }
}

/// The textures into which images are uploaded.
pub(super) fn sources(b: &mut Builder<'_>) -> [wgpu::Texture; 2] {
    let [texels, rows] = source_size(b);
    ["source.left", "source.right"].map(|name| b.texture(name, [texels, rows], rows, wgpu::TextureFormat::Rgba32Uint))
}

/// Texels a row and rows of an uploaded image.
fn source_size(b: &Builder<'_>) -> [u32; 2] {
    let texels = b.sizes.source_texels;
    [texels, (b.sizes.source / (16 * u64::from(texels))) as u32]
}

/// Stage `rectify` of both sides, if it is wanted: the images that the chain takes.
pub(super) fn rectified(b: &mut Builder<'_>, sources: [wgpu::TextureView; 2]) -> [wgpu::TextureView; 2] {
    let Some(rectification) = b.params.rectify.clone() else { return sources };
    let size = source_size(b);
    let mut side = 0;
    sources.map(|source| {
        let numbers = rectification.positions(side).iter().flatten().map(|&number| number as u32).collect();
        let positions = b.table("rectify.positions", numbers);
        let image = b.buffer("rectify", b.sizes.source);
        let storage = [Texture(&source), Buffer(&positions), Buffer(&image)];
        b.step("rectify", &storage, Dispatch::default(), size[0], size[1], Written::Rectified { side });
        side += 1;
        b.copy_to_texture(size, size[1], wgpu::TextureFormat::Rgba32Uint)
    })
}

/// The uploaded image of a side: a pair is mirrored with its sides exchanged.
pub(super) fn source_of(b: &Builder<'_>, sources: &[wgpu::TextureView; 2], side: usize) -> wgpu::TextureView {
    sources[if b.mirrored { 1 - side } else { side }].clone()
}

/// What is prefiltered: luma that is there already, or [`channel_of`].
pub(super) fn picture_of(
    b: &mut Builder<'_>,
    source: &wgpu::TextureView,
    luma: &wgpu::TextureView,
    side: usize,
    channel: u32,
) -> Picture {
    match (b.params.color_cost, b.format) {
        (false, PixelFormat::Gray8 | PixelFormat::Rgba8) => {
            Picture { filtered: false, side, channel: 0, texels: luma.clone(), deep: false }
        }
        _ => channel_of(b, source, side, channel),
    }
}

/// Stage `gray`: luma in 8 bits.
pub(super) fn gray(b: &mut Builder<'_>, source: &wgpu::TextureView, side: usize) -> wgpu::TextureView {
    let Frame { gray_stride, .. } = b.sizes.frame;
    let gray = b.buffer("gray", b.sizes.gray);
    let written = Written::Gray { side, channel: 0, deep: false };
    let own = GrayOwn { channel: 0, reversed: b.mirrored.into() };
    let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
    let storage = [Texture(source), Bound::Rows(&gray, 16 * u64::from(gray_stride))];
    b.step_rows("gray", &storage, dispatch, gray_stride, 1, written);
    b.copy_to_texels()
}

/// The image that the cost is to compare, at the depth of its samples: luma, or a colour.
fn channel_of(b: &mut Builder<'_>, source: &wgpu::TextureView, side: usize, channel: u32) -> Picture {
    let Frame { gray_stride, .. } = b.sizes.frame;
    let deep = b.format.is_deep();
    let channel_number = if b.params.color_cost { channel + 1 } else { 0 };
    let own = GrayOwn { channel: channel_number, reversed: b.mirrored.into() };
    let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
    let written = Written::Gray { side, channel: channel_number as usize, deep };
    let (name, bytes, stride) = match deep {
        true => ("deep_gray", 2 * b.sizes.gray, 2 * gray_stride),
        false => ("gray", b.sizes.gray, gray_stride),
    };
    let picture = b.buffer(name, bytes);
    let storage = [Texture(source), Bound::Rows(&picture, 16 * u64::from(stride))];
    b.step_rows(name, &storage, dispatch, stride, 1, written);
    Picture { filtered: false, side, channel: channel as usize, texels: b.copy_to_texels(), deep }
}

/// The prefiltered image, laid out like a gray one.
pub(super) fn filtered(b: &mut Builder<'_>, picture: &Picture, scratch: &Sums, written: Written) -> Picture {
    let filtered = b.buffer("prefilter", b.sizes.gray);
    let stride = 4 * b.sizes.frame.gray_stride;
    let to = Bound::Rows(&filtered, 4 * u64::from(stride));
    let own = PlaneOwn { lead: 16, ..PlaneOwn::default() };
    prefilter(b, picture, scratch, to, Dispatch { stride, own: own.into(), ..Dispatch::default() }, written);
    let Picture { side, channel, .. } = *picture;
    Picture { filtered: true, side, channel, texels: b.copy_to_texels(), deep: false }
}

/// Stage `prefilter`, into planes or all of an image.
pub(super) fn prefilter(
    b: &mut Builder<'_>,
    picture: &Picture,
    scratch: &Sums,
    to: Bound<'_>,
    dispatch: Dispatch,
    written: Written,
) {
    let (side, channel) = (picture.side, picture.channel);
    // What was prefiltered is only laid out.
    let wanted = b.params.prefilter;
    if picture.filtered {
        b.params.prefilter = Prefilter::None;
    }
    if b.params.prefilter == Prefilter::Normalized {
        let window = b.params.prefilter_window;
        scratch.compute(b, picture, window, Written::WindowSums { side, channel, filtered: false, window });
    }
    let storage = [Texture(&picture.texels), Buffer(&scratch.sums), to];
    match to {
        Bound::Rows(..) => {
            let lots = b.lots(&storage);
            for (i, &rows) in lots.iter().enumerate() {
                let bound = [storage[0], storage[1], b.lot(to, rows)];
                let dispatch = Dispatch { first_row: rows.first, rows: rows.count, ..dispatch };
                picture.step(b, "prefilter", &bound, dispatch, [dispatch.stride / 4, rows.count], written.clone());
                b.part_of(i, lots.len());
            }
        }
        _ => picture.step(b, "prefilter", &storage, dispatch, [dispatch.stride / 4, dispatch.rows], written),
    }
    b.params.prefilter = wanted;
}

/// Stage `window_sums`: where it is computed, and what it is computed with. Two words if nothing needs it: the kernels
/// that may read it are bound to it all the same.
pub(super) struct Sums {
    columns: wgpu::Buffer,
    pub(super) sums: wgpu::Buffer,
}

impl Sums {
    pub(super) fn new(b: &mut Builder<'_>) -> Self {
        let bytes = if b.params.sums_windows() { b.sizes.sums } else { 4 };
        Self { columns: b.buffer("window_columns", bytes), sums: b.buffer("window_sums", bytes) }
    }

    /// The sums over the windows around all pixels of a picture.
    pub(super) fn compute(&self, b: &mut Builder<'_>, picture: &Picture, window: u32, written: Written) {
        let Frame { width, height, .. } = b.sizes.frame;
        let dispatch = Dispatch { own: WindowOwn { window }.into(), ..Dispatch::default() };
        let segments = |side: u32| side.div_ceil(plan::segment(&b.plan));
        let (across, down) = (segments(width), segments(height));
        let storage = [Texture(&picture.texels), Buffer(&self.columns)];
        picture.step(b, "window_columns", &storage, dispatch, [width.div_ceil(4), down], Written::Part);
        b.step("window_sums", &[Buffer(&self.columns), Buffer(&self.sums)], dispatch, height, across, written);
    }
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
        filtered(b, &picture, &scratch, Written::Values { side }).texels
    });
    (grays, values)
}

/// Stage `halve` of both images, for the first level that is halved as often as `pyramid` is long.
pub(super) fn halved(b: &mut Builder<'_>, pyramid: &[[wgpu::TextureView; 2]]) -> [wgpu::TextureView; 2] {
    let levels = b.levels;
    let of = |halvings: usize| levels.iter().position(|level| level.halvings as usize == halvings).unwrap_or(0);
    let Frame { width, height, gray_stride, .. } = levels[of(pyramid.len() - 1)].sizes.frame;
    b.enter(of(pyramid.len()));
    let dispatch = Dispatch { lines: width, rows: height, stride: gray_stride, ..Dispatch::default() };
    let Frame { height, gray_stride, .. } = b.sizes.frame;
    [0, 1].map(|side| {
        let halved = b.buffer("halve", b.sizes.gray);
        let storage = [Texture(&pyramid[pyramid.len() - 1][side]), Buffer(&halved)];
        b.step("halve", &storage, dispatch, 4 * gray_stride, height, Written::Values { side });
        b.copy_to_texels()
    })
}
