use crate::{Camera, DepthMap, DisparityMap};

/// Stage `depth`: floor(focal baseline / (disparity + doffs)) in millionths of the baseline's unit, with 4096 focal
/// baseline in these and doffs in 1/4096 px to the nearest.
///
/// 0, no depth, where there is no disparity, where disparity and doffs are together not positive, and where the depth does
/// not fit 32 bits.
pub fn depth(map: &DisparityMap, camera: &Camera) -> DepthMap {
    let (product, offset) = camera.fixed();
    let of = |&value: &i16| match 256 * i64::from(value) + i64::from(offset) {
        _ if value == DisparityMap::INVALID => 0,
        shift @ 1.. => u32::try_from(product / shift as u64).unwrap_or(DepthMap::NONE),
        _ => DepthMap::NONE,
    };
    DepthMap { width: map.width, height: map.height, data: map.data.iter().map(of).collect() }
}
