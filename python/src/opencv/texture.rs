//! The texture of blocks, as OpenCV's StereoBM with `PREFILTER_NORMALIZED_RESPONSE` measures it.

use gpu_stereo::reference::{Plane, prefilter};
use gpu_stereo::{Params, Prefilter};

/// How the image is prefiltered, and the side of a block.
pub struct Response {
    pub window: u32,
    pub cap: u32,
    pub block: usize,
}

/// For each pixel how far the prefiltered image is from its middle, summed over the block around the pixel. Blocks that leave the
/// image are cut off: StereoBM has no disparity there.
pub fn sums(image: &[u8], width: usize, response: &Response) -> Vec<u32> {
    let height = image.len() / width;
    let mut params = Params::bm(1);
    (params.prefilter, params.prefilter_window, params.prefilter_cap) =
        (Prefilter::Normalized, response.window, response.cap);
    params.opencv_rules = true;
    let gray = Plane { width, height, data: image.iter().map(|&level| u16::from(level)).collect() };
    let filtered = prefilter(&gray, 1, &params);
    // above[(y, x)] is the sum over the rows before y and the columns before x.
    let mut above = vec![0_u64; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0;
        for x in 0..width {
            row += u64::from(u32::from(filtered.data[y * width + x]).abs_diff(response.cap));
            above[(y + 1) * (width + 1) + x + 1] = above[y * (width + 1) + x + 1] + row;
        }
    }
    let reach = response.block / 2;
    let mut out = Vec::with_capacity(image.len());
    for y in 0..height {
        let (top, bottom) = (y.saturating_sub(reach), (y + reach + 1).min(height));
        for x in 0..width {
            let (start, end) = (x.saturating_sub(reach), (x + reach + 1).min(width));
            let at = |y: usize, x: usize| above[y * (width + 1) + x];
            // At most 255 x 255 differences of at most 127.
            out.push((at(bottom, end) + at(top, start) - at(top, end) - at(bottom, start)) as u32);
        }
    }
    out
}
