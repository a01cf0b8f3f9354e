//! A calibration of images of another size.

use crate::{Camera, Lens};
use std::str::FromStr;

type Matrix = [f64; 9];

/// The ratio of the images' size to that of the calibrated ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale(pub(super) f64);

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let scale = match text.split_once('/') {
            Some((images, calibrated)) => number(images).zip(number(calibrated)).map(|(a, b)| a / b),
            None => number(text),
        };
        let scale = scale.filter(|scale| (1.0 / 64.0..=64.0).contains(scale));
        scale.map(Self).ok_or_else(|| "a number from 1/64 to 64 is needed, such as 0.5 or 2/3".into())
    }
}

impl Scale {
    /// The images are as large as those that were calibrated.
    pub const ONE: Self = Self(1.0);

    /// A place in the scaled image. 0 is the centre of the first pixel, so that its border lies at -0.5.
    pub(super) fn of_place(self, place: f64) -> f64 {
        if self == Self::ONE { place } else { (place + 0.5) * self.0 - 0.5 }
    }

    /// The size of the images.
    pub(super) fn of_size(self, calibrated: [u32; 2]) -> [u32; 2] {
        calibrated.map(|side| (f64::from(side) * self.0).round().max(1.0) as u32)
    }

    pub(super) fn of_matrix(self, m: Matrix) -> Matrix {
        let row = |i: usize| [m[i] * self.0, m[i + 1] * self.0, self.of_place(m[i + 2])];
        let ([a, b, c], [d, e, f]) = (row(0), row(3));
        [a, b, c, d, e, f, m[6], m[7], m[8]]
    }

    pub(super) fn of_camera(self, camera: Camera) -> Camera {
        let Camera { focal, baseline, doffs, cx, cy } = camera;
        let [cx, cy] = [cx, cy].map(|place| self.of_place(place));
        Camera { focal: focal * self.0, baseline, doffs: doffs * self.0, cx, cy }
    }

    pub(super) fn of_lens(self, lens: &Lens) -> Lens {
        Lens { matrix: self.of_matrix(lens.matrix), projection: self.of_matrix(lens.projection), ..*lens }
    }

    /// Whether images of a side are those of another one, scaled; halves may be rounded either way.
    pub(super) fn fits(self, calibrated: u32, side: u32) -> bool {
        match self {
            Self::ONE => calibrated == side,
            Self(scale) => (f64::from(calibrated) * scale - f64::from(side)).abs() < 1.0,
        }
    }
}

/// A scale as a decimal or a quotient.
pub(super) fn in_words(scale: f64) -> String {
    let quotient =
        |of: u32| (1..=8 * of).find(|n| (f64::from(*n) / f64::from(of) / scale - 1.0).abs() < 0.04).map(|n| (n, of));
    match (1..=8).find_map(quotient) {
        Some((n, of @ (1 | 2 | 4 | 5 | 8))) => (f64::from(n) / f64::from(of)).to_string(),
        Some((n, of)) => format!("{n}/{of}"),
        None => format!("{scale:.3}"),
    }
}
