//! PAM: a header of text before the pixels of each frame, as `ffmpeg -f image2pipe -c:v pam` writes them.

use super::lines::line;
use super::packing::{Packing, RGB8, RGBA8};
use crate::files::error::{Result, bail, ensure};
use std::io::BufRead;

/// The size and the packing that the next header says; `None` at the end of the stream.
pub fn header(source: &mut impl BufRead) -> Result<Option<(u32, u32, Packing)>> {
    let Some(first) = line(source)? else { return Ok(None) };
    ensure!(first == "P7", "a frame begins with {first:?} in place of P7; the stream is damaged");
    let mut numbers = [0_u32; 4];
    loop {
        let Some(text) = line(source)? else { bail!("the header of a frame is cut short") };
        if text == "ENDHDR" {
            break;
        }
        let (key, value) = text.split_once(' ').unwrap_or((&text, ""));
        if let Some(place) = ["WIDTH", "HEIGHT", "DEPTH", "MAXVAL"].iter().position(|known| *known == key) {
            let Ok(number) = value.trim().parse() else {
                bail!("the header of a frame has {text:?}, which is no number")
            };
            numbers[place] = number;
        }
    }
    let [width, height, depth, most] = numbers;
    let packing = match (depth, most) {
        (1, 255) => Packing::Gray8,
        (1, 65_535) => Packing::Gray16 { big: true },
        (3, 255) => RGB8,
        (4, 255) => RGBA8,
        (3, 65_535) => Packing::Rgb16,
        _ => bail!(
            "a frame has {depth} samples a pixel up to {most}, but 1 or 3 up to 255 or 65535 are read; convert it, for \
             example with ffmpeg's -pix_fmt rgb24"
        ),
    };
    Ok(Some((width, height, packing)))
}
