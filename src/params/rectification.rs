//! Where the pixels of rectified images come from.

use std::fmt;
use std::sync::Arc;

use crate::{Distortion, Error, Lens};

/// The largest images: more than any device takes, and 2 GiB of positions.
const MOST_PIXELS: u64 = 1 << 28;

/// Rectifies pairs of one size on their way into the matcher: for [`crate::Params::rectify`].
///
/// The rectified images have the size of the given ones, unless another one is asked for ([`Self::of_size`], [`Self::vertical`]).
/// Such pairs are rectified by [`crate::reference::rectify`] before they are given to a matcher. Positions are computed once, in
/// 64-bit floats, and kept in 1/256 px.
#[derive(Clone)]
pub struct Rectification(Arc<Inner>);

#[derive(PartialEq)]
struct Inner {
    size: [u32; 2],
    rectified: [u32; 2],
    turned: bool,
    lenses: [Lens; 2],
    positions: [Vec<[i32; 2]>; 2],
}

impl PartialEq for Rectification {
    fn eq(&self, other: &Self) -> bool {
        let all = |Self(inner): &Self| (inner.size, inner.rectified, inner.turned, inner.lenses);
        Arc::ptr_eq(&self.0, &other.0) || all(self) == all(other)
    }
}

impl fmt::Debug for Rectification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Inner { size, rectified, turned, lenses, .. } = &*self.0;
        let mut all = f.debug_struct("Rectification");
        all.field("size", size).field("rectified", rectified).field("turned", turned).field("lenses", lenses).finish()
    }
}

impl Rectification {
    /// For pairs of `width` x `height` pixels, the left lens and the right one.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a number is not finite, a focal length not positive, a camera matrix another one than
    /// [fx 0 cx; 0 fy cy; 0 0 1], a sensor tilted by more than 1.5, or a matrix without an inverse;
    /// [`Error::Image`] for a side of 0, and for more than 2^28 pixels.
    pub fn new(width: u32, height: u32, lenses: [Lens; 2]) -> Result<Self, Error> {
        Self::made([width, height], [width, height], false, lenses)
    }

    /// The same with rectified images of another size, columns and rows: for [`crate::reference::rectify`], not for matchers.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn of_size(given: [u32; 2], rectified: [u32; 2], lenses: [Lens; 2]) -> Result<Self, Error> {
        Self::made(given, rectified, false, lenses)
    }

    /// For cameras one above the other, the upper one in the place of the left one: the rectified images, of this size before
    /// they are turned, are turned by 90 degrees against the clock, so that the partners of a row lie in one row. What is made
    /// from them is turned back by [`Self::upright`]. For [`crate::reference::rectify`], not for matchers.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn vertical(given: [u32; 2], rectified: [u32; 2], lenses: [Lens; 2]) -> Result<Self, Error> {
        let [width, height] = rectified;
        let turned = lenses.map(|lens| lens.turned(width));
        Self::made(given, [height, width], true, turned)
    }

    /// The same for pairs that are rectified: they are turned, without a change of any sample.
    ///
    /// # Errors
    /// [`Error::Image`] for a side of 0.
    pub fn turn(given: [u32; 2]) -> Result<Self, Error> {
        let one = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let lens = Lens { matrix: one, distortion: Distortion::NONE, rotation: one, projection: one };
        Self::vertical(given, given, [lens; 2])
    }

    pub(super) fn made(size: [u32; 2], rectified: [u32; 2], turned: bool, lenses: [Lens; 2]) -> Result<Self, Error> {
        for [width, height] in [size, rectified] {
            if width == 0 || height == 0 || u64::from(width) * u64::from(height) > MOST_PIXELS {
                return Err(Error::Image(format!(
                    "the images are {width}x{height}, but each side must be at least 1, and the pixels at most {MOST_PIXELS}; give \
                     others"
                )));
            }
        }
        let [left, right] = &lenses;
        let positions = [left.positions(size, rectified)?, right.positions(size, rectified)?];
        Ok(Self(Arc::new(Inner { size, rectified, turned, lenses, positions })))
    }

    /// Columns and rows of the images that it makes.
    pub fn rectified_size(&self) -> [u32; 2] {
        self.0.rectified
    }

    /// Whether the images that it makes are turned.
    pub fn is_turned(&self) -> bool {
        self.0.turned
    }

    /// Whether matchers can do it, since it changes neither the size of images nor turns them.
    pub fn is_for_matchers(&self) -> bool {
        !self.0.turned && self.0.rectified == self.0.size
    }

    /// The samples of a map of the images that it makes, row by row, as they lie in images that are not turned.
    ///
    /// # Panics
    /// If it turns, and there are less samples than pixels.
    pub fn upright<T: Copy>(&self, samples: &[T]) -> Vec<T> {
        let [height, width] = self.0.rectified.map(|side| side as usize);
        if !self.0.turned {
            return samples.to_vec();
        }
        (0..width * height).map(|i| samples[(width - 1 - i % width) * height + i / width]).collect()
    }

    /// Columns and rows of the given images.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    /// The lens of the left camera and that of the right one.
    pub fn lenses(&self) -> &[Lens; 2] {
        &self.0.lenses
    }

    /// For each pixel of a rectified image (0: the left one) the column and the row in the given one, in 1/256 px. Those that
    /// lie outside it may be nearer than they are.
    ///
    /// # Panics
    /// If `side` is above 1.
    pub fn positions(&self, side: usize) -> &[[i32; 2]] {
        &self.0.positions[side]
    }

    /// Whether a matcher can rectify images of this size by it.
    pub(crate) fn suits(&self, width: u32, height: u32) -> Result<(), Error> {
        if self.is_for_matchers() {
            return self.accepts(width, height);
        }
        Err(Error::Image(
            "the rectification changes the size or turns; rectify both images before, by reference::rectify".into(),
        ))
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
