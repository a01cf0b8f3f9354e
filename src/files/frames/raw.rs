//! Raw frames: nothing but pixels, whose size and packing an option says.

use super::packing::{BGR8, BGRA8, Packing, RGB8, RGBA8};
use std::str::FromStr;

/// The size and the packing of frames that have no header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RawFrames {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How the bytes hold the pixels.
    pub packing: Packing,
}

/// The names of packings, which are ffmpeg's.
const PACKINGS: [(&str, Packing); 11] = [
    ("gray", Packing::Gray8),
    ("gray16le", Packing::Gray16 { big: false }),
    ("rgb24", RGB8),
    ("bgr24", BGR8),
    ("rgba", RGBA8),
    ("bgra", BGRA8),
    ("yuv420p", Packing::Planar { columns: 1, rows: 1, alpha: false, full: false, bits: 8 }),
    ("nv12", Packing::Nv12),
    ("yuyv422", Packing::Yuv422 { luma: 0 }),
    ("yuyv", Packing::Yuv422 { luma: 0 }),
    ("uyvy422", Packing::Yuv422 { luma: 1 }),
];

impl FromStr for RawFrames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = || {
            let (size, name) = text.split_once(':')?;
            let (width, height) = size.split_once(['x', 'X'])?;
            Some((width.parse().ok()?, height.parse().ok()?, name))
        };
        let Some((width, height, name)) = parts() else {
            return Err("the size and the pixels of a frame are needed, such as 1280x480:yuyv".into());
        };
        let Some((_, packing)) = PACKINGS.iter().find(|(known, _)| *known == name) else {
            let known: Vec<_> = PACKINGS.iter().map(|(known, _)| *known).collect();
            return Err(format!("the pixels must be one of {}; ffmpeg converts others by -pix_fmt", known.join(", ")));
        };
        packing.frame_bytes(width, height).map_err(|error| error.to_string())?;
        Ok(Self { width, height, packing: *packing })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_and_a_packing_are_read() {
        let nv12 = RawFrames { width: 1280, height: 480, packing: Packing::Nv12 };
        assert_eq!("1280x480:nv12".parse(), Ok(nv12));
        for (text, words) in [
            ("1280x480", "1280x480:yuyv"),
            ("1280:gray", "1280x480:yuyv"),
            ("-1x4:gray", "1280x480:yuyv"),
            ("0x4:gray", "0x4"),
            ("99999x99999:gray", "crop"),
            ("4x4:grey", "gray, gray16le"),
        ] {
            assert!(text.parse::<RawFrames>().unwrap_err().contains(words), "{text}");
        }
    }
}
