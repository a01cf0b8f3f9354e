use crate::DisparityMap;
use crate::reference::{Plane, Values, neighbours};
use rayon::prelude::*;

/// Stage `disparity_regression`: the scores of one channel are interpolated trilinearly to `disparities` planes and this
/// number of rows and columns; of each pixel, the sum over its planes d of d exp(score d) / sum of exp(scores).
pub fn disparity_regression(scores: &Values, [disparities, rows, columns]: [usize; 3], align_corners: bool) -> Values {
    let [_, from_planes, from_rows, from_columns] = scores.shape;
    let mut output = Values::new([1, 1, rows, columns]);
    output.data.par_chunks_mut(columns).enumerate().for_each(|(y, to)| {
        let (above, below, down) = neighbours(y, from_rows, rows, align_corners);
        for (x, disparity) in to.iter_mut().enumerate() {
            let (left, right, across) = neighbours(x, from_columns, columns, align_corners);
            let plane = |plane: usize| {
                let row = |row: usize| {
                    let row = scores.row(0, plane, row);
                    (1.0 - across) * row[left] + across * row[right]
                };
                (1.0 - down) * row(above) + down * row(below)
            };
            let planes: Vec<f64> = (0..from_planes).map(plane).collect();
            let score = |d: usize| {
                let (nearer, farther, share) = neighbours(d, from_planes, disparities, align_corners);
                (1.0 - share) * planes[nearer] + share * planes[farther]
            };
            *disparity = mean_of_softmax(&(0..disparities).map(score).collect::<Vec<f64>>());
        }
    });
    output
}

/// The mean of the numbers of the scores, weighted by the exponentials of the scores.
fn mean_of_softmax(scores: &[f64]) -> f64 {
    let largest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mut weights, mut sum) = (0.0, 0.0);
    for (d, score) in scores.iter().enumerate() {
        let weight = (score - largest).exp();
        weights += weight;
        sum += weight * d as f64;
    }
    sum / weights
}

/// Stage `round_disparities`: the nearest sixteenth of a pixel, of two the larger, from 0 to the largest of `disparities`
/// whole pixels. With disparities p in f32 it is exactly floor(16 p + 1/2).
pub fn round_disparities(disparity: &Plane<f32>, disparities: usize) -> DisparityMap {
    let largest = 16.0 * (disparities - 1) as f64;
    let rounded = |&p: &f32| (16.0 * f64::from(p) + 0.5).floor().clamp(0.0, largest) as i16;
    let (width, height) = (disparity.width as u32, disparity.height as u32);
    DisparityMap { width, height, data: disparity.data.iter().map(rounded).collect() }
}
