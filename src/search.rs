//! Which disparities a pair has, from a match of the pair at a lower resolution.

use crate::reference::{halved, rectify};
use crate::{DisparityMap, Error, Image, ImageView, Params, Pixels, Preset, Rectification};

/// Columns that the coarse pair has at most.
const COLUMNS: u32 = 400;

/// The search for the range of a pair's disparities: a match of the halved pair over everything that can be, with the strict
/// preset, whose map says where most disparities lie. It is integer arithmetic from end to end, so every device finds the same
/// range.
///
/// The images are halved until they have at most 400 columns: each pixel is the rounded mean of four, at odd borders of the last
/// row or column twice. Candidates reach from an eighth of the columns below 0 to half of them above. Of the n valid disparities in
/// ascending order those at floor(50 n / 10000) and floor(9995 n / 10000) are the ends, moved outwards by 1/32 of their difference and
/// half a coarse pixel.
///
/// ```
/// use gpu_stereo::{Image, Params, Pixels, RangeSearch, reference};
///
/// let texture = |x: u32, y: u32| (x.wrapping_mul(2654435761) ^ y.wrapping_mul(40503)).wrapping_mul(2246822519) >> 24;
/// let view = |shift| (0..96 * 48).map(|i| texture(i % 96 + shift, i / 96) as u8).collect();
/// let left = Image::new(96, 48, Pixels::Gray8(view(0)))?;
/// let right = Image::new(96, 48, Pixels::Gray8(view(9)))?; // shows 9 pixels to the left what the left image shows
///
/// let search = RangeSearch::new(&left, &right)?;
/// let map = reference::compute(&search.left, &search.right, &search.params)?; // or by a matcher
/// let mut params = Params::sgm(64);
/// search.found(&map, &mut params)?;
/// assert!(params.min_disparity >= 7 && params.disparities <= 5);
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
#[derive(Debug)]
pub struct RangeSearch {
    /// The halved left image.
    pub left: Image,
    /// The halved right image.
    pub right: Image,
    /// The settings of the coarse match.
    pub params: Params,
    /// How often the pair was halved.
    halvings: u32,
    width: u32,
}

impl RangeSearch {
    /// For a rectified pair.
    ///
    /// # Errors
    /// [`Error::Image`] if the images differ in size or format.
    pub fn new<'a>(left: impl Into<ImageView<'a>>, right: impl Into<ImageView<'a>>) -> Result<Self, Error> {
        let (left, right) = (left.into(), right.into());
        crate::image_view::check_pair([left, right])?;
        let halvings = (0..32).find(|&count| columns(left.width(), count) <= COLUMNS).unwrap_or(0);
        let halved = |image: ImageView<'_>| (0..halvings).try_fold(image.to_image(), |image, _| halve(&image));
        let (left, right, width) = (halved(left)?, halved(right)?, left.width());
        let below = (left.width() / 8) as i32;
        let mut params = Params::preset(Preset::Strict, left.width() / 2 + below as u32 + 1);
        params.min_disparity = -below;
        Ok(Self { left, right, params, halvings, width })
    }

    /// For a pair that is rectified before, if a rectification is given.
    ///
    /// # Errors
    /// As [`RangeSearch::new`], and [`Error::Image`] if the images are not of the size that the rectification is for.
    pub fn rectified<'a>(
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
        rectification: Option<&Rectification>,
    ) -> Result<Self, Error> {
        match rectification {
            Some(lenses) => Self::new(&rectify(left, lenses, 0)?, &rectify(right, lenses, 1)?),
            None => Self::new(left, right),
        }
    }

    /// Columns of the pair for each of the halved one.
    #[must_use]
    pub fn factor(&self) -> u32 {
        1 << self.halvings
    }

    /// Sets the range of `params` from the coarse map. Call it with the map that the coarse pair and [`RangeSearch::params`] gave.
    ///
    /// # Errors
    /// [`Error::Image`] if less than a hundredth of the coarse map is valid: there is too little to tell a range from.
    pub fn found(&self, map: &DisparityMap, params: &mut Params) -> Result<(), Error> {
        let mut valid: Vec<i16> = map.data.iter().copied().filter(|&value| value != DisparityMap::INVALID).collect();
        if valid.len() * 100 < map.data.len() || valid.is_empty() {
            return Err(Error::Image(format!(
                "only {} of {} pixels of the halved pair match, too few to find the range of disparities; check that the images \
                 are a rectified pair, left image first, or give the range",
                valid.len(),
                map.data.len()
            )));
        }
        valid.sort_unstable();
        let at = |share: usize| i32::from(valid[valid.len() * share / 10_000]);
        let (low, high) = (at(50), at(9995));
        let margin = (high - low) / 32 + 8;
        let most = Params::MAX_ABS_DISPARITY.min(self.width as i32 - 1);
        let low = (((low - margin) << self.halvings) >> 4).clamp(-most, most);
        let high = ((((high + margin) << self.halvings) + 15) >> 4).clamp(low, most);
        params.min_disparity = low;
        params.disparities = (high - low + 1) as u32;
        Ok(())
    }
}

