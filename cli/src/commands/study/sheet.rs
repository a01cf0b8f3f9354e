//! The sheet: colour maps side by side in one picture, each with its caption.

use anyhow::{Result, ensure};
use gpu_stereo::Colors;
use gpu_stereo::files::encoders::Font;
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

/// The longest side of a sheet in pixels: viewers open it, and it takes at most 300 MB.
const MAX_SIDE: u64 = 10_000;
/// Pixels between tiles and around them.
const GAP: u32 = 8;
/// Characters that fit below every map in one line: the longest note.
const LINE: u32 = 24;
/// The largest font in which [`LINE`] characters fit below a map is used, or else the first.
const FONTS: [Font; 4] = Font::ALL;
const BLACK: [u8; 3] = [0; 3];
const GRAY: [u8; 3] = [90; 3];

/// The arrangement of the tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The left image, then the maps, in as many columns as look well.
    Wrapped,
    /// The maps in so many columns, two or more, below the left image.
    Columns(u32),
}

/// The places of all parts, checked to have a sane size before anything is computed.
#[derive(Debug)]
pub struct SheetPlan {
    size: (u32, u32),
    /// Corners of the tiles: the left image, then the maps.
    tiles: Vec<(u32, u32)>,
    /// Size of a picture.
    picture: (u32, u32),
    captions: Vec<Vec<String>>,
    legend: Vec<String>,
    legend_at: (u32, u32),
    font: Font,
}

impl SheetPlan {
    /// A sheet of pictures of `size`, drawn `width` pixels wide: the left image and maps, each with its caption, and
    /// lines about all of them.
    pub fn new(
        size: (u32, u32),
        captions: &[String],
        legend: &[String],
        order: Order,
        width: Option<u32>,
    ) -> Result<Self> {
        let tiles = captions.len() as u32;
        let columns = match order {
            Order::Wrapped => best_columns(tiles, f64::from(size.0) / f64::from(size.1)),
            Order::Columns(columns) => columns,
        };
        let width = width.unwrap_or_else(|| usual_width(size, columns));
        let scale = f64::from(width) / f64::from(size.0);
        let picture = (width, ((f64::from(size.1) * scale).round() as u32).max(1));
        let tile_width = width.max(LINE * FONTS[0].character()[0]);
        let fitting = FONTS.into_iter().rev().find(|font| LINE * font.character()[0] <= tile_width);
        let font = fitting.unwrap_or(FONTS[0]);
        let [character, line] = font.character();

        let captions: Vec<_> = captions.iter().map(|caption| wrapped(caption, tile_width / character)).collect();
        let lines = captions.iter().map(Vec::len).max().unwrap_or_default() as u32 + 1; // the note, too
        // In 64 bits: a picture may be as high as an image is wide.
        let (step_x, step_y) = (tile_width + GAP, u64::from(picture.1) + u64::from(GAP / 2 + lines * line + GAP));
        let across = u64::from(columns) * u64::from(step_x) + u64::from(GAP);
        let (beside, first) = match order {
            Order::Wrapped => (0, 1),
            Order::Columns(_) => (1, columns), // the left image stands in a row of its own, beside the legend
        };
        let room = across.min(MAX_SIDE) as u32 - beside * step_x - 2 * GAP;
        let legend: Vec<_> = legend.iter().flat_map(|text| wrapped(text, room / character)).collect();
        let legend_height = u64::from(GAP + (legend.len() as u32 + 1) * (line + GAP / 4));
        let rows = u64::from((first + tiles - 1).div_ceil(columns));
        let (head, height) = match order {
            Order::Wrapped => (0, rows * step_y + legend_height),
            Order::Columns(_) => {
                let head = step_y.max(legend_height);
                (head - step_y, head + (rows - 1) * step_y)
            }
        };
        let height = height + u64::from(GAP);
        ensure!(
            across <= MAX_SIDE && height <= MAX_SIDE,
            "the sheet of {} maps would have {across}x{height} pixels, but at most {MAX_SIDE} a side are drawn; lower \
             --tile-width, which is {width} here, or give fewer values",
            tiles - 1
        );
        let (step_y, head) = (step_y as u32, head as u32);
        let corner = |place: u32| {
            let (column, row) = (place % columns, place / columns);
            let y = GAP + row * step_y + if row > 0 { head } else { 0 };
            (GAP + column * step_x, y)
        };
        let of_tile = |tile: u32| corner(if tile == 0 { 0 } else { first + tile - 1 });
        let legend_at = match order {
            Order::Wrapped => (GAP, GAP + rows as u32 * step_y),
            Order::Columns(_) => corner(1),
        };
        let tiles = (0..tiles).map(of_tile).collect();
        Ok(Self { size: (across as u32, height as u32), tiles, picture, captions, legend, legend_at, font })
    }
}

