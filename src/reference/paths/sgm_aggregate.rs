use crate::reference::Volume;
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
    const fn new(dx: i32, dy: i32) -> Self {
        Self { dx, dy }
    }

    /// Of each pair of opposite directions the one that goes down, or to the right.
    pub const FORWARD: [Direction; 8] = [
        Self::new(0, 1),
        Self::new(1, 1),
        Self::new(-1, 1),
        Self::new(1, 0),
        Self::new(1, 2),
        Self::new(-1, 2),
        Self::new(2, 1),
        Self::new(-2, 1),
    ];

    /// The same steps the other way.
    pub fn opposite(self) -> Self {
        Self::new(-self.dx, -self.dy)
    }

    /// The directions of `paths`: (1, 0) and (-1, 0) are the last two, opposite directions follow each other.
    pub fn all(paths: Paths) -> Vec<Direction> {
        let [down, right_down, left_down, right, knights @ ..] = Self::FORWARD;
        let both = |forward: &[Direction]| forward.iter().flat_map(|&d| [d, d.opposite()]).collect::<Vec<_>>();
        let across = match paths {
            Paths::Three => vec![down],
            Paths::Four => both(&[down]),
            Paths::Five => vec![right_down, left_down, down],
            Paths::Eight => both(&[down, right_down, left_down]),
            Paths::Sixteen => [both(&[down, right_down, left_down]), both(&knights)].concat(),
        };
        [across, both(&[right])].concat()
    }
}

/// One pixel of a path: Hirschmüller 2008, equation 13. `previous` are the path costs of the pixel before and P1 and P2 of the
/// step from it, if there is one in the image.
///
/// L(d) = C(d) + min(L'(d), L'(d - 1) + P1, L'(d + 1) + P1, min L' + P2) - min L'; L = C where a path starts.
fn step(cost: &[u8], previous: Option<(&[u8], [u32; 2])>, path: &mut [u8]) {
    let Some((previous, [p1, p2])) = previous else {
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

/// The path costs L of one direction, at most the largest cost + P2. `penalties` are those of [`crate::reference::penalties`] where P1 or
/// P2 is adaptive.
pub fn aggregate_direction(
    cost: &Volume<u8>,
    penalties: Option<&Volume<u8>>,
    direction: Direction,
    params: &Params,
) -> Volume<u8> {
    let n = cost.disparities;
    let (width, height) = (cost.width as i64, cost.height as i64);
    let (dx, dy) = (i64::from(direction.dx), i64::from(direction.dy));
    let mut paths = Volume::new(cost.width, cost.height, n);
    let row_len = cost.row_len();
    // Pixels in an order in which the pixel before comes first; of a row all at once where it lies in another row.
    let has_before = |x: i64, y: i64| (0..width).contains(&(x - dx)) && (0..height).contains(&(y - dy));
    let penalty = |x: i64, y: i64| match penalties {
        // The step from q to p has the penalty of that from p to q: of the two, the forward one is stored.
        Some(penalties) => {
            let forward = |d: &Direction| *d == direction;
            let backward = |d: &Direction| *d == direction.opposite();
            let (x, y, k) = match Direction::FORWARD.iter().position(forward) {
                Some(k) => (x, y, k),
                None => (x - dx, y - dy, Direction::FORWARD.iter().position(backward).unwrap_or(0)),
            };
            let of_pixel = &penalties.data[(y * width + x) as usize * penalties.disparities..][..penalties.disparities];
            match params.adaptive_p1 {
                true => [of_pixel[2 * k + 1], of_pixel[2 * k]].map(u32::from),
                false => [params.p1, of_pixel[k].into()],
            }
        }
        None => [params.p1, params.p2],
    };
    if dy == 0 {
        paths.data.par_chunks_mut(row_len).zip(cost.data.par_chunks(row_len)).enumerate().for_each(
            |(y, (paths, cost))| {
                for i in 0..width {
                    let x = if dx > 0 { i } else { width - 1 - i };
                    let mut path = vec![0; n];
                    let before = (i > 0).then(|| (&paths[(x - dx) as usize * n..][..n], penalty(x, y as i64)));
                    step(&cost[x as usize * n..][..n], before, &mut path);
                    paths[x as usize * n..][..n].copy_from_slice(&path);
                }
            },
        );
        return paths;
    }
    for i in 0..height {
        let y = if dy > 0 { i } else { height - 1 - i };
        let (above, rest) = paths.data.split_at_mut(y as usize * row_len);
        let (here, below) = rest.split_at_mut(row_len);
        let rows_before = if dy > 0 { &*above } else { &*below };
        let first_row = if dy > 0 { 0 } else { y + 1 };
        let cost_row = &cost.data[y as usize * row_len..][..row_len];
        here.par_chunks_mut(n).zip(cost_row.par_chunks(n)).enumerate().with_min_len(32).for_each(
            |(x, (path, cost))| {
                let x = x as i64;
                let before = has_before(x, y).then(|| {
                    let at = ((y - dy - first_row) * width + x - dx) as usize;
                    (&rows_before[at * n..][..n], penalty(x, y))
                });
                step(cost, before, path);
            },
        );
    }
    paths
}

/// Stage `sgm_aggregate`: the sum of the path costs of all directions (equation 14), at most 16 * 255.
pub fn sgm_aggregate(cost: &Volume<u8>, penalties: Option<&Volume<u8>>, params: &Params) -> Volume<u16> {
    let mut sum = Volume::new(cost.width, cost.height, cost.disparities);
    for direction in Direction::all(params.paths) {
        let paths = aggregate_direction(cost, penalties, direction, params);
        sum.data.par_iter_mut().zip(&paths.data).with_min_len(1 << 16).for_each(|(sum, &path)| {
            *sum += u16::from(path);
        });
    }
    sum
}
