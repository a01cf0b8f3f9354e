use crate::DisparityMap;

/// Stage `speckle`: regions of at most `window` pixels become invalid, as OpenCV's `filterSpeckles` does.
///
/// Two valid pixels beside or above each other are of one region if their values differ by at most 16 * `range`. A region
/// is all pixels that such steps lead to.
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
