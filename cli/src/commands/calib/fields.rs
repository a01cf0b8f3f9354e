//! A picture of what both cameras see, in the plane of the rectified images: their outlines, and the rectified image's frame.

use anyhow::Result;
use gpu_stereo::files::calibration::Fitted;
use gpu_stereo::files::encoders::{self, Font};
use gpu_stereo::{Lens, Rectification};
use image::{Rgb, RgbImage};

/// The longer side of the frame in the picture.
const FRAME: f64 = 560.0;
/// What is drawn around the frame, as a share of its sides.
const MARGIN: f64 = 0.3;

const BACKGROUND: [u8; 3] = [24, 24, 28];
const WHITE: [u8; 3] = [255, 255, 255];
/// Of the left camera and of the right one; they are told apart by everybody.
const COLORS: [[u8; 3]; 2] = [[230, 159, 0], [86, 180, 233]];

/// The bytes of a PNG.
pub fn picture(given: [u32; 2], fitted: &Fitted, lenses: [Lens; 2]) -> Result<Vec<u8>> {
    let sides = fitted.size.map(f64::from);
    let scale = FRAME / sides[0].max(sides[1]);
    let frame = sides.map(|side| (side * scale).round().max(1.0));
    let margin = frame.map(|side| (side * MARGIN).round());
    let canvas = [0, 1].map(|axis| (frame[axis] + 2.0 * margin[axis]) as u32);
    // The rectified cameras, zoomed and with a larger sensor.
    let wider = lenses.map(|lens| {
        let mut p = lens.projection;
        let place = |place: f64, axis: usize| (place + 0.5) * scale - 0.5 + margin[axis];
        (p[0], p[4], p[2], p[5]) = (p[0] * scale, p[4] * scale, place(p[2], 0), place(p[5], 1));
        Lens::new(lens.matrix, lens.distortion, lens.rotation, p)
    });
    let rectification = Rectification::of_size(given, canvas, wider)?;
    let ends = given.map(|side| 256 * (side as i32 - 1));
    let sees = |side: usize, x: u32, y: u32| {
        let [column, row] = rectification.positions(side)[(y * canvas[0] + x) as usize];
        (0..=ends[0]).contains(&column) && (0..=ends[1]).contains(&row)
    };
    let mut picture = RgbImage::from_pixel(canvas[0], canvas[1], Rgb(BACKGROUND));
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        let both = [0, 1].map(|side| sees(side, x, y));
        let mut color = match both {
            [true, true] => [112, 112, 118],
            [true, false] => mixed(COLORS[0]),
            [false, true] => mixed(COLORS[1]),
            [false, false] => BACKGROUND,
        };
        for side in [0, 1] {
            let near = [(x.saturating_sub(2), y), (x, y.saturating_sub(2)), (x + 2, y), (x, y + 2)];
            let outside = |&(x, y): &(u32, u32)| !sees(side, x.min(canvas[0] - 1), y.min(canvas[1] - 1));
            if both[side] && near.iter().any(outside) {
                color = COLORS[side];
            }
        }
        *pixel = Rgb(color);
    }
    outline(&mut picture, margin, frame);
    let names = if fitted.vertical { ["upper camera", "lower camera"] } else { ["left camera", "right camera"] };
    let font = Font::ALL[1];
    let lines = [(names[0], COLORS[0]), (names[1], COLORS[1]), ("rectified image", WHITE)];
    let rows = font.character()[1] + 3;
    for (i, (text, color)) in (0..).zip(lines) {
        font.write(&mut picture, (8, 8 + i * rows), text, color);
    }
    Ok(encoders::png(&picture)?)
}

/// The frame of the rectified image, dashed so that what coincides with it is seen.
fn outline(picture: &mut RgbImage, margin: [f64; 2], frame: [f64; 2]) {
    let [left, top] = margin.map(|side| side as u32);
    let [right, bottom] = [0, 1].map(|axis| (margin[axis] + frame[axis]) as u32 - 1);
    let dashed = |at: u32| (at / 6).is_multiple_of(2);
    for x in (left..=right).filter(|&x| dashed(x)) {
        [top, bottom].into_iter().for_each(|y| picture.put_pixel(x, y, Rgb(WHITE)));
    }
    for y in (top..=bottom).filter(|&y| dashed(y)) {
        [left, right].into_iter().for_each(|x| picture.put_pixel(x, y, Rgb(WHITE)));
    }
}

fn mixed(color: [u8; 3]) -> [u8; 3] {
    std::array::from_fn(|i| ((u16::from(color[i]) + 2 * u16::from(BACKGROUND[i])) / 3) as u8)
}
