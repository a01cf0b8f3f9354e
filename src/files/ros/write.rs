//! Messages that are written: disparities, depths and points.

use super::cdr::Writer;
use super::header::Header;
use crate::files::encoders::{Point, coloured, metres};
use crate::{Camera, DepthMap, DisparityMap, Image};

/// What a disparity image says besides its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisparityRange {
    /// The smallest and the largest disparity that was searched, in pixels.
    pub searched: [i32; 2],
    /// The cameras of the rectified pair, if they are known.
    pub camera: Option<Camera>,
}

/// A stereo_msgs/DisparityImage. Its disparities count from the principal points, as ROS wants it; where there is none, it is one
/// less than the smallest one that was searched.
#[must_use]
pub fn disparity(header: &Header, map: &DisparityMap, range: &DisparityRange) -> Vec<u8> {
    let (focal, baseline, doffs) = range.camera.map_or((0.0, 0.0, 0.0), |c| (c.focal, c.baseline, c.doffs));
    let [least, most] = range.searched.map(|searched| (f64::from(searched) + doffs) as f32);
    let value = |&value: &i16| match value {
        DisparityMap::INVALID => least - 1.0,
        value => (f64::from(value) / 16.0 + doffs) as f32,
    };
    let mut message = Writer::new(header);
    floats(&mut message, header, map.width, map.height, map.data.iter().map(value));
    message.f32(focal as f32);
    message.f32(baseline as f32);
    // The part of the image that is valid: x, y, height, width, and that it is no crop.
    [0, 0, map.height, map.width].into_iter().for_each(|side| message.u32(side));
    message.u8(0);
    [least, most, 1.0 / 16.0].into_iter().for_each(|value| message.f32(value));
    message.finish()
}

/// A sensor_msgs/Image of depths in metres, 32FC1, NaN where there is none.
#[must_use]
pub fn depth(header: &Header, depth: &DepthMap) -> Vec<u8> {
    let mut message = Writer::new(header);
    image(&mut message, depth.width, depth.height, metres(depth, f32::NAN).into_iter());
    message.finish()
}

/// A sensor_msgs/PointCloud2 of all pixels that have a depth, in metres, with the colours of the left image.
#[must_use]
pub fn points(header: &Header, depth: &DepthMap, camera: &Camera, left: &Image) -> Vec<u8> {
    const FLOAT32: u8 = 7;
    const STEP: usize = 16;
    let points = coloured(depth, camera, left);
    let mut message = Writer::new(header);
    message.u32(1);
    message.u32(points.len() as u32);
    let fields = ["x", "y", "z", "rgb"];
    message.u32(fields.len() as u32);
    for (name, place) in fields.into_iter().zip([0, 4, 8, 12]) {
        message.text(name);
        message.u32(place);
        message.u8(FLOAT32);
        message.u32(1);
    }
    message.u8(0);
    message.u32(STEP as u32);
    message.u32((STEP * points.len()) as u32);
    let bytes = points.iter().flat_map(|Point { place, color: [red, green, blue] }| {
        let [x, y, z] = place.map(f32::to_le_bytes);
        [x, y, z, [*blue, *green, *red, 0]].concat()
    });
    message.blob(STEP * points.len(), bytes);
    message.u8(1); // every point has a place
    message.finish()
}

/// An image of floats with a header of its own.
fn floats(message: &mut Writer, header: &Header, width: u32, height: u32, values: impl ExactSizeIterator<Item = f32>) {
    message.header(header);
    image(message, width, height, values);
}

