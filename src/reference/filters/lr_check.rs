use crate::DisparityMap;
use crate::reference::points_inside;

/// Stage `lr_check`: a left pixel keeps its disparity if the right pixel that it points to agrees.
///
/// With q = floor((left(x, y) + 8) / 16), the nearest whole disparity: if x - q lies in the image, right(x - q, y) is
/// valid and |floor(right(x - q, y) / 16) - q| <= max_difference pixels. Otherwise the pixel becomes invalid.
///
/// At the left border a disparity of 1 px points outside and becomes invalid; 0.4 px is nearest to 0 px and is kept:
///
/// ```
/// use gpu_stereo::{DisparityMap, reference};
/// let row = |data| DisparityMap { width: 3, height: 1, data };
/// let right = row(vec![16, 16, 0]);
/// assert_eq!(reference::lr_check(&row(vec![16, 16, 16]), &right, 0).data, [DisparityMap::INVALID, 16, 16]);
/// assert_eq!(reference::lr_check(&row(vec![7, 16, 16]), &right, 1).data, [7, 16, 16]);
/// ```
pub fn lr_check(left: &DisparityMap, right: &DisparityMap, max_difference: u32) -> DisparityMap {
    let width = left.width as usize;
    let mut checked = left.clone();
    for (i, value) in checked.data.iter_mut().enumerate() {
        let x = i % width;
        if *value == DisparityMap::INVALID {
            continue;
        }
        let whole = (i32::from(*value) + 8) >> 4;
        let agrees = points_inside(x as i64, *value, width) && {
            let seen = right.data[(i as i64 - i64::from(whole)) as usize];
            seen != DisparityMap::INVALID && (i32::from(seen) >> 4).abs_diff(whole) <= max_difference
        };
        if !agrees {
            *value = DisparityMap::INVALID;
        }
    }
    checked
}
