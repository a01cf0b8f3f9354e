//! Images that lie in the caller's memory, row by row with any distance between them.

use std::borrow::Cow;
use std::fmt;
use std::ops::Deref;

use rayon::prelude::*;

use crate::{Error, Image, PixelFormat, Pixels};

/// How the bytes of a pixel lie in an [`ImageView`]. Samples of 16 bits are in the order of the host; they need not be aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ViewFormat {
    /// One 8-bit sample.
    Gray8,
    /// One 16-bit sample.
    Gray16,
    /// Red, green and blue, 8 bits each.
    Rgb8,
    /// Blue, green and red, 8 bits each: the order of OpenCV.
    Bgr8,
    /// Red, green, blue and an ignored fourth sample, 8 bits each.
    Rgba8,
    /// Blue, green, red and an ignored fourth sample, 8 bits each.
    Bgra8,
    /// Red, green, blue and an ignored fourth sample, 16 bits each.
    Rgba16,
}

impl ViewFormat {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Gray8, Self::Gray16, Self::Rgb8, Self::Bgr8, Self::Rgba8, Self::Bgra8, Self::Rgba16];

    /// Bytes a pixel.
    pub fn bytes_per_pixel(self) -> u32 {
        match self {
            Self::Gray8 => 1,
            Self::Gray16 => 2,
            Self::Rgb8 | Self::Bgr8 => 3,
            Self::Rgba8 | Self::Bgra8 => 4,
            Self::Rgba16 => 8,
        }
    }

    /// The format of the matchers that take such views.
    pub fn pixel_format(self) -> PixelFormat {
        match self {
            Self::Gray8 => PixelFormat::Gray8,
            Self::Gray16 => PixelFormat::Gray16,
            Self::Rgb8 | Self::Bgr8 | Self::Rgba8 | Self::Bgra8 => PixelFormat::Rgba8,
            Self::Rgba16 => PixelFormat::Rgba16,
        }
    }

    /// Which samples of a pixel are red, green and blue.
    fn red_green_blue(self) -> [usize; 3] {
        match self {
            Self::Gray8 | Self::Gray16 => [0; 3],
            Self::Rgb8 | Self::Rgba8 | Self::Rgba16 => [0, 1, 2],
            Self::Bgr8 | Self::Bgra8 => [2, 1, 0],
        }
    }
}

impl From<PixelFormat> for ViewFormat {
    fn from(format: PixelFormat) -> Self {
        match format {
            PixelFormat::Gray8 => Self::Gray8,
            PixelFormat::Gray16 => Self::Gray16,
            PixelFormat::Rgba8 => Self::Rgba8,
            PixelFormat::Rgba16 => Self::Rgba16,
        }
    }
}

/// One image of a pair, in the caller's memory: what takes pairs takes this or an [`Image`] by reference, and copies nothing
/// that it can read as it lies.
///
/// ```
/// use gpu_stereo::cpu::CpuMatcher;
/// use gpu_stereo::{ImageView, Params, ViewFormat};
///
/// // A frame of a camera with both views side by side, in OpenCV's order of colours: rows of 2 * 64 pixels, 3 bytes each.
/// let frame: Vec<u8> = (0..48 * 2 * 64 * 3).map(|i: u32| (i.wrapping_mul(2654435761) >> 24) as u8).collect();
/// let both = ImageView::new(2 * 64, 48, ViewFormat::Bgr8, 2 * 64 * 3, &frame)?;
/// let (left, right) = (both.crop(0, 0, 64, 48)?, both.crop(64, 0, 64, 48)?);
///
/// let matcher = CpuMatcher::new(64, 48, left.format(), &Params::sgm(16))?;
/// assert_eq!(matcher.compute(left, right)?.map.width, 64);
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct ImageView<'a> {
    width: u32,
    height: u32,
    format: ViewFormat,
    stride: usize,
    bytes: &'a [u8],
    /// The image that all of it is.
    whole: Option<&'a Image>,
}

