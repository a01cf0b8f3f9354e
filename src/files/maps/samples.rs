//! The values of a file, before it is known what they stand for.

use crate::files::error::{Result, bail, ensure};

/// The longest text before the samples of a PFM or NumPy file.
pub const MAX_HEADER: usize = 1 << 16;
/// The most pixels: a small file can declare many, and reading keeps a few numbers for each.
const MAX_PIXELS: u64 = 1 << 27;
/// Digits in the header of a NumPy file: two sides, those of 1 and the size of a sample have fewer.
pub const MAX_DIGITS: usize = 20;

/// Values as they stand in a file.
pub enum Samples {
    /// Whole numbers.
    Whole {
        /// The values.
        values: Vec<i64>,
        /// The value that stands for 1 px, if the kind of file has one.
        usual_scale: Option<f64>,
        /// The value that usually means no disparity.
        none: i64,
    },
    /// What is not finite is no disparity.
    Float(Vec<f64>),
}

impl Samples {
    /// Whole numbers of no usual scale, of which 0 is no disparity.
    pub fn whole(values: Vec<i64>) -> Self {
        Self::Whole { values, usual_scale: None, none: 0 }
    }

    /// Whole numbers of 16 bits with a sign. Those of OpenCV's matchers (CV_16S) count sixteenths of a pixel, and no disparity is
    /// (the smallest disparity - 1) * 16, below 0 and below all others.
    pub fn signed16(values: Vec<i64>) -> Self {
        match values.iter().min() {
            Some(&least) if least < 0 && least % 16 == 0 => {
                Self::Whole { values, usual_scale: Some(16.0), none: least }
            }
            _ => Self::whole(values),
        }
    }
}

pub fn ensure_pixels(width: u32, height: u32) -> Result<()> {
    ensure!(
        u64::from(width) * u64::from(height) <= MAX_PIXELS,
        "it declares {width}x{height} pixels, but at most {MAX_PIXELS} are read; crop or scale it"
    );
    Ok(())
}

/// The sides, if the file has as many samples as it declares.
pub fn ensure_length(width: u64, height: u64, bytes_each: u64, got: usize) -> Result<(u32, u32)> {
    let needed = width.checked_mul(height).and_then(|count| count.checked_mul(bytes_each));
    let sides = u32::try_from(width).ok().zip(u32::try_from(height).ok());
    match (sides, needed) {
        (Some((width @ 1.., height @ 1..)), Some(needed)) if needed == got as u64 => {
            ensure_pixels(width, height).map(|()| (width, height))
        }
        _ => bail!(
            "it declares {width}x{height} pixels of {bytes_each} bytes, but {got} bytes follow; it is cut short or damaged: save it \
             again"
        ),
    }
}
