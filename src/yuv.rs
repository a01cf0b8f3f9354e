//! Y, U and V, as cameras and video decoders give them, and the colours that they stand for.

use crate::{Error, Image, Pixels};

/// What Y, U and V of 8 bits stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum YuvColors {
    /// ITU-R BT.601, Y from 16 to 235, U and V from 16 to 240: cameras, and videos of up to 576 rows.
    Bt601,
    /// ITU-R BT.601, all values from 0 to 255: JPEG.
    Bt601Full,
    /// ITU-R BT.709, Y from 16 to 235, U and V from 16 to 240: videos of more rows.
    Bt709,
    /// ITU-R BT.709, all values from 0 to 255.
    Bt709Full,
}

/// In 1/65536.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// The Y of black.
    pub(crate) zero: i32,
    pub(crate) y: i32,
    pub(crate) v_red: i32,
    pub(crate) u_green: i32,
    pub(crate) v_green: i32,
    pub(crate) u_blue: i32,
}

impl YuvColors {
    /// The nearest to the standards' numbers.
    pub(crate) fn weights(self) -> Weights {
        let (zero, [y, v_red, u_green, v_green, u_blue]) = match self {
            YuvColors::Bt601 => (16, [76_309, 104_597, 25_675, 53_279, 132_201]),
            YuvColors::Bt601Full => (0, [65_536, 91_881, 22_553, 46_802, 116_130]),
            YuvColors::Bt709 => (16, [76_309, 117_489, 13_975, 34_925, 138_438]),
            YuvColors::Bt709Full => (0, [65_536, 103_206, 12_276, 30_679, 121_609]),
        };
        Weights { zero, y, v_red, u_green, v_green, u_blue }
    }

    /// Red, green and blue of Y, U and V: docs/ALGORITHMS.md, Input.
    ///
    /// ```
    /// use gpu_stereo::YuvColors;
    /// assert_eq!(YuvColors::Bt601.rgb([235, 128, 128]), [255, 255, 255]);
    /// assert_eq!(YuvColors::Bt601Full.rgb([76, 85, 255]), [254, 0, 0]);
    /// ```
    pub fn rgb(self, [y, u, v]: [u8; 3]) -> [u8; 3] {
        let Weights { zero, y: of_y, v_red, u_green, v_green, u_blue } = self.weights();
        let gray = of_y * (i32::from(y) - zero);
        let [u, v] = [u, v].map(|value| i32::from(value) - 128);
        [gray + v_red * v, gray - u_green * u - v_green * v, gray + u_blue * u]
            .map(|sum| ((sum + 32_768) >> 16).clamp(0, 255) as u8)
    }

    /// The colours of a picture in NV12: rows of Y, and for each two rows one of pairs of U and V, one for two columns; the last
    /// row and column of an odd side have pairs of their own. Rows are without padding.
    ///
    /// # Errors
    /// [`Error::Image`] if a side is 0, or a plane has not the bytes that the sides need.
    pub fn nv12(self, width: u32, height: u32, luma: &[u8], chroma: &[u8]) -> Result<Image, Error> {
        let [w, h] = [width, height].map(|side| side as usize);
        let row = 2 * w.div_ceil(2);
        check(width, height, ("luma", luma, w as u128 * h as u128))?;
        check(width, height, ("chroma", chroma, row as u128 * h.div_ceil(2) as u128))?;
        self.image(width, height, |x, y| {
            let pair = y / 2 * row + x / 2 * 2;
            [luma[y * w + x], chroma[pair], chroma[pair + 1]]
        })
    }

    /// The colours of a picture in YUYV (YUY2): of each two columns Y, U, Y and V. Rows are without padding; of an odd width the last
    /// Y of a row is ignored.
    ///
    /// # Errors
    /// [`Error::Image`] if a side is 0, or there are not as many bytes as the sides need.
    pub fn yuyv(self, width: u32, height: u32, bytes: &[u8]) -> Result<Image, Error> {
        let row = 4 * (width as usize).div_ceil(2);
        check(width, height, ("a picture", bytes, row as u128 * u128::from(height)))?;
        self.image(width, height, |x, y| {
            let four = y * row + x / 2 * 4;
            [bytes[four + x % 2 * 2], bytes[four + 1], bytes[four + 3]]
        })
    }

