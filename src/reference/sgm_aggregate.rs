use super::Volume;
use crate::{Params, Paths};
use rayon::prelude::*;

/// A direction of aggregation: the step from one pixel of a path to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction {
    /// Columns, to the right.
    pub dx: i32,
    /// Rows, downwards.
    pub dy: i32,
}

impl Direction {
    /// The directions of `paths`, each followed by its opposite where that is among them.
    pub fn all(paths: Paths) -> &'static [Direction] {
        const ALL: [Direction; 8] = [
            Direction { dx: 0, dy: 1 },
            Direction { dx: 0, dy: -1 },
            Direction { dx: 1, dy: 1 },
            Direction { dx: -1, dy: -1 },
            Direction { dx: -1, dy: 1 },
            Direction { dx: 1, dy: -1 },
            Direction { dx: 1, dy: 0 },
            Direction { dx: -1, dy: 0 },
        ];
        const FOUR: [Direction; 4] = [ALL[0], ALL[1], ALL[6], ALL[7]];
        const THREE: [Direction; 3] = [ALL[0], ALL[6], ALL[7]];
        match paths {
            Paths::Three => &THREE,
            Paths::Four => &FOUR,
            Paths::Eight => &ALL,
            Paths::Five | Paths::Sixteen => &[],
        }
    }
}

/// One pixel of a path: Hirschmüller 2008, equation 13. `previous` is the path cost of the pixel before, if there is
/// one in the image.
///
/// L(d) = C(d) + min(L'(d), L'(d - 1) + P1, L'(d + 1) + P1, min L' + P2) - min L'; L = C where a path starts.
fn step(cost: &[u8], previous: Option<&[u8]>, p1: u32, p2: u32, path: &mut [u8]) {
    let Some(previous) = previous else {
        path.copy_from_slice(cost);
        return;
    };
    let lowest = u32::from(previous.iter().copied().min().unwrap_or(0));
    let last = cost.len() - 1;
    for d in 0..cost.len() {
        let mut best = u32::from(previous[d]).min(lowest + p2);
        if d > 0 {
            best = best.min(u32::from(previous[d - 1]) + p1);
        }
        if d < last {
            best = best.min(u32::from(previous[d + 1]) + p1);
        }
        path[d] = (u32::from(cost[d]) + best - lowest) as u8;
    }
}

/// The path costs L of one direction, at most 89 + P2.
pub fn aggregate_direction(cost: &Volume<u8>, direction: Direction, params: &Params) -> Volume<u8> {
    let (p1, p2, n) = (params.p1, params.p2, cost.disparities);
    let mut paths = Volume::new(cost.width, cost.height, n);
    let row_len = cost.row_len();
    if direction.dy == 0 {
        paths.data.par_chunks_mut(row_len).zip(cost.data.par_chunks(row_len)).for_each(|(paths, cost)| {
            for i in 0..row_len / n {
                let x = if direction.dx > 0 { i } else { row_len / n - 1 - i };
                let (before, rest) = paths.split_at_mut(x * n);
                let (here, after) = rest.split_at_mut(n);
                let previous = match (i, direction.dx > 0) {
                    (0, _) => None,
                    (_, true) => Some(&before[(x - 1) * n..]),
                    (_, false) => Some(&after[..n]),
                };
                step(&cost[x * n..][..n], previous, p1, p2, here);
            }
        });
        return paths;
    }
    for i in 0..cost.height {
        let y = if direction.dy > 0 { i } else { cost.height - 1 - i };
        let (before, rest) = paths.data.split_at_mut(y * row_len);
        let (here, after) = rest.split_at_mut(row_len);
        let previous_row = match (i, direction.dy > 0) {
            (0, _) => None,
            (_, true) => Some(&before[(y - 1) * row_len..]),
            (_, false) => Some(&after[..row_len]),
        };
        let cost_row = &cost.data[y * row_len..][..row_len];
        here.par_chunks_mut(n).zip(cost_row.par_chunks(n)).enumerate().with_min_len(32).for_each(
            |(x, (path, cost))| {
                let from = x as i64 - i64::from(direction.dx);
                let inside = (0..(row_len / n) as i64).contains(&from);
                let previous = previous_row.filter(|_| inside).map(|row| &row[from as usize * n..][..n]);
                step(cost, previous, p1, p2, path);
            },
        );
    }
    paths
}

/// Stage `sgm_aggregate`: the sum of the path costs of all directions (equation 14), at most 8 * (89 + 127).
pub fn sgm_aggregate(cost: &Volume<u8>, params: &Params) -> Volume<u16> {
    let mut sum = Volume::new(cost.width, cost.height, cost.disparities);
    for &direction in Direction::all(params.paths) {
        let paths = aggregate_direction(cost, direction, params);
        sum.data.par_iter_mut().zip(&paths.data).with_min_len(1 << 16).for_each(|(sum, &path)| {
            *sum += u16::from(path);
        });
    }
    sum
}
