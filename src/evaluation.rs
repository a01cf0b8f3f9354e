//! A disparity map against the truth, by the definitions of the Middlebury and KITTI benchmarks. docs/EVALUATION.md has
//! the formulas in one place.
//!
//! A pixel counts if its truth is known and the mask, if there is one, contains it. Of these pixels, with the error
//! `e = |estimate - truth|` in px, computed in 64 bits:
//!
//! - **density**: the share that has an estimate. The others are called invalid.
//! - **bad-t** for t of [`BAD_THRESHOLDS`]: the share that is invalid or has `e > t`
//!   ([Middlebury SDK v3](https://vision.middlebury.edu/stereo/submit3/), evaldisp: "totbad"); and over valid pixels only.
//! - **average**, **RMS** error: the mean of `e`, the root of the mean of `e²`, over valid pixels (evaldisp: "avgErr").
//! - **A50, A90, A95, A99**: of the n errors of valid pixels in ascending order the one at ⌊n q⌋, counted from 0, with q = 0.50
//!   to 0.99 ([ETH3D's evaluation](https://github.com/ETH3D/two-view-evaluation), which computes Middlebury's columns; evaldisp has
//!   no quantiles).
//! - **D1**: the share with `e > 3` and `e > |truth| / 20`: **est** of the valid pixels, **all** of all pixels after
//!   [`interpolate_background`] ([KITTI 2015](https://www.cvlibs.net/datasets/kitti/eval_scene_flow.php?benchmark=stereo)
//!   development kit). A pixel that is empty even then counts as -1 px, as it does there.
//!
//! evaldisp clips estimates to the range that a method was given. A map whose estimates lie in that range is not changed by it;
//! here nothing is clipped. KITTI's kit treats a negative disparity as invalid; here it is a disparity.
//!
//! ```
//! use gpu_stereo::evaluation::{FloatMap, evaluate};
//!
//! let estimate = FloatMap::new(3, 1, vec![10.0, f32::NAN, 31.0])?;
//! let truth = FloatMap::new(3, 1, vec![10.5, 12.0, 20.0])?;
//! let scores = evaluate(&estimate, &truth, None)?;
//! assert_eq!((scores.pixels, scores.valid), (3, 2));
//! assert_eq!(scores.bad_of_valid(2), Some(0.5)); // of two errors, 0.5 and 11 px, one exceeds 2 px
//! assert_eq!(scores.d1_all(), 1.0 / 3.0); // the hole becomes 10 px, which is 2 px off
//! # Ok::<(), gpu_stereo::Error>(())
//! ```

use crate::{DisparityMap, Error};

/// Thresholds of bad-t, in px.
pub const BAD_THRESHOLDS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Quantiles of the error, in hundredths.
pub const QUANTILES: [u64; 4] = [50, 90, 95, 99];

/// The classes of [`error_picture`]: an error belongs to the last one whose number it reaches. It counts in units of what
/// D1 allows, `min(e / 3, e / (|truth| / 20))`, so the classes from 1 on are what D1 counts, but for exactly 1. From
/// KITTI's development kit (log_colormap.h).
pub const ERROR_CLASSES: [(f64, [u8; 3]); 10] = [
    (0.0, [49, 54, 149]),
    (0.0625, [69, 117, 180]),
    (0.125, [116, 173, 209]),
    (0.25, [171, 217, 233]),
    (0.5, [224, 243, 248]),
    (1.0, [254, 224, 144]),
    (2.0, [253, 174, 97]),
    (4.0, [244, 109, 67]),
    (8.0, [215, 48, 39]),
    (16.0, [165, 0, 38]),
];

/// Disparities in px, row by row from the top. What is not finite is no disparity.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatMap {
    width: u32,
    height: u32,
    data: Vec<f32>,
}

impl FloatMap {
    /// A map of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`Error::Image`] if a side is 0, or the values are not `width * height`.
    pub fn new(width: u32, height: u32, data: Vec<f32>) -> Result<Self, Error> {
        if width == 0 || height == 0 || data.len() as u128 != u128::from(width) * u128::from(height) {
            return Err(Error::Image(format!(
                "a map of {width}x{height} has {} values; both sides must be at least 1, with one value per pixel",
                data.len()
            )));
        }
        Ok(Self { width, height, data })
    }

