//! The planes of bytes that the matching cost compares.

use crate::Prefilter;
use crate::gpu::chain::features::Features;
use crate::gpu::chain::images::{Picture, Sums, filtered, gray, picture_of, prefilter, source_of};
use crate::gpu::layout::{Dispatch, Frame, Piece, PlaneOwn, Rows};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::params::Descriptor;

/// The bytes of each image that the cost compares, for a piece of its rows at a time: in buffers, and in textures if the kernel
/// that reads them wants those.
pub(super) struct Planes {
    pub(super) buffers: [wgpu::Buffer; 2],
    textures: Vec<wgpu::Texture>,
    pub(super) views: Vec<wgpu::TextureView>,
    /// The images that they are made from, of each side: one a channel.
    pictures: [Vec<Picture>; 2],
    scratch: Sums,
    /// What a network makes of these images, if the cost compares that.
    pub(super) features: Option<Features>,
    /// The rows that they hold.
    held: Option<Rows>,
    /// The gray images in 8 bits.
    pub(super) grays: Vec<wgpu::TextureView>,
    /// What pairs of values cost, if the cost is looked up.
    pub(super) table: Option<wgpu::TextureView>,
    /// The same as bytes.
    pub(super) table_bytes: Option<wgpu::Buffer>,
}

impl Planes {
    fn new(b: &mut Builder<'_>, pictures: [Vec<Picture>; 2], grays: Vec<wgpu::TextureView>, scratch: Sums) -> Self {
        let buffers = [b.buffer("descriptors.left", b.sizes.left), b.buffer("descriptors.right", b.sizes.right)];
        let features = Features::new(b, [&pictures[0][0], &pictures[1][0]]);
        let (rows, strides) =
            (b.params.compared_planes() * b.sizes.planes_rows, [0, 1].map(|side| place_of(b, side).0));
        let in_textures = b.sizes.small_block && !b.plan.per_subgroup && features.is_none();
        let texture = |stride: u32| b.texture("planes", [stride, rows], rows, wgpu::TextureFormat::R32Uint);
        let textures = if in_textures { strides.map(texture).to_vec() } else { Vec::new() };
        let mut planes = Self {
            buffers,
            textures,
            views: Vec::new(),
            pictures,
            scratch,
            features,
            held: None,
            grays,
            table: None,
            table_bytes: None,
        };
        let first = b.sizes.pieces[0][0].clone();
        planes.hold(b, &first);
        planes
    }

    /// Stages `features`, and `descriptors`, or `prefilter` if that is what is compared, of the rows of a piece, unless it is done. Returns
    /// where the kernels that take the planes find the rows.
    pub(super) fn hold(&mut self, b: &mut Builder<'_>, piece: &Piece) -> Dispatch {
        let rows = piece.planes;
        if self.held.replace(rows) != Some(rows) {
            self.views.clear();
            for side in [0, 1] {
                if let Some(features) = &self.features {
                    features.compute(b, &self.pictures[side][0], rows);
                }
                if b.params.compared_planes() > 0 {
                    self.compute(b, side, rows);
                }
                if let Some(texture) = self.textures.get(side) {
                    let size = [place_of(b, side).0, b.params.compared_planes() * rows.count];
                    self.views.push(b.copy_into(texture, size));
                }
            }
        }
        Dispatch { planes_row: rows.first, planes_rows: rows.count, ..Dispatch::default() }
    }

    fn compute(&self, b: &mut Builder<'_>, side: usize, rows: Rows) {
        let count = b.params.compared_planes() / b.params.described();
        for (channel, picture) in (0..).zip(&self.pictures[side]) {
            let first_plane = channel * count;
            let (stride, own) = place_of(b, side);
            let own = PlaneOwn { first_plane, ..own }.into();
            let dispatch = Dispatch { first_row: rows.first, rows: rows.count, stride, own, ..Dispatch::default() };
            let written = Written::Descriptors { side, first: first_plane as usize, count: count as usize, rows };
            if b.params.compares_values() {
                prefilter(b, picture, &self.scratch, Buffer(&self.buffers[side]), dispatch, written);
                continue;
            }
            if b.params.compares(Descriptor::Excess) {
                let window = b.params.block;
                let sums = Written::WindowSums { side, channel: 0, filtered: true, window };
                self.scratch.compute(b, picture, window, sums);
            }
            let storage = [Texture(&picture.texels), Buffer(&self.scratch.sums), Buffer(&self.buffers[side])];
            picture.step(b, "descriptors", &storage, dispatch, [dispatch.stride / 4, rows.count], written);
        }
    }

    /// What a kernel that compares features is bound to beside what it writes: what else is compared comes last.
    pub(super) fn with_planes<'a>(
        &'a self,
        b: &Builder<'_>,
        features: &'a Features,
        written: &'a wgpu::Buffer,
    ) -> Vec<Bound<'a>> {
        let [left, right] = &features.features;
        let planes = if b.params.compared_planes() > 0 { &self.buffers[..] } else { &[] };
        [left, right, written].into_iter().chain(planes).map(Buffer).collect()
    }

    /// What a kernel that compares pixels is bound to: the table comes last.
    pub(super) fn with_table<'a>(&'a self, storage: &[Bound<'a>]) -> Vec<Bound<'a>> {
        storage.iter().copied().chain(self.table.as_ref().map(Texture)).collect()
    }
}

/// Stages `gray`, `prefilter` and, of the first piece, `descriptors` of both sides.
pub(super) fn planes(b: &mut Builder<'_>, sources: &[wgpu::TextureView; 2]) -> Planes {
    let scratch = Sums::new(b);
    let mut grays = Vec::new();
    let pictures = [0, 1].map(|side| {
        let source = source_of(b, sources, side);
        let luma = gray(b, &source, side);
        grays.push(luma.clone());
        let beside = b.params.cost.row().beside_gray;
        let gray = Picture { filtered: false, side, channel: 0, texels: luma.clone(), deep: false };
        let pictures = (0..b.params.channels()).map(|channel| {
            let picture = picture_of(b, &source, &luma, side, channel);
            match b.params.prefilter {
                Prefilter::None => picture,
                _ if b.params.compares_values() => picture,
                _ => filtered(b, &picture, &scratch, Written::Prefiltered { side, channel: channel as usize }),
            }
        });
        pictures.collect::<Vec<_>>().into_iter().chain(beside.then_some(gray)).collect()
    });
    Planes::new(b, pictures, grays, scratch)
}

/// Words a row of the planes of a side, and where its bytes lie in them.
fn place_of(b: &Builder<'_>, side: usize) -> (u32, PlaneOwn) {
    let Frame { width, min_disparity, block_radius, left_stride, right_stride, .. } = b.sizes.frame;
    let radius = block_radius as i32;
    if side == 0 {
        return (left_stride, PlaneOwn { lead: radius, ..PlaneOwn::default() });
    }
    let lead = width as i32 - 1 + radius - min_disparity;
    (right_stride, PlaneOwn { mirrored: 1, lead, first_plane: 0 })
}

/// The planes of values that [`images::values`](crate::gpu::chain::images::values) left, or that were halved.
pub(super) fn planes_of(b: &mut Builder<'_>, values: &[wgpu::TextureView; 2], grays: &[wgpu::TextureView]) -> Planes {
    let scratch = Sums::new(b);
    let picture = |side: usize| Picture { filtered: true, side, channel: 0, texels: values[side].clone(), deep: false };
    Planes::new(b, [0, 1].map(|side| vec![picture(side)]), grays.to_vec(), scratch)
}
