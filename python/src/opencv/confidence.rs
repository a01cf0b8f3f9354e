//! How sure a pair of maps is of each left pixel, as ximgproc's `DisparityWLSFilter` has it: the smaller of two smoothnesses where
//! the left and the right map agree, else 0.

/// What of a map counts: `x`, `y`, `width`, `height`, inside the map.
#[derive(Clone, Copy)]
pub struct Rectangle {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

/// The settings of the filter that the confidence depends on.
pub struct Agreement {
    /// In 1/16 px: what disparities that agree differ by less than.
    pub threshold: i32,
    /// The radius of the window whose variance is taken.
    pub radius: usize,
    /// By how much a variance of 1 lowers the smoothness.
    pub roll_off: f32,
}

/// The index of a pixel beyond the border, mirrored about the outermost one.
fn mirrored(at: isize, length: usize) -> usize {
    if length == 1 {
        return 0;
    }
    let period = 2 * (length as isize - 1);
    let at = at.rem_euclid(period);
    (if at < length as isize { at } else { period - at }) as usize
}

/// 1 less the variance around each pixel of the part of a map, times `roll_off`, at least 0.
fn smoothness(map: &[i16], width: usize, part: Rectangle, agreement: &Agreement) -> Vec<f32> {
    let reach = agreement.radius as isize;
    let side = 2 * agreement.radius + 1;
    let share = 1.0 / (side * side) as f64;
    // Sums over the rows of a window, then over its columns.
    let mut vertical = vec![(0_i64, 0_i64); part.width * part.height];
    for x in 0..part.width {
        let value = |y: isize| i64::from(map[(part.y + mirrored(y, part.height)) * width + part.x + x]);
        let mut sums = (0, 0);
        for y in -reach..=reach {
            sums = (sums.0 + value(y), sums.1 + value(y) * value(y));
        }
        for y in 0..part.height {
            vertical[y * part.width + x] = sums;
            let (enters, leaves) = (value(y as isize + reach + 1), value(y as isize - reach));
            sums = (sums.0 + enters - leaves, sums.1 + enters * enters - leaves * leaves);
        }
    }
    let mut out = Vec::with_capacity(vertical.len());
    for row in vertical.chunks_exact(part.width) {
        let value = |x: isize| row[mirrored(x, part.width)];
        let mut sums = (0, 0);
        for x in -reach..=reach {
            sums = (sums.0 + value(x).0, sums.1 + value(x).1);
        }
        for x in 0..part.width as isize {
            let mean = (sums.0 as f64 * share) as f32;
            let square = (sums.1 as f64 * share) as f32;
            out.push((1.0 - agreement.roll_off * (square - mean * mean)).max(0.0));
            let (enters, leaves) = (value(x + reach + 1), value(x - reach));
            sums = (sums.0 + enters.0 - leaves.0, sums.1 + enters.1 - leaves.1);
        }
    }
    out
}

/// The confidence of each pixel of the left map, 0 to 255; 0 outside of `part`. The right map has negative disparities.
pub fn confidence(left: &[i16], right: &[i16], width: usize, part: Rectangle, agreement: &Agreement) -> Vec<f32> {
    let right_part = Rectangle { x: width - (part.x + part.width), ..part };
    let left_smoothness = smoothness(left, width, part, agreement);
    let right_smoothness = smoothness(right, width, right_part, agreement);
    let mut out = vec![0.0; left.len()];
    for y in 0..part.height {
        let row = (part.y + y) * width;
        for x in 0..part.width {
            let disparity = i32::from(left[row + part.x + x]);
            let own = left_smoothness[y * part.width + x];
            let column = (part.x + x) as isize - (disparity >> 4) as isize - right_part.x as isize;
            // What leads out of the right map's part keeps its own smoothness: there is nothing to check it against.
            let confidence = match usize::try_from(column).ok().filter(|&column| column < right_part.width) {
                None => own,
                Some(column) => {
                    let other = i32::from(right[row + right_part.x + column]);
                    let agrees = (disparity + other).abs() < agreement.threshold;
                    if agrees { own.min(right_smoothness[y * part.width + column]) } else { 0.0 }
                }
            };
            out[row + part.x + x] = 255.0 * confidence;
        }
    }
    out
}
