//! Images in, disparity maps out: the host's side of the matcher's buffers.

use crate::Error;

/// Samples of an image, row by row from the top, left to right, without padding.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pixels {
    /// One 8-bit sample a pixel.
    Gray8(Vec<u8>),
    /// One 16-bit sample a pixel.
    Gray16(Vec<u16>),
    /// Red, green, blue and an ignored fourth sample, 8 bits each.
    Rgba8(Vec<u8>),
    /// Red, green, blue and an ignored fourth sample, 16 bits each.
    Rgba16(Vec<u16>),
}

/// How the samples of [`Pixels`] are laid out, without the samples.
///
/// ```
/// use gpu_stereo::{Image, PixelFormat, Pixels};
/// let image = Image::new(2, 1, Pixels::Gray16(vec![0, 65535]))?;
/// assert_eq!((image.format(), image.format().bytes_per_pixel()), (PixelFormat::Gray16, 2));
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PixelFormat {
    /// See [`Pixels::Gray8`].
    Gray8,
    /// See [`Pixels::Gray16`].
    Gray16,
    /// See [`Pixels::Rgba8`].
    Rgba8,
    /// See [`Pixels::Rgba16`].
    Rgba16,
}

impl PixelFormat {
    /// Bytes a pixel.
    pub fn bytes_per_pixel(self) -> u32 {
        match self {
            PixelFormat::Gray8 => 1,
            PixelFormat::Gray16 => 2,
            PixelFormat::Rgba8 => 4,
            PixelFormat::Rgba16 => 8,
        }
    }

    /// Samples a pixel.
    pub(crate) fn samples(self) -> usize {
        match self {
            PixelFormat::Gray8 | PixelFormat::Gray16 => 1,
            PixelFormat::Rgba8 | PixelFormat::Rgba16 => 4,
        }
    }

    /// Whether a sample has 16 bits.
    pub(crate) fn is_deep(self) -> bool {
        matches!(self, PixelFormat::Gray16 | PixelFormat::Rgba16)
    }
}

/// One image of a rectified pair. Samples that lie in other memory need no copy: see [`ImageView`](crate::ImageView).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Pixels,
}

impl Image {
    /// An image of `width` x `height` pixels.
    ///
    /// ```
    /// use gpu_stereo::{Image, Pixels};
    /// let red_and_blue = Image::new(2, 1, Pixels::Rgba8(vec![255, 0, 0, 255, 0, 0, 255, 255]))?;
    /// assert_eq!((red_and_blue.width(), red_and_blue.height()), (2, 1));
    /// assert!(Image::new(2, 2, Pixels::Gray8(vec![0; 3])).is_err());
    /// # Ok::<(), gpu_stereo::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a side is 0, or the number of samples is not what the size and the format need.
    pub fn new(width: u32, height: u32, pixels: Pixels) -> Result<Self, Error> {
        let (samples, a_pixel) = match &pixels {
            Pixels::Gray8(s) => (s.len(), 1),
            Pixels::Gray16(s) => (s.len(), 1),
            Pixels::Rgba8(s) => (s.len(), 4),
            Pixels::Rgba16(s) => (s.len(), 4),
        };
        if width == 0 || height == 0 || samples as u128 != u128::from(width) * u128::from(height) * a_pixel {
            return Err(Error::Image(format!(
                "an image of {width}x{height} was given {samples} samples; both sides must be at least 1 and the \
                 samples {a_pixel} a pixel"
            )));
        }
        Ok(Self { width, height, pixels })
    }

    /// The same of as many samples as the size and the format need.
    pub(crate) fn of_samples(width: u32, height: u32, pixels: Pixels) -> Self {
        Self { width, height, pixels }
    }

    /// Pixels a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The samples.
    pub fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// The layout of the samples.
    pub fn format(&self) -> PixelFormat {
        match self.pixels {
            Pixels::Gray8(_) => PixelFormat::Gray8,
            Pixels::Gray16(_) => PixelFormat::Gray16,
            Pixels::Rgba8(_) => PixelFormat::Rgba8,
            Pixels::Rgba16(_) => PixelFormat::Rgba16,
        }
    }

    /// The samples as the bytes that are uploaded (16-bit samples in the host's order, which is little endian on
    /// every platform that wgpu supports).
    pub(crate) fn bytes(&self) -> &[u8] {
        match &self.pixels {
            Pixels::Gray8(s) | Pixels::Rgba8(s) => s,
            Pixels::Gray16(s) | Pixels::Rgba16(s) => bytemuck::cast_slice(s),
        }
    }
}

/// A disparity map of the left image: `left(x, y)` shows what `right(x - disparity, y)` shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisparityMap {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Disparity in 1/16 pixel, row by row from the top; [`DisparityMap::INVALID`] where there is none.
    pub data: Vec<i16>,
}