impl<'a> ImageView<'a> {
    /// An image of `width` x `height` pixels whose row y begins at byte `y * stride`. `stride` is the row pitch in bytes, at
    /// least that of the pixels of a row. What lies between the rows and behind the last one is not read.
    ///
    /// # Errors
    /// [`Error::Image`] if a side is 0, the stride is below the bytes of a row, or there are less bytes than the rows take.
    pub fn new(width: u32, height: u32, format: ViewFormat, stride: usize, bytes: &'a [u8]) -> Result<Self, Error> {
        if width == 0 || height == 0 {
            return Err(Error::Image(format!(
                "a view of an image is {width}x{height}, but both sides must be at least 1; give the size of the image"
            )));
        }
        let row = u128::from(width) * u128::from(format.bytes_per_pixel());
        if (stride as u128) < row {
            return Err(Error::Image(format!(
                "a view of an image has a stride of {stride} bytes, but must have at least {row}, those of {width} pixels in \
                 {format:?}; give the distance of two rows in bytes"
            )));
        }
        let needed = u128::from(height - 1) * stride as u128 + row;
        if (bytes.len() as u128) < needed {
            return Err(Error::Image(format!(
                "a view of an image was given {} bytes, but {width}x{height} in {format:?} with a stride of {stride} take at \
                 least {needed}; give all rows",
                bytes.len()
            )));
        }
        Ok(Self { width, height, format, stride, bytes, whole: None })
    }

    /// The part of `width` x `height` pixels from column `x` and row `y` on: a region of interest, or one view of two in a frame.
    ///
    /// # Errors
    /// [`Error::Image`] if a side is 0, or the part reaches beyond the image.
    pub fn crop(&self, x: u32, y: u32, width: u32, height: u32) -> Result<Self, Error> {
        let fits = |from: u32, count: u32, all: u32| count > 0 && from.checked_add(count).is_some_and(|end| end <= all);
        if !fits(x, width, self.width) || !fits(y, height, self.height) {
            return Err(Error::Image(format!(
                "a part of {width}x{height} from column {x} and row {y} on was given, but it must lie within the image of {}x{}, \
                 and both sides must be at least 1; give another part",
                self.width, self.height
            )));
        }
        let first = y as usize * self.stride + x as usize * self.format.bytes_per_pixel() as usize;
        let whole = self.whole.filter(|_| (width, height) == (self.width, self.height));
        Ok(Self { width, height, bytes: &self.bytes[first..], whole, ..*self })
    }

    /// Pixels a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The format of the matchers that take it.
    pub fn format(&self) -> PixelFormat {
        self.format.pixel_format()
    }

    /// How the bytes of a pixel lie.
    pub fn view_format(&self) -> ViewFormat {
        self.format
    }

