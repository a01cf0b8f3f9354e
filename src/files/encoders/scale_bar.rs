//! The bar beside a picture of a map: which colour stands for which disparity, or for which distance.

use super::font::Font;
use crate::{Camera, Colors};
use image::imageops;
use image::{Rgb, RgbImage};

const WHITE: Rgb<u8> = Rgb([255; 3]);
const BLACK: [u8; 3] = [0; 3];
/// The colour of pixels without a disparity.
const NONE: Rgb<u8> = Rgb([0; 3]);

/// A mark of the bar: its place, from 0 (the smallest disparity) to 1, and what stands there.
type Mark = (f64, String);

/// The picture with a bar on its right: large disparities at the top, in metres with a camera, else in px.
pub fn beside(picture: &RgbImage, range: (i32, i32), colors: Colors, camera: Option<&Camera>) -> RgbImage {
    let (width, height) = picture.dimensions();
    let font = Font::ALL.into_iter().rev().find(|font| font.character()[1] * 12 <= height).unwrap_or(Font::ALL[0]);
    let [character, line] = font.character();
    let gap = line / 2;
    // From the top: a half line, the bar, and a line that shows what no disparity looks like.
    let bar = height.saturating_sub(gap + 3 * line).max(1);
    let marks = marks(range, camera, (bar / (2 * line)).max(2) as usize);
    let most = marks.iter().map(|(_, text)| text.chars().count()).max().unwrap_or_default().max("none".len()) as u32;
    let wide = gap + line + gap + most * character + gap;
    let mut sheet = RgbImage::from_pixel(width + wide, height, WHITE);
    imageops::replace(&mut sheet, picture, 0, 0);
    let x = width + gap;
    for row in 0..bar {
        let share = 1.0 - f64::from(row) / f64::from((bar - 1).max(1));
        fill(&mut sheet, (x, gap + row), (line, 1), Rgb(colors.at(share)));
    }
    for (share, text) in marks {
        let y = gap + ((1.0 - share) * f64::from(bar - 1)).round() as u32;
        fill(&mut sheet, (x + line, y), (gap / 2, 1), Rgb(BLACK));
        font.write(&mut sheet, (x + line + gap, y.saturating_sub(line / 2)), &text, BLACK);
    }
    let y = gap + bar + line;
    fill(&mut sheet, (x, y), (line, line), NONE);
    font.write(&mut sheet, (x + line + gap, y), "none", BLACK);
    sheet
}

fn fill(sheet: &mut RgbImage, (x, y): (u32, u32), (width, height): (u32, u32), color: Rgb<u8>) {
    for (x, y) in (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y))) {
        if let Some(pixel) = sheet.get_pixel_mut_checked(x, y) {
            *pixel = color;
        }
    }
}

/// At most so many marks, at round numbers that lie apart.
fn marks(range: (i32, i32), camera: Option<&Camera>, most: usize) -> Vec<Mark> {
    match camera {
        Some(camera) => {
            let metres = metres(range, camera, most);
            if metres.is_empty() { pixels(range, most) } else { metres }
        }
        None => pixels(range, most),
    }
}

fn share(disparity: f64, (first, last): (i32, i32)) -> f64 {
    (disparity - f64::from(first)) / f64::from((last - first).max(1))
}

/// Disparities in px: multiples of 1, 2 or 5 times a power of 10.
fn pixels((first, last): (i32, i32), most: usize) -> Vec<Mark> {
    let steps = (0..).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_i32.pow(power)));
    let step = steps.take(12).find(|step| ((last - first) / step) < most as i32).unwrap_or(last - first).max(1);
    let least = first.div_euclid(step) + i32::from(first.rem_euclid(step) != 0);
    (least..=last.div_euclid(step))
        .map(|i| (share(f64::from(i * step), (first, last)), format!("{} px", i * step)))
        .collect()
}

/// Distances in metres that lie at least a mark's height apart, the nearest first; none if all is infinitely far away.
fn metres(range: (i32, i32), camera: &Camera, most: usize) -> Vec<Mark> {
    let Camera { focal, baseline, doffs, .. } = *camera;
    let depth = |disparity: i32| focal * baseline / (f64::from(disparity) + doffs);
    let nearest = depth(range.1);
    if !(nearest.is_finite() && nearest > 0.0) {
        return Vec::new();
    }
    let mut found: Vec<Mark> = Vec::new();
    let power = nearest.log10().floor() as i32;
    let digits = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
    for metres in (power..power + 5).flat_map(|power| digits.map(|digit| digit * 10f64.powi(power))) {
        let share = share(focal * baseline / metres - doffs, range);
        let is_apart = found.last().is_none_or(|(last, _)| last - share >= 1.0 / most as f64);
        if (0.0..=1.0).contains(&share) && is_apart {
            // The digits of a number such as 0.30000000000000004.
            let rounded: f64 = format!("{metres:.6}").parse().unwrap_or(metres);
            found.push((share, format!("{rounded} m")));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_numbers_within_the_range() {
        let texts = |marks: Vec<Mark>| marks.into_iter().map(|(_, text)| text).collect::<Vec<_>>().join(" ");
        assert_eq!(texts(marks((0, 63), None, 8)), "0 px 10 px 20 px 30 px 40 px 50 px 60 px");
        assert_eq!(texts(marks((-7, 8), None, 4)), "-5 px 0 px 5 px");
        assert_eq!(texts(marks((0, 0), None, 4)), "0 px");
        let camera = Camera { doffs: 0.0, ..Camera::new(100.0, 0.5) };
        // 63 px are 0.79 m away; half of that is twice as far.
        let found = marks((0, 63), Some(&camera), 8);
        assert_eq!(texts(found.clone()), "0.8 m 1 m 1.2 m 1.5 m 2 m 3 m 6 m 120 m");
        for (share, text) in found {
            let metres: f64 = text.trim_end_matches(" m").parse().unwrap();
            assert!((50.0 / (share * 63.0) - metres).abs() < 1e-9, "{text}");
        }
        // Where nothing is nearer than infinity there is nothing to tell but pixels.
        assert_eq!(texts(marks((-9, -1), Some(&camera), 3)), texts(marks((-9, -1), None, 3)));
    }

    #[test]
    fn the_picture_stays_as_it_is() {
        let picture = RgbImage::from_fn(40, 120, |x, y| Rgb([x as u8, y as u8, 7]));
        let drawn = beside(&picture, (0, 15), Colors::Viridis, None);
        assert!(drawn.width() > 60 && drawn.height() == 120);
        assert!(picture.enumerate_pixels().all(|(x, y, pixel)| drawn.get_pixel(x, y) == pixel));
        let has = |color: [u8; 3]| drawn.enumerate_pixels().any(|(x, _, pixel)| x >= 40 && pixel.0 == color);
        assert!(has(Colors::Viridis.at(0.0)) && has(Colors::Viridis.at(1.0)) && has([0; 3]) && has([255; 3]));
        beside(&RgbImage::new(1, 1), (0, 15), Colors::Gray, None); // what has no room is cut off
    }
}
