use crate::reference::{Plane, median_weight};
use crate::{DisparityMap, Fill, Params};
use rayon::prelude::*;
use std::ops::Range;

const INVALID: i16 = DisparityMap::INVALID;

/// [`crate::reference::fill`]: the nearest values along rays are carried from pixel to pixel.
pub(super) fn fill(map: &DisparityMap, right: &DisparityMap, gray: &Plane<u8>, params: &Params) -> DisparityMap {
    let mut map = map.clone();
    let width = map.width as usize;
    match params.fill {
        Fill::None => return map,
        Fill::Background => {}
        Fill::Rays => {
            map.data.par_chunks_mut(width).zip(right.data.par_chunks(width)).for_each(|(row, right)| {
                let mismatches = mismatches(right, params);
                fill_row(row, |x| !mismatches[x]);
            });
            along_rays(&mut map, |_, _, values| median(values));
        }
        Fill::WeightedRays => {
            let slopes: Vec<[i32; 2]> = (0..map.height as usize).into_par_iter().map(|y| slopes(&map, y)).collect();
            let rows = map.data.par_chunks_mut(width).zip(right.data.par_chunks(width)).zip(slopes);
            rows.for_each(|((row, right), slopes)| {
                let mismatches = mismatches(right, params);
                fill_row_by_medians(row, slopes, params, |x| !mismatches[x]);
            });
            along_weighted_rays(&mut map, gray, params.weighted_median_sigma);
        }
        Fill::Hirschmuller => {
            let mismatches: Vec<bool> =
                right.data.par_chunks(width).flat_map_iter(|row| mismatches(row, params)).collect();
            along_rays(
                &mut map,
                |x, y, values| {
                    if mismatches[y * width + x] { median(values) } else { second_lowest(values) }
                },
            );
        }
    }
    map.data.par_chunks_mut(width).for_each(|row| fill_row(row, |_| true));
    fill_columns(&mut map);
    map
}

/// Which pixels of a row are mismatches, from that row of the right view.
fn mismatches(right: &[i16], params: &Params) -> Vec<bool> {
    let width = right.len() as i64;
    let most = i64::from(params.lr_check.unwrap_or(1));
    let (first, last) = (i64::from(params.min_disparity), i64::from(params.disparities) - 1);
    // How many right pixels are seen from a column, as differences from column to column.
    let mut steps = vec![0i32; right.len() + 1];
    for (u, &seen) in (0..).zip(right) {
        if seen != INVALID {
            let x = u + i64::from(seen >> 4);
            let from = (x - most).max(u + first).max(0);
            let end = (x + most).min(u + first + last).min(width - 1) + 1;
            if from < end {
                steps[from as usize] += 1;
                steps[end as usize] -= 1;
            }
        }
    }
    let mut count = 0;
    let step = |step: &i32| {
        count += step;
        count > 0
    };
    steps[..right.len()].iter().map(step).collect()
}

/// The smaller one of two values, of which either may be invalid.
fn farther(a: i16, b: i16) -> i16 {
    if a == INVALID || b == INVALID { a.max(b) } else { a.min(b) }
}

/// Sets each invalid pixel of a row to `value` of its column, the nearest values before and after it, and the columns of the
/// hole that it lies in.
fn fill_holes(row: &mut [i16], value: impl Fn(usize, i16, i16, &Range<usize>) -> i16) {
    let (mut x, mut before) = (0, INVALID);
    while x < row.len() {
        if row[x] != INVALID {
            before = row[x];
            x += 1;
            continue;
        }
        let end = row[x..].iter().position(|&value| value != INVALID).map_or(row.len(), |count| x + count);
        let after = row.get(end).copied().unwrap_or(INVALID);
        let hole = x..end;
        for (x, to) in (x..).zip(&mut row[x..end]) {
            *to = value(x, before, after, &hole);
        }
        x = end;
    }
}

/// Fills the invalid pixels of a row that are `wanted` with the farther one of the two nearest values.
fn fill_row(row: &mut [i16], wanted: impl Fn(usize) -> bool) {
    fill_holes(row, |x, before, after, _| if wanted(x) { farther(before, after) } else { INVALID });
}

/// The first and the last valid pixel of a row.
fn ends(row: &[i16]) -> Option<[usize; 2]> {
    let valid = |&value: &i16| value != INVALID;
    Some([row.iter().position(valid)?, row.iter().rposition(valid)?])
}