/// The number of columns that leaves few places empty and makes the sheet about as wide as a screen.
fn best_columns(tiles: u32, aspect: f64) -> u32 {
    let fault = |columns: u32| {
        let rows = tiles.div_ceil(columns);
        let empty = f64::from(rows * columns - tiles) / f64::from(rows * columns);
        let shape = f64::from(columns) * aspect * 0.85 / f64::from(rows); // what is written below counts, too
        4.0 * empty + (shape / 1.6).ln().abs()
    };
    (1..=tiles).min_by(|&a, &b| fault(a).total_cmp(&fault(b))).unwrap_or(1)
}

/// A width at which labels and maps are legible and the sheet is not much wider than a screen.
fn usual_width((width, height): (u32, u32), columns: u32) -> u32 {
    let least = 240;
    let wide = (2400 / columns).clamp(least, 480).min(width.max(least));
    // A tall image gets at most twice the height of a square one.
    let high = 2.0 * f64::from(wide) * f64::from(width) / f64::from(height);
    wide.min(high.ceil() as u32)
}

/// A text in lines of at most so many characters, broken between words where it can be.
fn wrapped(text: &str, characters: u32) -> Vec<String> {
    let most = characters.max(1) as usize;
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let mut word: Vec<char> = word.chars().collect();
        loop {
            let line = lines.last_mut().filter(|line| {
                let length = line.chars().count();
                length == 0 || length + 1 + word.len() <= most
            });
            let Some(line) = line else {
                lines.push(String::new());
                continue;
            };
            if !line.is_empty() {
                line.push(' ');
            }
            let rest = word.split_off(word.len().min(most));
            line.extend(word);
            if rest.is_empty() {
                break;
            }
            word = rest;
        }
    }
    lines
}

/// A sheet that is being drawn.
pub struct Sheet {
    plan: SheetPlan,
    canvas: RgbImage,
}

impl Sheet {
    /// A white sheet with the left image and the colours of the disparities `first` to `last`.
    pub fn new(plan: SheetPlan, left: &RgbImage, (first, last): (i32, i32), colors: Colors) -> Self {
        let canvas = RgbImage::from_pixel(plan.size.0, plan.size.1, Rgb([255; 3]));
        let mut sheet = Self { plan, canvas };
        sheet.tile(0, left, &format!("{} x {}", left.width(), left.height()));

        let ((x, mut y), [character, line]) = (sheet.plan.legend_at, sheet.plan.font.character());
        let from = format!("{first} ");
        let bar_at = x + from.len() as u32 * character;
        let bar = 8 * character;
        sheet.plan.font.write(&mut sheet.canvas, (x, y), &from, BLACK);
        for i in 0..bar {
            let color = colors.at(f64::from(i) / f64::from(bar - 1));
            imageops::replace(
                &mut sheet.canvas,
                &RgbImage::from_pixel(1, line, Rgb(color)),
                (bar_at + i).into(),
                y.into(),
            );
        }
        sheet.plan.font.write(&mut sheet.canvas, (bar_at + bar, y), &format!(" {last} px"), BLACK);
        for text in std::mem::take(&mut sheet.plan.legend) {
            y += line + GAP / 4;
            sheet.plan.font.write(&mut sheet.canvas, (x, y), &text, GRAY);
        }
        sheet
    }

