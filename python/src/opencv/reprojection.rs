//! Points from a map, as OpenCV's `reprojectImageTo3D` computes them.

/// What is written as Z where the map has its smallest value, if that stands for "missing".
const FAR: f64 = 10000.0;

/// Q (x, y, disparity, 1), divided by its fourth number, for each pixel of a map in rows: X, Y, Z. The pixels whose value is
/// `missing` are as far as `FAR`.
pub fn points(disparities: &[f32], width: usize, q: &[[f64; 4]; 4], missing: Option<f64>) -> Vec<f32> {
    let mut out = Vec::with_capacity(3 * disparities.len());
    for (at, &disparity) in disparities.iter().enumerate() {
        let point = [(at % width) as f64, (at / width) as f64, f64::from(disparity), 1.0];
        let [x, y, z, w] = q.map(|row| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| row[i] * point[i]);
            a + b + c + d
        });
        // OpenCV rounds to 32 bits before and after the division.
        let scaled = |number: f64| (f64::from(number as f32) * (1.0 / w)) as f32;
        let is_missing = missing.is_some_and(|value| (f64::from(disparity) - value).abs() <= f64::from(f32::EPSILON));
        out.extend([scaled(x), scaled(y), if is_missing { FAR as f32 } else { scaled(z) }]);
    }
    out
}
