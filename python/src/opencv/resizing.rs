//! Maps of another size, as OpenCV's `resize` interpolates them linearly.

/// For each of `to` columns the two of `from` columns that it lies between, and how much of the second it takes.
fn between(from: usize, to: usize) -> Vec<(usize, usize, f32)> {
    let step = from as f64 / to as f64;
    (0..to)
        .map(|at| {
            let place = ((at as f64 + 0.5) * step - 0.5) as f32;
            let first = place.floor();
            if first < 0.0 {
                (0, 0, 0.0)
            } else if first as usize >= from - 1 {
                (from - 1, from - 1, 0.0)
            } else {
                (first as usize, first as usize + 1, place - first)
            }
        })
        .collect()
}

/// A map of `width` columns, resized to `size`: width and height.
pub fn resized(map: &[f32], width: usize, size: (usize, usize)) -> Vec<f32> {
    let columns = between(width, size.0);
    let rows = between(map.len() / width, size.1);
    let mut out = Vec::with_capacity(size.0 * size.1);
    for (above, below, down) in rows {
        let [above, below] = [above, below].map(|row| &map[row * width..][..width]);
        for &(left, right, along) in &columns {
            let [above, below] = [above, below].map(|row| row[left] * (1.0 - along) + row[right] * along);
            out.push(above * (1.0 - down) + below * down);
        }
    }
    out
}
