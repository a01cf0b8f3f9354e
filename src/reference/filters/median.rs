use crate::DisparityMap;
use crate::reference::points_inside;

/// Stage `median`: the middle one of the values around a pixel in ascending order, the map continued by its border. `side`
/// is 3 or 5: the fifth of 3x3 values, or the thirteenth of 5x5.
///
/// An invalid value is smaller than every valid one. So a hole among a majority of valid pixels is filled, and a pixel
/// among a majority of invalid ones is removed. A result that does not point into the right image is invalid.
///
/// At the upper right corner the border is read several times: 16 four times, 48 and 80 twice. At the left border a disparity
/// of 1 px points outside and becomes invalid, though it is the median:
///
/// ```
/// use gpu_stereo::{DisparityMap, reference};
/// const NONE: i16 = DisparityMap::INVALID;
/// let corner = DisparityMap { width: 4, height: 2, data: vec![NONE, NONE, 48, 16, NONE, NONE, NONE, 80] };
/// assert_eq!(reference::median(&corner, 3).get(3, 0), Some(1.0));
/// let border = DisparityMap { width: 2, height: 1, data: vec![0, 16] };
/// let alike = DisparityMap { width: 2, height: 1, data: vec![16, 16] };
/// assert_eq!(reference::median(&border, 3).data, [0, 16]);
/// assert_eq!(reference::median(&alike, 3).data, [NONE, 16]);
/// ```
pub fn median(map: &DisparityMap, side: usize) -> DisparityMap {
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let reach = side as i64 / 2;
    let mut data = Vec::with_capacity(map.data.len());
    let mut window = Vec::with_capacity(side * side);
    for y in 0..height {
        for x in 0..width {
            window.clear();
            for y in y - reach..=y + reach {
                let row = y.clamp(0, height - 1) * width;
                window.extend((x - reach..=x + reach).map(|x| map.data[(row + x.clamp(0, width - 1)) as usize]));
            }
            window.sort_unstable();
            let middle = window[side * side / 2];
            data.push(if points_inside(x, middle, width as usize) { middle } else { DisparityMap::INVALID });
        }
    }
    DisparityMap { data, ..*map }
}
