use crate::reference::Values;

/// Between which two of `from` values the value `at` of `to` lies, and the share of the second one. With `align_corners` the
/// first and the last values of both lie on each other: at (from - 1) / (to - 1). Without it their outer ends do: at
/// (at + 1/2) from / to - 1/2, and what is before the first value is the first.
pub fn neighbours(at: usize, from: usize, to: usize, align_corners: bool) -> (usize, usize, f64) {
    let place = match align_corners {
        true if to > 1 => at as f64 * (from - 1) as f64 / (to - 1) as f64,
        true => 0.0,
        false => ((at as f64 + 0.5) * from as f64 / to as f64 - 0.5).max(0.0),
    };
    let first = (place as usize).min(from - 1);
    (first, (first + 1).min(from - 1), place - first as f64)
}

/// Stage `upsample`: bilinear interpolation to this number of rows and columns.
pub fn upsample(input: &Values, rows: usize, columns: usize, align_corners: bool) -> Values {
    let [channels, _, from_rows, from_columns] = input.shape;
    let mut output = Values::new([channels, 1, rows, columns]);
    for (i, value) in output.data.iter_mut().enumerate() {
        let (channel, y, x) = (i / columns / rows, i / columns % rows, i % columns);
        let (above, below, down) = neighbours(y, from_rows, rows, align_corners);
        let (left, right, across) = neighbours(x, from_columns, columns, align_corners);
        let row = |row: usize| {
            let row = input.row(channel, 0, row);
            (1.0 - across) * row[left] + across * row[right]
        };
        *value = (1.0 - down) * row(above) + down * row(below);
    }
    output
}