    /// Pixels a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The values, row by row from the top.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    fn rows(&self) -> std::slice::ChunksExact<'_, f32> {
        self.data.chunks_exact(self.width as usize)
    }
}

impl From<&DisparityMap> for FloatMap {
    /// NaN where the map is invalid.
    fn from(map: &DisparityMap) -> Self {
        let pixels = |&value: &i16| if value == DisparityMap::INVALID { f32::NAN } else { f32::from(value) / 16.0 };
        Self { width: map.width, height: map.height, data: map.data.iter().map(pixels).collect() }
    }
}

/// What [`evaluate`] finds: counts and sums, so that those of several maps can be added.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Scores {
    /// Pixels whose truth is known and that the mask has.
    pub pixels: u64,
    /// Of these, pixels with an estimate.
    pub valid: u64,
    /// Of the valid, pixels with an error above each of [`BAD_THRESHOLDS`].
    pub bad: [u64; 4],
    /// Of the valid, pixels that D1 counts.
    pub d1_est: u64,
    /// Of all, pixels that D1 counts after [`interpolate_background`].
    pub d1_all: u64,
    /// The sum of the errors of valid pixels, in px.
    pub error_sum: f64,
    /// The sum of their squares.
    pub squared_sum: f64,
    /// The errors at [`QUANTILES`], in px; `None` where nothing is valid.
    pub quantiles: Option<[f64; 4]>,
}

impl Scores {
    /// The share of pixels that have an estimate.
    pub fn density(&self) -> f64 {
        self.valid as f64 / self.pixels as f64
    }

    /// The share that is invalid or off by more than the `threshold`-th of [`BAD_THRESHOLDS`].
    ///
    /// # Panics
    /// If `threshold` is above 3.
    pub fn bad(&self, threshold: usize) -> f64 {
        (self.bad[threshold] + self.pixels - self.valid) as f64 / self.pixels as f64
    }

    /// Of the valid pixels, the share that is off by more than the `threshold`-th of [`BAD_THRESHOLDS`]; `None` where
    /// nothing is valid.
    ///
    /// # Panics
    /// If `threshold` is above 3.
    pub fn bad_of_valid(&self, threshold: usize) -> Option<f64> {
        self.of_valid(self.bad[threshold] as f64)
    }

    /// The mean error of valid pixels, in px.
    pub fn average(&self) -> Option<f64> {
        self.of_valid(self.error_sum)
    }

    /// The root of the mean squared error of valid pixels, in px.
    pub fn rms(&self) -> Option<f64> {
        self.of_valid(self.squared_sum).map(f64::sqrt)
    }

    /// D1-est: the share of valid pixels that are off by more than 3 px and 5 %.
    pub fn d1_est(&self) -> Option<f64> {
        self.of_valid(self.d1_est as f64)
    }

    /// D1-all: the same of all pixels, after [`interpolate_background`].
    pub fn d1_all(&self) -> f64 {
        self.d1_all as f64 / self.pixels as f64
    }

    /// Adds the pixels of another map; the quantiles of both together are not known.
    pub fn add(&mut self, other: &Scores) {
        self.pixels += other.pixels;
        self.valid += other.valid;
        for (sum, count) in self.bad.iter_mut().zip(other.bad) {
            *sum += count;
        }
        self.d1_est += other.d1_est;
        self.d1_all += other.d1_all;
        self.error_sum += other.error_sum;
        self.squared_sum += other.squared_sum;
        self.quantiles = None;
    }

    fn of_valid(&self, sum: f64) -> Option<f64> {
        (self.valid > 0).then(|| sum / self.valid as f64)
    }
}

