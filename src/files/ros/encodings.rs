//! The encodings of sensor_msgs/Image.

use crate::files::error::{Result, bail};
use crate::files::frames::Packing;

/// The packing of an encoding. `big`: whether the higher byte of a sample comes first.
pub fn packing(encoding: &str, big: bool) -> Result<Packing> {
    let rgb = |bytes, places| Packing::Rgb8 { bytes, places };
    Ok(match encoding {
        "mono8" | "8UC1" => Packing::Gray8,
        "mono16" | "16UC1" => Packing::Gray16 { big },
        "rgb8" => rgb(3, [0, 1, 2]),
        "bgr8" | "8UC3" => rgb(3, [2, 1, 0]),
        "rgba8" => rgb(4, [0, 1, 2]),
        "bgra8" | "8UC4" => rgb(4, [2, 1, 0]),
        "yuv422" | "uyvy" => Packing::Yuv422 { luma: 1 },
        "yuv422_yuy2" | "yuyv" => Packing::Yuv422 { luma: 0 },
        "nv12" => Packing::Nv12,
        _ if encoding.starts_with("bayer_") => bail!(
            "an image has the encoding {encoding}, raw samples of a colour filter, which are not read; record the rectified or the \
             colour topic, as image_proc makes it"
        ),
        _ => bail!(
            "an image has the encoding {encoding:?}, but mono8, mono16, rgb8, bgr8, rgba8, bgra8, yuv422 and yuv422_yuy2 are \
             read; convert it before it is recorded"
        ),
    })
}

/// Bytes of a row of so many pixels, without padding; of planes, of the first one.
pub fn row_bytes(packing: Packing, width: u32) -> usize {
    let wide = width as usize;
    match packing {
        Packing::Gray8 | Packing::Nv12 | Packing::Planar { .. } => wide,
        Packing::Gray16 { .. } => 2 * wide,
        Packing::Rgb8 { bytes, .. } => bytes * wide,
        Packing::Rgb16 => 6 * wide,
        Packing::Yuv422 { .. } => 4 * wide.div_ceil(2),
    }
}
