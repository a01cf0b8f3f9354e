//! From scores to disparities, without the volume at full size.

use super::activation::Activation;
use super::images::between;
use crate::reference::neighbours;
use rayon::prelude::*;

/// Stage `disparity_regression`.
pub(super) fn disparity_regression(scores: &Activation, disparities: usize, align_corners: bool) -> Activation {
    let [_, planes, from_rows, from_columns] = scores.shape;
    let (rows, columns) = (4 * from_rows, 4 * from_columns);
    let mut made = Activation::new([1, 1, rows, columns]);
    let across: Vec<_> = (0..columns).map(|x| neighbours(x, from_columns, columns, align_corners)).collect();
    let along: Vec<_> = (0..disparities).map(|d| neighbours(d, planes, disparities, align_corners)).collect();
    let along: Vec<_> = along.into_iter().map(|(nearer, farther, share)| (nearer, farther, share as f32)).collect();
    made.data.par_chunks_mut(columns).enumerate().for_each(|(y, to)| {
        let (above, below, down) = neighbours(y, from_rows, rows, align_corners);
        // Interpolated between rows: the planes of a column lie together.
        let mut line = vec![0.0; from_columns * planes];
        for plane in 0..planes {
            let [above, below] = [above, below].map(|row| scores.row(0, plane, row));
            for (x, (above, below)) in above.iter().zip(below).enumerate() {
                line[x * planes + plane] = between(*above, *below, down as f32);
            }
        }
        let mut column = vec![0.0; planes];
        for (to, &(left, right, share)) in to.iter_mut().zip(&across) {
            let [left, right] = [left, right].map(|x| &line[x * planes..][..planes]);
            for (score, (left, right)) in column.iter_mut().zip(left.iter().zip(right)) {
                *score = between(*left, *right, share as f32);
            }
            *to = mean_of_softmax(&column, &along);
        }
    });
    made
}

/// The mean of the disparities, weighted by the exponentials of their scores, which lie between those of planes.
fn mean_of_softmax(planes: &[f32], along: &[(usize, usize, f32)]) -> f32 {
    let largest = planes.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let (mut weights, mut sum) = (0.0, 0.0);
    for (d, &(nearer, farther, share)) in along.iter().enumerate() {
        let weight = f64::from((between(planes[nearer], planes[farther], share) - largest).exp());
        weights += weight;
        sum += weight * d as f64;
    }
    (sum / weights) as f32
}
