use crate::cpu::instructions::Instructions;
use crate::reference::{Plane, median_spacing, median_weight};
use crate::{DisparityMap, Params};
use rayon::prelude::*;

const INVALID: i16 = DisparityMap::INVALID;

/// Pixels that are computed side by side.
const LANES: usize = 32;

/// The samples around a pixel.
const SAMPLES: usize = 25;

/// The samples of some pixels of a row: values, and weights, 0 of what is invalid or outside.
struct Samples {
    values: [[i32; LANES]; SAMPLES],
    weights: [[u32; LANES]; SAMPLES],
}

impl Samples {
    /// The smallest numbers for which the samples that are not larger have half of the weight: each is the value of a sample.
    #[inline(always)]
    fn medians(&self) -> [i32; LANES] {
        let mut half = [0u32; LANES];
        let (mut low, mut high) = ([i32::MAX; LANES], [i32::MIN; LANES]);
        for (values, weights) in self.values.iter().zip(&self.weights) {
            for i in 0..LANES {
                half[i] += weights[i];
                low[i] = low[i].min(if weights[i] == 0 { i32::MAX } else { values[i] });
                high[i] = high[i].max(if weights[i] == 0 { i32::MIN } else { values[i] });
            }
        }
        half.iter_mut().for_each(|half| *half = half.div_ceil(2));
        let spread = (0..LANES).map(|i| high[i].saturating_sub(low[i])).max().unwrap_or(0);
        // Each round halves what is between them, rounded down.
        for _ in 0..(spread.max(0) as u32).checked_ilog2().map_or(0, |bits| bits + 1) {
            let middle: [i32; LANES] = std::array::from_fn(|i| (low[i] & high[i]) + ((low[i] ^ high[i]) >> 1));
            let mut reached = [0u32; LANES];
            for (values, weights) in self.values.iter().zip(&self.weights) {
                for i in 0..LANES {
                    reached[i] += if values[i] <= middle[i] { weights[i] } else { 0 };
                }
            }
            for i in 0..LANES {
                let enough = reached[i] >= half[i];
                high[i] = if enough { middle[i] } else { high[i] };
                low[i] = if enough { low[i] } else { (middle[i] + 1).min(high[i]) };
            }
        }
        high
    }
}

/// What the rows of the filtered map are made from.
struct Source<'a> {
    map: &'a DisparityMap,
    gray: &'a Plane<u8>,
    spacing: i64,
    weights: [u32; 256],
}

impl Source<'_> {
    #[inline(always)]
    fn row(&self, y: usize, to: &mut [i16], samples: &mut Samples) {
        let (width, height) = (self.gray.width, self.gray.height);
        for (i, to) in to.chunks_mut(LANES).enumerate() {
            let x = LANES * i;
            let own = &self.map.data[y * width + x..][..to.len()];
            if own.iter().all(|&value| value == INVALID) {
                to.fill(INVALID);
                continue;
            }
            for n in 0..SAMPLES {
                let v = y as i64 + (n as i64 / 5 - 2) * self.spacing;
                samples.weights[n] = [0; LANES];
                if (0..height as i64).contains(&v) {
                    self.sample(x, to.len(), [y, v as usize], (n as i64 % 5 - 2) * self.spacing, samples, n);
                }
            }
            let medians = samples.medians();
            for ((to, &own), median) in to.iter_mut().zip(own).zip(medians) {
                *to = if own == INVALID { INVALID } else { median as i16 };
            }
        }
    }

    /// Sample `n` of `count` pixels from x on: row v, `beside` columns beside each.
    #[inline(always)]
    fn sample(&self, x: usize, count: usize, [y, v]: [usize; 2], beside: i64, samples: &mut Samples, n: usize) {
        let width = self.gray.width;
        let first = (-beside - x as i64).clamp(0, count as i64) as usize;
        let end = (width as i64 - beside - x as i64).clamp(first as i64, count as i64) as usize;
        let at = |row: usize, beside: i64| ((row * width + x + first) as i64 + beside) as usize;
        let length = end - first;
        let values = &self.map.data[at(v, beside).min(self.map.data.len() - length)..][..length];
        let grays = &self.gray.data[at(v, beside).min(self.gray.data.len() - length)..][..length];
        let own = &self.gray.data[at(y, 0).min(self.gray.data.len() - length)..][..length];
        let (to, weights) = (&mut samples.values[n][first..end], &mut samples.weights[n][first..end]);
        for i in 0..length {
            to[i] = i32::from(values[i]);
            let weight = self.weights[usize::from(grays[i].max(own[i]) - grays[i].min(own[i]))];
            weights[i] = if values[i] == INVALID { 0 } else { weight };
        }
    }
}

/// [`crate::reference::weighted_median`]: many pixels at once, whose medians are found by halving the range of their samples.
pub(super) fn weighted_median(
    map: &DisparityMap,
    gray: &Plane<u8>,
    radius: u32,
    params: &Params,
    instructions: Instructions,
) -> DisparityMap {
    let weights = std::array::from_fn(|difference| median_weight(difference as u32, params.weighted_median_sigma));
    let source = Source { map, gray, spacing: i64::from(median_spacing(radius)), weights };
    let mut data = vec![0; map.data.len()];
    data.par_chunks_mut(gray.width).enumerate().with_min_len(4).for_each(|(y, to)| {
        let mut samples = Samples { values: [[0; LANES]; SAMPLES], weights: [[0; LANES]; SAMPLES] };
        instructions.run(
            #[inline(always)]
            || source.row(y, to, &mut samples),
        );
    });
    DisparityMap { data, ..*map }
}