    /// Draws a picture at its place, 0 the left image, with its caption and a note below.
    pub fn tile(&mut self, place: usize, picture: &RgbImage, note: &str) {
        let Self { plan, canvas } = self;
        let ((x, y), (width, height)) = (plan.tiles[place], plan.picture);
        let scaled = match (width, height) {
            size if size == picture.dimensions() => picture.clone(),
            (width, _) if width >= picture.width() => imageops::resize(picture, width, height, FilterType::Nearest),
            _ => imageops::resize(picture, width, height, FilterType::Triangle),
        };
        imageops::replace(canvas, &scaled, x.into(), y.into());
        let [_, line] = plan.font.character();
        let mut y = y + height + GAP / 2;
        for text in &plan.captions[place] {
            plan.font.write(canvas, (x, y), text, BLACK);
            y += line;
        }
        plan.font.write(canvas, (x, y), note, GRAY);
    }

    /// The picture.
    pub fn finish(self) -> RgbImage {
        self.canvas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words_or_within_long_ones() {
        assert_eq!(wrapped("block 9, disp 61", 16), ["block 9, disp 61"]);
        assert_eq!(wrapped("block 9, disp 61", 15), ["block 9, disp", "61"]);
        assert_eq!(wrapped("a hirschmuller b", 5), ["a", "hirsc", "hmull", "er b"]);
        assert_eq!(wrapped("", 5), [""]);
        assert_eq!(wrapped("ab", 0), ["a", "b"]);
    }

    #[test]
    fn columns() {
        let columns = |tiles| best_columns(tiles, 1.5);
        assert_eq!([1, 2, 3, 4, 5, 6, 9].map(columns), [1, 2, 3, 2, 3, 3, 3]);
    }

    #[test]
    fn nothing_overlaps_and_nothing_is_cut() {
        let texts = |n: usize| (0..n).map(|i| format!("block {i}, prefilter normalized, fill hirschmuller"));
        let legend: Vec<_> = texts(3).collect();
        for size in [(1, 1), (741, 500), (256, 256), (9, 1), (1, 9), (3000, 20)] {
            for (maps, order) in
                [(1, Order::Wrapped), (7, Order::Wrapped), (4, Order::Columns(2)), (6, Order::Columns(3))]
            {
                for width in [None, Some(64), Some(300)] {
                    let captions: Vec<_> = texts(maps + 1).collect();
                    let plan = SheetPlan::new(size, &captions, &legend, order, width).unwrap();
                    let [character, line] = plan.font.character();
                    let mut boxes: Vec<(u32, u32, u32, u32)> = Vec::new();
                    for (&(x, y), caption) in plan.tiles.iter().zip(&plan.captions) {
                        let text = caption.iter().map(String::len).max().unwrap().max(LINE as usize) as u32 * character;
                        let height = plan.picture.1 + GAP / 2 + (caption.len() as u32 + 1) * line;
                        boxes.push((x, y, x + text.max(plan.picture.0), y + height));
                    }
                    let text = plan.legend.iter().map(String::len).max().unwrap() as u32 * character;
                    let ((x, y), lines) = (plan.legend_at, plan.legend.len() as u32 + 1);
                    boxes.push((x, y, x + text.max(LINE * character), y + lines * (line + GAP / 4)));
                    for (i, a) in boxes.iter().enumerate() {
                        assert!(a.2 <= plan.size.0 && a.3 <= plan.size.1, "{a:?} {plan:?}");
                        for b in &boxes[..i] {
                            let apart = a.2 <= b.0 || b.2 <= a.0 || a.3 <= b.1 || b.3 <= a.1;
                            assert!(apart, "{a:?} {b:?} {plan:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn sheets_too_large_are_refused() {
        let captions = vec![String::new(); 401];
        let told = |size, order, width| SheetPlan::new(size, &captions, &[], order, width).unwrap_err().to_string();
        for error in [
            told((741, 500), Order::Wrapped, Some(4096)),
            told((741, 500), Order::Columns(200), None),
            told((1, 60_000), Order::Wrapped, Some(4096)),
        ] {
            assert!(
                error.contains("400 maps") && error.contains("10000 a side") && error.contains("--tile-width"),
                "{error}"
            );
        }
        assert!(SheetPlan::new((741, 500), &captions, &[], Order::Wrapped, None).is_ok());
    }
}
