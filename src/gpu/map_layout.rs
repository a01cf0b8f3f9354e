//! How the maps lie in the matcher's buffers.

use crate::gpu::interop::VALUES;
use crate::gpu::layout::Frame;
use crate::{ConfidenceMap, DepthMap, DisparityMap, Error};

/// What the pixels of a map are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MapFormat {
    /// `i16` in 1/16 px, [`DisparityMap::INVALID`] where there is none: [`StereoMatcher::output`](crate::StereoMatcher::output) and
    /// [`StereoMatcher::right`](crate::StereoMatcher::right).
    Disparity,
    /// `u8`, 0 where there is no disparity: [`StereoMatcher::confidence`](crate::StereoMatcher::confidence).
    Confidence,
    /// `u32` in micrometres, [`DepthMap::NONE`] where there is none: [`StereoMatcher::depth`](crate::StereoMatcher::depth).
    Depth,
}

impl MapFormat {
    /// Bytes a pixel.
    pub fn bytes_per_pixel(self) -> u32 {
        match self {
            MapFormat::Disparity => 2,
            MapFormat::Confidence => 1,
            MapFormat::Depth => 4,
        }
    }
}

/// How a map lies in a buffer of the matcher's and in the copies that [`Outputs`](crate::Outputs) makes of it: rows from the top, pixels from
/// the left, little endian, each row padded. [`StereoMatcher::layout`](crate::StereoMatcher::layout) returns it.
///
/// A program that reads a copy back itself makes a map of its bytes:
///
/// ```
/// # use gpu_stereo::{DisparityMap, Error, MapFormat, StereoMatcher};
/// # fn program(matcher: &StereoMatcher, bytes: &[u8]) -> Result<(), Error> {
/// let layout = matcher.layout(MapFormat::Disparity);
/// // `bytes`: `layout.bytes()` of them, from the place that `Outputs::buffer` was given on
/// let map: DisparityMap = layout.disparities(bytes)?;
/// # Ok(())
/// # }
/// ```
///
/// A shader reads it with the functions of [`MapLayout::WGSL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MapLayout {
    /// What a pixel is.
    pub format: MapFormat,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes from the beginning of a row to that of the next one, a multiple of 8.
    pub bytes_per_row: u32,
}

impl MapLayout {
    /// Functions for a shader that reads such a buffer as `array<u32>`, to be put before or behind its text:
    /// `stereo_disparity_word(x, y, bytes_per_row)` is the index of the word that holds pixel (x, y), `stereo_disparity(word, x)` its
    /// value in 1/16 px, `STEREO_INVALID` where there is none. `stereo_confidence_word` and `stereo_confidence` are the same for
    /// the confidence, 0 to 255; `stereo_depth_word` finds a depth in micrometres, and `stereo_metres` makes of it the nearest float
    /// in metres. All names begin with `stereo_` or `STEREO_`.
    ///
    /// ```
    /// let shader = [gpu_stereo::MapLayout::WGSL, "
    ///     @group(0) @binding(0) var<storage, read> map: array<u32>;
    ///     @group(0) @binding(1) var<uniform> bytes_per_row: u32;
    ///     fn pixels(x: u32, y: u32) -> f32 {
    ///         return f32(stereo_disparity(map[stereo_disparity_word(x, y, bytes_per_row)], x)) / 16.0;
    ///     }"].concat();
    /// # assert!(gpu_stereo::wgpu::naga::front::wgsl::parse_str(&shader).is_ok());
    /// ```
    pub const WGSL: &'static str = VALUES;

    pub(crate) fn new(format: MapFormat, frame: &Frame) -> Self {
        let Frame { width, height, map_stride, .. } = *frame;
        let bytes_per_row = 2 * map_stride * format.bytes_per_pixel(); // two pixels a word of a map
        Self { format, width, height, bytes_per_row }
    }

    /// Bytes of the whole map. The matcher's own buffers may be longer.
    pub fn bytes(&self) -> u64 {
        u64::from(self.bytes_per_row) * u64::from(self.height)
    }

    /// The disparities in the bytes of a buffer.
    ///
    /// # Errors
    /// [`Error::Image`] if the format is not [`MapFormat::Disparity`], or there are fewer than [`MapLayout::bytes`].
    pub fn disparities(&self, bytes: &[u8]) -> Result<DisparityMap, Error> {
        self.check(MapFormat::Disparity, bytes)?;
        let data = self.pixels(bytes, |[low, high]| i16::from_le_bytes([low, high]));
        Ok(DisparityMap { width: self.width, height: self.height, data })
    }

    /// The confidence in the bytes of a buffer.
    ///
    /// # Errors
    /// [`Error::Image`] if the format is not [`MapFormat::Confidence`], or there are fewer than [`MapLayout::bytes`].
    pub fn confidences(&self, bytes: &[u8]) -> Result<ConfidenceMap, Error> {
        self.check(MapFormat::Confidence, bytes)?;
        Ok(ConfidenceMap { width: self.width, height: self.height, data: self.pixels(bytes, |[value]| value) })
    }

    /// The depths in the bytes of a buffer.
    ///
    /// # Errors
    /// [`Error::Image`] if the format is not [`MapFormat::Depth`], or there are fewer than [`MapLayout::bytes`].
    pub fn depths(&self, bytes: &[u8]) -> Result<DepthMap, Error> {
        self.check(MapFormat::Depth, bytes)?;
        Ok(DepthMap { width: self.width, height: self.height, data: self.pixels(bytes, u32::from_le_bytes) })
    }

    /// The pixels, without the padding. There are enough bytes.
    pub(crate) fn pixels<const N: usize, T>(&self, bytes: &[u8], pixel: impl Fn([u8; N]) -> T) -> Vec<T> {
        let mut data = Vec::with_capacity(self.width as usize * self.height as usize);
        for row in bytes.chunks_exact(self.bytes_per_row as usize).take(self.height as usize) {
            let (pixels, _) = row.as_chunks::<N>();
            data.extend(pixels[..self.width as usize].iter().map(|bytes| pixel(*bytes)));
        }
        data
    }

    fn check(&self, format: MapFormat, bytes: &[u8]) -> Result<(), Error> {
        if self.format != format {
            let Self { format: own, .. } = self;
            return Err(Error::Image(format!(
                "a layout of {own:?} was asked for {format:?}, but can only read what it describes; take \
                 StereoMatcher::layout(MapFormat::{format:?})"
            )));
        }
        if (bytes.len() as u64) < self.bytes() {
            return Err(Error::Image(format!(
                "a map of {}x{} was given as {} bytes, but {format:?} takes {} a row, {} in all; read the whole copy",
                self.width,
                self.height,
                bytes.len(),
                self.bytes_per_row,
                self.bytes()
            )));
        }
        Ok(())
    }
}
