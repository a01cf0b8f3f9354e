//! Semi-global matching: from the planes through the cost to the paths that cross rows.

use crate::gpu::chain::cost::{CostVolume, matching_cost};
use crate::gpu::chain::planes::Planes;
use crate::gpu::layout::{Dispatch, Frame, PAIR_BUFFERS, PathOwn, Rows, TEXTURE_ROW, cut};
use crate::gpu::plan::{PATHS_BYTES, ROWS_BYTES, penalty_bytes};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::reference::Direction;

/// What is aggregated, and where.
pub(super) struct Aggregation {
    /// The directions that cross rows, two by two.
    pairs: Vec<Vec<Direction>>,
    /// The directions to the right and to the left.
    along: Vec<Direction>,
    /// The cost of each band.
    pub(super) costs: Vec<CostVolume>,
    penalties: Penalties,
    /// The sums of the pairs of directions: [`PAIR_BUFFERS`] or fewer, a buffer a band.
    pub(super) paired: Vec<Vec<wgpu::Buffer>>,
    /// What paths leave at the end of a band, of each of those buffers. Paths along rows carry nothing, and are bound to the first.
    carries: Vec<[wgpu::Buffer; 2]>,
    /// T of the path to the right, of a strip of rows, and the rows of that.
    pub(super) forward: wgpu::Buffer,
    strip_rows: u32,
}

/// Stages `penalties` and `matching_cost`, and what `sgm_aggregate` needs.
pub(super) fn aggregation(b: &mut Builder<'_>, planes: &mut Planes) -> Aggregation {
    let directions = Direction::all(b.params.paths);
    let penalties = Penalties::new(b, &directions, &planes.grays[0]);
    let (across, along) = directions.split_at(directions.len() - 2);
    let pairs: Vec<_> = across.chunks(2).map(<[Direction]>::to_vec).collect();
    // The i-th pair is in buffer i % 3, which is one for each band.
    let slots = pairs.len().div_ceil(PAIR_BUFFERS);
    let paired: Vec<Vec<wgpu::Buffer>> =
        pairs.iter().take(PAIR_BUFFERS).map(|_| b.volumes("sgm_aggregate", slots as u32)).collect();
    let steepest = across.iter().map(|direction| direction.dy.unsigned_abs()).max().unwrap_or(1);
    let row = u64::from(steepest) * b.sizes.volume_row;
    let carries: Vec<[wgpu::Buffer; 2]> =
        paired.iter().map(|_| [(); 2].map(|()| b.buffer("sgm_aggregate.carry", row))).collect();
    // On `per-thread` the cost is computed into what is then the first pair's volume, and copied into a texture.
    let computed = match b.plan.per_subgroup {
        // In a second pass it changes places with the first pair.
        true => b.volumes("matching_cost", if b.params.aggregates_twice() { slots as u32 } else { 1 }),
        false => paired[0].clone(),
    };
    let costs = matching_cost(b, planes, &computed);
    let most_band = b.sizes.bands.iter().map(|band| band.count).max().unwrap_or(1);
    let strip_rows = b.plan.strip(most_band, b.sizes.volume_row, ROWS_BYTES);
    let room = b.plan.strip_room(most_band, b.sizes.volume_row, ROWS_BYTES);
    let forward = b.buffer_of("sgm_aggregate.forward", b.sizes.volume(strip_rows), room.next_multiple_of(TEXTURE_ROW));
    Aggregation { pairs, along: along.to_vec(), costs, penalties, paired, carries, forward, strip_rows }
}

impl Aggregation {
    /// `sgm_aggregate` of all directions that cross rows.
    pub(super) fn across_rows(&self, b: &mut Builder<'_>) {
        for (i, pair) in self.pairs.iter().enumerate() {
            let (at, slot) = (i % PAIR_BUFFERS, (i / PAIR_BUFFERS) as u32);
            paths_across(b, pair, &self.costs, &self.penalties, &self.paired[at], slot, &self.carries[at]);
        }
    }

    /// The rows that are walked along at a time: the number of their band, and the strip.
    pub(super) fn strips(&self, b: &Builder<'_>) -> Vec<(usize, Rows)> {
        let strips = |(band, &rows)| cut(rows, self.strip_rows).into_iter().map(move |strip| (band, strip));
        b.sizes.bands.iter().enumerate().flat_map(strips).collect()
    }

