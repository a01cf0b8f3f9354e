use crate::reference::{Plane, window_sum};
use crate::{Params, Prefilter};

/// The 3x3 Sobel derivatives to the right and downwards, undivided, of an image continued by its border, in units of
/// `unit` (the nearest, halves upwards).
pub(crate) fn sobel<T: Copy + Into<i32> + Sync>(image: &Plane<T>, unit: i32, x: i64, y: i64) -> (i32, i32) {
    let at = |dx: i64, dy: i64| image.clamped(x + dx, y + dy);
    let gx = at(1, -1) - at(-1, -1) + 2 * (at(1, 0) - at(-1, 0)) + at(1, 1) - at(-1, 1);
    let gy = at(-1, 1) - at(-1, -1) + 2 * (at(0, 1) - at(0, -1)) + at(1, 1) - at(1, -1);
    ((gx + unit / 2).div_euclid(unit), (gy + unit / 2).div_euclid(unit))
}

/// The derivative to the right as OpenCV's StereoBM has it: rows outside the image are those as far inside, and it is 0 in the
/// first and the last column, and in the last one of an odd number of rows.
pub(crate) fn stereo_bm_sobel<T: Copy + Into<i32> + Sync>(image: &Plane<T>, unit: i32, x: i64, y: i64) -> i32 {
    let (right, bottom) = (image.width as i64 - 1, image.height as i64 - 1);
    if x == 0 || x == right || (y == bottom && bottom % 2 == 0) {
        return 0;
    }
    let across = |y: i64| image.clamped(x + 1, y) - image.clamped(x - 1, y);
    let gx = across((y - 1).abs()) + 2 * across(y) + across(bottom - (bottom - y - 1).abs());
    (gx + unit / 2).div_euclid(unit)
}

/// Stage `prefilter`: the image on which costs are computed, from [`crate::reference::deep_gray`], whose unit is `unit`.
///
/// - `xsobel`: clamp(gx, -cap, cap) + cap, with the 3x3 Sobel derivatives gx (to the right) and gy (downwards);
/// - `sobel`: min(floor(sqrt(gx^2 + gy^2)), 2 cap);
/// - `normalized`: clamp(4 (s - m), -cap, cap) + cap, with the pixel smoothed by its four neighbours, s = (4 centre + left
///   + right + above + below) / 8, and the mean m of the window around it, rounded down as a whole;
/// - `none`: the image itself, at its own depth.
///
/// With [`Params::opencv_rules`] gx of `xsobel` is another at the border of the image, and `normalized` is
/// clamp(floor((e t - sum) f / 1024), -cap, cap) + cap, with t = 8 s, the sum of the n pixels of the window, e = floor(n / 8) and
/// f = floor((1024 + e) / (2 e)): 4 (s - m) with the reciprocal of n in 1024ths.
pub fn prefilter(gray: &Plane<u16>, unit: i32, params: &Params) -> Plane<u16> {
    let cap = params.prefilter_cap as i32;
    gray.map(|x, y| {
        let at = |dx: i64, dy: i64| gray.clamped(x + dx, y + dy);
        let value = match params.prefilter {
            Prefilter::XSobel if params.opencv_rules => stereo_bm_sobel(gray, unit, x, y).clamp(-cap, cap) + cap,
            Prefilter::XSobel => sobel(gray, unit, x, y).0.clamp(-cap, cap) + cap,
            Prefilter::Sobel => {
                let (gx, gy) = sobel(gray, unit, x, y);
                (gx * gx + gy * gy).isqrt().min(2 * cap)
            }
            Prefilter::Normalized => {
                let n = (params.prefilter_window * params.prefilter_window) as i32;
                let smoothed = 4 * at(0, 0) + at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1);
                let sum = window_sum(gray, params.prefilter_window, x, y);
                let response = if params.opencv_rules {
                    let [eighth, scale] = params.normalized_scales().map(|factor| factor as i32);
                    ((eighth * smoothed - sum) * scale).div_euclid(1024 * unit)
                } else {
                    (n * smoothed - 8 * sum).div_euclid(2 * n * unit)
                };
                response.clamp(-cap, cap) + cap
            }
            Prefilter::None => at(0, 0),
        };
        value as u16
    })
}
