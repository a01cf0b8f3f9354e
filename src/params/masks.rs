//! Which pixels of the given images have content.

use std::fmt;
use std::sync::Arc;

use crate::Error;

/// Which pixels of the given images have content, for pairs of one size: for [`crate::Params::masks`].
///
/// A mask may hide what the cameras carry along, such as the bonnet of a car, the rim of a lens or a time stamp.
///
/// ```
/// use gpu_stereo::{Image, Masks, Params, Pixels, reference};
///
/// let texture = |x: u32, y: u32| (x * x * 31 + x * y * 17 + y * 7) as u8;
/// let view = |shift| (0..32 * 8).map(|i| texture(i % 32 + shift, i / 32)).collect();
/// let left = Image::new(32, 8, Pixels::Gray8(view(0)))?;
/// let right = Image::new(32, 8, Pixels::Gray8(view(3)))?;
/// let mut params = Params::sgm(16);
/// let upper_half = (0..32 * 8).map(|i| if i < 32 * 4 { 255 } else { 0 }).collect();
/// params.masks = Some(Masks::new(32, 8, [Some(upper_half), None])?);
/// let map = reference::compute(&left, &right, &params)?;
/// assert_eq!((map.get(20, 2), map.get(20, 6)), (Some(3.0), None));
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
#[derive(Clone)]
pub struct Masks(Arc<Inner>);

#[derive(PartialEq)]
struct Inner {
    size: [u32; 2],
    sides: [Option<Vec<u8>>; 2],
}

impl PartialEq for Masks {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

impl fmt::Debug for Masks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let masked =
            |side: &Option<Vec<u8>>| side.as_ref().map(|mask| mask.iter().filter(|&&value| value == 0).count());
        let [left, right] = self.0.sides.each_ref().map(masked);
        f.debug_struct("Masks").field("size", &self.0.size).field("left", &left).field("right", &right).finish()
    }
}

impl Masks {
    /// Of the left image and of the right one, each of `width` x `height` pixels: a byte a pixel, row by row from the top,
    /// 0 where there is no content. Without a mask all pixels of a side have content. With [`crate::Params::rectify`] the
    /// masks are of the given images, before they are rectified.
    ///
    /// # Errors
    /// [`Error::Image`] for a side of 0, and for a mask that has not a byte for each pixel.
    pub fn new(width: u32, height: u32, masks: [Option<Vec<u8>>; 2]) -> Result<Self, Error> {
        let pixels = u128::from(width) * u128::from(height);
        let wrong = masks.iter().flatten().find(|mask| mask.len() as u128 != pixels);
        if pixels == 0 || wrong.is_some() {
            return Err(Error::Image(format!(
                "a mask of {width}x{height} was given {} values; both sides must be at least 1 and the values one a pixel",
                wrong.map_or(0, Vec::len)
            )));
        }
        Ok(Self(Arc::new(Inner { size: [width, height], sides: masks })))
    }

    /// Columns and rows of the images.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    /// The mask of the left image (0) or of the right one (1), if there is one.
    ///
    /// # Panics
    /// If `side` is above 1.
    pub fn side(&self, side: usize) -> Option<&[u8]> {
        self.0.sides[side].as_deref()
    }

    /// Whether images are of their size.
    pub(crate) fn accepts(&self, width: u32, height: u32) -> Result<(), Error> {
        let [w, h] = self.size();
        if (w, h) == (width, height) {
            return Ok(());
        }
        Err(Error::Image(format!(
            "the images are {width}x{height}, but the masks are {w}x{h}; give masks of this size"
        )))
    }
}
