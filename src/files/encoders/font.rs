//! Text in pictures.

use embedded_graphics::mono_font::iso_8859_1::{FONT_6X10, FONT_8X13, FONT_9X15, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::{DrawTarget, Drawable as _, OriginDimensions, Pixel, Point, RgbColor as _, Size};
use embedded_graphics::text::{Baseline, Text};
use image::{Rgb, RgbImage};
use std::convert::Infallible;
use std::fmt;

/// A font whose characters have one width.
#[derive(Clone, Copy)]
pub struct Font(&'static MonoFont<'static>);

impl fmt::Debug for Font {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Font").field(&self.character()).finish()
    }
}

impl Font {
    /// All of them, the smallest first.
    pub const ALL: [Self; 4] = [Self(&FONT_6X10), Self(&FONT_8X13), Self(&FONT_9X15), Self(&FONT_10X20)];

    /// Columns and rows of a character.
    pub fn character(self) -> [u32; 2] {
        let Size { width, height } = self.0.character_size;
        [width, height]
    }

    /// Writes a line whose upper left corner is at (x, y); what lies outside the picture is cut off.
    pub fn write(self, picture: &mut RgbImage, (x, y): (u32, u32), text: &str, [red, green, blue]: [u8; 3]) {
        let style = MonoTextStyle::new(self.0, Rgb888::new(red, green, blue));
        let text = Text::with_baseline(text, Point::new(x as i32, y as i32), style, Baseline::Top);
        let Ok(_) = text.draw(&mut Canvas(picture));
    }
}

/// A picture that text can be drawn on.
struct Canvas<'a>(&'a mut RgbImage);

impl OriginDimensions for Canvas<'_> {
    fn size(&self) -> Size {
        Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Canvas<'_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            let at = u32::try_from(at.x).ok().zip(u32::try_from(at.y).ok());
            if let Some(pixel) = at.and_then(|(x, y)| self.0.get_pixel_mut_checked(x, y)) {
                *pixel = Rgb([color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}