/// The same with the medians of the three nearest values on either side, or of as many as there are; the strip before the first
/// value, and that behind the last, by the median and the slope there.
fn fill_row_by_medians(row: &mut [i16], slopes: [i32; 2], params: &Params, wanted: impl Fn(usize) -> bool) {
    let Some([first, last]) = ends(row) else { return };
    let values: Vec<i16> = row.iter().copied().filter(|&value| value != INVALID).collect();
    let median_of = |values: &[i16]| {
        let mut three = [INVALID; 3];
        three[..values.len()].copy_from_slice(values);
        let three = &mut three[..values.len()];
        three.sort_unstable();
        median(three)
    };
    // How many of the values lie before a pixel, and what a pixel between them and the others takes.
    let (mut passed, mut taken) = (0usize, None);
    for (x, to) in row[..last].iter_mut().enumerate().skip(first) {
        if *to != INVALID {
            (passed, taken) = (passed + 1, None);
        } else if wanted(x) {
            let medians = || {
                let [before, after] = [passed.saturating_sub(3)..passed, passed..values.len().min(passed + 3)];
                median_of(&values[before]).min(median_of(&values[after]))
            };
            *to = *taken.get_or_insert_with(medians);
        }
    }
    let lowest = 16 * params.min_disparity;
    let highest = lowest + 16 * (params.disparities as i32 - 1);
    let near = values.len().min(3);
    let nearest = [&values[..near], &values[values.len() - near..]];
    for (side, strip) in [0..first, last + 1..row.len()].into_iter().enumerate() {
        let (end, median) = ([first, last][side], i32::from(median_of(nearest[side])));
        for x in strip.filter(|&x| wanted(x)) {
            let led = (slopes[side] * (x.abs_diff(end) as i32 + 1)) >> 3;
            row[x] = (median - led.clamp(-64, 64)).clamp(lowest, highest) as i16;
        }
    }
}

/// The slopes at a row's first value and at its last, where there is a strip beyond them.
fn slopes(map: &DisparityMap, y: usize) -> [i32; 2] {
    let width = map.width as usize;
    let Some([first, last]) = ends(&map.data[y * width..][..width]) else { return [0; 2] };
    [
        if first == 0 { 0 } else { slope(map, first, y, false) },
        if last + 1 == width { 0 } else { slope(map, last, y, true) },
    ]
}

/// The median change of values over 8 columns, from column `end` of a row on, to the right or `leftwards`.
fn slope(map: &DisparityMap, end: usize, y: usize, leftwards: bool) -> i32 {
    let (width, height) = (map.width as usize, map.height as usize);
    let (mut changes, mut count) = ([0i32; 80], 0);
    for y in y.saturating_sub(2)..height.min(y + 3) {
        let row = &map.data[y * width..][..width];
        // The 16 columns, as far as the image has others 8 columns beyond.
        let near = if leftwards {
            (end + 1).saturating_sub(16).max(8)..end + 1
        } else {
            end..(end + 16).min(width.saturating_sub(8))
        };
        for x in near {
            let [from, to] = [x, if leftwards { x - 8 } else { x + 8 }].map(|x| row[x]);
            if from != INVALID && to != INVALID {
                changes[count] = i32::from(to) - i32::from(from);
                count += 1;
            }
        }
    }
    if count == 0 {
        return 0;
    }
    let (_, &mut middle, _) = changes[..count].select_nth_unstable((count - 1) / 2);
    middle.clamp(-128, 127)
}

/// Rows without a value take the farther one of the nearest rows on either side.
fn fill_columns(map: &mut DisparityMap) {
    let (width, height) = (map.width as usize, map.height as usize);
    // A row has values everywhere or nowhere.
    let has: Vec<bool> = map.data.chunks_exact(width).map(|row| row[0] != INVALID).collect();
    for y in (0..height).filter(|&y| !has[y]) {
        let above = (0..y).rev().find(|&y| has[y]);
        let below = (y + 1..height).find(|&y| has[y]);
        for x in 0..width {
            let value = |y: Option<usize>| y.map_or(INVALID, |y| map.data[y * width + x]);
            map.data[y * width + x] = farther(value(above), value(below));
        }
    }
}

/// Of each pixel the nearest values in rows before it, of three directions: straight, from the left and from the right.
type Carried<T> = [Vec<T>; 3];

