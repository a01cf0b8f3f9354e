use super::Plane;
use crate::{Params, Prefilter};

/// Stage `prefilter`: the 8-bit image on which costs are computed.
///
/// With the 3x3 Sobel derivatives gx (to the right) and gy (downwards), undivided, over the image continued by its
/// border:
/// - `xsobel`: clamp(gx, -cap, cap) + cap;
/// - `sobel`: min(floor(sqrt(gx^2 + gy^2)), 2 cap);
/// - `none`: the gray value.
pub fn prefilter(gray: &Plane, params: &Params) -> Plane {
    let cap = params.prefilter_cap as i32;
    let mut data = Vec::with_capacity(gray.data.len());
    for y in 0..gray.height as i64 {
        for x in 0..gray.width as i64 {
            let at = |dx: i64, dy: i64| gray.clamped(x + dx, y + dy);
            let gx = at(1, -1) - at(-1, -1) + 2 * (at(1, 0) - at(-1, 0)) + at(1, 1) - at(-1, 1);
            let gy = at(-1, 1) - at(-1, -1) + 2 * (at(0, 1) - at(0, -1)) + at(1, 1) - at(1, -1);
            let value = match params.prefilter {
                Prefilter::XSobel => gx.clamp(-cap, cap) + cap,
                Prefilter::Sobel => ((gx * gx + gy * gy).isqrt()).min(2 * cap),
                Prefilter::Normalized | Prefilter::None => at(0, 0),
            };
            data.push(value as u8);
        }
    }
    Plane { width: gray.width, height: gray.height, data }
}