    /// `sgm_aggregate` to the right along a strip.
    pub(super) fn rightwards(&self, b: &mut Builder<'_>, band: usize, strip: Rows) {
        let step = self.along[0];
        let dispatch = strip_of(b, band, strip);
        let dispatch = Dispatch { lines: strip.count, dx: step.dx, dy: step.dy, slot: 0, ..dispatch };
        let written = Written::Paths { directions: vec![step], band: strip, volume_row: 0, first: true, last: true };
        let [from, to] = &self.carries[0];
        let storage = [self.costs[band].bound(), Buffer(&self.forward), Buffer(from), Buffer(to)];
        let own = PathOwn::default();
        let (storage, dispatch) = self.penalties.bound(b.sizes.frame, step, &storage, dispatch, own);
        b.step("sgm_aggregate", &storage, dispatch, strip.count, 1, written);
    }

    /// The kernel of the path to the left along a strip, which adds up all.
    pub(super) fn leftwards(
        &self,
        b: &mut Builder<'_>,
        (kernel, written): (&str, Written),
        (band, strip): (usize, Rows),
        storage: &[Bound<'_>],
        map_row: u32,
    ) {
        let dispatch = Dispatch { map_row, ..strip_of(b, band, strip) };
        let own = PathOwn::default();
        let (storage, dispatch) = self.penalties.bound(b.sizes.frame, self.along[1], storage, dispatch, own);
        b.step(kernel, &storage, dispatch, strip.count, 1, written);
    }

    /// The first pass up to the cost of the second one, stage `second_cost`, which takes the place of the cost.
    pub(super) fn first_pass(&mut self, b: &mut Builder<'_>) {
        self.across_rows(b);
        let height = b.sizes.frame.height;
        for (band, strip) in self.strips(b) {
            self.rightwards(b, band, strip);
            // What the kernel writes is not bound a second time.
            let pair = |i: usize| Buffer(self.paired.get(i).map_or(&self.carries[0][0], |pair| &pair[band]));
            let storage = [self.costs[band].bound(), Buffer(&self.forward), pair(0), pair(1), pair(2)];
            let rows = b.sizes.bands[band];
            let volume_row = strip.first - rows.first;
            let written = Written::SecondCost { rows: strip, volume_row, last: strip.end() == height };
            self.leftwards(b, ("second_cost", written), (band, strip), &storage, 0);
            if strip.end() == rows.end() {
                self.costs[band].replace(b, rows, &mut self.paired[0][band]);
            }
        }
    }
}

/// What kernels that walk along the rows of a strip are given.
fn strip_of(b: &Builder<'_>, band: usize, strip: Rows) -> Dispatch {
    let rows = b.sizes.bands[band];
    Dispatch {
        first_row: strip.first,
        rows: strip.count,
        volume_row: strip.first - rows.first,
        slot: rows.count * b.sizes.frame.volume_stride,
        ..Dispatch::default()
    }
}

/// P2 of the steps of each forward direction that is walked, forwards or backwards, and P1 if that is adaptive; empty where they
/// are the same for all.
struct Penalties {
    /// Of a step.
    bytes: u32,
    of: Vec<(Direction, wgpu::Buffer)>,
}

impl Penalties {
    /// Stage `penalties`, if P1 or P2 is adaptive.
    fn new(b: &mut Builder<'_>, directions: &[Direction], gray: &wgpu::TextureView) -> Self {
        let Frame { width, height, .. } = b.sizes.frame;
        let forward: &[Direction] = if b.plan.adaptive { &Direction::FORWARD } else { &[] };
        let walked = |forward: &&Direction| directions.iter().any(|d| [*d, d.opposite()].contains(forward));
        let compute = |&direction: &Direction| {
            let buffer = b.buffer("penalties", b.sizes.penalties);
            let (storage, written) = ([Texture(gray), Buffer(&buffer)], Written::Penalties { direction });
            match direction.dy.unsigned_abs() {
                0 => b.step("penalties", &storage, Dispatch::default(), width / 16 + 1, height, written),
                step => {
                    let Direction { dx, dy } = direction;
                    let dispatch = Dispatch { dx: step_across(width, dx), dy, ..Dispatch::default() };
                    b.step(
                        "penalties_lines",
                        &storage,
                        dispatch,
                        width,
                        step * (height.div_ceil(step) / 16 + 1),
                        written,
                    );
                }
            }
            (direction, buffer)
        };
        let of = forward.iter().filter(walked).map(compute).collect();
        Self { bytes: penalty_bytes(&b.params), of }
    }

