use crate::reference::{Plane, window_sum};
use crate::{Params, Prefilter};

/// The 3x3 Sobel derivatives to the right and downwards, undivided, of an image continued by its border, in units of
/// `unit` (the nearest, halves upwards).
pub(crate) fn sobel(image: &Plane<u16>, unit: i32, x: i64, y: i64) -> (i32, i32) {
    let at = |dx: i64, dy: i64| image.clamped(x + dx, y + dy);
    let gx = at(1, -1) - at(-1, -1) + 2 * (at(1, 0) - at(-1, 0)) + at(1, 1) - at(-1, 1);
    let gy = at(-1, 1) - at(-1, -1) + 2 * (at(0, 1) - at(0, -1)) + at(1, 1) - at(1, -1);
    ((gx + unit / 2).div_euclid(unit), (gy + unit / 2).div_euclid(unit))
}

/// Stage `prefilter`: the image on which costs are computed, from [`crate::reference::deep_gray`], whose unit is `unit`.
///
/// - `xsobel`: clamp(gx, -cap, cap) + cap, with the 3x3 Sobel derivatives gx (to the right) and gy (downwards);
/// - `sobel`: min(floor(sqrt(gx^2 + gy^2)), 2 cap);
/// - `normalized`: clamp(4 (s - m), -cap, cap) + cap, with the pixel smoothed by its four neighbours, s = (4 centre + left
///   + right + above + below) / 8, and the mean m of the window around it, rounded down as a whole;
/// - `none`: the image itself, at its own depth.
pub fn prefilter(gray: &Plane<u16>, unit: i32, params: &Params) -> Plane<u16> {
    let cap = params.prefilter_cap as i32;
    gray.map(|x, y| {
        let at = |dx: i64, dy: i64| gray.clamped(x + dx, y + dy);
        let value = match params.prefilter {
            Prefilter::XSobel => sobel(gray, unit, x, y).0.clamp(-cap, cap) + cap,
            Prefilter::Sobel => {
                let (gx, gy) = sobel(gray, unit, x, y);
                (gx * gx + gy * gy).isqrt().min(2 * cap)
            }
            Prefilter::Normalized => {
                let n = (params.prefilter_window * params.prefilter_window) as i32;
                let smoothed = 4 * at(0, 0) + at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1);
                let response = n * smoothed - 8 * window_sum(gray, params.prefilter_window, x, y);
                response.div_euclid(2 * n * unit).clamp(-cap, cap) + cap
            }
            Prefilter::None => at(0, 0),
        };
        value as u16
    })
}
