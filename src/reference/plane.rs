//! The results of stages: a value or several bytes for each pixel, or a value for each pixel and disparity.

use rayon::prelude::*;

/// An image, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane<T> {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `data[y * width + x]`.
    pub data: Vec<T>,
}

impl<T: Copy + Into<i32> + Sync> Plane<T> {
    /// The pixel nearest to (x, y) that lies in the image: the image is continued by its border.
    pub fn clamped(&self, x: i64, y: i64) -> i32 {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        self.data[y * self.width + x].into()
    }

    /// An image of the same size, from a function of x and y.
    pub fn map<U: Send>(&self, value: impl Fn(i64, i64) -> U + Sync) -> Plane<U> {
        let pixel = |i: usize| value((i % self.width) as i64, (i / self.width) as i64);
        let data = (0..self.data.len()).into_par_iter().with_min_len(1 << 12).map(pixel).collect();
        Plane { width: self.width, height: self.height, data }
    }
}

/// A value for each pixel and disparity: `data[(y * width + x) * disparities + d]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Volume<T> {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Disparities a pixel; index d stands for the disparity `min_disparity + d`.
    pub disparities: usize,
    /// The values, disparity fastest.
    pub data: Vec<T>,
}

impl<T: Copy + Default> Volume<T> {
    /// A volume of zeros.
    pub fn new(width: usize, height: usize, disparities: usize) -> Self {
        Self { width, height, disparities, data: vec![T::default(); width * height * disparities] }
    }

    /// Values a row of the image.
    pub fn row_len(&self) -> usize {
        self.width * self.disparities
    }
}

/// What the matching cost compares of each pixel: `planes` bytes, `data[(y * width + x) * planes + p]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Descriptors {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Bytes a pixel.
    pub planes: usize,
    /// The bytes.
    pub data: Vec<u8>,
}

impl Descriptors {
    /// The bytes of the pixel nearest to (x, y) that lies in the image.
    pub fn clamped(&self, x: i64, y: i64) -> &[u8] {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        &self.data[(y * self.width + x) * self.planes..][..self.planes]
    }
}
