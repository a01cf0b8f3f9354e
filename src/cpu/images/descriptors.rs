//! Stage `descriptors`, as planes.

use crate::Params;
use crate::cpu::features::FeatureRows;
use crate::cpu::images::channels::Channels;
use crate::cpu::images::derivatives::{Depth, derivatives};
use crate::cpu::images::padded::{MARGIN, Padded, Samples};
use crate::cpu::images::planes::{Planes, RowOfPlanes, Side, census_neighbours};
use crate::cpu::images::prefilter::window_sums;
use crate::params::Descriptor;

impl Channels {
    /// What the cost compares of one side, of which these are the features, if it compares such.
    pub fn planes(&self, side: Side, features: Option<&FeatureRows>, params: &Params) -> Planes {
        let instructions = self.instructions();
        let (width, height) = match &self.channels[0] {
            Samples::Bytes(image) => (image.width, image.height),
            Samples::Words(image) => (image.width, image.height),
        };
        let neighbours = census_neighbours(params);
        Planes::from_rows(width, height, side, params, |y, row| {
            let y = y as i64;
            instructions.run(
                #[inline(always)]
                || {
                    for samples in self.channels.iter().chain(&self.gray) {
                        match samples {
                            Samples::Bytes(image) => describe(image, y, params, &neighbours, features, row),
                            Samples::Words(image) => describe(image, y, params, &neighbours, features, row),
                        }
                    }
                },
            );
        })
    }
}

/// The planes of one channel.
#[inline(always)]
fn describe<T: Depth>(
    image: &Padded<T>,
    y: i64,
    params: &Params,
    census: &[[[i64; 2]; 2]],
    features: Option<&FeatureRows>,
    row: &mut RowOfPlanes<'_>,
) {
    for descriptor in params.cost.row().descriptors {
        match descriptor {
            Descriptor::Value => {
                let values = image.row(y, 0);
                row.next(|out| out.iter_mut().zip(values).for_each(|(out, value)| *out = value.narrow()));
            }
            Descriptor::Gradients => {
                let cap = params.prefilter_cap as i16;
                let clip = |v: i16| (v.clamp(-cap, cap) + cap) as u8;
                row.next(|out| derivatives(image, y, out, |gx, _| clip(gx)));
                row.next(|out| derivatives(image, y, out, |_, gy| clip(gy)));
            }
            Descriptor::Interval => interval(image, y, row),
            Descriptor::Excess => row.next(|out| excess(image, y, params, out)),
            Descriptor::Features => {
                let rows = features.into_iter().flat_map(|features| features.row(y as usize));
                rows.for_each(|feature| row.next(|out| out.copy_from_slice(feature)));
            }
            Descriptor::Census => census.chunks(8).for_each(|eight| row.next(|out| bits(image, y, eight, out))),
        }
    }
}

/// Up to eight bits of the census string: each is 1 where the first neighbour, `[dx, dy]`, is less than the second.
#[inline(always)]
fn bits<T: Depth>(image: &Padded<T>, y: i64, pairs: &[[[i64; 2]; 2]], out: &mut [u8]) {
    out.fill(0);
    for (bit, &[first, second]) in pairs.iter().enumerate() {
        let [first, second] = [first, second].map(|[dx, dy]| image.row(y + dy, dx));
        set_bits(first, second, 1 << bit, out);
    }
}

/// Sets a bit where the first value is less than the second.
#[inline(always)]
fn set_bits<T: Depth>(first: &[T], second: &[T], bit: u8, out: &mut [u8]) {
    for ((out, first), second) in out.iter_mut().zip(first).zip(second) {
        *out |= if first < second { bit } else { 0 };
    }
}

/// floor((a + b) / 2).
#[inline(always)]
fn mean(a: u8, b: u8) -> u8 {
    (a & b) + ((a ^ b) >> 1)
}

/// The value, and the smallest and the largest of it and the means of it and its neighbours.
#[inline(always)]
fn interval<T: Depth>(image: &Padded<T>, y: i64, row: &mut RowOfPlanes<'_>) {
    let three = [-1, 0, 1].map(|dx| image.row(y, dx));
    let each = |x: usize| {
        let [left, v, right] = three.map(|row| row[x].narrow());
        (v, mean(v, left), mean(v, right))
    };
    row.next(|out| out.iter_mut().enumerate().for_each(|(x, out)| *out = each(x).0));
    row.next(|out| {
        for (x, out) in out.iter_mut().enumerate() {
            let (v, left, right) = each(x);
            *out = v.min(left).min(right);
        }
    });
    row.next(|out| {
        for (x, out) in out.iter_mut().enumerate() {
            let (v, left, right) = each(x);
            *out = v.max(left).max(right);
        }
    });
}

/// The value less the mean of the block around it.
fn excess<T: Depth>(image: &Padded<T>, y: i64, params: &Params, out: &mut [u8]) {
    let n = (params.block * params.block) as i32;
    let mut sums = vec![0; image.width];
    window_sums(image, params.block as usize, y, &mut sums);
    for ((out, &value), sum) in out.iter_mut().zip(image.row(y, 0)).zip(sums) {
        let excess = n * value.into() - sum;
        let rounded = (2 * excess + n * T::UNIT).div_euclid(2 * n * T::UNIT);
        *out = (rounded.clamp(-127, 127) + 127) as u8;
    }
}

const _: () = assert!(MARGIN > Params::MAX_BLOCK as usize / 2, "the largest window reaches that far");
