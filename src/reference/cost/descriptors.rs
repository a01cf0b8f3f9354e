use crate::params::{Census, Descriptor, Params};
use crate::reference::images::prefilter::sobel;
use crate::reference::{Descriptors, Images, Plane, features_of, images::gray::narrow, window_sum};

impl Images {
    /// What the cost compares of them.
    pub fn descriptors(&self, params: &Params) -> Descriptors {
        let features = params.feature_network().map(|network| features_of(&self.channels[0], self.unit, &network));
        self.described(features.as_ref(), params)
    }

    /// The same, with their features, if the cost compares such.
    pub(crate) fn described(&self, features: Option<&Descriptors>, params: &Params) -> Descriptors {
        let images: Vec<&Plane<u16>> = self.channels.iter().chain(&self.gray).collect();
        descriptors(&images, self.unit, features, params)
    }
}

/// Stage `descriptors`: the bytes of each pixel that [`crate::reference::pixel_cost`] compares, from the prefiltered image, or for
/// [`Params::color_cost`] from those of red, green and blue. `unit` is that of [`crate::reference::deep_gray`] if the prefilter is
/// `none`, else 1. With the cost `bt-gray` luma, brought to this unit, follows the prefiltered image. A value in 8 bits is that image, narrowed as in stage `gray`.
///
/// - `sad`, `ssd`, `ncc`, `mi`: the value;
/// - `zsad`: the value less the mean of the block around it, clamp(round(v - mean), -127, 127) + 127;
/// - `bt`, `bt-gray`: the value v, and the smallest and the largest of v, floor((v + left) / 2) and floor((v + right) / 2);
/// - `sad-xy`: clamp(gx, -cap, cap) + cap and the same of gy;
/// - `census`: the census string;
/// - `census-sobel`: the census string, then as `sad-xy`; `ad-census`: the census string, then the value;
/// - `learned`: the pixel's `features`; `learned-census`: those of `census-sobel`, then the features.
pub fn descriptors(images: &[&Plane<u16>], unit: i32, features: Option<&Descriptors>, params: &Params) -> Descriptors {
    let (width, height) = (images[0].width, images[0].height);
    let mut data = Vec::new();
    for y in 0..height as i64 {
        for x in 0..width as i64 {
            for image in images {
                let value = |dx: i64| {
                    let v = image.clamped(x + dx, y) as u16;
                    if unit == 1 { v as u8 } else { narrow(v) }
                };
                for descriptor in params.cost.row().descriptors {
                    match descriptor {
                        Descriptor::Value => data.push(value(0)),
                        Descriptor::Excess => {
                            let n = (params.block * params.block) as i32;
                            let excess = n * image.clamped(x, y) - window_sum(image, params.block, x, y);
                            let rounded = (2 * excess + n * unit).div_euclid(2 * n * unit);
                            data.push((rounded.clamp(-127, 127) + 127) as u8);
                        }
                        Descriptor::Interval => {
                            let v = value(0);
                            let sides = [-1, 1].map(|dx| ((u32::from(v) + u32::from(value(dx))) / 2) as u8);
                            data.extend([v, v.min(sides[0]).min(sides[1]), v.max(sides[0]).max(sides[1])]);
                        }
                        Descriptor::Gradients => {
                            let cap = params.prefilter_cap as i32;
                            let (gx, gy) = sobel(image, unit, x, y);
                            data.extend([gx, gy].map(|g| (g.clamp(-cap, cap) + cap) as u8));
                        }
                        Descriptor::Census => data.extend(census(image, x, y, params.census)),
                        Descriptor::Features => data.extend(features.iter().flat_map(|all| all.clamped(x, y))),
                    }
                }
            }
        }
    }
    Descriptors { width, height, planes: data.len() / (width * height), data }
}

/// The census string of a pixel, a byte a row of the window from the top: bit 4 + dx is 1 where the neighbour dx columns
/// to the right is less than the centre, which is never less than itself. For the fifth column to the right of 9 there
/// is a last byte: its bit p belongs to row p.
///
/// Centre-symmetric: of 9 columns x 7 rows only the three rows above the centre, and a bit is 1 where a neighbour is less
/// than the one opposite to it. Bits 3 to 6 of the last byte belong to the row of the centre, to dx = -4 to -1.
fn census(image: &Plane<u16>, x: i64, y: i64, window: Census) -> Vec<u8> {
    let at = |dx: i64, dy: i64| image.clamped(x + dx, y + dy);
    let (side, above, below) = match window {
        Census::Five => (2, 2, 2),
        Census::Seven => (3, 3, 3),
        Census::NineBySeven => (4, 3, 3),
        Census::CentreSymmetric => (4, 3, -1),
    };
    let symmetric = window == Census::CentreSymmetric;
    let less = |dx: i64, dy: i64| u8::from(at(dx, dy) < if symmetric { at(-dx, -dy) } else { at(0, 0) });
    let rows = -above..=below;
    let mut bytes: Vec<u8> =
        rows.clone().map(|dy| (-side..=side.min(3)).map(|dx| less(dx, dy) << (4 + dx)).sum()).collect();
    if side == 4 {
        let last: u8 = rows.map(|dy| less(4, dy) << (dy + above)).sum();
        let beside: u8 = (-4..0).map(|dx| less(dx, 0) << (7 + dx)).sum();
        bytes.push(if symmetric { last + beside } else { last });
    }
    bytes
}
