use crate::reference::Plane;
use crate::reference::images::prefilter::{sobel, stereo_bm_sobel};
use crate::{DisparityMap, Params};
use rayon::prelude::*;

/// Stage `texture`: a left pixel keeps its disparity if there is enough to compare in its block.
///
/// t(x, y) is the sum over the block around (x, y) of min(|gx|, cap), where gx is the undivided horizontal Sobel derivative
/// of the left gray image; both the gray image and the values are continued by their borders. The pixel becomes invalid
/// where t < texture. It is the `textureThreshold` of OpenCV's StereoBM with `PREFILTER_XSOBEL`; with [`Params::opencv_rules`] gx
/// has its border, too.
///
/// In an image of the two columns 0 and 10, |gx| is 4 (10 - 0) = 40 in both, clipped to 31, and the columns outside repeat
/// that: a block of 3 has 9 * 31 = 279 everywhere.
///
/// ```
/// use gpu_stereo::{DisparityMap, Params, reference};
/// let gray = reference::Plane { width: 2, height: 2, data: vec![0, 10, 0, 10] };
/// let map = DisparityMap { width: 2, height: 2, data: vec![0; 4] };
/// let mut params = Params::bm(16);
/// (params.block, params.prefilter_cap, params.texture) = (3, 31, 279);
/// assert_eq!(reference::texture(&map, &gray, &params).valid_fraction(), 1.0);
/// params.texture = 280;
/// assert_eq!(reference::texture(&map, &gray, &params).valid_fraction(), 0.0);
/// ```
pub fn texture(left: &DisparityMap, gray: &Plane<u8>, params: &Params) -> DisparityMap {
    let (width, height, r) = (gray.width as i64, gray.height as i64, i64::from(params.radius()));
    let mut clipped = Plane { width: gray.width, height: gray.height, data: Vec::with_capacity(gray.data.len()) };
    for y in 0..height {
        for x in 0..width {
            let gx = if params.opencv_rules { stereo_bm_sobel(gray, 1, x, y) } else { sobel(gray, 1, x, y).0 };
            clipped.data.push(gx.unsigned_abs().min(params.prefilter_cap) as u8);
        }
    }
    let kept = |y: i64| {
        let column = |x: i64| (-r..=r).map(|j| clipped.clamped(x, y + j) as u32).sum();
        let columns: Vec<u32> = (-r..width + r).map(column).collect();
        let sums = columns.windows(params.block as usize).map(|block| block.iter().sum::<u32>());
        let row = left.data[(y * width) as usize..].iter();
        let checked = sums.zip(row).map(|(t, &value)| if t < params.texture { DisparityMap::INVALID } else { value });
        checked.collect::<Vec<_>>()
    };
    DisparityMap { data: (0..height).into_par_iter().flat_map_iter(kept).collect(), ..*left }
}
