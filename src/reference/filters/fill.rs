use crate::reference::{Plane, median_weight, weighted_middle};
use crate::{DisparityMap, Fill, Params};

const INVALID: i16 = DisparityMap::INVALID;

/// A direction in which a ray goes from pixel to pixel.
type Ray = (i64, i64);

const AXES: [[Ray; 2]; 2] = [[(-1, 0), (1, 0)], [(0, -1), (0, 1)]];
const RAYS: [Ray; 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)];

/// Stage `fill`: invalid pixels are given a value. A map without any valid pixel stays as it is.
///
/// - [`Fill::Background`]: the smaller of the two nearest values of the row, or the only one; then, in rows without a
///   value, the same of the column. As `interpolateBackground` of the KITTI development kit, except that the kit
///   leaves rows without a value between rows that have some.
/// - [`Fill::Rays`]: occlusions take the smaller of the two nearest values of the row, or the only one; then each pixel that
///   is still invalid takes the median along eight rays; then the background.
/// - [`Fill::WeightedRays`]: as rays, but of each side of the row an occlusion sees the median of the three nearest values, led on
///   by the slope beside it where the other side has none; and in the median along the rays a value weighs the more, the nearer
///   its pixel's gray is to that of the pixel to fill.
/// - [`Fill::Hirschmuller`]: occlusions take the second lowest value along eight rays and mismatches the median; then the
///   background. Hirschmüller 2008, section 2.6.
///
/// A pixel is a mismatch if a disparity of the range leads to a pixel of the right view that has it, or one that differs
/// by at most `lr_check` (1 if the check is off); otherwise an occlusion.
///
/// A ray ends at the border, which is not continued: at either end of a row only one side has a value, and a row without any
/// is filled from the next one. The result need not point into the right image:
///
/// ```
/// use gpu_stereo::reference::{self, Plane};
/// use gpu_stereo::{DisparityMap, Fill, Params};
/// const NONE: i16 = DisparityMap::INVALID;
/// let map = DisparityMap { width: 4, height: 2, data: vec![NONE, 32, NONE, 16, NONE, NONE, NONE, NONE] };
/// let gray = Plane { width: 4, height: 2, data: vec![0; 8] };
/// let mut params = Params::sgm(16);
/// params.fill = Fill::Background;
/// assert_eq!(reference::fill(&map, &map, &gray, &params).data, [32, 32, 16, 16, 32, 32, 16, 16]);
/// ```
pub fn fill(map: &DisparityMap, right: &DisparityMap, gray: &Plane<u8>, params: &Params) -> DisparityMap {
    let occluded = |x, y| !mismatch(right, params, x, y);
    let map = match params.fill {
        Fill::None | Fill::Background => map.clone(),
        Fill::Rays => {
            let row = |x, y| if occluded(x, y) { farther(&nearest(map, &AXES[0], x, y)) } else { INVALID };
            let map = filled(map, row);
            filled(&map, |x, y| median(&nearest(&map, &RAYS, x, y)))
        }
        Fill::WeightedRays => {
            let row = |x, y| if occluded(x, y) { beside(map, params, x, y) } else { INVALID };
            let map = filled(map, row);
            filled(&map, |x, y| weighted_median(&map, gray, params.weighted_median_sigma, x, y))
        }
        Fill::Hirschmuller => filled(map, |x, y| {
            let values = nearest(map, &RAYS, x, y);
            if occluded(x, y) { second_lowest(&values) } else { median(&values) }
        }),
    };
    if params.fill == Fill::None {
        return map;
    }
    let map = filled(&map, |x, y| farther(&nearest(&map, &AXES[0], x, y)));
    filled(&map, |x, y| farther(&nearest(&map, &AXES[1], x, y)))
}

/// The map with `value(x, y)` where it is invalid.
fn filled(map: &DisparityMap, value: impl Fn(i64, i64) -> i16) -> DisparityMap {
    let width = map.width as usize;
    let fill = |(i, &v): (usize, &i16)| if v == INVALID { value((i % width) as i64, (i / width) as i64) } else { v };
    DisparityMap { data: map.data.iter().enumerate().map(fill).collect(), ..*map }
}