    /// The row pitch in bytes.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The bytes of a row, without what lies behind it.
    ///
    /// # Panics
    /// If `y` is not below the height.
    pub fn row(&self, y: u32) -> &'a [u8] {
        assert!(y < self.height, "row {y} of {}", self.height);
        &self.bytes[y as usize * self.stride..][..self.row_bytes()]
    }

    /// A copy of its own: colours of 8 bits as [`Pixels::Rgba8`].
    pub fn to_image(&self) -> Image {
        self.image().into_owned()
    }

    fn row_bytes(&self) -> usize {
        self.width as usize * self.format.bytes_per_pixel() as usize
    }

    /// Red, green and blue of a pixel; of a gray one its only sample, three times.
    pub(crate) fn color(&self, x: usize, y: usize) -> [u16; 3] {
        let bytes = self.format.bytes_per_pixel() as usize;
        let pixel = &self.bytes[y * self.stride + x * bytes..][..bytes];
        self.format.red_green_blue().map(|sample| match self.format().is_deep() {
            true => u16::from_ne_bytes([pixel[2 * sample], pixel[2 * sample + 1]]),
            false => pixel[sample].into(),
        })
    }

    /// The image itself, or a copy in the format of the matchers that take it.
    pub(crate) fn image(&self) -> Cow<'a, Image> {
        if let Some(image) = self.whole {
            return Cow::Borrowed(image);
        }
        let bytes = self.packed();
        let pixels = match self.format() {
            PixelFormat::Gray8 => Pixels::Gray8(bytes.into_owned()),
            PixelFormat::Gray16 => Pixels::Gray16(bytemuck::pod_collect_to_vec(&bytes)),
            PixelFormat::Rgba8 => Pixels::Rgba8(bytes.into_owned()),
            PixelFormat::Rgba16 => Pixels::Rgba16(bytemuck::pod_collect_to_vec(&bytes)),
        };
        Cow::Owned(Image::of_samples(self.width, self.height, pixels))
    }

    /// The bytes without gaps, in the format of the matchers that take it.
    pub(crate) fn packed(&self) -> Cow<'a, [u8]> {
        let (row, rows) = (self.row_bytes(), self.height as usize);
        if self.is_as_matchers_take_it() && (self.stride == row || rows == 1) {
            return Cow::Borrowed(&self.bytes[..row * rows]);
        }
        let packed = self.width as usize * self.format().bytes_per_pixel() as usize;
        let mut bytes = vec![0; packed * rows];
        let rows = bytes.par_chunks_exact_mut(packed).zip(0..self.height).with_min_len(16);
        rows.for_each(|(to, y)| self.pack_row(y, to));
        Cow::Owned(bytes)
    }

    fn is_as_matchers_take_it(&self) -> bool {
        ViewFormat::from(self.format()) == self.format
    }

    /// A row in the format of the matchers that take it.
    fn pack_row(&self, y: u32, to: &mut [u8]) {
        let from = self.row(y);
        let to_colors = to.as_chunks_mut::<4>().0;
        match self.format {
            ViewFormat::Rgb8 => {
                let pixels = to_colors.iter_mut().zip(from.as_chunks::<3>().0);
                pixels.for_each(|(to, &[red, green, blue])| *to = [red, green, blue, 255]);
            }
            ViewFormat::Bgr8 => {
                let pixels = to_colors.iter_mut().zip(from.as_chunks::<3>().0);
                pixels.for_each(|(to, &[blue, green, red])| *to = [red, green, blue, 255]);
            }
            ViewFormat::Bgra8 => {
                let pixels = to_colors.iter_mut().zip(from.as_chunks::<4>().0);
                pixels.for_each(|(to, &[blue, green, red, rest])| *to = [red, green, blue, rest]);
            }
            ViewFormat::Gray8 | ViewFormat::Gray16 | ViewFormat::Rgba8 | ViewFormat::Rgba16 => to.copy_from_slice(from),
        }
    }

    /// Calls `write` with each row in the format of the matchers that take it, and the byte that it begins at where rows have no
    /// gaps; all rows at once, if they lie so.
    pub(crate) fn each_packed_row(&self, mut write: impl FnMut(usize, &[u8])) {
        let (as_it_is, row) = (self.is_as_matchers_take_it(), self.row_bytes());
        if as_it_is && self.stride == row {
            return write(0, &self.bytes[..row * self.height as usize]);
        }
        let packed = self.width as usize * self.format().bytes_per_pixel() as usize;
        let mut scratch = vec![0; if as_it_is { 0 } else { packed }];
        for y in 0..self.height {
            let at = y as usize * packed;
            if as_it_is {
                write(at, self.row(y));
            } else {
                self.pack_row(y, &mut scratch);
                write(at, &scratch);
            }
        }
    }
}

impl<'a> From<&'a Image> for ImageView<'a> {
    fn from(image: &'a Image) -> Self {
        let format = image.format();
        let stride = image.width() as usize * format.bytes_per_pixel() as usize;
        let (width, height, bytes) = (image.width(), image.height(), image.bytes());
        Self { width, height, format: format.into(), stride, bytes, whole: Some(image) }
    }
}

/// Of what holds an image: an `Arc`, a `Box`, a `Cow`.
impl<'a, T: Deref<Target = Image>> From<&'a T> for ImageView<'a> {
    fn from(holder: &'a T) -> Self {
        Self::from(holder.deref())
    }
}

impl fmt::Debug for ImageView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, format, stride, .. } = self;
        let mut shown = f.debug_struct("ImageView");
        shown.field("width", width).field("height", height).field("format", format).field("stride", stride);
        shown.finish_non_exhaustive()
    }
}

/// Both images of a pair are what a matcher was made for.
pub(crate) fn check_made_for(
    pair: [ImageView<'_>; 2],
    [width, height]: [u32; 2],
    format: PixelFormat,
) -> Result<(), Error> {
    check_pair(pair)?;
    match pair.into_iter().find(|i| ([i.width, i.height], i.format()) != ([width, height], format)) {
        None => Ok(()),
        Some(image) => Err(Error::Image(format!(
            "an image is {}x{} in {:?}, but the matcher was made for {width}x{height} in {format:?}; resize it, or make another \
             one",
            image.width, image.height, image.format,
        ))),
    }
}

/// Both images of a pair have one size.
pub(crate) fn check_pair([left, right]: [ImageView<'_>; 2]) -> Result<(), Error> {
    let (l, r) = ((left.width, left.height), (right.width, right.height));
    if l == r {
        return Ok(());
    }
    Err(Error::Image(format!(
        "the left image is {}x{} and the right one {}x{}, but a rectified pair has one size; crop or rectify them again",
        l.0, l.1, r.0, r.1
    )))
}