/// Columns after so many halvings.
fn columns(width: u32, halvings: u32) -> u32 {
    (0..halvings).fold(width, |width, _| width.div_ceil(2))
}

/// An image of half the columns and rows, rounded up.
fn halve(image: &Image) -> Result<Image, Error> {
    let (width, height) = (image.width(), image.height());
    let size = [width as usize, height as usize];
    let pixels = match image.pixels() {
        Pixels::Gray8(samples) => Pixels::Gray8(halved(samples, size, 1)),
        Pixels::Gray16(samples) => Pixels::Gray16(halved(samples, size, 1)),
        Pixels::Rgba8(samples) => Pixels::Rgba8(halved(samples, size, 4)),
        Pixels::Rgba16(samples) => Pixels::Rgba16(halved(samples, size, 4)),
    };
    Image::new(width.div_ceil(2), height.div_ceil(2), pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_is_the_rounded_mean_of_four() {
        let image = Image::new(3, 3, Pixels::Gray8(vec![0, 1, 7, 1, 4, 9, 10, 20, 30])).unwrap();
        let half = halve(&image).unwrap();
        assert_eq!((half.width(), half.height()), (2, 2));
        assert_eq!(half.pixels(), &Pixels::Gray8(vec![2, 8, 15, 30]));
        let color = Image::new(2, 1, Pixels::Rgba16(vec![1, 2, 3, 65535, 4, 65535, 3, 65535])).unwrap();
        assert_eq!(halve(&color).unwrap().pixels(), &Pixels::Rgba16(vec![3, 32769, 3, 65535]));
    }

    #[test]
    fn the_range_reaches_a_little_beyond_the_map() {
        let image = Image::new(801, 3, Pixels::Gray8(vec![0; 2403])).unwrap();
        let search = RangeSearch::new(&image, &image).unwrap();
        assert_eq!((search.left.width(), search.left.height(), search.halvings), (201, 1, 2));
        assert_eq!((search.params.min_disparity, search.params.disparities), (-25, 126));
        let map = |data: Vec<i16>| DisparityMap { width: data.len() as u32, height: 1, data };
        let mut params = Params::sgm(64);
        // 10 to 20 coarse pixels, 160 / 32 + 8 = 13 sixteenths more: 36.75 to 83.25 px.
        search.found(&map((160..=320).collect()), &mut params).unwrap();
        assert_eq!((params.min_disparity, params.disparities), (36, 84 - 36 + 1));
        let mut few = vec![DisparityMap::INVALID; 1000];
        few[3] = 5;
        let error = search.found(&map(few), &mut params).unwrap_err().to_string();
        assert!(error.contains("only 1 of 1000 pixels"), "{error}");
    }
}
