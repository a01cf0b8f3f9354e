use crate::DisparityMap;

/// Stage `speckle`: regions of at most `window` pixels become invalid, as OpenCV's `filterSpeckles` does.
///
/// Two valid pixels that are neighbours in a row or a column belong to one region if their values differ by at most
/// 16 * `range`. A region is a pixel and all pixels that chains of such neighbours lead to.
///
/// The border has no neighbours outside, and a row does not continue in the next one: the last pixel of row 0 and the first
/// of row 1 are two regions of one pixel each, and the two upper pixels on the left are one of two:
///
/// ```
/// use gpu_stereo::{DisparityMap, reference};
/// const NONE: i16 = DisparityMap::INVALID;
/// let map = DisparityMap { width: 4, height: 2, data: vec![16, 32, NONE, 64, 64, NONE, NONE, NONE] };
/// assert_eq!(reference::speckle(&map, 1, 1).data, [16, 32, NONE, NONE, NONE, NONE, NONE, NONE]);
/// ```
pub fn speckle(map: &DisparityMap, window: u32, range: u32) -> DisparityMap {
    let (width, height) = (map.width as usize, map.height as usize);
    let mut filtered = map.clone();
    let mut seen: Vec<bool> = map.data.iter().map(|&value| value == DisparityMap::INVALID).collect();
    for first in 0..map.data.len() {
        if seen[first] {
            continue;
        }
        seen[first] = true;
        let mut region = vec![first];
        let mut next = 0;
        while let Some(&at) = region.get(next) {
            next += 1;
            let (x, y) = (at % width, at / width);
            let neighbours = [
                (x > 0).then(|| at - 1),
                (x + 1 < width).then(|| at + 1),
                (y > 0).then(|| at - width),
                (y + 1 < height).then(|| at + width),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                let step = i32::from(map.data[neighbour]).abs_diff(i32::from(map.data[at]));
                if !seen[neighbour] && step <= 16 * range {
                    seen[neighbour] = true;
                    region.push(neighbour);
                }
            }
        }
        if region.len() as u64 <= u64::from(window) {
            for at in region {
                filtered.data[at] = DisparityMap::INVALID;
            }
        }
    }
    filtered
}