/// Scores an estimate. `mask`: which pixels count, row by row; all without one.
///
/// # Errors
/// [`Error::Image`] if the sizes differ, or no pixel counts.
pub fn evaluate(estimate: &FloatMap, truth: &FloatMap, mask: Option<&[bool]>) -> Result<Scores, Error> {
    check_sizes(estimate, truth, mask)?;
    let filled = interpolate_background(estimate);
    let mut scores = Scores::default();
    let mut errors = Vec::new();
    for (i, &true_value) in truth.data.iter().enumerate() {
        if !true_value.is_finite() || mask.is_some_and(|mask| !mask[i]) {
            continue;
        }
        scores.pixels += 1;
        scores.d1_all += u64::from(is_d1(error(filled.data[i], true_value), true_value));
        if !estimate.data[i].is_finite() {
            continue;
        }
        let e = error(estimate.data[i], true_value);
        scores.valid += 1;
        for (count, threshold) in scores.bad.iter_mut().zip(BAD_THRESHOLDS) {
            *count += u64::from(e > threshold);
        }
        scores.d1_est += u64::from(is_d1(e, true_value));
        scores.error_sum += e;
        scores.squared_sum += e * e;
        errors.push(e);
    }
    if scores.pixels == 0 {
        return Err(Error::Image(format!(
            "the truth has no known pixel{}; give another truth{}",
            if mask.is_some() { " within the mask" } else { "" },
            if mask.is_some() { " or mask" } else { "" },
        )));
    }
    if !errors.is_empty() {
        errors.sort_unstable_by(f64::total_cmp);
        scores.quantiles = Some(QUANTILES.map(|hundredths| errors[(scores.valid * hundredths / 100) as usize]));
    }
    Ok(scores)
}

fn check_sizes(estimate: &FloatMap, truth: &FloatMap, mask: Option<&[bool]>) -> Result<(), Error> {
    if (estimate.width, estimate.height) != (truth.width, truth.height) {
        return Err(Error::Image(format!(
            "the estimate is {}x{}, but the truth is {}x{}; both must be of one size",
            estimate.width, estimate.height, truth.width, truth.height
        )));
    }
    for (name, map) in [("estimate", estimate), ("truth", truth)] {
        if map.data.len() as u128 != u128::from(map.width) * u128::from(map.height) {
            return Err(Error::Image(format!(
                "the {name} is {}x{}, but has {} values; give a map with one value per pixel",
                map.width,
                map.height,
                map.data.len()
            )));
        }
    }
    match mask {
        Some(mask) if mask.len() != truth.data.len() => Err(Error::Image(format!(
            "the mask has {} pixels, but the truth is {}x{}; both must be of one size",
            mask.len(),
            truth.width,
            truth.height
        ))),
        _ => Ok(()),
    }
}

/// In px. What is still empty after the interpolation counts as -1 px.
fn error(estimate: f32, truth: f32) -> f64 {
    let estimate = if estimate.is_finite() { f64::from(estimate) } else { -1.0 };
    (estimate - f64::from(truth)).abs()
}

fn is_d1(error: f64, truth: f32) -> bool {
    error > 3.0 && 20.0 * error > f64::from(truth).abs()
}

/// Fills what is empty as KITTI's development kit does. A gap within a row is filled with the smaller of the two values
/// next to it, a gap at its end with the one value next to it. Then empty rows above the first row with values are copies of
/// that row, those below the last one copies of the last; empty rows between two others stay empty (NaN).
pub fn interpolate_background(map: &FloatMap) -> FloatMap {
    let width = map.width as usize;
    let mut filled = map.clone();
    let (mut first, mut last) = (None, None);
    for (y, row) in filled.data.chunks_exact_mut(width).enumerate() {
        if !fill_row(row) {
            row.fill(f32::NAN);
            continue;
        }
        first = first.or(Some(y));
        last = Some(y);
    }
    if let (Some(first), Some(last)) = (first, last) {
        for y in 0..first {
            filled.data.copy_within(first * width..(first + 1) * width, y * width);
        }
        for y in last + 1..map.height as usize {
            filled.data.copy_within(last * width..(last + 1) * width, y * width);
        }
    }
    filled
}

