//! Stage `prefilter`.

use bytemuck::Pod;

use crate::cpu::images::derivatives::{Depth, derivatives, derivatives_between};
use crate::cpu::images::padded::{MARGIN, Padded};
use crate::cpu::instructions::Instructions;
use crate::{Params, Prefilter};

/// An image after a prefilter that is not `none`.
pub fn filtered<T: Depth>(image: &Padded<T>, params: &Params, instructions: Instructions) -> Padded<u8> {
    let cap = params.prefilter_cap as i16;
    Padded::from_rows(image.width, image.height, |y, row| {
        let y = y as i64;
        instructions.run(
            #[inline(always)]
            || match params.prefilter {
                Prefilter::XSobel if params.opencv_rules => stereo_bm_sobel(image, y, cap, row),
                Prefilter::XSobel | Prefilter::None => {
                    derivatives(image, y, row, |gx, _| (gx.clamp(-cap, cap) + cap) as u8);
                }
                // Both are at most 1020. So the sum is exact in f32, and its root is rounded down from the right number.
                Prefilter::Sobel => derivatives(image, y, row, |gx, gy| {
                    let (gx, gy) = (i32::from(gx), i32::from(gy));
                    (((gx * gx + gy * gy) as f32).sqrt() as i32).min(2 * i32::from(cap)) as u8
                }),
                Prefilter::Normalized => normalized(image, y, params, row),
            },
        );
    })
}

/// `xsobel` with the border of OpenCV's StereoBM.
#[inline(always)]
fn stereo_bm_sobel<T: Depth>(image: &Padded<T>, y: i64, cap: i16, row: &mut [u8]) {
    let (right, bottom) = (image.width - 1, image.height as i64 - 1);
    let rows = [(y - 1).abs(), y, bottom - (bottom - y - 1).abs()];
    derivatives_between(image, rows, row, |gx, _| (gx.clamp(-cap, cap) + cap) as u8);
    (row[0], row[right]) = (cap as u8, cap as u8);
    if y == bottom && bottom % 2 == 0 {
        row.fill(cap as u8);
    }
}

fn normalized<T: Depth>(image: &Padded<T>, y: i64, params: &Params, row: &mut [u8]) {
    let (window, cap) = (params.prefilter_window as usize, params.prefilter_cap as i32);
    let n = (window * window) as i32;
    let [eighth, scale] = params.normalized_scales().map(|factor| factor as i32);
    let mut sums = vec![0; image.width];
    window_sums(image, window, y, &mut sums);
    let at = |dx: i64, dy: i64| image.row(y + dy, dx);
    let five = [at(0, 0), at(-1, 0), at(1, 0), at(0, -1), at(0, 1)];
    for (x, (value, sum)) in row.iter_mut().zip(sums).enumerate() {
        let [centre, left, right, above, below]: [i32; 5] = five.map(|row| row[x].into());
        let smoothed = 4 * centre + left + right + above + below;
        let response = match params.opencv_rules {
            true => ((eighth * smoothed - sum) * scale).div_euclid(1024 * T::UNIT),
            false => (n * smoothed - 8 * sum).div_euclid(2 * n * T::UNIT),
        };
        *value = (response.clamp(-cap, cap) + cap) as u8;
    }
}

/// The sums over windows around the pixels of a row.
pub fn window_sums<T: Pod + Into<i32> + Send + Sync>(image: &Padded<T>, window: usize, y: i64, sums: &mut [i32]) {
    let radius = (window / 2) as i64;
    let mut columns = vec![0; image.width + 2 * MARGIN];
    for y in y - radius..=y + radius {
        for (column, &value) in columns.iter_mut().zip(image.whole_row(y)) {
            *column += value.into();
        }
    }
    let first = MARGIN - radius as usize;
    let mut sum: i32 = columns[first..first + window - 1].iter().sum();
    for (x, out) in sums.iter_mut().enumerate() {
        sum += columns[first + window - 1 + x];
        *out = sum;
        sum -= columns[first + x];
    }
}
