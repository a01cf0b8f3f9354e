use crate::DisparityMap;
use crate::cpu::instructions::Instructions;
use rayon::prelude::*;

/// Values that are put in order side by side.
const LANES: usize = 32;

/// One value of each lane.
type Values = [i16; LANES];

#[inline(always)]
fn min(a: Values, b: Values) -> Values {
    std::array::from_fn(|i| a[i].min(b[i]))
}

#[inline(always)]
fn max(a: Values, b: Values) -> Values {
    std::array::from_fn(|i| a[i].max(b[i]))
}

#[inline(always)]
fn load(row: &[i16], at: usize) -> Values {
    let mut values = [0; LANES];
    values.copy_from_slice(&row[at..at + LANES]);
    values
}

/// Three values a lane in ascending order.
#[inline(always)]
fn three([a, b, c]: [Values; 3]) -> [Values; 3] {
    let (low, high) = (min(a, b), max(a, b));
    let rest = min(high, c);
    [min(low, rest), max(low, rest), max(high, c)]
}

/// Five values a lane in ascending order.
#[inline(always)]
fn five([v, w, x, y, z]: [Values; 5]) -> [Values; 5] {
    let (a, b, d, e) = (min(v, w), max(v, w), min(y, z), max(y, z));
    let (c, high) = (min(x, e), max(x, e));
    let (low, mid) = (min(c, d), max(c, d));
    let (x, y, z) = (min(b, high), min(a, mid), max(a, mid));
    let (u, w) = (max(y, low), min(x, z));
    [min(y, low), min(w, u), max(w, u), max(x, z), max(b, high)]
}

/// The middle one of nine values in three columns that are in order.
#[inline(always)]
fn middle_of_nine([a, b, c]: [[Values; 3]; 3]) -> Values {
    let low = max(max(a[0], b[0]), c[0]);
    let high = min(min(a[2], b[2]), c[2]);
    three([low, three([a[1], b[1], c[1]])[1], high])[1]
}

/// The largest and the second largest of four.
#[inline(always)]
fn largest([a, b, c, d]: [Values; 4]) -> [Values; 2] {
    let (e, f) = (max(a, b), max(c, d));
    [max(e, f), max(min(e, f), max(min(a, b), min(c, d)))]
}

/// The smallest and the second smallest of four.
#[inline(always)]
fn smallest([a, b, c, d]: [Values; 4]) -> [Values; 2] {
    let (e, f) = (min(a, b), min(c, d));
    [min(e, f), min(max(e, f), min(max(a, b), max(c, d)))]
}

/// The middle one of 25 values in five columns that are in order. The values of each rank are put in order, too: twelve of the 25
/// are then below the thirteenth or above it by their places. Of the others, on three diagonals, each value is at most its
/// neighbours on the next.
#[inline(always)]
fn middle_of_25(columns: [[Values; 5]; 5]) -> Values {
    let ranks: [[Values; 5]; 5] = std::array::from_fn(|rank| five(std::array::from_fn(|column| columns[column][rank])));
    let low = largest([ranks[0][3], ranks[1][2], ranks[2][1], ranks[3][0]]);
    let middle = five([ranks[0][4], ranks[1][3], ranks[2][2], ranks[3][1], ranks[4][0]]);
    let high = smallest([ranks[1][4], ranks[2][3], ranks[3][2], ranks[4][1]]);
    let third = min(middle[2], max(low[1], max(min(low[0], high[1]), high[0])));
    max(max(middle[1], third), min(middle[3], min(low[0], high[0])))
}

/// The columns of some rows in order, a row of values for each rank, continued by `N / 2` columns on either side and to whole
/// vectors.
struct Columns<const N: usize>([Vec<i16>; N]);

impl<const N: usize> Columns<N> {
    fn new(width: usize) -> Self {
        Self(std::array::from_fn(|_| vec![0; width.next_multiple_of(LANES) + 2 * LANES]))
    }

    /// Puts the columns of `rows` in order.
    #[inline(always)]
    fn put(&mut self, rows: [&[i16]; N], width: usize, order: impl Fn([Values; N]) -> [Values; N]) {
        let reach = N / 2;
        for x in (0..width).step_by(LANES) {
            let count = LANES.min(width - x);
            let read = |row: &[i16]| {
                if count == LANES {
                    return load(row, x);
                }
                let mut values = [0; LANES];
                values[..count].copy_from_slice(&row[x..x + count]);
                values
            };
            let ordered = order(rows.map(read));
            for (rank, values) in self.0.iter_mut().zip(ordered) {
                rank[reach + x..reach + x + LANES].copy_from_slice(&values);
            }
        }
        for rank in &mut self.0 {
            let (first, last) = (rank[reach], rank[reach + width - 1]);
            rank[..reach].fill(first);
            rank[reach + width..reach + width + reach].fill(last);
        }
    }

    /// The columns around x .. x + `LANES`.
    #[inline(always)]
    fn around(&self, x: usize) -> [[Values; N]; N] {
        std::array::from_fn(|column| std::array::from_fn(|rank| load(&self.0[rank], x + column)))
    }
}

/// Some rows of the filtered map, from `first` on.
#[inline(always)]
fn rows_of<const N: usize>(
    map: &DisparityMap,
    first: usize,
    to: &mut [i16],
    order: impl Fn([Values; N]) -> [Values; N] + Copy,
    middle: impl Fn([[Values; N]; N]) -> Values,
) {
    let (width, height) = (map.width as usize, map.height as usize);
    let mut columns = Columns::<N>::new(width);
    for (y, to) in (first..).zip(to.chunks_exact_mut(width)) {
        let row = |j: usize| &map.data[(y + j).saturating_sub(N / 2).min(height - 1) * width..][..width];
        columns.put(std::array::from_fn(row), width, order);
        for (i, to) in to.chunks_mut(LANES).enumerate() {
            let values = middle(columns.around(LANES * i));
            let inside: Values = std::array::from_fn(|lane| {
                let seen = (LANES * i + lane) as i32 - ((i32::from(values[lane]) + 8) >> 4);
                if (seen as u32) < map.width { values[lane] } else { DisparityMap::INVALID }
            });
            to.copy_from_slice(&inside[..to.len()]);
        }
    }
}

/// [`crate::reference::median`] by networks of minima and maxima.
pub(super) fn median(map: &DisparityMap, side: usize, instructions: Instructions) -> DisparityMap {
    let width = map.width as usize;
    let rows = (map.height as usize).div_ceil(4 * rayon::current_num_threads()).max(8);
    let mut data = vec![0; map.data.len()];
    data.par_chunks_mut(rows * width).enumerate().for_each(|(band, to)| {
        instructions.run(
            #[inline(always)]
            || match side {
                3 => rows_of::<3>(map, rows * band, to, three, middle_of_nine),
                _ => rows_of::<5>(map, rows * band, to, five, middle_of_25),
            },
        );
    });
    DisparityMap { data, ..*map }
}