fn image(message: &mut Writer, width: u32, height: u32, values: impl ExactSizeIterator<Item = f32>) {
    message.u32(height);
    message.u32(width);
    message.text("32FC1");
    message.u8(0);
    message.u32(4 * width);
    message.blob(4 * values.len(), values.flat_map(f32::to_le_bytes));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::ros::{CameraInfo, ImageMessage};
    use crate::{PixelFormat, Pixels};

    fn header() -> Header {
        Header { stamp: (-1, 5), frame: "left_optical".into() }
    }

    const CAMERA: Camera = Camera { focal: 100.0, baseline: 0.5, doffs: 2.0, cx: 0.5, cy: 0.0 };

    #[test]
    fn messages_are_laid_out_as_cdr_says() {
        let map = DisparityMap { width: 2, height: 1, data: vec![40, DisparityMap::INVALID] };
        let range = DisparityRange { searched: [0, 15], camera: Some(CAMERA) };
        let message = disparity(&header(), &map, &range);
        let number = |at: usize| f32::from_le_bytes(message[at..at + 4].try_into().unwrap());
        assert_eq!(Header::read(&message).unwrap(), header());
        // After the first four bytes: a header of 8 + 4 + 13 bytes, a padded one from 28 on, height at 56.
        let at = 4 + 56;
        assert_eq!(message[at..at + 8], [1, 0, 0, 0, 2, 0, 0, 0]);
        // "32FC1" at 64, its zero, the order of bytes at 74, the step at 76, the length at 80, the pixels at 84.
        assert_eq!((number(4 + 84), number(4 + 88)), (4.5, 1.0));
        assert_eq!((number(4 + 92), number(4 + 96)), (100.0, 0.5));
        let end = message.len();
        assert_eq!((number(end - 12), number(end - 8), number(end - 4)), (2.0, 17.0, 0.0625));

        let left = Image::new(2, 1, Pixels::Gray8(vec![7, 9])).unwrap();
        assert_eq!(left.format(), PixelFormat::Gray8);
        let depths = DepthMap { width: 2, height: 1, data: vec![2_000_000, DepthMap::NONE] };
        let message = points(&header(), &depths, &CAMERA, &left);
        assert_eq!(
            message[message.len() - 17..],
            [&(-0.01_f32).to_le_bytes()[..], &[0; 4], &2_f32.to_le_bytes(), &[7, 7, 7, 0, 1]].concat()
        );
    }

    #[test]
    fn images_are_read_with_their_padding_and_their_order_of_bytes() {
        let image = |encoding: &str, big: u8, step: u32, data: &[u8]| {
            let mut message = Writer::new(&header());
            message.u32(2);
            message.u32(2);
            message.text(encoding);
            message.u8(big);
            message.u32(step);
            message.blob(data.len(), data.iter().copied());
            message.finish()
        };
        let read = |message: &[u8]| ImageMessage::read(message).map(|image| image.picture);
        let gray = read(&image("mono8", 0, 3, &[1, 2, 99, 3, 4])).unwrap();
        assert_eq!(gray.to_luma8().into_raw(), [1, 2, 3, 4]);
        let deep = read(&image("mono16", 1, 4, &[0, 1, 0, 2, 0, 3, 0, 4])).unwrap();
        assert_eq!(deep.to_luma16().into_raw(), [1, 2, 3, 4]);
        let colour = read(&image("bgr8", 0, 6, &[3, 2, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0])).unwrap();
        assert_eq!(colour.to_rgb8().get_pixel(0, 0).0, [1, 2, 3]);
        for (message, words) in [
            (image("bayer_rggb8", 0, 2, &[0; 4]), "image_proc"),
            (image("32FC1", 0, 8, &[0; 16]), "mono8"),
            (image("mono8", 0, 1, &[0; 4]), "too few"),
            (image("mono8", 0, 2, &[0; 3]), "too few"),
            (image("mono8", 0, 2, &[0; 4])[..40].to_vec(), "within a field"),
            (b"\0\x03\0\0".to_vec(), "representation 3"),
            (b"abc".to_vec(), "as CDR does"),
        ] {
            let told = read(&message).unwrap_err().to_string();
            assert!(told.contains(words), "{words}: {told}");
        }
        let whole = image("rgb8", 0, 6, &[0; 12]);
        for cut in 0..whole.len() {
            let _ =
                (read(&whole[..cut]), CameraInfo::read(&whole[..cut]), ImageMessage::read_compressed(&whole[..cut]));
        }
    }
}
