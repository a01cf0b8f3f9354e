//! From the uploaded images to the planes that the matching cost compares.

use crate::gpu::kernels;
use crate::gpu::layout::{Frame, Pass, Piece, Rows};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Output};
use crate::{Cost, PixelFormat, Prefilter};

/// What the cost compares of each image, for a piece of its rows at a time: in buffers, and in textures if the kernel that
/// takes them wants those.
pub(super) struct Planes {
    pub(super) buffers: [wgpu::Buffer; 2],
    textures: Vec<wgpu::Texture>,
    pub(super) views: Vec<wgpu::TextureView>,
    /// What they are made of, of each side: a picture a channel.
    pictures: [Vec<Picture>; 2],
    scratch: Sums,
    /// The rows that they hold.
    held: Option<Rows>,
    /// The gray images in 8 bits.
    pub(super) grays: Vec<wgpu::TextureView>,
    /// What pairs of values cost, if the cost is looked up.
    pub(super) table: Option<wgpu::TextureView>,
}

impl Planes {
    fn new(b: &mut Builder<'_>, pictures: [Vec<Picture>; 2], grays: Vec<wgpu::TextureView>, scratch: Sums) -> Self {
        let buffers = [b.buffer("descriptors.left", b.sizes.left), b.buffer("descriptors.right", b.sizes.right)];
        let (rows, places) = (b.params.planes() * b.sizes.planes_rows, [0, 1].map(|side| place_of(b, side)));
        let in_textures = b.sizes.small_block && !b.plan.per_subgroup;
        let texture = |place: Pass| b.texture("planes", [place.stride, rows], rows, wgpu::TextureFormat::R32Uint);
        let textures = if in_textures { places.map(texture).to_vec() } else { Vec::new() };
        let mut planes =
            Self { buffers, textures, views: Vec::new(), pictures, scratch, held: None, grays, table: None };
        let first = b.sizes.pieces[0][0].clone();
        planes.hold(b, &first);
        planes
    }

    /// Stages `descriptors`, or `prefilter` if that is what is compared, of the rows of a piece, unless it is done. Returns
    /// where the kernels that take the planes find the rows.
    pub(super) fn hold(&mut self, b: &mut Builder<'_>, piece: &Piece) -> Pass {
        let rows = piece.planes;
        if self.held.replace(rows) != Some(rows) {
            self.views.clear();
            for side in [0, 1] {
                self.compute(b, side, rows);
                if let Some(texture) = self.textures.get(side) {
                    let size = [place_of(b, side).stride, b.params.planes() * rows.count];
                    self.views.push(b.copy_into(texture, size));
                }
            }
        }
        Pass { planes_row: rows.first, planes_rows: rows.count, ..Pass::default() }
    }

    fn compute(&self, b: &mut Builder<'_>, side: usize, rows: Rows) {
        let count = b.params.planes() / b.params.channels();
        for (channel, picture) in (0..).zip(&self.pictures[side]) {
            let first_plane = channel * count;
            let pass = Pass { first_plane, first_row: rows.first, rows: rows.count, ..place_of(b, side) };
            let output = Output::Descriptors { side, first: first_plane as usize, count: count as usize, rows };
            if b.params.compares_values() {
                prefilter(b, picture, &self.scratch, Buffer(&self.buffers[side]), pass, output);
                continue;
            }
            if b.params.cost == Cost::ZeroMeanSad {
                let window = b.params.block;
                let sums = Output::WindowSums { side, channel: 0, filtered: true, window };
                self.scratch.compute(b, picture, window, sums);
            }
            let storage = [Texture(&picture.texels), Buffer(&self.scratch.sums), Buffer(&self.buffers[side])];
            picture.step(b, "descriptors", &storage, pass, [pass.stride / 4, rows.count], output);
        }
    }

    /// What a kernel that compares pixels is bound to: the table comes last.
    pub(super) fn with_table<'a>(&'a self, storage: &[Bound<'a>]) -> Vec<Bound<'a>> {
        storage.iter().copied().chain(self.table.as_ref().map(Texture)).collect()
    }
}

/// An image with a value a pixel: in a texture, of 8 or 16 bits.
#[derive(Clone)]
struct Picture {
    /// Whether it was prefiltered.
    filtered: bool,
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
        b.step("rectify", &storage, Pass::default(), size[0], size[1], Output::Rectified { side });
        side += 1;
        b.copy_to_texture(size, size[1], wgpu::TextureFormat::Rgba32Uint)
    })
}

