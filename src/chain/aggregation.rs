//! Semi-global matching: from the planes through the cost and its aggregation to the winner.

use super::Views;
use super::cost::{self, Cost};
use super::planes::Planes;
use crate::Paths;
use crate::buffers::{Frame, PAIR_BUFFERS, Pass, Rows, WORDS, cut};
use crate::reference::Direction;
use crate::schedule::{PATHS_BYTES, ROWS_BYTES};
use crate::steps::Bound::{self, Buffer, Texture};
use crate::steps::{Builder, Output};

/// Stages `penalties`, `matching_cost`, `sgm_aggregate` and `winner`.
pub(super) fn winner(b: &mut Builder<'_>, planes: &Planes, views: &Views) {
    let penalties = Penalties::new(b, planes);
    let directions = Direction::all(b.params.paths);
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
    // On `lines` the cost is computed into what is then the first pair's volume, and copied into a texture.
    let computed = if b.plan.lanes { b.volumes("matching_cost", 1) } else { paired[0].clone() };
    let costs = cost::matching_cost(b, planes, &computed);
    for (i, pair) in pairs.iter().enumerate() {
        let (at, slot) = (i % PAIR_BUFFERS, (i / PAIR_BUFFERS) as u32);
        paths_across(b, pair, &costs, &penalties, &paired[at], slot, &carries[at]);
    }
    rows(b, along, &costs, &penalties, &paired, &carries[0], views);
}

/// Where P2 of each step is read; nothing where it is the same for all.
struct Penalties(Vec<wgpu::TextureView>);

impl Penalties {
    /// Stage `penalties`, if P2 is adaptive.
    fn new(b: &mut Builder<'_>, planes: &Planes) -> Self {
        let Frame { width, height, .. } = b.sizes.frame;
        let kernels: &[&str] = match b.params.paths {
            _ if !b.plan.adaptive => &[],
            Paths::Sixteen => &["penalties", "penalties_steep"],
            _ => &["penalties"],
        };
        let textures = kernels.iter().enumerate().map(|(word, kernel)| {
            let buffer = b.buffer("penalties", b.sizes.penalties);
            let storage = [Texture(&planes.grays[0]), Buffer(&buffer)];
            let output = Output::Penalties { first: 4 * word };
            b.step(kernel, &storage, Pass::default(), width.div_ceil(16), height, output);
            let rows = (b.sizes.penalties / (4 * u64::from(WORDS))) as u32;
            b.copy_to_texture(WORDS, rows, wgpu::TextureFormat::R32Uint)
        });
        Self(textures.collect())
    }

    /// What the steps of a direction are bound to besides `storage`, and how they find their penalties.
    fn bound<'a>(
        &'a self,
        frame: Frame,
        direction: Direction,
        storage: &[Bound<'a>],
        pass: Pass,
    ) -> (Vec<Bound<'a>>, Pass) {
        let stride = 16 * frame.width.div_ceil(16) as i32;
        let is = |direction: Direction| Direction::FORWARD.iter().position(|forward| *forward == direction);
        let (k, penalty_offset) = match is(direction) {
            Some(k) => (k, 0),
            None => (is(direction.opposite()).unwrap_or(0), -(direction.dy * stride + direction.dx)),
        };
        let texture = self.0.get(k / 4).map(Texture);
        let pass = Pass { penalty_offset, penalty_shift: 8 * (k as u32 % 4), ..pass };
        (storage.iter().copied().chain(texture).collect(), pass)
    }
}