/// The valid pixels on a ray, as indices, the nearest first.
fn on_ray(map: &DisparityMap, (dx, dy): Ray, x: i64, y: i64) -> impl Iterator<Item = usize> {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let points = (1..).map(move |n| (x + n * dx, y + n * dy));
    let inside = points.take_while(move |&(x, y)| (0..width).contains(&x) && (0..height).contains(&y));
    inside.map(move |(x, y)| (y * width + x) as usize).filter(|&i| map.data[i] != INVALID)
}

/// The nearest valid value on each ray that has one, in ascending order.
fn nearest(map: &DisparityMap, rays: &[Ray], x: i64, y: i64) -> Vec<i16> {
    let on = |&ray: &Ray| on_ray(map, ray, x, y).next().map(|i| map.data[i]);
    let mut values: Vec<i16> = rays.iter().filter_map(on).collect();
    values.sort_unstable();
    values
}

/// The smaller of the medians of the three nearest valid values, or of as many as there are, on either side in the row. Where only
/// one side has values, the pixel lies in a strip at the row's end: the median, whose place is the second pixel of that side, is
/// led on by the slope there, by at most 4 px, within the range of disparities.
fn beside(map: &DisparityMap, params: &Params, x: i64, y: i64) -> i16 {
    let sides = AXES[0].map(|ray| {
        let mut values: Vec<i16> = on_ray(map, ray, x, y).take(3).map(|i| map.data[i]).collect();
        values.sort_unstable();
        median(&values)
    });
    let led = |side: usize| {
        let Some(end) = on_ray(map, AXES[0][side], x, y).next() else { return INVALID };
        let end = end as i64 % i64::from(map.width);
        let led = (slope(map, AXES[0][side].0, end, y) * ((x - end).abs() + 1)) >> 3;
        let first = 16 * i64::from(params.min_disparity);
        let last = first + 16 * i64::from(params.disparities - 1);
        (i64::from(sides[side]) - led.clamp(-64, 64)).clamp(first, last) as i16
    };
    match sides {
        [INVALID, _] => led(1),
        [_, INVALID] => led(0),
        [before, after] => before.min(after),
    }
}

/// How the values beside column `end` of a row change over 8 columns in the direction `dx`: the median, the lower one of an even
/// number, in the 16 columns from `end` on in this row, the two above and the two below.
fn slope(map: &DisparityMap, dx: i64, end: i64, y: i64) -> i64 {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let value = |x: i64, y: i64| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        let value = if inside { map.data[(y * width + x) as usize] } else { INVALID };
        (value != INVALID).then_some(i64::from(value))
    };
    let rows = (y - 2..=y + 2).flat_map(|y| (0..16).map(move |n| (end + n * dx, y)));
    let change = |(x, y)| Some(value(x + 8 * dx, y)? - value(x, y)?);
    let mut changes: Vec<i64> = rows.filter_map(change).map(|change| change.clamp(-128, 127)).collect();
    changes.sort_unstable();
    changes.get(changes.len().saturating_sub(1) / 2).copied().unwrap_or(0)
}

/// The median along the rays, a value weighted by its pixel's gray. No weight is 0, so there is one wherever there is a value.
fn weighted_median(map: &DisparityMap, gray: &Plane<u8>, sigma: u32, x: i64, y: i64) -> i16 {
    let own = gray.clamped(x, y);
    let weighted = |i: usize| (map.data[i], 1 + median_weight(i32::from(gray.data[i]).abs_diff(own), sigma));
    weighted_middle(RAYS.iter().filter_map(|&ray| on_ray(map, ray, x, y).next()).map(weighted).collect())
}

fn farther(values: &[i16]) -> i16 {
    values.first().copied().unwrap_or(INVALID)
}

fn second_lowest(values: &[i16]) -> i16 {
    values.get(1).copied().unwrap_or(farther(values))
}

/// The lower one of an even number.
fn median(values: &[i16]) -> i16 {
    values.get(values.len().saturating_sub(1) / 2).copied().unwrap_or(INVALID)
}

fn mismatch(right: &DisparityMap, params: &Params, x: i64, y: i64) -> bool {
    let (width, most) = (i64::from(right.width), i64::from(params.lr_check.unwrap_or(1)));
    let first = i64::from(params.min_disparity);
    (first..first + i64::from(params.disparities)).any(|d| {
        (0..width).contains(&(x - d)) && {
            let seen = right.data[(y * width + x - d) as usize];
            seen != INVALID && (i64::from(seen >> 4) - d).abs() <= most
        }
    })
}
