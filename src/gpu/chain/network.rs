//! The network: from the images to the map of its disparities.

use crate::gpu::chain::images::source_of;
use crate::gpu::layout::{Dispatch, Frame, GrayOwn, ImageOwn, LayerOwn, Layers, Place, RoundOwn, TEXELS, TEXTURE_ROW};
use crate::gpu::recording::Bound::{self, Buffer, Part, Rows, Texture};
use crate::gpu::recording::{Builder, Held, Weights, Written};
use crate::network::{Kind, Operation};

#[cfg(test)]
mod tests;

/// The memory of a slot.
struct Memory {
    /// What kernels write.
    written: wgpu::Buffer,
    read: Read,
}

/// Where values are read.
enum Read {
    /// Where they were written.
    There,
    /// What is written is copied into a texture: all of it, also of what is joined.
    Texture(wgpu::Texture, wgpu::TextureView),
    /// What is written is a part, and copied to where the parts are joined: no kernel may read the buffer that it writes.
    Joined(wgpu::Buffer),
}

impl Memory {
    fn bound(&self) -> Bound<'_> {
        match &self.read {
            Read::There => Buffer(&self.written),
            Read::Texture(_, view) => Texture(view),
            Read::Joined(buffer) => Buffer(buffer),
        }
    }

    /// The first texel of a place in the buffer that is written.
    fn begin(&self, place: &Place) -> u32 {
        if matches!(self.read, Read::Joined(_)) { 0 } else { place.at }
    }

    /// Copies what was written of a place.
    fn copy(&self, b: &mut Builder<'_>, place: &Place) {
        match &self.read {
            Read::There => {}
            Read::Texture(texture, _) => {
                let end = 16 * u64::from(place.at) + place.values();
                b.copy_into(texture, [TEXELS, end.div_ceil(TEXTURE_ROW) as u32]);
            }
            Read::Joined(buffer) => b.copy_to_buffer(buffer, 16 * u64::from(place.at), place.values()),
        }
    }
}

/// The steps of a network.
struct Steps<'a> {
    operations: &'a [Operation],
    layers: &'a Layers,
    slots: Vec<Memory>,
    weights: Weights,
    sources: [wgpu::TextureView; 2],
}

/// All operations, into the left one of the views. Returns the disparities.
pub(super) fn network(b: &mut Builder<'_>, sources: &[wgpu::TextureView; 2], map: &wgpu::Buffer) -> wgpu::Buffer {
    let sizes = b.sizes;
    let (Some(network), Some(layers)) = (b.params.network.clone(), &sizes.layers) else {
        unreachable!("settings without a network were refused before")
    };
    let sources = [0, 1].map(|side| source_of(b, sources, side));
    let (slots, weights) = (slots(b, layers), b.weights(&network));
    let steps = Steps { operations: network.operations(), layers, slots, weights, sources };
    for at in 0..steps.operations.len() - 1 {
        steps.step(b, at);
    }
    let disparities = steps.regression(b);
    rounded(b, layers, &disparities, map);
    disparities
}

/// The memory of all slots.
fn slots(b: &mut Builder<'_>, layers: &Layers) -> Vec<Memory> {
    let scratch = b.buffer("network.result", if b.plan.per_subgroup { layers.part } else { layers.largest });
    let memory = |(slot, &bytes): (usize, &u64)| {
        let joined = layers.joined.contains(&slot);
        if b.plan.per_subgroup {
            let values = b.buffer("network.values", bytes);
            return match joined {
                true => Memory { written: scratch.clone(), read: Read::Joined(values) },
                false => Memory { written: values, read: Read::There },
            };
        }
        let rows = (bytes / TEXTURE_ROW) as u32;
        let texture = b.texture("network.values", [TEXELS, rows], rows, wgpu::TextureFormat::Rgba32Uint);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let written = if joined { b.buffer("network.joined", bytes) } else { scratch.clone() };
        Memory { written, read: Read::Texture(texture, view) }
    };
    layers.slots.iter().enumerate().map(memory).collect()
}

