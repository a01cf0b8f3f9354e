//! Depths as coloured points.

use super::pictures::rgba8;
use crate::files::error::Result;
use crate::{Camera, DepthMap, Image};
use std::io::Write as _;

/// A point in metres: to the right, down and forward of the left camera; and its colour.
pub struct Point {
    /// Metres.
    pub place: [f32; 3],
    /// Red, green, blue.
    pub color: [u8; 3],
}

/// The pixels that have a depth, row by row.
pub fn coloured(depth: &DepthMap, camera: &Camera, left: &Image) -> Vec<Point> {
    let width = depth.width.max(1) as usize;
    let with_depth = depth.data.iter().enumerate().filter(|(_, value)| **value != DepthMap::NONE);
    let colors = rgba8(left);
    let point = |(i, &value): (usize, &u32)| {
        let place = camera.point((i % width) as u32, (i / width) as u32, value).map(|metres| metres as f32);
        Point { place, color: [colors[4 * i], colors[4 * i + 1], colors[4 * i + 2]] }
    };
    with_depth.map(point).collect()
}

/// A binary PLY file of coloured points.
///
/// # Errors
/// If the bytes cannot be written.
pub fn ply(depth: &DepthMap, camera: &Camera, left: &Image) -> Result<Vec<u8>> {
    let points = coloured(depth, camera, left);
    let mut bytes = Vec::with_capacity(300 + 15 * points.len());
    write!(
        bytes,
        "ply\nformat binary_little_endian 1.0\ncomment metres: x right, y down, z forward of the left camera\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\nend_header\n",
        points.len()
    )?;
    for Point { place, color } in points {
        place.iter().for_each(|metres| bytes.extend(metres.to_le_bytes()));
        bytes.extend(color);
    }
    Ok(bytes)
}

/// A binary PCD file of coloured points, as the Point Cloud Library has them: `rgb` holds the bits of 0x00rrggbb in a float.
///
/// # Errors
/// If the bytes cannot be written.
pub fn pcd(depth: &DepthMap, camera: &Camera, left: &Image) -> Result<Vec<u8>> {
    let points = coloured(depth, camera, left);
    let mut bytes = Vec::with_capacity(300 + 16 * points.len());
    write!(
        bytes,
        "# .PCD v0.7 - metres: x right, y down, z forward of the left camera\nVERSION 0.7\nFIELDS x y z rgb\n\
         SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
        points.len()
    )?;
    for Point { place, color: [r, g, b] } in points {
        place.iter().for_each(|metres| bytes.extend(metres.to_le_bytes()));
        bytes.extend([b, g, r, 0]);
    }
    Ok(bytes)
}
