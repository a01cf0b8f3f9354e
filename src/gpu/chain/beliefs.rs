//! Belief propagation: from the matching cost to the messages at the full size.

use crate::gpu::chain::cost::{CostVolume, matching_cost};
use crate::gpu::chain::planes::Planes;
use crate::gpu::layout::{BeliefOwn, CoarseOwn, Dispatch, Scale, StartOwn, TEXTURE_ROW, WAYS};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::reference::shares;

/// What the winner is chosen from.
pub(super) struct Beliefs {
    /// The cost of each band.
    pub(super) costs: Vec<CostVolume>,
    /// What the pixels of each band send.
    messages: Vec<wgpu::Buffer>,
    /// Bound in place of the messages of a band beyond the image.
    none: wgpu::Buffer,
}

/// Stages `matching_cost`, `coarse_cost` and `messages`.
pub(super) fn beliefs(b: &mut Builder<'_>, planes: &mut Planes) -> Beliefs {
    let scales = &b.sizes.scales;
    let none = b.buffer("messages.none", 32);
    let finest = message_buffers(b, 0);
    // On `per-thread` the cost is copied into a texture before there are messages at the full size.
    let computed = if b.plan.per_subgroup { b.volumes("matching_cost", 1) } else { finest.clone() };
    let costs = matching_cost(b, planes, &computed);
    let sums = coarse_costs(b, scales, &costs);
    let mut beliefs = Beliefs { costs, messages: Vec::new(), none };
    for (level, scale) in scales.iter().enumerate().rev() {
        let to = if level == 0 { finest.clone() } else { message_buffers(b, level) };
        // A pixel alone has nobody to send to.
        let alone = scale.width * scale.height == 1;
        beliefs.start(b, scale, scales.get(level + 1), Start { level, alone }, to);
        let shares = if alone { Vec::new() } else { shares(&b.params, level == 0) };
        for (nth, &share) in shares.iter().enumerate() {
            let round = Round { level, nth, share, last: nth + 1 == shares.len() };
            beliefs.send(b, scale, level.checked_sub(1).map(|before| &sums[before]), &planes.grays[0], round);
        }
    }
    beliefs
}

/// A buffer a band for the messages of a level, in which the cost of a band has room, too.
fn message_buffers(b: &mut Builder<'_>, level: usize) -> Vec<wgpu::Buffer> {
    let (scale, quads, room) = (&b.sizes.scales[level], b.params.quads(), room(b, level));
    let bytes = |volume: u64| (u64::from(WAYS) * volume).next_multiple_of(TEXTURE_ROW);
    let buffer = |band| b.buffer_of("messages", bytes(scale.volume(band, quads)), bytes(room));
    (0..scale.bands.len()).map(buffer).collect()
}

/// The most bytes of a volume of a band at a level, here or in a smaller image, whose bands may have more rows.
fn room(b: &Builder<'_>, level: usize) -> u64 {
    let Scale { width, height, stride, bands } = &b.sizes.scales[0];
    if bands.len() == 1 || level == 0 {
        return 0;
    }
    // Of r rows of c pixels there are no more than (r / 2^level + 1) (c / 2^level + 2).
    let [area, sides] = [stride * bands[0].count, width + 2 * height].map(u64::from);
    let pixels = (area >> (2 * level)) + (sides >> level) + 4;
    16 * u64::from(b.params.quads()) * pixels
}

/// Stage `coarse_cost`: the sums of each level but the first, a buffer a band.
fn coarse_costs(b: &mut Builder<'_>, scales: &[Scale], costs: &[CostVolume]) -> Vec<Vec<wgpu::Buffer>> {
    let quads = b.params.quads();
    let mut sums: Vec<Vec<wgpu::Buffer>> = Vec::new();
    for (level, pair) in scales.windows(2).enumerate() {
        let [finer, coarser] = pair else { unreachable!("windows of two") };
        let bands = (0..coarser.bands.len()).map(|band| {
            let buffer = b.buffer_of("coarse_cost", 2 * coarser.volume(band, quads), 2 * room(b, level + 1));
            let (rows, to) = (coarser.bands[band], &buffer);
            let own = CoarseOwn {
                width: finer.width,
                rows: finer.bands[band].count,
                stride: finer.stride,
                coarse_stride: coarser.stride,
            };
            let written = Written::CoarseCost { level: level + 1, band };
            let lines = coarser.width;
            let dispatch = Dispatch { lines, own: own.into(), ..Dispatch::default() };
            match level {
                0 => b.step("coarse_cost", &[costs[band].bound(), Buffer(to)], dispatch, lines, rows.count, written),
                _ => {
                    let storage = [Buffer(&sums[level - 1][band]), Buffer(to)];
                    b.step("coarse_cost_sums", &storage, dispatch, lines, rows.count, written);
                }
            }
            buffer
        });
        let bands = bands.collect();
        sums.push(bands);
    }
    sums
}

