use super::prefilter::sobel;
use super::{Plane, gray::narrow, window_sum};
use crate::{Census, Cost, Params};

/// What the matching cost compares of each pixel: `planes` bytes, `data[(y * width + x) * planes + p]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Features {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Bytes a pixel.
    pub planes: usize,
    /// The bytes.
    pub data: Vec<u8>,
}

impl Features {
    /// The bytes of the pixel nearest to (x, y) that lies in the image.
    pub fn clamped(&self, x: i64, y: i64) -> &[u8] {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        &self.data[(y * self.width + x) * self.planes..][..self.planes]
    }
}

/// Stage `features`: the bytes of each pixel that [`super::pixel_cost`] compares, from the prefiltered image, or for
/// [`Params::color_cost`] from those of red, green and blue. `unit` is that of [`super::deep_gray`] if the prefilter is
/// `none`, else 1. A value in 8 bits is that image, narrowed as in stage `gray`.
///
/// - `sad`, `ssd`, `ncc`, `mi`: the value;
/// - `zsad`: the value less the mean of the block around it, clamp(round(v - mean), -127, 127) + 127;
/// - `bt`: the value v, and the smallest and the largest of v, floor((v + left) / 2) and floor((v + right) / 2);
/// - `sad-xy`: clamp(gx, -cap, cap) + cap and the same of gy;
/// - `census`: the census string, eight bits a byte;
/// - `census-sobel`: the census string, then as `sad-xy`; `ad-census`: the census string, then the value.
pub fn features(images: &[Plane<u16>], unit: i32, params: &Params) -> Features {
    let (width, height) = (images[0].width, images[0].height);
    let mut data = Vec::new();
    for y in 0..height as i64 {
        for x in 0..width as i64 {
            for image in images {
                let value = |dx: i64| {
                    let v = image.clamped(x + dx, y) as u16;
                    if unit == 1 { v as u8 } else { narrow(v) }
                };
                let gradients = || {
                    let cap = params.prefilter_cap as i32;
                    let (gx, gy) = sobel(image, unit, x, y);
                    [gx, gy].map(|g| (g.clamp(-cap, cap) + cap) as u8)
                };
                match params.cost {
                    Cost::Sad | Cost::Ssd | Cost::Ncc | Cost::MutualInformation => data.push(value(0)),
                    Cost::ZeroMeanSad => {
                        let n = (params.block * params.block) as i32;
                        let excess = n * image.clamped(x, y) - window_sum(image, params.block, x, y);
                        let rounded = (2 * excess + n * unit).div_euclid(2 * n * unit);
                        data.push((rounded.clamp(-127, 127) + 127) as u8);
                    }
                    Cost::BirchfieldTomasi => {
                        let v = value(0);
                        let sides = [-1, 1].map(|dx| ((u32::from(v) + u32::from(value(dx))) / 2) as u8);
                        data.extend([v, v.min(sides[0]).min(sides[1]), v.max(sides[0]).max(sides[1])]);
                    }
                    Cost::SadXy => data.extend(gradients()),
                    Cost::Census => data.extend(census(image, x, y, params.census)),
                    Cost::CensusSobel => {
                        data.extend(census(image, x, y, params.census));
                        data.extend(gradients());
                    }
                    Cost::AdCensus => {
                        data.extend(census(image, x, y, params.census));
                        data.push(value(0));
                    }
                }
            }
        }
    }
    Features { width, height, planes: data.len() / (width * height), data }
}

/// The census string of a pixel as bytes, the last bit lowest in the first byte. The neighbours are taken row by row from
/// the top, in a row from the left, without the centre: 1 where a neighbour is less than the centre. Centre-symmetric: of
/// the first 31 pixels of 9 columns x 7 rows, 1 where one is less than the one opposite to it.
fn census(image: &Plane<u16>, x: i64, y: i64, window: Census) -> Vec<u8> {
    let (columns, rows) = match window {
        Census::Five => (5, 5),
        Census::Seven => (7, 7),
        Census::NineBySeven | Census::CentreSymmetric => (9, 7),
    };
    let centre = columns * rows / 2;
    let at = |i: i64| image.clamped(x + i % columns - columns / 2, y + i / columns - rows / 2);
    let bits: Vec<bool> = match window {
        Census::CentreSymmetric => (0..centre).map(|i| at(i) < at(2 * centre - i)).collect(),
        _ => (0..columns * rows).filter(|&i| i != centre).map(|i| at(i) < at(centre)).collect(),
    };
    let string = bits.iter().fold(0, |string: u64, &bit| string << 1 | u64::from(bit));
    string.to_le_bytes()[..bits.len().div_ceil(8)].into()
}