impl Steps<'_> {
    /// The steps of one operation, and the copy of what they leave.
    fn step(&self, b: &mut Builder<'_>, at: usize) {
        let operation = &self.operations[at];
        match operation.kind {
            Kind::Input => self.input(b, at),
            Kind::AveragePool { side } => self.resized(b, at, "average_pool", side as u32),
            Kind::Upsample => {
                let corners = network_corners(b);
                self.resized(b, at, "upsample", corners);
            }
            Kind::Conv2d { kernel: 1, stride: 1, .. } => self.convolution(b, at, "conv2d_point"),
            Kind::Conv2d { kernel: 1, .. } => self.convolution(b, at, "conv2d_point_half"),
            Kind::Conv2d { stride: 2, .. } => self.convolution(b, at, "conv2d_half"),
            Kind::Conv2d { dilation: 2, .. } => self.convolution(b, at, "conv2d_dilated"),
            Kind::Conv2d { .. } => self.convolution(b, at, "conv2d"),
            Kind::VolumeConv3d => self.convolution(b, at, "conv3d_volume"),
            Kind::Conv3d { stride: 2 } => self.convolution(b, at, "conv3d_half"),
            Kind::Conv3d { .. } => self.convolution(b, at, "conv3d"),
            Kind::TransposedConv3d => self.convolution(b, at, "conv3d_transposed"),
            // Its inputs lie side by side; the last operation is not among these.
            Kind::Concat | Kind::Regression => return,
        }
        let place = &self.layers.places[at];
        self.slots[place.slot].copy(b, place);
    }

    /// Where an operation's output is written: bound from a block on, and the first texel there.
    fn target(&self, at: usize, first: u32, blocks: u32) -> Bound<'_> {
        let place = &self.layers.places[at];
        let memory = &self.slots[place.slot];
        let texels = |blocks: u32| 16 * u64::from(blocks) * u64::from(place.stride);
        Part(&memory.written, 16 * u64::from(memory.begin(place)) + texels(first), texels(blocks))
    }

    /// What is left by an operation, for the check.
    fn written(&self, at: usize) -> Written {
        let place = &self.layers.places[at];
        let memory = &self.slots[place.slot];
        let joined = matches!(memory.read, Read::Texture(..)) && self.layers.joined.contains(&place.slot);
        Written::Layer { operation: at, at: memory.begin(place), joined }
    }

    fn bound_weights(&self) -> Bound<'_> {
        match &self.weights.held {
            Held::Buffer(buffer) => Buffer(buffer),
            Held::Texture(_, view) => Texture(view),
        }
    }

    /// What an operation reads.
    fn read(&self, at: usize) -> (Bound<'_>, &Place) {
        let place = &self.layers.places[at];
        (self.slots[place.slot].bound(), place)
    }

    /// Stage `network_input`.
    fn input(&self, b: &mut Builder<'_>, at: usize) {
        let place = self.layers.places[at];
        let target = self.target(at, 0, place.blocks);
        for side in [0, 1] {
            let own = GrayOwn { channel: 0, reversed: b.mirrored.into() };
            let dispatch = Dispatch {
                rows: place.rows,
                stride: place.columns,
                slot: side * place.rows * place.columns,
                own: own.into(),
                ..Dispatch::default()
            };
            let storage = [Texture(&self.sources[side as usize]), target];
            b.step("network_input", &storage, dispatch, place.columns, place.rows, self.written(at));
            b.part_of(side as usize, 2);
        }
    }

    /// Stages `average_pool` and `upsample`.
    fn resized(&self, b: &mut Builder<'_>, at: usize, kernel: &str, rule: u32) {
        let place = self.layers.places[at];
        let (values, from) = self.read(self.operations[at].inputs[0]);
        let own = ImageOwn {
            columns: place.columns,
            rows: place.rows,
            in_columns: from.columns,
            in_rows: from.rows,
            in_stride: from.stride,
            in_at: from.at,
            out_stride: place.stride,
            rule,
        };
        let storage = [values, self.target(at, 0, place.blocks)];
        let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
        b.step(kernel, &storage, dispatch, place.columns * place.rows, 2 * place.blocks, self.written(at));
    }

    /// Stages `conv2d`, `conv3d` and `conv3d_transposed`: as many blocks of channels at a time as a binding holds.
    fn convolution(&self, b: &mut Builder<'_>, at: usize, kernel: &str) {
        let operation = &self.operations[at];
        let place = self.layers.places[at];
        let (values, from) = self.read(operation.inputs[0]);
        let (added, addend) = operation.add.map_or((self.bound_weights(), None), |add| {
            let (bound, place) = self.read(add);
            (bound, Some(place))
        });
        let sides = if operation.kind == Kind::VolumeConv3d { 2 } else { 1 };
        let own = LayerOwn {
            columns: place.columns,
            rows: place.rows,
            planes: place.planes,
            in_columns: from.columns,
            in_rows: from.rows,
            in_planes: if sides == 2 { place.planes } else { from.planes },
            blocks: sides * from.blocks,
            in_stride: from.stride,
            out_stride: place.stride,
            at: from.at,
            added_at: addend.map_or(0, |place| place.at),
            weights: self.weights.firsts[at],
            out_blocks: place.blocks,
            flags: u32::from(addend.is_some()) + 2 * u32::from(operation.relu),
            ..LayerOwn::default()
        };
        let block = 16 * u64::from(place.stride);
        let most = ((b.sizes.binding / block) as u32).clamp(1, place.blocks);
        let parts = place.blocks.div_ceil(most);
        for part in 0..parts {
            let first_block = part * most;
            let blocks = most.min(place.blocks - first_block);
            let storage = [values, self.bound_weights(), added, self.target(at, first_block, blocks)];
            let own = LayerOwn { first_block, ..own };
            let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
            let lines = place.rows * place.columns.div_ceil(LAYER_COLUMNS);
            b.step(kernel, &storage, dispatch, lines, blocks * place.planes, self.written(at));
            b.part_of(part as usize, parts as usize);
        }
    }

    /// Stage `disparity_regression`.
    fn regression(&self, b: &mut Builder<'_>) -> wgpu::Buffer {
        let at = self.operations.len() - 1;
        let place = self.layers.places[at];
        let (values, from) = self.read(self.operations[at].inputs[0]);
        let disparities = b.buffer("network.disparities", self.layers.disparities);
        let own = ImageOwn {
            columns: place.columns,
            rows: place.rows,
            in_columns: from.columns,
            in_rows: from.rows,
            in_at: from.at,
            rule: network_corners(b),
            ..ImageOwn::default()
        };
        let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
        let storage = [values, Buffer(&disparities)];
        let written = Written::Layer { operation: at, at: 0, joined: false };
        b.step("disparity_regression", &storage, dispatch, place.columns, place.rows, written);
        disparities
    }
}

/// Columns that an invocation of a convolution computes: `COLUMNS` in shaders/network/parts/layer.wgsl.
const LAYER_COLUMNS: u32 = 6;

/// Whether interpolation lays corner pixels on each other, as kernels are told.
fn network_corners(b: &Builder<'_>) -> u32 {
    b.params.align_corners.into()
}

/// Stage `round_disparities`.
fn rounded(b: &mut Builder<'_>, layers: &Layers, disparities: &wgpu::Buffer, map: &wgpu::Buffer) {
    let Frame { height, map_stride, .. } = b.sizes.frame;
    let own = RoundOwn { columns: layers.padded.width as u32, padding: layers.padded.height as u32 - height };
    let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
    let storage = [Buffer(disparities), Rows(map, 4 * u64::from(map_stride))];
    b.step_rows("round_disparities", &storage, dispatch, map_stride, 1, Written::Rounded);
}