/// The beginning of a level.
#[derive(Clone, Copy)]
struct Start {
    level: usize,
    /// Whether it has a single pixel.
    alone: bool,
}

/// One time that all pixels of a colour send.
#[derive(Clone, Copy)]
struct Round {
    level: usize,
    /// How often others sent before, at this level.
    nth: usize,
    share: u32,
    last: bool,
}

impl Beliefs {
    /// The messages with which a level begins, which take the place of those of the level before.
    fn start(
        &mut self,
        b: &mut Builder<'_>,
        scale: &Scale,
        coarser: Option<&Scale>,
        Start { level, alone }: Start,
        to: Vec<wgpu::Buffer>,
    ) {
        for (band, buffer) in to.iter().enumerate() {
            let rows = scale.bands[band].count;
            let own = StartOwn {
                rows,
                stride: scale.stride,
                ..coarser.map_or_else(StartOwn::default, |of| start_of(of, band))
            };
            let from = self.messages.get(band).unwrap_or(&self.none);
            let [above, below] = self.beside(band);
            let lines = scale.width * (b.params.quads() / b.plan.width);
            let dispatch = Dispatch { lines, own: own.into(), ..Dispatch::default() };
            let written = Written::Messages { level, band, rounds: 0, last: alone };
            b.step("messages_start", &[Buffer(from), above, below, Buffer(buffer)], dispatch, lines, rows, written);
        }
        self.messages = to;
    }

    /// Stage `messages`: one round, from the sums of a level, or from the cost.
    fn send(
        &self,
        b: &mut Builder<'_>,
        scale: &Scale,
        sums: Option<&Vec<wgpu::Buffer>>,
        gray: &wgpu::TextureView,
        Round { level, nth, share, last }: Round,
    ) {
        for (band, rows) in scale.bands.iter().enumerate() {
            let [above, below] = self.beside(band);
            let data = sums.map_or_else(|| self.costs[band].bound(), |sums| Buffer(&sums[band]));
            let mut storage = vec![data, Buffer(&self.messages[band]), above, below];
            if level == 0 && b.params.smoothness_edge.is_some() {
                storage.push(Texture(gray));
            }
            let own = BeliefOwn { odd: nth as u32 % 2, share, ..own_of(scale, band) };
            let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
            let written = Written::Messages { level, band, rounds: nth + 1, last };
            let kernel = if sums.is_some() { "messages_coarse" } else { "messages" };
            b.step(kernel, &storage, dispatch, scale.width.div_ceil(2), rows.count, written);
        }
    }

    /// The messages of the bands above and below one.
    fn beside(&self, band: usize) -> [Bound<'_>; 2] {
        let of = |band: Option<usize>| Buffer(band.and_then(|band| self.messages.get(band)).unwrap_or(&self.none));
        [of(band.checked_sub(1)), of(Some(band + 1))]
    }

    /// What `winner_beliefs` is bound to of a band, but the maps.
    pub(super) fn bound(&self, band: usize) -> [Bound<'_>; 4] {
        let [above, below] = self.beside(band);
        [self.costs[band].bound(), Buffer(&self.messages[band]), above, below]
    }
}

/// What kernels know of a band of a level.
pub(super) fn own_of(scale: &Scale, band: usize) -> BeliefOwn {
    let rows = scale.bands[band];
    let above = band.checked_sub(1).map_or(0, |above| (2 * scale.bands[above].count - 1) * scale.stride);
    let Scale { width, height, stride, .. } = *scale;
    BeliefOwn { width, height, stride, first: rows.first, rows: rows.count, above, ..BeliefOwn::default() }
}

/// What the first messages of a band are made of.
fn start_of(coarser: &Scale, band: usize) -> StartOwn {
    let BeliefOwn { width, height, stride, first, rows, above, .. } = own_of(coarser, band);
    StartOwn {
        coarse_width: width,
        coarse_height: height,
        coarse_stride: stride,
        coarse_first: first,
        coarse_rows: rows,
        above,
        ..StartOwn::default()
    }
}
