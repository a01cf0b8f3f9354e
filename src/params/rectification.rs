//! Where the pixels of rectified images come from.

use std::fmt;
use std::sync::Arc;

use crate::{Error, Lens};

/// Rectifies pairs of one size on their way into the matcher: for [`crate::Params::rectify`].
///
/// The rectified images have the size of the given ones. Positions are computed once, in 64-bit floats, and kept in 1/256 px.
#[derive(Clone)]
pub struct Rectification(Arc<Inner>);

#[derive(PartialEq)]
struct Inner {
    size: [u32; 2],
    lenses: [Lens; 2],
    positions: [Vec<[i32; 2]>; 2],
}

impl PartialEq for Rectification {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.size == other.0.size && self.0.lenses == other.0.lenses
    }
}

impl fmt::Debug for Rectification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Rectification").field("size", &self.0.size).field("lenses", &self.0.lenses).finish()
    }
}

impl Rectification {
    /// For pairs of `width` x `height` pixels, the left lens and the right one.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a number is not finite, a focal length not positive, a camera matrix another one than
    /// [fx 0 cx; 0 fy cy; 0 0 1], a sensor tilted by more than 1.5, or a matrix without an inverse;
    /// [`Error::Image`] for a side of 0.
    pub fn new(width: u32, height: u32, lenses: [Lens; 2]) -> Result<Self, Error> {
        if width == 0 || height == 0 {
            return Err(Error::Image(format!("the images are {width}x{height}, but each side must be at least 1")));
        }
        let [left, right] = &lenses;
        let positions = [left.positions([width, height])?, right.positions([width, height])?];
        Ok(Self(Arc::new(Inner { size: [width, height], lenses, positions })))
    }

    /// Columns and rows of the images.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    /// The lens of the left camera and that of the right one.
    pub fn lenses(&self) -> &[Lens; 2] {
        &self.0.lenses
    }

    /// For each pixel of a rectified image (0: the left one) the column and the row in the given one, in 1/256 px. Those that
    /// lie outside it may be nearer than they are.
    pub fn positions(&self, side: usize) -> &[[i32; 2]] {
        &self.0.positions[side]
    }

    /// Whether images are of its size.
    pub(crate) fn accepts(&self, width: u32, height: u32) -> Result<(), Error> {
        let [w, h] = self.size();
        if (w, h) == (width, height) {
            return Ok(());
        }
        Err(Error::Image(format!(
            "the images are {width}x{height}, but the rectification is of {w}x{h}; make one for this size"
        )))
    }
}
