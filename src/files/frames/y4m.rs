//! Y4M (YUV4MPEG2): one header of text, then frames of planes.

use super::lines::line;
use super::packing::Packing;
use crate::files::error::{Context as _, Result, bail, ensure};
use std::io::BufRead;

/// What the header of a stream says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    pub width: u32,
    pub height: u32,
    pub packing: Packing,
    /// Frames a second, if they are said.
    pub rate: Option<f64>,
}

/// The header of a stream.
pub fn header(source: &mut impl BufRead) -> Result<Header> {
    let text = line(source)?.unwrap_or_default();
    let mut fields = text.split(' ');
    ensure!(fields.next() == Some("YUV4MPEG2"), "the stream begins with {text:?} in place of YUV4MPEG2");
    let (mut width, mut height, mut rate, mut colours, mut full) = (0, 0, None, "420", false);
    for field in fields.filter(|field| !field.is_empty()) {
        let Some(first) = field.chars().next() else { continue };
        let value = &field[first.len_utf8()..];
        let side = || value.parse().ok().with_context(|| format!("the Y4M header has {field:?}, which is no size"));
        match first {
            'W' => width = side()?,
            'H' => height = side()?,
            'F' => {
                rate = value.split_once(':').and_then(|(a, b)| Some(a.parse::<f64>().ok()? / b.parse::<f64>().ok()?))
            }
            'C' => colours = value,
            'X' if value == "COLORRANGE=FULL" => full = true,
            _ => {} // interlacing, aspect ratio, comments
        }
    }
    // 420p10 and so on have samples of two bytes.
    let deep = colours.split_once('p').and_then(|(form, bits)| {
        Some((form, [9, 10, 12, 14, 16].into_iter().find(|known: &u32| bits == known.to_string())?))
    });
    let (form, bits) = deep.filter(|(form, _)| ["420", "422", "444"].contains(form)).unwrap_or((colours, 8));
    let planar = |columns, rows| Packing::Planar { columns, rows, alpha: false, full, bits };
    let packing = match form {
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => planar(1, 1),
        "411" => planar(2, 0),
        "422" => planar(1, 0),
        "444" => planar(0, 0),
        "444alpha" => Packing::Planar { columns: 0, rows: 0, alpha: true, full, bits },
        "mono" => Packing::Gray8,
        "mono9" | "mono10" | "mono12" | "mono14" | "mono16" => Packing::Gray16 { big: false },
        _ => bail!(
            "the Y4M header says C{colours}, but 420, 411, 422, 444 and mono are read; give ffmpeg -pix_fmt yuv420p, or gray16le \
             with -strict -1"
        ),
    };
    packing.frame_bytes(width, height)?;
    Ok(Header { width, height, packing, rate: rate.filter(|rate| rate.is_finite() && *rate > 0.0) })
}

/// Reads the line before a frame; false at the end of the stream.
pub fn begins_frame(source: &mut impl BufRead) -> Result<bool> {
    let Some(text) = line(source)? else { return Ok(false) };
    ensure!(
        text == "FRAME" || text.starts_with("FRAME "),
        "a frame begins with {text:?} in place of FRAME; the stream is damaged"
    );
    Ok(true)
}