/// The nearest values above, or with `upwards` below, which are `none` where there is none.
fn carried<T: Copy + PartialEq>(data: &[T], none: T, width: usize, upwards: bool) -> Carried<T> {
    let height = data.len() / width;
    let mut all: Carried<T> = std::array::from_fn(|_| vec![none; data.len()]);
    let mut last: Carried<T> = std::array::from_fn(|_| vec![none; width]);
    let at = |n: usize| if upwards { height - 1 - n } else { n } * width;
    for n in 1..height {
        let values = &data[at(n - 1)..][..width];
        for ((all, last), (to, from)) in all.iter_mut().zip(&mut last).zip([(0, 0), (1, 0), (0, 1)]) {
            let row = &mut all[at(n)..][..width];
            let before = values[from..].iter().zip(&last[from..]);
            for (to, (&value, &carried)) in row[to..].iter_mut().zip(before) {
                *to = if value == none { carried } else { value };
            }
            last.copy_from_slice(row);
        }
    }
    all
}

/// The nearest values above and below.
fn nearest<T: Copy + PartialEq + Send + Sync>(data: &[T], none: T, width: usize) -> (Carried<T>, Carried<T>) {
    rayon::join(|| carried(data, none, width, false), || carried(data, none, width, true))
}

/// Fills invalid pixels by `value` of the column, the row and the nearest values along eight rays in ascending order.
fn along_rays(map: &mut DisparityMap, value: impl Fn(usize, usize, &[i16]) -> i16 + Sync) {
    let width = map.width as usize;
    let (above, below) = nearest(&map.data, INVALID, width);
    map.data.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        fill_holes(row, |x, before, after, _| {
            let [[a, b, c], [d, e, f]] = [&above, &below].map(|of| of.each_ref().map(|of| of[y * width + x]));
            let mut values = [before, after, a, b, c, d, e, f];
            values.sort_unstable();
            let valid = values.iter().take_while(|&&value| value == INVALID).count();
            value(x, y, &values[valid..])
        });
    });
}

/// A value, above invalid, which is 0, over a number of 16 bits.
fn key(value: i16, low: u32) -> u32 {
    (u32::from(value as u16 ^ 0x8000) << 16) | low
}

/// Fills invalid pixels by the median of the nearest values along eight rays, each weighted by the difference of its pixel's
/// gray. Keys hold the gray of a value, then its weight.
fn along_weighted_rays(map: &mut DisparityMap, gray: &Plane<u8>, sigma: u32) {
    let width = map.width as usize;
    let weights: [u32; 256] = std::array::from_fn(|difference| 1 + median_weight(difference as u32, sigma));
    let with_gray = |(&value, &gray): (&i16, &u8)| if value == INVALID { 0 } else { key(value, gray.into()) };
    let keys: Vec<u32> = map.data.iter().zip(&gray.data).map(with_gray).collect();
    let (above, below) = nearest(&keys, 0, width);
    map.data.par_chunks_mut(width).zip(keys.par_chunks(width)).enumerate().for_each(|(y, (row, keys))| {
        fill_holes(row, |x, _, _, hole| {
            let [[a, b, c], [d, e, f]] = [&above, &below].map(|of| of.each_ref().map(|of| of[y * width + x]));
            let before = hole.start.checked_sub(1).map_or(0, |x| keys[x]);
            let after = keys.get(hole.end).copied().unwrap_or(0);
            let own = gray.data[y * width + x];
            let weighted = |key: u32| {
                if key == 0 { 0 } else { (key & 0xffff_0000) | weights[usize::from((key as u8).abs_diff(own))] }
            };
            weighted_middle([before, after, a, b, c, d, e, f].map(weighted))
        });
    });
}

/// Of keys the smallest value for which it and all smaller ones have at least half of the weight.
fn weighted_middle(mut keys: [u32; 8]) -> i16 {
    keys.sort_unstable();
    let total: u32 = keys.iter().map(|key| key & 0xffff).sum();
    let mut reached = 0;
    let enough = |&&key: &&u32| {
        reached += key & 0xffff;
        2 * reached >= total
    };
    keys.iter().find(enough).map_or(INVALID, |key| (key >> 16) as u16 as i16 ^ INVALID)
}

fn second_lowest(values: &[i16]) -> i16 {
    values.get(1).or(values.first()).copied().unwrap_or(INVALID)
}

/// The lower one of an even number.
fn median(values: &[i16]) -> i16 {
    values.get(values.len().saturating_sub(1) / 2).copied().unwrap_or(INVALID)
}
