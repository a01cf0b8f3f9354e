use super::*;
use crate::{Fill, Median};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sizes of maps: single pixels, rows and columns, and those that vectors do not divide.
const SIZES: [[u32; 2]; 9] = [[1, 1], [1, 9], [9, 1], [2, 2], [31, 5], [32, 17], [33, 40], [67, 23], [130, 19]];

/// A map of planes with noise and holes, which may also be everywhere or nowhere.
fn map(random: &mut ChaCha8Rng, [width, height]: [u32; 2], params: &Params) -> DisparityMap {
    let [holes, noise] = [random.random_range(0..=100), random.random_range(1..100)];
    let (first, count) = (16 * params.min_disparity, 16 * params.disparities as i32);
    let mut base = 0;
    let value = |i: u32| {
        if i.is_multiple_of(7) {
            base = random.random_range(0..count);
        }
        let value = first + (base + random.random_range(0..noise)) % count;
        if random.random_range(0..100) < holes { DisparityMap::INVALID } else { value as i16 }
    };
    DisparityMap { width, height, data: (0..width * height).map(value).collect() }
}

/// All filters, over all instruction sets.
#[test]
fn filters_are_those_of_the_reference() {
    for seed in 0..80 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let size = SIZES[seed as usize % SIZES.len()];
        let mut params = Params::sgm([1, 2, 17, 64][random.random_range(0..4)]);
        params.min_disparity = [0, -9, 30, -2000][random.random_range(0..4)];
        let [left, right] = [(); 2].map(|()| map(&mut random, size, &params));
        let data = (0..size[0] * size[1]).map(|_| random.random()).collect();
        let luma = Plane { width: size[0] as usize, height: size[1] as usize, data };
        params.lr_check = [None, Some(0), Some(1), Some(4095)][random.random_range(0..4)];
        (params.speckle_window, params.speckle_range) = (random.random_range(0..40), random.random_range(0..3));
        params.speckle_range = if random.random_range(0..9) == 0 { 4095 } else { params.speckle_range };
        params.weighted_median = Some(random.random_range(1..=15));
        params.weighted_median_sigma = random.random_range(1..=255);
        params.fill = [Fill::Background, Fill::Rays, Fill::WeightedRays, Fill::Hirschmuller][random.random_range(0..4)];
        params.median = [Median::Three, Median::Five][random.random_range(0..2)];
        for &filter in Filter::ALL {
            let expected = reference::filtered(filter, &left, &right, &luma, &params);
            for instructions in Instructions::all() {
                let got = filtered(filter, &left, &right, &luma, &params, instructions);
                assert!(got == expected, "{filter:?} with {}, seed {seed}, {size:?}, {params:?}", instructions.name());
            }
        }
    }
}