impl DisparityMap {
    /// The value of a pixel that has no disparity. It is below every disparity that can be searched.
    pub const INVALID: i16 = i16::MIN;

    /// Disparity in pixels, `None` where there is none (or outside the map).
    ///
    /// ```
    /// use gpu_stereo::DisparityMap;
    /// let map = DisparityMap { width: 2, height: 1, data: vec![40, DisparityMap::INVALID] };
    /// assert_eq!((map.get(0, 0), map.get(1, 0), map.get(2, 0)), (Some(2.5), None, None));
    /// ```
    pub fn get(&self, x: u32, y: u32) -> Option<f32> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let value = *self.data.get(y as usize * self.width as usize + x as usize)?;
        (value != Self::INVALID).then(|| f32::from(value) / 16.0)
    }

    /// The share of pixels that have a disparity, 0 to 1.
    pub fn valid_fraction(&self) -> f64 {
        let valid = self.data.iter().filter(|&&v| v != Self::INVALID).count();
        valid as f64 / self.data.len().max(1) as f64
    }
}

/// How far each pixel's winner is ahead of its best rival, where the disparity map has a disparity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfidenceMap {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 1 (none) to 255 (there is no rival, or each costs far more), row by row from the top; 0 where there
    /// is no disparity.
    pub data: Vec<u8>,
}

/// The index of each pixel's winner, before any test of it: what a method assigns to every pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Labels {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row from the top, 0 to [`Params::disparities`](crate::Params::disparities) - 1: index d stands for the
    /// disparity `min_disparity + d`.
    pub data: Vec<u16>,
    /// With [`Cost::MutualInformation`](crate::Cost::MutualInformation) what two values cost in the last round, `[left][right]`;
    /// otherwise empty.
    pub table: Vec<u8>,
}

/// What a labelling costs: the smaller, the better it is in the eyes of a Markov random field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Energy {
    /// The sum over all pixels of the matching cost of their labels.
    pub data: u64,
    /// The sum over all pairs of neighbours in a row or in a column of what the difference of their labels costs.
    pub smoothness: u64,
}

impl Energy {
    /// Both together.
    pub fn sum(&self) -> u64 {
        self.data + self.smoothness
    }
}

/// The distance of what each pixel shows, along the viewing direction of the cameras.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DepthMap {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Micrometres, row by row from the top; [`DepthMap::NONE`] where there is no depth.
    pub data: Vec<u32>,
}

impl DepthMap {
    /// The value of a pixel that has no depth: without a disparity, infinitely far away or beyond, or at 4295 m or more.
    pub const NONE: u32 = 0;

    /// Depth in metres, `None` where there is none (or outside the map).
    pub fn get(&self, x: u32, y: u32) -> Option<f64> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let value = *self.data.get(y as usize * self.width as usize + x as usize)?;
        (value != Self::NONE).then(|| f64::from(value) * 1e-6)
    }

    /// The depths in metres, row by row from the top, 0 where there is none: of each the nearest `f32`, as
    /// `Outputs::depth` leaves it in a texture.
    ///
    /// ```
    /// let map = gpu_stereo::DepthMap { width: 2, height: 1, data: vec![1_500_000, gpu_stereo::DepthMap::NONE] };
    /// assert_eq!(map.metres(), [1.5, 0.0]);
    /// ```
    pub fn metres(&self) -> Vec<f32> {
        // A double is near enough: no quotient of a 32-bit number lies so close to the middle between two floats.
        self.data.iter().map(|&value| (f64::from(value) / 1e6) as f32).collect()
    }
}

/// The disparities of the left image as a network gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct Unrounded {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Pixels, row by row from the top.
    pub data: Vec<f32>,
}

/// Everything that matching a pair returns.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Matched {
    /// The disparities of the left image.
    pub map: DisparityMap,
    /// The disparities of the right image, if [`crate::Params::right_map`] asks for them: `right(x, y)` shows what
    /// `left(x + disparity, y)` shows.
    pub right: Option<DisparityMap>,
    /// The confidence of `map`, if [`crate::Params::confidence`] asks for it.
    pub confidence: Option<ConfidenceMap>,
    /// The winners of the left image, if [`crate::Params::labels`] asks for them.
    pub labels: Option<Labels>,
    /// What the map was rounded from, if [`crate::Params::unrounded`] asks for it and the method is
    /// [`crate::Method::Psmnet`].
    pub unrounded: Option<Unrounded>,
    /// The depth of `map`, if [`crate::Params::depth`] asks for it.
    pub depth: Option<DepthMap>,
}

/// The time of one stage in one frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StageTime {
    /// The stage's name, as in docs/ALGORITHMS.md.
    pub name: String,
    /// Milliseconds.
    pub ms: f64,
}
