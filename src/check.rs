//! What a check reports: how far a schedule agrees with the reference.

/// The first element of a stage that differs from the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Mismatch {
    /// Column; of a gray, a prefiltered or a rectified image the byte of its row, of column sums the column plus the block's radius,
    /// of statistics of blocks their place in a row.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Index of the disparity, for stages that have one value for each.
    pub d: Option<u32>,
    /// The value of the reference; of the stages of a network in millionths.
    pub expected: i64,
    /// The value of the schedule that is checked, in the same unit.
    pub got: i64,
}

/// The result of the comparison of one stage.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StageCheck {
    /// The stage's name, as in docs/ALGORITHMS.md.
    pub stage: String,
    /// Elements compared.
    pub elements: u64,
    /// Elements that differ.
    pub mismatches: u64,
    /// The first of them in order of computation.
    pub first: Option<Mismatch>,
}

impl StageCheck {
    /// Compares one element of a stage that computes with floats.
    pub(crate) fn compare_close(&mut self, [x, y, d]: [usize; 3], expected: f64, got: f64, tolerance: f64) {
        self.elements += 1;
        if (expected - got).abs() <= tolerance {
            return;
        }
        // Not a number is far from all.
        self.mismatches += 1;
        let millionths = |value: f64| (1e6 * value).round() as i64;
        let (expected, got) = (millionths(expected), millionths(got));
        self.first.get_or_insert(Mismatch { x: x as u32, y: y as u32, d: Some(d as u32), expected, got });
    }

    /// Compares one element.
    pub(crate) fn compare(&mut self, x: usize, y: usize, d: Option<usize>, expected: i64, got: i64) {
        self.elements += 1;
        if expected != got {
            self.mismatches += 1;
            self.first.get_or_insert(Mismatch { x: x as u32, y: y as u32, d: d.map(|d| d as u32), expected, got });
        }
    }
}
