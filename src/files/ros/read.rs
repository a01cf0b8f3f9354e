//! Messages that are read: images, compressed images, and what a camera says of itself.

use super::cdr::Reader;
use super::encodings::{packing, row_bytes};
use super::header::Header;
use crate::files::calibration::{Calibration, Reading, Source};
use crate::files::error::{Context as _, Result, bail, ensure};
use crate::files::images;
use image::DynamicImage;
use std::path::Path;

impl Header {
    /// The header that a message begins with.
    ///
    /// # Errors
    /// If the message is cut short or not in CDR.
    pub fn read(message: &[u8]) -> Result<Self> {
        Reader::new(message)?.header()
    }
}

/// An image, decoded.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ImageMessage {
    /// When it was taken.
    pub header: Header,
    /// Its pixels.
    pub picture: DynamicImage,
}

impl ImageMessage {
    /// The image in a sensor_msgs/Image.
    ///
    /// # Errors
    /// If the message is cut short, or its encoding is not read.
    pub fn read(message: &[u8]) -> Result<Self> {
        let mut reader = Reader::new(message)?;
        let header = reader.header()?;
        let (height, width, encoding, big) = (reader.u32()?, reader.u32()?, reader.text()?, reader.u8()? != 0);
        let (step, data) = (reader.u32()? as usize, reader.blob()?);
        let packing = packing(&encoding, big)?;
        let expected = packing.frame_bytes(width, height)?;
        let row = row_bytes(packing, width);
        let rows = expected / row;
        ensure!(
            step >= row && step.checked_mul(rows).is_some_and(|all| data.len() >= all - (step - row)),
            "an image of {width}x{height} pixels in {encoding} has {} bytes in rows of {step}, which are too few",
            data.len()
        );
        let pixels = match step == row {
            true => data.get(..expected).context("an image has too few bytes")?.to_vec(),
            false => data.chunks(step).take(rows).flat_map(|padded| &padded[..row]).copied().collect(),
        };
        Ok(Self { header, picture: packing.picture(width, height, pixels)? })
    }

    /// The image in a sensor_msgs/CompressedImage: JPEG, PNG or another format that is read from files.
    ///
    /// # Errors
    /// If the message is cut short, or its image cannot be decoded.
    pub fn read_compressed(message: &[u8]) -> Result<Self> {
        let mut reader = Reader::new(message)?;
        let (header, format, data) = (reader.header()?, reader.text()?, reader.blob()?);
        if format.contains("compressedDepth") || format.contains("h264") || format.contains("theora") {
            bail!(
                "an image is compressed as {format:?}, but JPEG and PNG are read; record the topic without transport"
            );
        }
        let name = Path::new("a compressed image");
        let picture = images::decode(name, images::decoder(name, data)?)?;
        Ok(Self { header, picture })
    }
}

/// What a camera says of itself: sensor_msgs/CameraInfo.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CameraInfo {
    /// Columns and rows.
    pub size: [u32; 2],
    /// The name of the model of its lens.
    pub model: String,
    /// The numbers of its lens.
    pub distortion: Vec<f64>,
    /// The camera before it is rectified, 3 x 3.
    pub matrix: [f64; 9],
    /// How it is turned to be rectified, 3 x 3.
    pub rotation: [f64; 9],
    /// The projection of the rectified camera, 3 x 4.
    pub projection: [f64; 12],
}

impl CameraInfo {
    /// Reads a message.
    ///
    /// # Errors
    /// If it is cut short.
    pub fn read(message: &[u8]) -> Result<Self> {
        let mut reader = Reader::new(message)?;
        reader.header()?;
        let (height, width, model) = (reader.u32()?, reader.u32()?, reader.text()?);
        let count = reader.u32()?;
        ensure!(count <= 64, "a camera says {count} numbers of its lens, but at most 64 are read");
        let distortion = (0..count).map(|_| reader.f64()).collect::<Result<_>>()?;
        let (matrix, rotation, projection) = (reader.f64s()?, reader.f64s()?, reader.f64s()?);
        Ok(Self { size: [width, height], model, distortion, matrix, rotation, projection })
    }

    /// Whether images of the camera as it is differ from rectified ones.
    fn bends_or_turns(&self) -> bool {
        const NOT_TURNED: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let turned = self.rotation != NOT_TURNED && self.rotation != [0.0; 9];
        turned || self.distortion.iter().any(|value| *value != 0.0)
    }

    /// The calibration of a pair by the messages of both cameras; `None` if they say no baseline. Of `raw` images, as they were
    /// taken, it rectifies where that changes them; others are taken for rectified.
    ///
    /// # Errors
    /// If the numbers are those of no pair.
    pub fn pair(left: &Self, right: &Self, raw: bool) -> Result<Option<Calibration>> {
        let is_apart = right.projection[3] != 0.0 || right.projection[7] != 0.0; // to the right, or below
        if left.projection[0] == 0.0 || !is_apart {
            return Ok(None);
        }
        let [left_file, right_file] = [left, right].map(|info| Source::parse(info.yaml().as_bytes()));
        let lenses = raw && (left.bends_or_turns() || right.bends_or_turns());
        Calibration::of(&left_file?, Some(&right_file?), Reading { lenses, ..Reading::default() }).map(Some)
    }

    /// The same as a file of a calibration.
    fn yaml(&self) -> String {
        let numbers = |values: &[f64]| values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ");
        let matrix = |name: &str, columns: usize, values: &[f64]| {
            let rows = values.len() / columns.max(1);
            format!("{name}:\n  rows: {rows}\n  cols: {columns}\n  data: [{}]\n", numbers(values))
        };
        let [width, height] = self.size;
        let model = self.model.replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "");
        let parts = [
            format!("image_width: {width}\nimage_height: {height}\ndistortion_model: \"{model}\"\n"),
            matrix("camera_matrix", 3, &self.matrix),
            matrix("distortion_coefficients", self.distortion.len(), &self.distortion),
            matrix("rectification_matrix", 3, &self.rotation),
            matrix("projection_matrix", 4, &self.projection),
        ];
        parts.concat()
    }
}