/// Paths that cross a band: `set` 0 are those that enter at its first row in their direction, `set` 1 those that
/// enter at the second, of a direction that takes two rows a step.
fn paths_through(frame: Frame, band: Rows, direction: Direction, set: u32) -> Pass {
    let Direction { dx, dy } = direction;
    let (step, entry) = (dy.unsigned_abs(), if dy > 0 { set as i32 } else { band.count as i32 - 1 - set as i32 });
    let rows = (band.count + step - 1 - set) / step;
    // A line is named by the row, 0 or 1, and the column at which it crosses that.
    let steps = (i64::from(band.first) + i64::from(entry)).div_euclid(step.into());
    let slope = i64::from(dx * dy.signum());
    Pass {
        first_row: band.first,
        rows,
        shift: (slope * steps).rem_euclid(frame.width.into()) as u32,
        // Where there is one column, every step leaves the image.
        dx: if frame.width == 1 { dx.signum() } else { dx },
        dy,
        entry,
        carry_from: set,
        carry_to: set + step * rows - band.count,
        ..Pass::default()
    }
}

/// The paths of a pair that cross rows, a strip of them at a time: if they are opposite ones, there and back.
fn paths_across(
    b: &mut Builder<'_>,
    pair: &[Direction],
    costs: &[Cost],
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
                    let pass = Pass {
                        first_line: strip.first,
                        lines: strip.count,
                        carried: (nth > 0).into(),
                        accumulate: second as u32,
                        slot: slot * rows.count * volume_stride,
                        ..paths_through(b.sizes.frame, rows, direction, set)
                    };
                    let (from, to) = (Buffer(&carry[nth % 2]), Buffer(&carry[1 - nth % 2]));
                    let output = Output::Paths {
                        directions: pair.to_vec(),
                        band: rows,
                        volume_row: slot * rows.count,
                        first: slot == 0 && second == 0 && strip.first == 0 && set == 0,
                        last: second + 1 == pair.len() && strip.first + strip.count == width && set + 1 == sets,
                    };
                    let storage = [costs[band].bound(), Buffer(&paths[band]), from, to];
                    let (storage, pass) = penalties.bound(b.sizes.frame, direction, &storage, pass);
                    b.step("sgm_aggregate", &storage, pass, strip.count, 1, output);
                }
            }
        }
    }
}

/// The horizontal pair, which ends in the winner, a strip of rows at a time.
fn rows(
    b: &mut Builder<'_>,
    along: &[Direction],
    costs: &[Cost],
    penalties: &Penalties,
    paired: &[Vec<wgpu::Buffer>],
    unused: &[wgpu::Buffer; 2],
    views: &Views,
) {
    let frame = b.sizes.frame;
    let most_band = b.sizes.bands.iter().map(|band| band.count).max().unwrap_or(1);
    let strip_rows = b.plan.strip(most_band, b.sizes.volume_row, ROWS_BYTES);
    let forward = b.buffer("sgm_aggregate.forward", b.sizes.volume(strip_rows));
    for (band, &rows) in b.sizes.bands.iter().enumerate() {
        for strip in cut(rows, strip_rows) {
            let volume_row = strip.first - rows.first;
            let pass = Pass { first_row: strip.first, rows: strip.count, volume_row, ..Pass::default() };
            let along_row = Pass { lines: strip.count, dx: along[0].dx, dy: along[0].dy, ..pass };
            let output =
                Output::Paths { directions: vec![along[0]], band: strip, volume_row: 0, first: true, last: true };
            let storage = [costs[band].bound(), Buffer(&forward), Buffer(&unused[0]), Buffer(&unused[1])];
            let (storage, along_row) = penalties.bound(frame, along[0], &storage, along_row);
            b.step("sgm_aggregate", &storage, along_row, strip.count, 1, output);
            let pair = |i: usize| Buffer(&paired[i.min(paired.len() - 1)][band]);
            let storage = [
                costs[band].bound(),
                Buffer(&forward),
                pair(0),
                pair(1),
                pair(2),
                Buffer(&views.left),
                Buffer(&views.right),
            ];
            let output = Output::Views { right: views.right.clone(), last: strip.first + strip.count == frame.height };
            let pass = Pass { slot: rows.count * frame.volume_stride, ..pass };
            let (storage, pass) = penalties.bound(frame, along[1], &storage, pass);
            b.step("winner", &storage, pass, strip.count, 1, output);
        }
    }
}
