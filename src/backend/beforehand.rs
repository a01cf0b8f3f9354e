//! Rectification that no matcher does: to another size, or of cameras one above the other. The pair is rectified before, and what
//! is made from it is turned back.

use std::borrow::Cow;

use crate::{
    ConfidenceMap, DepthMap, DisparityMap, Error, Image, ImageView, Masks, Matched, Params, PixelFormat, Pixels,
    Rectification, reference,
};

/// What a matcher is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Shape {
    /// Columns and rows.
    pub size: [u32; 2],
    /// The samples.
    pub format: PixelFormat,
}

impl Shape {
    /// Images of so many columns and rows, in this format.
    #[must_use]
    pub fn new(size: [u32; 2], format: PixelFormat) -> Self {
        Self { size, format }
    }

    /// That of an image.
    pub fn of<'a>(image: impl Into<ImageView<'a>>) -> Self {
        let image = image.into();
        Self { size: [image.width(), image.height()], format: image.format() }
    }
}

/// What is done before and after, and the settings between.
#[derive(Debug)]
pub struct Beforehand {
    rectification: Option<Rectification>,
    /// The settings for pairs that were rectified.
    pub params: Params,
}

impl Beforehand {
    /// With these settings, for the given pairs.
    ///
    /// # Errors
    /// As [`Masks::new`].
    pub fn of(params: &Params) -> Result<Self, Error> {
        let rectification = params.rectify.clone().filter(|rectification| !rectification.is_for_matchers());
        let mut params = params.clone();
        if let Some(rectification) = &rectification {
            let [width, height] = rectification.size();
            let content = reference::Content::new(&params, width, height);
            let [width, height] = rectification.rectified_size();
            let bytes = |side: &reference::Plane<bool>| side.data.iter().map(|&has| u8::from(has)).collect();
            let masks = content
                .map(|content| Masks::new(width, height, content.sides.each_ref().map(|side| Some(bytes(side)))));
            (params.rectify, params.masks) = (None, masks.transpose()?);
        }
        Ok(Self { rectification, params })
    }

    /// The image of a side (0: left) as the matcher takes it.
    ///
    /// # Errors
    /// [`Error::Image`] if its size is not that of the rectification.
    pub fn image<'a>(&self, image: &'a Image, side: usize) -> Result<Cow<'a, Image>, Error> {
        Ok(match &self.rectification {
            Some(rectification) => Cow::Owned(reference::rectify(image, rectification, side)?),
            None => Cow::Borrowed(image),
        })
    }

    /// The shape of the images that the matcher takes, where such are given.
    pub fn shape<'a>(&self, image: impl Into<ImageView<'a>>) -> Shape {
        let given = Shape::of(image);
        Shape { size: self.size(given.size), ..given }
    }

    /// Columns and rows of the images that the matcher takes, where such of this size are given.
    pub fn size(&self, given: [u32; 2]) -> [u32; 2] {
        self.rectification.as_ref().map_or(given, Rectification::rectified_size)
    }

    /// What a matcher made, as it lies in the rectified images before they were turned.
    pub fn upright(&self, mut matched: Matched) -> Matched {
        let Some(rectification) = self.rectification.as_ref().filter(|rectification| rectification.is_turned()) else {
            return matched;
        };
        let map = |map: &DisparityMap| {
            let data = rectification.upright(&map.data);
            DisparityMap { width: map.height, height: map.width, data }
        };
        (matched.map, matched.right) = (map(&matched.map), matched.right.as_ref().map(map));
        let [height, width] = rectification.rectified_size();
        matched.confidence =
            matched.confidence.map(|all| ConfidenceMap { width, height, data: rectification.upright(&all.data) });
        matched.depth = matched.depth.map(|all| DepthMap { width, height, data: rectification.upright(&all.data) });
        matched
    }
}

/// An image that was turned, as it lies before.
///
/// # Errors
/// [`Error::Image`] if its size is not that of the turned images.
pub fn upright(image: &Image, rectification: &Rectification) -> Result<Image, Error> {
    let [height, width] = rectification.rectified_size();
    fn colors<T: Copy>(samples: &[T], rectification: &Rectification) -> Vec<T> {
        rectification.upright(samples.as_chunks::<4>().0).as_flattened().to_vec()
    }
    let pixels = match image.pixels() {
        Pixels::Gray8(samples) => Pixels::Gray8(rectification.upright(samples)),
        Pixels::Gray16(samples) => Pixels::Gray16(rectification.upright(samples)),
        Pixels::Rgba8(samples) => Pixels::Rgba8(colors(samples, rectification)),
        Pixels::Rgba16(samples) => Pixels::Rgba16(colors(samples, rectification)),
    };
    Image::new(width, height, pixels)
}
