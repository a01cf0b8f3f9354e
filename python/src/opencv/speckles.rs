//! Small regions of a map, as OpenCV's `filterSpeckles` finds them.

/// A map in rows, with the numbers that say what a region is.
pub struct Regions {
    pub width: usize,
    /// What a pixel without a disparity has, and what a pixel of a small region gets.
    pub invalid: i32,
    /// Regions of at most so many pixels are small.
    pub largest: i64,
    /// Neighbours are of one region if they differ by at most this much.
    pub difference: i32,
}

/// Sets the pixels of all small regions of `map` to `replacement`, which is `invalid` as the map holds it. A pixel joins those
/// beside, above and below it whose values are near its own; no pixel of the value `invalid` is of a region.
pub fn remove<T: Copy + Into<i32>>(map: &mut [T], replacement: T, regions: &Regions) {
    let width = regions.width;
    let given: Vec<i32> = map.iter().map(|&value| value.into()).collect();
    let mut seen = vec![false; given.len()];
    let mut region = Vec::new();
    for start in 0..given.len() {
        if seen[start] || given[start] == regions.invalid {
            continue;
        }
        seen[start] = true;
        region.clear();
        region.push(start);
        let mut next = 0;
        while next < region.len() {
            let at = region[next];
            next += 1;
            let column = at % width;
            let neighbours = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then(|| at + 1),
                at.checked_sub(width),
                (at + width < given.len()).then(|| at + width),
            ];
            for other in neighbours.into_iter().flatten() {
                let near = given[other].abs_diff(given[at]) as i64 <= regions.difference as i64;
                if !seen[other] && given[other] != regions.invalid && near {
                    seen[other] = true;
                    region.push(other);
                }
            }
        }
        if region.len() as i64 <= regions.largest {
            for &at in &region {
                map[at] = replacement;
            }
        }
    }
}
