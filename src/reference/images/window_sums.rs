use crate::reference::Plane;

/// Stage `window_sums`: the sum over the `window` x `window` pixels around a pixel, the image continued by its border.
pub fn window_sum(image: &Plane<u16>, window: u32, x: i64, y: i64) -> i32 {
    let radius = i64::from(window / 2);
    let row = |y: i64| (-radius..=radius).map(|dx| image.clamped(x + dx, y)).sum::<i32>();
    (-radius..=radius).map(|dy| row(y + dy)).sum()
}
