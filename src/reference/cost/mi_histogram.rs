use crate::DisparityMap;
use crate::reference::Descriptors;

/// Stage `mi_histogram`: how often a left pixel of value l matches a right one of value r, `[l][r]`.
///
/// `map` is a map of the same pair at its size, or halved once (`halvings`), or there is none yet and all counts are 0. With
/// v = 2^halvings map(floor(x / 2^halvings), floor(y / 2^halvings)) and q = floor((v + 8) / 16), each left pixel (x, y)
/// counts for (left(x, y), right(x - q, y)), unless the map has no disparity there or x - q lies outside.
pub fn mi_histogram(left: &Descriptors, right: &Descriptors, map: Option<&DisparityMap>, halvings: u32) -> Vec<u32> {
    let mut counts = vec![0; 256 * 256];
    let Some(map) = map else { return counts };
    for y in 0..left.height {
        for x in 0..left.width {
            let value = map.data[(y >> halvings) * map.width as usize + (x >> halvings)];
            if value == DisparityMap::INVALID {
                continue;
            }
            let disparity = i32::from(value) << halvings;
            let seen = x as i64 - i64::from((disparity + 8) >> 4);
            if (0..left.width as i64).contains(&seen) {
                let (l, r) = (left.clamped(x as i64, y as i64)[0], right.clamped(seen, y as i64)[0]);
                counts[usize::from(l) * 256 + usize::from(r)] += 1;
            }
        }
    }
    counts
}