    /// What the steps of a direction are bound to besides `storage`, and how they find their penalties.
    fn bound<'a>(
        &'a self,
        frame: Frame,
        direction: Direction,
        storage: &[Bound<'a>],
        dispatch: Dispatch,
        own: PathOwn,
    ) -> (Vec<Bound<'a>>, Dispatch) {
        let of = self.of.iter().find(|(forward, _)| [direction, direction.opposite()].contains(forward));
        let own = match direction.dy.unsigned_abs() {
            0 => {
                let vectors = self.bytes * (frame.width / 16 + 1);
                let penalties_from = dispatch.first_row * vectors;
                PathOwn { penalties_from, penalties_line: vectors, penalties_step: 1, ..own }
            }
            step => {
                // Of two sets of paths in a band of one row the second one has no pixel.
                let (entry, rows) = (dispatch.first_row as i32 + dispatch.entry, step as i32);
                PathOwn {
                    penalties_from: entry.rem_euclid(rows) as u32 * frame.width,
                    penalties_line: 1,
                    penalties_step: step * frame.width,
                    place: entry.div_euclid(rows) + i32::from(direction.dy < 0),
                    ..own
                }
            }
        };
        (
            storage.iter().copied().chain(of.map(|(_, buffer)| Buffer(buffer))).collect(),
            Dispatch { own: own.into(), ..dispatch },
        )
    }
}

/// Columns of a step, but that every step leaves the image where there is one column.
fn step_across(width: u32, dx: i32) -> i32 {
    if width == 1 { dx.signum() } else { dx }
}

/// Paths that cross a band: `set` 0 are those that enter at its first row in their direction, `set` 1 those that
/// enter at the second, of a direction that takes two rows a step.
fn paths_through(frame: Frame, band: Rows, direction: Direction, set: u32) -> (Dispatch, PathOwn) {
    let Direction { dx, dy } = direction;
    let (step, entry) = (dy.unsigned_abs(), if dy > 0 { set as i32 } else { band.count as i32 - 1 - set as i32 });
    let rows = (band.count + step - 1 - set) / step;
    // A line is named by the row, 0 or 1, and the column at which it crosses that.
    let steps = (i64::from(band.first) + i64::from(entry)).div_euclid(step.into());
    let slope = i64::from(dx * dy.signum());
    let own = PathOwn { carry_from: set, carry_to: set + step * rows - band.count, ..PathOwn::default() };
    let dispatch = Dispatch {
        first_row: band.first,
        rows,
        shift: (slope * steps).rem_euclid(frame.width.into()) as u32,
        dx: step_across(frame.width, dx),
        dy,
        entry,
        ..Dispatch::default()
    };
    (dispatch, own)
}

/// The paths of a pair that cross rows, a strip of them at a time: if they are opposite ones, there and back.
fn paths_across(
    b: &mut Builder<'_>,
    pair: &[Direction],
    costs: &[CostVolume],
    penalties: &Penalties,
    paths: &[wgpu::Buffer],
    slot: u32,
    carry: &[wgpu::Buffer; 2],
) {
    let Frame { width, height, volume_stride, .. } = b.sizes.frame;
    let path_bytes = u64::from(16 * b.params.quads()) * u64::from(height);
    let opposite = pair.iter().all(|&direction| direction == pair[0] || direction == pair[0].opposite());
    let strip_lines = if opposite { b.plan.strip(width, path_bytes, PATHS_BYTES) } else { width };
    for strip in cut(Rows { first: 0, count: width }, strip_lines) {
        for (second, &direction) in pair.iter().enumerate() {
            for nth in 0..b.sizes.bands.len() {
                let band = if direction.dy > 0 { nth } else { b.sizes.bands.len() - 1 - nth };
                let rows = b.sizes.bands[band];
                let sets = direction.dy.unsigned_abs();
                for set in 0..sets {
                    let (through, own) = paths_through(b.sizes.frame, rows, direction, set);
                    let own = PathOwn { accumulate: second as u32, ..own };
                    let dispatch = Dispatch {
                        first_line: strip.first,
                        lines: strip.count,
                        carried: (nth > 0).into(),
                        slot: slot * rows.count * volume_stride,
                        ..through
                    };
                    let (from, to) = (Buffer(&carry[nth % 2]), Buffer(&carry[1 - nth % 2]));
                    let written = Written::Paths {
                        directions: pair.to_vec(),
                        band: rows,
                        volume_row: slot * rows.count,
                        first: slot == 0 && second == 0 && strip.first == 0 && set == 0,
                        last: second + 1 == pair.len() && strip.first + strip.count == width && set + 1 == sets,
                    };
                    let storage = [costs[band].bound(), Buffer(&paths[band]), from, to];
                    let (storage, dispatch) = penalties.bound(b.sizes.frame, direction, &storage, dispatch, own);
                    b.step("sgm_aggregate", &storage, dispatch, strip.count, 1, written);
                }
            }
        }
    }
}
