//! Disparities as samples.

use crate::DisparityMap;
use crate::files::error::{Context as _, Result};

/// Disparity in pixels.
pub(super) fn pixels(value: i16) -> Option<f32> {
    (value != DisparityMap::INVALID).then(|| f32::from(value) / 16.0)
}

/// 16-bit samples, 256 a pixel; a disparity is in 1/16 pixel, so this is exact.
pub(super) fn kitti(map: &DisparityMap) -> Result<Vec<u16>> {
    let sample = |(i, &value): (usize, &i16)| {
        let Some(disparity) = pixels(value) else {
            return Ok(0);
        };
        u16::try_from(16 * i32::from(value)).ok().map(|sample| sample.max(1)).with_context(|| {
            let (x, y) = (i % map.width as usize, i / map.width as usize);
            format!(
                "the disparity at ({x}, {y}) is {disparity} px, but a 16-bit PNG holds 0 to {} px; use .pfm, .npy or \
                 .tif, or search another range",
                f32::from(u16::MAX >> 4) / 16.0
            )
        })
    };
    map.data.iter().enumerate().map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(data: &[i16]) -> DisparityMap {
        DisparityMap { width: data.len() as u32, height: 1, data: data.into() }
    }

    #[test]
    fn kitti_samples_are_exact_and_never_wrap() {
        let samples = kitti(&map(&[DisparityMap::INVALID, 0, 1, 16, 4095])).unwrap();
        assert_eq!(samples, [0, 1, 16, 256, 65520]);
        for (value, told) in [(-1, "-0.0625 px"), (4096, "256 px"), (i16::MAX, "2047.9375 px")] {
            let error = kitti(&map(&[0, value])).unwrap_err().to_string();
            assert!(error.contains(told) && error.contains("(1, 0)") && error.contains("255.9375"), "{error}");
        }
    }
}