    fn image(self, width: u32, height: u32, at: impl Fn(usize, usize) -> [u8; 3]) -> Result<Image, Error> {
        let mut samples = Vec::with_capacity(4 * width as usize * height as usize);
        for y in 0..height as usize {
            for x in 0..width as usize {
                let [red, green, blue] = self.rgb(at(x, y));
                samples.extend([red, green, blue, 255]);
            }
        }
        Image::new(width, height, Pixels::Rgba8(samples))
    }
}

fn check(width: u32, height: u32, (what, bytes, needed): (&str, &[u8], u128)) -> Result<(), Error> {
    if width > 0 && height > 0 && bytes.len() as u128 == needed {
        return Ok(());
    }
    Err(Error::Image(format!(
        "{what} of {width}x{height} was given {} bytes; both sides must be at least 1 and the bytes {needed}, rows without padding",
        bytes.len()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [YuvColors; 4] = [YuvColors::Bt601, YuvColors::Bt601Full, YuvColors::Bt709, YuvColors::Bt709Full];

    /// Within a level of the standards' formulas, of all values.
    #[test]
    fn colours_are_those_of_the_standards() {
        for colors in ALL {
            let (red, blue) = match colors {
                YuvColors::Bt601 | YuvColors::Bt601Full => (0.299, 0.114),
                _ => (0.2126, 0.0722),
            };
            let full = matches!(colors, YuvColors::Bt601Full | YuvColors::Bt709Full);
            let [zero, of_y, of_c] = if full { [0.0, 1.0, 1.0] } else { [16.0, 255.0 / 219.0, 255.0 / 224.0] };
            for i in 0..1 << 24 {
                let [y, u, v, _] = u32::to_le_bytes(i);
                let gray = of_y * (f64::from(y) - zero);
                let [pb, pr] = [u, v].map(|value| of_c * (f64::from(value) - 128.0));
                let [r, b] = [gray + 2.0 * (1.0 - red) * pr, gray + 2.0 * (1.0 - blue) * pb];
                let g = (gray - red * r - blue * b) / (1.0 - red - blue);
                let got = colors.rgb([y, u, v]);
                for (got, exact) in got.into_iter().zip([r, g, b]) {
                    let far = (f64::from(got) - exact.clamp(0.0, 255.0)).abs();
                    assert!(far < 0.51, "{colors:?} {y} {u} {v}: {got} for {exact}");
                }
            }
        }
    }

    #[test]
    fn planes_are_read_where_they_are() {
        let luma = [1, 2, 3, 4, 5, 6, 7, 8, 9];
        let chroma = [10, 20, 30, 40, 50, 60, 70, 80];
        let of = |y, u, v| YuvColors::Bt709.rgb([y, u, v]);
        let image = YuvColors::Bt709.nv12(3, 3, &luma, &chroma).unwrap();
        let Pixels::Rgba8(samples) = image.pixels() else { panic!("{image:?}") };
        assert_eq!(samples[4 * 4..4 * 4 + 3], of(5, 10, 20));
        assert_eq!(samples[4 * 5..4 * 5 + 3], of(6, 30, 40));
        assert_eq!(samples[4 * 8..4 * 8 + 4], [of(9, 70, 80).as_slice(), &[255]].concat());
        let image = YuvColors::Bt709.yuyv(3, 1, &[1, 10, 2, 20, 3, 30, 4, 40]).unwrap();
        let Pixels::Rgba8(samples) = image.pixels() else { panic!("{image:?}") };
        assert_eq!(samples[4..7], of(2, 10, 20));
        assert_eq!(samples[8..11], of(3, 30, 40));
        for error in [
            YuvColors::Bt601.nv12(3, 3, &luma[1..], &chroma),
            YuvColors::Bt601.nv12(3, 3, &luma, &luma),
            YuvColors::Bt601.nv12(0, 3, &[], &[]),
            YuvColors::Bt601.yuyv(3, 1, &luma),
            YuvColors::Bt601.yuyv(u32::MAX, u32::MAX, &luma),
        ] {
            let text = error.unwrap_err().to_string();
            assert!(text.contains("bytes; both sides"), "{text}");
        }
    }
}
