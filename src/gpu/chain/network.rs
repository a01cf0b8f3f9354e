//! The network: from the images to the map of its disparities.

use std::iter;
use std::ops::Range;

use crate::gpu::chain::images::source_of;
use crate::gpu::layout::{
    BLOCK_UNIT, Dispatch, Frame, GrayOwn, ImageOwn, LayerOwn, Layers, Place, RoundOwn, TEXELS, TEXTURE_ROW,
};
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

    /// Where some blocks of an operation's output are written.
    fn target(&self, at: usize, blocks: &Range<u32>) -> Bound<'_> {
        let place = &self.layers.places[at];
        let memory = &self.slots[place.slot];
        let bytes = |blocks: u32| 16 * u64::from(blocks) * u64::from(place.stride);
        let first = 16 * u64::from(memory.begin(place)) + bytes(blocks.start);
        Part(&memory.written, first, bytes(blocks.end - blocks.start))
    }

    /// What is left by an operation, for the check.
    fn written(&self, at: usize) -> Written {
        let place = &self.layers.places[at];
        let memory = &self.slots[place.slot];
        let joined = matches!(memory.read, Read::Texture(..)) && self.layers.joined.contains(&place.slot);
        Written::Layer { operation: at, at: memory.begin(place), joined }
    }

    /// The weights of an operation, of a buffer no others, and the first texel of what is bound.
    fn bound_weights(&self, at: usize) -> (Bound<'_>, u32) {
        match &self.weights.held {
            Held::Buffer(buffer) => {
                let [first, end] = self.weights.texels[at];
                let from = first / BLOCK_UNIT * BLOCK_UNIT;
                (Part(buffer, 16 * u64::from(from), 16 * u64::from(end - from)), from)
            }
            Held::Texture(_, view) => (Texture(view), 0),
        }
    }

    /// What an operation left, of a buffer some blocks alone, and the texel of what is bound at which block 0 would lie: it may be
    /// below zero.
    fn read(&self, at: usize, blocks: &Range<u32>) -> (Bound<'_>, u32) {
        let place = &self.layers.places[at];
        let memory = &self.slots[place.slot];
        let buffer = match &memory.read {
            Read::Texture(_, view) => return (Texture(view), place.at),
            Read::There => &memory.written,
            Read::Joined(buffer) => buffer,
        };
        let [before, count] = [blocks.start, blocks.end - blocks.start].map(|blocks| blocks * place.stride);
        let bound = Part(buffer, 16 * u64::from(place.at + before), 16 * u64::from(count));
        (bound, 0u32.wrapping_sub(before))
    }

    /// Stage `network_input`.
    fn input(&self, b: &mut Builder<'_>, at: usize) {
        let place = self.layers.places[at];
        let target = self.target(at, &(0..place.blocks));
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

    /// Stages `average_pool` and `upsample`: as many blocks of channels at a time as a binding holds.
    fn resized(&self, b: &mut Builder<'_>, at: usize, kernel: &str, rule: u32) {
        let place = self.layers.places[at];
        let input = self.operations[at].inputs[0];
        let from = self.layers.places[input];
        let lots = lots(b, &place, from.stride.max(place.stride));
        for (i, blocks) in lots.iter().enumerate() {
            let (values, first) = self.read(input, blocks);
            let own = ImageOwn {
                columns: place.columns,
                rows: place.rows,
                in_columns: from.columns,
                in_rows: from.rows,
                in_stride: from.stride,
                in_at: first.wrapping_add(blocks.start * from.stride),
                out_stride: place.stride,
                rule,
            };
            let storage = [values, self.target(at, blocks)];
            let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
            let rows = 2 * (blocks.end - blocks.start);
            b.step(kernel, &storage, dispatch, place.columns * place.rows, rows, self.written(at));
            b.part_of(i, lots.len());
        }
    }

    /// The blocks that a convolution reads at a time: of a buffer as many as a binding holds.
    fn read_lots(&self, b: &Builder<'_>, operation: &Operation) -> Vec<Range<u32>> {
        let from = &self.layers.places[operation.inputs[0]];
        match operation.kind {
            // The left features, then the right ones. They are no larger than the images, which a binding holds.
            Kind::VolumeConv3d => iter::once(0..2 * from.blocks).collect(),
            _ if b.plan.per_subgroup => lots(b, from, from.stride),
            _ => iter::once(0..from.blocks).collect(),
        }
    }

    /// What a convolution knows of its operation: all but what differs between its dispatches.
    fn layer_own(&self, at: usize) -> LayerOwn {
        let operation = &self.operations[at];
        let (place, from) = (&self.layers.places[at], &self.layers.places[operation.inputs[0]]);
        let sides = if operation.kind == Kind::VolumeConv3d { 2 } else { 1 };
        LayerOwn {
            columns: place.columns,
            rows: place.rows,
            planes: place.planes,
            in_columns: from.columns,
            in_rows: from.rows,
            in_planes: if sides == 2 { place.planes } else { from.planes },
            blocks: sides * from.blocks,
            in_stride: from.stride,
            out_stride: place.stride,
            out_blocks: place.blocks,
            ..LayerOwn::default()
        }
    }

    /// Stages `conv2d`, `conv3d` and `conv3d_transposed`: as many blocks of channels at a time as a binding holds. What is read at a
    /// time is added to the sums of what was read before, in the same order as all at once.
    fn convolution(&self, b: &mut Builder<'_>, at: usize, kernel: &str) {
        let operation = &self.operations[at];
        let (place, input) = (self.layers.places[at], operation.inputs[0]);
        let held = self.layers.places[input].blocks;
        let all = self.layer_own(at);
        let (weights, before) = self.bound_weights(at);
        let (writes, reads) = (lots(b, &place, place.stride), self.read_lots(b, operation));
        let steps = writes.iter().flat_map(|to| reads.iter().map(move |from| (to, from)));
        for (i, (to, from)) in steps.enumerate() {
            // Where the volume is made of the features, the blocks of both sides lie in the same memory.
            let (values, first) = self.read(input, &(from.start..from.end.min(held)));
            let ends = from.end == all.blocks;
            let addend = operation.add.filter(|_| ends).map(|add| self.read(add, to));
            let [adds, cuts, goes_on] = [addend.is_some(), ends && operation.relu, from.start > 0].map(u32::from);
            let own = LayerOwn {
                first_in: from.start,
                end_in: from.end,
                at: first,
                added_at: addend.map_or(0, |(_, first)| first),
                weights: self.weights.texels[at][0] - before,
                first_block: to.start,
                flags: adds + 2 * cuts + 4 * goes_on,
                ..all
            };
            let added = addend.map_or(weights, |(bound, _)| bound);
            let storage = [values, weights, added, self.target(at, to)];
            let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
            let lines = place.rows * place.columns.div_ceil(LAYER_COLUMNS);
            b.step(kernel, &storage, dispatch, lines, (to.end - to.start) * place.planes, self.written(at));
            b.part_of(i, writes.len() * reads.len());
        }
    }

    /// Stage `disparity_regression`.
    fn regression(&self, b: &mut Builder<'_>) -> wgpu::Buffer {
        let at = self.operations.len() - 1;
        let place = self.layers.places[at];
        let input = self.operations[at].inputs[0];
        let (from, (values, first)) = (&self.layers.places[input], self.read(input, &(0..1)));
        let disparities = b.buffer("network.disparities", self.layers.disparities);
        let own = ImageOwn {
            columns: place.columns,
            rows: place.rows,
            in_columns: from.columns,
            in_rows: from.rows,
            in_at: first,
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

/// The blocks of channels of a place, as many at a time as a binding holds where each has so many texels.
fn lots(b: &Builder<'_>, place: &Place, texels: u32) -> Vec<Range<u32>> {
    let most = (b.sizes.binding / (16 * u64::from(texels))).clamp(1, place.blocks.into()) as u32;
    (0..place.blocks).step_by(most as usize).map(|first| first..(first + most).min(place.blocks)).collect()
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
