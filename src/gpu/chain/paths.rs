//! Semi-global matching: from the planes through the cost to the paths that cross rows.

use crate::gpu::chain::cost::{CostVolume, matching_cost};
use crate::gpu::chain::planes::Planes;
use crate::gpu::layout::{Dispatch, Frame, PAIR_BUFFERS, PathOwn, Rows, cut};
use crate::gpu::plan::PATHS_BYTES;
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::reference::Direction;

/// What the paths along rows, and the winner, continue from.
pub(super) struct AcrossRows {
    /// The two directions along rows, which are not walked yet.
    pub(super) along: Vec<Direction>,
    /// The cost of each band.
    pub(super) costs: Vec<CostVolume>,
    pub(super) penalties: Penalties,
    /// The sums of the pairs of directions: [`PAIR_BUFFERS`] or fewer, a buffer a band.
    pub(super) paired: Vec<Vec<wgpu::Buffer>>,
    /// Bound where paths along rows carry nothing.
    pub(super) unused: [wgpu::Buffer; 2],
}

/// Stages `penalties` and `matching_cost`, and `sgm_aggregate` of all directions that cross rows.
pub(super) fn across_rows(b: &mut Builder<'_>, planes: &mut Planes) -> AcrossRows {
    let directions = Direction::all(b.params.paths);
    let penalties = Penalties::new(b, &directions, &planes.grays[0]);
    let (across, along) = directions.split_at(directions.len() - 2);
    let pairs: Vec<&[Direction]> = across.chunks(2).collect();
    // The i-th pair is in buffer i % 3, which is one for each band.
    let slots = pairs.len().div_ceil(PAIR_BUFFERS);
    let paired: Vec<Vec<wgpu::Buffer>> =
        pairs.iter().take(PAIR_BUFFERS).map(|_| b.volumes("sgm_aggregate", slots as u32)).collect();
    let steepest = across.iter().map(|direction| direction.dy.unsigned_abs()).max().unwrap_or(1);
    let row = u64::from(steepest) * b.sizes.volume_row;
    let carries: Vec<[wgpu::Buffer; 2]> =
        paired.iter().map(|_| [(); 2].map(|()| b.buffer("sgm_aggregate.carry", row))).collect();
    // On `per-thread` the cost is computed into what is then the first pair's volume, and copied into a texture.
    let computed = if b.plan.per_subgroup { b.volumes("matching_cost", 1) } else { paired[0].clone() };
    let costs = matching_cost(b, planes, &computed);
    for (i, pair) in pairs.iter().enumerate() {
        let (at, slot) = (i % PAIR_BUFFERS, (i / PAIR_BUFFERS) as u32);
        paths_across(b, pair, &costs, &penalties, &paired[at], slot, &carries[at]);
    }
    AcrossRows { along: along.to_vec(), costs, penalties, paired, unused: carries[0].clone() }
}

/// P2 of the steps of each forward direction that is walked, forwards or backwards; empty where it is the same for all.
pub(super) struct Penalties(Vec<(Direction, wgpu::Buffer)>);

impl Penalties {
    /// Stage `penalties`, if P2 is adaptive.
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
        Self(forward.iter().filter(walked).map(compute).collect())
    }

    /// What the steps of a direction are bound to besides `storage`, and how they find their penalties.
    pub(super) fn bound<'a>(
        &'a self,
        frame: Frame,
        direction: Direction,
        storage: &[Bound<'a>],
        dispatch: Dispatch,
        own: PathOwn,
    ) -> (Vec<Bound<'a>>, Dispatch) {
        let of = self.0.iter().find(|(forward, _)| [direction, direction.opposite()].contains(forward));
        let own = match direction.dy.unsigned_abs() {
            0 => {
                let vectors = frame.width / 16 + 1;
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