/// Returns whether there was a value to fill with.
fn fill_row(row: &mut [f32]) -> bool {
    let mut before: Option<usize> = None;
    for x in 0..row.len() {
        if !row[x].is_finite() {
            continue;
        }
        let value = before.map_or(row[x], |before| row[before].min(row[x]));
        row[before.map_or(0, |before| before + 1)..x].fill(value);
        before = Some(x);
    }
    if let Some(before) = before {
        let value = row[before];
        row[before + 1..].fill(value);
    }
    before.is_some()
}

/// A picture of the errors after [`interpolate_background`] in the colours of [`ERROR_CLASSES`], red, green and blue, row by row;
/// half as bright where the mask has no pixel; black where no truth is known near. So that a sparse truth can be seen, a
/// pixel whose truth is unknown takes the colour of a neighbour, as in KITTI's development kit (errorImage) the one that
/// comes last in the order of rows and columns.
///
/// # Errors
/// [`Error::Image`] if the sizes differ.
pub fn error_picture(estimate: &FloatMap, truth: &FloatMap, mask: Option<&[bool]>) -> Result<Vec<[u8; 3]>, Error> {
    check_sizes(estimate, truth, mask)?;
    let filled = interpolate_background(estimate);
    let color = |i: usize| {
        let true_value = truth.data[i];
        let e = error(filled.data[i], true_value);
        let allowed = (e / 3.0).min(20.0 * e / f64::from(true_value).abs()); // min passes over 0 / 0
        let class = ERROR_CLASSES.iter().rev().find(|(least, _)| allowed >= *least).unwrap_or(&ERROR_CLASSES[0]);
        match mask {
            Some(mask) if !mask[i] => class.1.map(|channel| channel / 2),
            _ => class.1,
        }
    };
    const NEAR: [(isize, isize); 9] = [(0, 0), (1, 1), (0, 1), (-1, 1), (1, 0), (-1, 0), (1, -1), (0, -1), (-1, -1)];
    let rows: Vec<&[f32]> = truth.rows().collect();
    let width = truth.width as usize;
    let near = |x: usize, y: usize, (dx, dy): (isize, isize)| {
        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        rows.get(y)?.get(x)?.is_finite().then_some(y * width + x)
    };
    let pixel = |i: usize| NEAR.iter().find_map(|&by| near(i % width, i / width, by)).map_or([0; 3], color);
    Ok((0..truth.data.len()).map(pixel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f32 = f32::NAN;

    fn map(width: u32, data: &[f32]) -> FloatMap {
        FloatMap::new(width, data.len() as u32 / width, data.into()).unwrap()
    }

    #[test]
    fn gaps_take_the_smaller_neighbour_and_rows_the_nearest_end() {
        let rows = [
            [NONE, NONE, NONE, NONE, NONE],
            [NONE, 5.0, NONE, NONE, 3.0],
            [f32::INFINITY, NONE, f32::NEG_INFINITY, NONE, NONE],
            [2.0, NONE, 7.0, NONE, NONE],
            [NONE, NONE, NONE, NONE, NONE],
        ];
        let filled = interpolate_background(&map(5, &rows.concat()));
        let expected = [
            [5.0, 5.0, 3.0, 3.0, 3.0],
            [5.0, 5.0, 3.0, 3.0, 3.0],
            [NONE; 5], // between rows with values, as in the development kit
            [2.0, 2.0, 7.0, 7.0, 7.0],
            [2.0, 2.0, 7.0, 7.0, 7.0],
        ];
        let bits = |data: &[f32]| data.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(filled.data()), bits(&expected.concat()));
        assert!(interpolate_background(&map(1, &[NONE])).data()[0].is_nan());
    }

    #[test]
    fn thresholds_are_exclusive() {
        let truth = map(8, &[80.0, 80.0, 10.0, 10.0, 10.0, 10.0, 10.0, 0.0]);
        let estimate = map(8, &[84.0, 84.0625, 13.0, 13.0625, 10.5, 12.0, NONE, 0.0]);
        let scores = evaluate(&estimate, &truth, None).unwrap();
        assert_eq!((scores.pixels, scores.valid), (8, 7));
        assert_eq!(scores.bad, [5, 5, 4, 1]); // 4 is not above 4, 2 not above 2, 0.5 not above 0.5
        assert_eq!(scores.d1_est, 2); // 4 of 80 px is not above 5 %; 3 px are not above 3 px
        assert_eq!(scores.d1_all, 3); // and the hole between 12 and 0 becomes 0, 10 px off
        assert_eq!(scores.bad(3), 2.0 / 8.0);
    }

    #[test]
    fn what_stays_empty_counts_as_minus_one() {
        let scores = evaluate(&map(2, &[NONE, NONE]), &map(2, &[2.0, 2.5]), None).unwrap();
        assert_eq!((scores.valid, scores.d1_all), (0, 1));
        assert_eq!((scores.d1_est(), scores.average(), scores.quantiles), (None, None, None));
        assert_eq!(scores.bad(0), 1.0);
    }

    #[test]
    fn quantiles_are_errors_that_occur() {
        let estimate: Vec<f32> = (0..200).map(|v| v as f32).collect();
        let scores = evaluate(&map(200, &estimate), &map(200, &[0.0; 200]), None).unwrap();
        assert_eq!(scores.quantiles, Some([100.0, 180.0, 190.0, 198.0]));
        let one = evaluate(&map(1, &[3.0]), &map(1, &[1.0]), None).unwrap();
        assert_eq!(one.quantiles, Some([2.0; 4]));
    }

    #[test]
    fn a_mask_takes_pixels_out() {
        let (estimate, truth) = (map(3, &[1.0, 2.0, 9.0]), map(3, &[1.0, NONE, 1.0]));
        let scores = evaluate(&estimate, &truth, Some(&[true, true, false])).unwrap();
        assert_eq!((scores.pixels, scores.bad), (1, [0; 4]));
        let error = evaluate(&estimate, &truth, Some(&[false, true, false])).unwrap_err().to_string();
        assert!(error.contains("no known pixel within the mask"), "{error}");
        assert!(evaluate(&estimate, &truth, Some(&[true])).unwrap_err().to_string().contains("1 pixels"));
        assert!(evaluate(&map(1, &[1.0]), &truth, None).unwrap_err().to_string().contains("1x1"));
        // The fields of a DisparityMap are the caller's.
        let broken = FloatMap::from(&DisparityMap { width: 3, height: 1, data: vec![16] });
        for pair in [[&broken, &truth], [&truth, &broken]] {
            let error = evaluate(pair[0], pair[1], None).unwrap_err().to_string();
            assert!(error.contains("3x1, but has 1 values"), "{error}");
            assert!(error_picture(pair[0], pair[1], None).is_err());
        }
        assert!(FloatMap::new(2, 2, vec![0.0; 3]).is_err() && FloatMap::new(0, 2, vec![]).is_err());
    }

    #[test]
    fn errors_have_kittis_colors() {
        let colors = |estimate: &[f32], truth: &[f32], mask: Option<&[bool]>| {
            error_picture(&map(estimate.len() as u32, estimate), &map(truth.len() as u32, truth), mask).unwrap()
        };
        // Below 60 px of truth 3 px are allowed, above it 5 %.
        let estimates: Vec<f32> = [0.0, 0.1875, 0.375, 0.75, 1.5, 3.0, 6.0, 12.0, 24.0, 48.0].map(|e| 40.0 + e).into();
        let classes: Vec<_> = ERROR_CLASSES.iter().map(|class| class.1).collect();
        assert_eq!(colors(&estimates, &[40.0; 10], None), classes);
        assert_eq!(colors(&[125.0], &[120.0], None), [[224, 243, 248]]); // 5 of 6 px
        assert_eq!(colors(&[0.0], &[0.0], None), [[49, 54, 149]]);
        // Unknown: the neighbour's colour, or black. Outside the mask: half as bright.
        let (estimate, truth) = ([1.0; 5], [1.0, NONE, 5.0, NONE, NONE]);
        let (good, off) = ([49, 54, 149], [254, 224, 144]);
        assert_eq!(colors(&estimate, &truth, None), [good, off, off, off, [0; 3]]);
        let half = colors(&estimate, &truth, Some(&[false, true, true, true, true]));
        assert_eq!(half[0], [24, 27, 74]);
    }
}
