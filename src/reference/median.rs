use super::points_inside;
use crate::DisparityMap;

/// Stage `median`: the fifth of the 3x3 values around a pixel in ascending order, the map continued by its border.
///
/// An invalid value is smaller than every valid one. So a hole among five or more valid pixels is filled, and a pixel
/// among five or more invalid ones is removed. A result that does not point into the right image is invalid.
pub fn median(map: &DisparityMap) -> DisparityMap {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let mut data = Vec::with_capacity(map.data.len());
    for y in 0..height {
        for x in 0..width {
            let mut window = [0; 9];
            for (i, value) in window.iter_mut().enumerate() {
                let x = (x + i as i64 % 3 - 1).clamp(0, width - 1);
                let y = (y + i as i64 / 3 - 1).clamp(0, height - 1);
                *value = map.data[(y * width + x) as usize];
            }
            window.sort_unstable();
            let middle = window[4];
            data.push(if points_inside(x, middle, width as usize) { middle } else { DisparityMap::INVALID });
        }
    }
    DisparityMap { data, ..*map }
}
