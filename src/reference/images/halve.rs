use crate::Params;
use crate::reference::Descriptors;

/// A pass through the chain for [`crate::Cost::MutualInformation`], which begins on small images.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// How many times the images are halved.
    pub halvings: u32,
    /// The settings, with the range of disparities divided accordingly; without filters of the map before the last round.
    pub params: Params,
}

/// The most halvings, and the shortest side that an image may have after them.
const MOST_HALVINGS: u32 = 4;
const SHORTEST_SIDE: u32 = 16;

/// The rounds of the smallest images.
const FIRST_ROUNDS: u32 = 3;

/// The rounds of a match: three of the smallest images, then one of each larger size. The images are halved while the
/// shorter side is at least 32, at most four times. One round for any other cost.
pub fn rounds(width: u32, height: u32, params: &Params) -> Vec<Round> {
    let last = Round { halvings: 0, params: params.clone() };
    if !params.has_table() {
        return vec![last];
    }
    let fits = |&halvings: &u32| width.min(height) >> halvings >= SHORTEST_SIDE;
    let most = (1..=MOST_HALVINGS).take_while(fits).last().unwrap_or(0);
    let rough = |halvings| Round { halvings, params: params.rough(halvings) };
    let first = (1..FIRST_ROUNDS).map(|_| rough(most));
    first.chain((1..=most).rev().map(rough)).chain([last]).collect()
}

/// Of the pairs that are at most so large, the largest ones with fewer halvings than the largest.
pub(crate) fn largest_with_fewer_rounds(width: u32, height: u32, params: &Params) -> Vec<[u32; 2]> {
    let most = rounds(width, height, params)[0].halvings;
    let side = |halvings| (SHORTEST_SIDE << (halvings + 1)) - 1;
    (0..most).flat_map(|halvings| [[width, side(halvings)], [side(halvings), height]]).collect()
}

/// Stage `halve`: an image at half the size, rounded up: of the four pixels (2x, 2y) to (2x + 1, 2y + 1), the image
/// continued by its border, floor((their sum + 2) / 4).
pub fn halve(values: &Descriptors) -> Descriptors {
    let Descriptors { width, height, .. } = *values;
    let data = halved(&values.data, [width, height], 1);
    Descriptors { width: width.div_ceil(2), height: height.div_ceil(2), planes: 1, data }
}

/// The same of `a_pixel` samples a pixel, each by itself; row by row.
pub(crate) fn halved<T: Copy + Into<u32> + TryFrom<u32> + Default>(
    samples: &[T],
    [width, height]: [usize; 2],
    a_pixel: usize,
) -> Vec<T> {
    let mut out = Vec::with_capacity(width.div_ceil(2) * height.div_ceil(2) * a_pixel);
    for y in (0..height).step_by(2) {
        let rows = [y, (y + 1).min(height - 1)].map(|y| &samples[y * width * a_pixel..][..width * a_pixel]);
        for x in (0..width).step_by(2) {
            for sample in 0..a_pixel {
                let columns = [x, (x + 1).min(width - 1)].map(|x| x * a_pixel + sample);
                let sum: u32 = rows.iter().map(|row| columns.map(|at| row[at].into()).iter().sum::<u32>()).sum();
                out.push(T::try_from((sum + 2) >> 2).unwrap_or_default());
            }
        }
    }
    out
}