/// Stages `gray`, `prefilter` and, of the first piece, `descriptors` of both sides.
pub(super) fn planes(b: &mut Builder<'_>, sources: &[wgpu::TextureView; 2]) -> Planes {
    let scratch = Sums::new(b);
    let mut grays = Vec::new();
    let pictures = [0, 1].map(|side| {
        let source = source_of(b, sources, side);
        let luma = gray(b, &source, side);
        grays.push(luma.clone());
        let pictures = (0..b.params.channels()).map(|channel| {
            let picture = picture_of(b, &source, &luma, side, channel);
            match b.params.prefilter {
                Prefilter::None => picture,
                _ if b.params.compares_values() => picture,
                _ => filtered(b, &picture, &scratch, Output::Prefiltered { side, channel: channel as usize }),
            }
        });
        pictures.collect()
    });
    Planes::new(b, pictures, grays, scratch)
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
    let scratch = Sums::new(b);
    let picture = |side: usize| Picture { filtered: true, side, channel: 0, texels: values[side].clone(), deep: false };
    Planes::new(b, [0, 1].map(|side| vec![picture(side)]), grays.to_vec(), scratch)
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
            Picture { filtered: false, side, channel: 0, texels: luma.clone(), deep: false }
        }
        _ => channel_of(b, source, side, channel),
    }
}

/// Stage `gray`: luma in 8 bits.
fn gray(b: &mut Builder<'_>, source: &wgpu::TextureView, side: usize) -> wgpu::TextureView {
    let Frame { gray_stride, .. } = b.sizes.frame;
    let gray = b.buffer("gray", b.sizes.gray);
    let output = Output::Gray { side, channel: 0, deep: false };
    let pass = Pass { reversed: b.mirrored.into(), ..Pass::default() };
    let storage = [Texture(source), Bound::Rows(&gray, 16 * u64::from(gray_stride))];
    b.step_rows("gray", &storage, pass, gray_stride, 1, output);
    b.copy_to_texels()
}

/// The image that the cost is to compare, at the depth of its samples: luma, or a colour.
fn channel_of(b: &mut Builder<'_>, source: &wgpu::TextureView, side: usize, channel: u32) -> Picture {
    let Frame { gray_stride, .. } = b.sizes.frame;
    let deep = b.format.is_deep();
    let channel_number = if b.params.color_cost { channel + 1 } else { 0 };
    let pass = Pass { channel: channel_number, reversed: b.mirrored.into(), ..Pass::default() };
    let output = Output::Gray { side, channel: pass.channel as usize, deep };
    let (name, bytes, stride) = match deep {
        true => ("deep_gray", 2 * b.sizes.gray, 2 * gray_stride),
        false => ("gray", b.sizes.gray, gray_stride),
    };
    let picture = b.buffer(name, bytes);
    let storage = [Texture(source), Bound::Rows(&picture, 16 * u64::from(stride))];
    b.step_rows(name, &storage, pass, stride, 1, output);
    Picture { filtered: false, side, channel: channel as usize, texels: b.copy_to_texels(), deep }
}

/// The prefiltered image, laid out like a gray one.
fn filtered(b: &mut Builder<'_>, picture: &Picture, scratch: &Sums, output: Output) -> Picture {
    let filtered = b.buffer("prefilter", b.sizes.gray);
    let stride = 4 * b.sizes.frame.gray_stride;
    let to = Bound::Rows(&filtered, 4 * u64::from(stride));
    prefilter(b, picture, scratch, to, Pass { lead: 16, stride, ..Pass::default() }, output);
    let Picture { side, channel, .. } = *picture;
    Picture { filtered: true, side, channel, texels: b.copy_to_texels(), deep: false }
}

/// Stage `prefilter`, into planes or all of an image.
fn prefilter(b: &mut Builder<'_>, picture: &Picture, scratch: &Sums, to: Bound<'_>, pass: Pass, output: Output) {
    let (side, channel) = (picture.side, picture.channel);
    // What was prefiltered is only laid out.
    let wanted = b.params.prefilter;
    if picture.filtered {
        b.params.prefilter = Prefilter::None;
    }
    if b.params.prefilter == Prefilter::Normalized {
        let window = b.params.prefilter_window;
        scratch.compute(b, picture, window, Output::WindowSums { side, channel, filtered: false, window });
    }
    let storage = [Texture(&picture.texels), Buffer(&scratch.sums), to];
    match to {
        Bound::Rows(..) => {
            let lots = b.lots(&storage);
            for (i, &rows) in lots.iter().enumerate() {
                let bound = [storage[0], storage[1], b.lot(to, rows)];
                let pass = Pass { first_row: rows.first, rows: rows.count, ..pass };
                picture.step(b, "prefilter", &bound, pass, [pass.stride / 4, rows.count], output.clone());
                b.part_of(i, lots.len());
            }
        }
        _ => picture.step(b, "prefilter", &storage, pass, [pass.stride / 4, pass.rows], output),
    }
    b.params.prefilter = wanted;
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
