//! Semi-global matching: from the planes through the cost and its aggregation to the winner.

use super::Views;
use super::cost::{self, Cost};
use super::planes::Planes;
use crate::buffers::{Frame, Pass, Rows, cut};
use crate::reference::Direction;
use crate::schedule::{PATHS_BYTES, ROWS_BYTES};
use crate::steps::Bound::Buffer;
use crate::steps::{Builder, Output};

/// Stages `matching_cost`, `sgm_aggregate` and `winner`.
pub(super) fn winner(b: &mut Builder<'_>, planes: &Planes, views: &Views) {
    let directions = Direction::all(b.params.paths);
    let (across, along) = directions.split_at(directions.len() - 2);
    let pairs: Vec<&[Direction]> = across.chunks(2).collect();
    let paired: Vec<Vec<wgpu::Buffer>> = pairs.iter().map(|_| b.volume("sgm_aggregate")).collect();
    let row = b.sizes.volume_row;
    let carries: Vec<[wgpu::Buffer; 2]> =
        pairs.iter().map(|_| [(); 2].map(|()| b.buffer("sgm_aggregate.carry", row))).collect();
    // On `lines` the cost is computed into what is then the first pair's volume, and copied into a texture.
    let computed = if b.plan.lanes { b.volume("matching_cost") } else { paired[0].clone() };
    let costs = cost::matching_cost(b, planes, &computed);
    for ((pair, paths), carry) in pairs.iter().zip(&paired).zip(&carries) {
        paths_across(b, pair, &costs, paths, carry);
    }
    rows(b, along[0], &costs, &paired, &carries[0], views);
}

/// The paths of a pair that cross rows, there and back, a strip of them at a time.
fn paths_across(
    b: &mut Builder<'_>,
    pair: &[Direction],
    costs: &[Cost],
    paths: &[wgpu::Buffer],
    carry: &[wgpu::Buffer; 2],
) {
    let Frame { width, height, .. } = b.sizes.frame;
    let path_bytes = u64::from(16 * b.params.quads()) * u64::from(height);
    let strip_lines = b.plan.strip(width, path_bytes, PATHS_BYTES);
    for strip in cut(Rows { first: 0, count: width }, strip_lines) {
        for (second, direction) in pair.iter().enumerate() {
            for nth in 0..b.sizes.bands.len() {
                let band = if direction.dy > 0 { nth } else { b.sizes.bands.len() - 1 - nth };
                let rows = b.sizes.bands[band];
                let enters = if direction.dy > 0 { rows.first } else { rows.first + rows.count - 1 };
                let slope = i64::from(direction.dx * direction.dy);
                let pass = Pass {
                    rows: rows.count,
                    first_line: strip.first,
                    lines: strip.count,
                    shift: (slope * i64::from(enters)).rem_euclid(width.into()) as u32,
                    dx: direction.dx,
                    dy: direction.dy,
                    carried: (nth > 0).into(),
                    accumulate: second as u32,
                    ..Pass::default()
                };
                let (from, to) = (Buffer(&carry[nth % 2]), Buffer(&carry[1 - nth % 2]));
                let output = Output::Paths {
                    directions: pair.to_vec(),
                    band: rows,
                    first: second == 0 && strip.first == 0,
                    last: second + 1 == pair.len() && strip.first + strip.count == width,
                };
                let storage = [costs[band].bound(), Buffer(&paths[band]), from, to];
                b.step("sgm_aggregate", &storage, pass, strip.count, 1, output);
            }
        }
    }
}

/// The horizontal pair, which ends in the winner, a strip of rows at a time.
fn rows(
    b: &mut Builder<'_>,
    forwards: Direction,
    costs: &[Cost],
    paired: &[Vec<wgpu::Buffer>],
    unused: &[wgpu::Buffer; 2],
    views: &Views,
) {
    let most_band = b.sizes.bands.iter().map(|band| band.count).max().unwrap_or(1);
    let strip_rows = b.plan.strip(most_band, b.sizes.volume_row, ROWS_BYTES);
    let forward = b.buffer("sgm_aggregate.forward", b.sizes.volume(strip_rows));
    for (band, &rows) in b.sizes.bands.iter().enumerate() {
        for strip in cut(rows, strip_rows) {
            let volume_row = strip.first - rows.first;
            let pass = Pass { first_row: strip.first, rows: strip.count, volume_row, ..Pass::default() };
            let along_row = Pass { lines: strip.count, dx: forwards.dx, dy: forwards.dy, ..pass };
            let output = Output::Paths { directions: vec![forwards], band: strip, first: true, last: true };
            let storage = [costs[band].bound(), Buffer(&forward), Buffer(&unused[0]), Buffer(&unused[1])];
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
            let output =
                Output::Views { right: views.right.clone(), last: strip.first + strip.count == b.sizes.frame.height };
            b.step("winner", &storage, pass, strip.count, 1, output);
        }
    }
}
