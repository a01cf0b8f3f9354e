//! Every stage of every chain equals the reference to the bit, on awkward sizes and random parameters.
#![allow(clippy::unwrap_used)]

mod support;

use gpu_stereo::{Image, Params, Paths, Prefilter, StereoMatcher, wgpu};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn check(setup: &(wgpu::Adapter, wgpu::Device, wgpu::Queue), left: &Image, right: &Image, params: &Params, seed: u64) {
    let (adapter, device, queue) = setup;
    let (width, height) = (left.width(), left.height());
    let matcher = StereoMatcher::new(device, queue, width, height, left.format(), params).unwrap();
    let case = (width, height, params, seed);
    support::assert_equal(&matcher.check(left, right).unwrap(), adapter, &case);
    let map = matcher.compute(left, right).unwrap();
    let expected = gpu_stereo::reference::compute(left, right, params).unwrap();
    assert!(map == expected, "the whole chain differs from the reference, case {case:?}");
}

/// One pixel wide or high, odd, narrower than the disparity range, not a multiple of a word or a workgroup.
const SIZES: [(u32, u32); 12] =
    [(1, 1), (1, 9), (9, 1), (2, 2), (3, 5), (5, 33), (31, 32), (32, 31), (33, 17), (64, 40), (67, 13), (101, 37)];

#[test]
fn awkward_sizes() {
    let Some(setup) = support::device() else { return };
    for (seed, (width, height)) in (0..).zip(SIZES) {
        let (left, right) = support::pair(width, height, seed);
        for paths in [Paths::Four, Paths::Eight] {
            let mut params = Params::sgm(40);
            params.paths = paths;
            check(&setup, &left, &right, &params, seed);
        }
        check(&setup, &left, &right, &Params::bm(21), seed);
        check(&setup, &left, &right, &Params::bm(150), seed);
        for min_disparity in [-3, 1, 3, 6] {
            let mut params = Params::bm(14);
            params.min_disparity = min_disparity;
            check(&setup, &left, &right, &params, seed);
        }
    }
}

#[test]
fn random_parameters() {
    let Some(setup) = support::device() else { return };
    for seed in 0..40 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let params = support::random_params(&mut random);
        let (left, right) = support::pair(random.random_range(1..90), random.random_range(1..50), seed);
        let format = random.random_range(0..4);
        check(&setup, &support::as_format(&left, format), &support::as_format(&right, format), &params, seed);
    }
}

/// The extremes of what an accumulator holds.
#[test]
fn largest_sums() {
    let Some(setup) = support::device() else { return };
    let (left, right) = support::pair(61, 23, 7);
    for paths in [Paths::Four, Paths::Eight] {
        for mut params in [Params::sgm(20), Params::bm(20)] {
            params.paths = paths;
            params.block = 51;
            params.prefilter = Prefilter::None;
            params.p1 = 127;
            params.p2 = 127;
            check(&setup, &left, &right, &params, 7);
        }
    }
    // Every cost the largest, and a uniqueness limit beyond all that the keys hold.
    let image = |value| Image::new(61, 23, gpu_stereo::Pixels::Gray8(vec![value; 61 * 23])).unwrap();
    for disparities in [1, 2, 3, 17] {
        for mut params in [Params::sgm(disparities), Params::bm(disparities)] {
            (params.block, params.prefilter, params.uniqueness) = (51, Prefilter::None, 99);
            check(&setup, &image(0), &image(255), &params, 0);
        }
    }
}

/// Sides that no texture has: the planes stay in buffers.
#[test]
fn long_sides() {
    let setup = support::device_with(|limits| limits.max_texture_dimension_2d = 2048);
    let Some(setup) = setup else { return };
    for (seed, (width, height)) in (0..).zip([(3, 2100), (9001, 3), (33_001, 2)]) {
        let (left, right) = support::pair(width, height, seed);
        check(&setup, &left, &right, &Params::sgm(9), seed);
        check(&setup, &left, &right, &Params::bm(9), seed);
    }
}

/// A device whose bindings are so small that volumes are cut into many bands.
#[test]
fn bands() {
    let setup = support::device_with(|limits| limits.max_storage_buffer_binding_size = 24 << 10);
    let Some(setup) = setup else { return };
    for (seed, (width, height)) in (0..).zip([(40, 37), (7, 61), (61, 50)]) {
        let (left, right) = support::pair(width, height, seed);
        for paths in [Paths::Four, Paths::Eight] {
            let mut params = Params::sgm(35);
            params.paths = paths;
            params.min_disparity = -3;
            check(&setup, &left, &right, &params, seed);
        }
        check(&setup, &left, &right, &Params::bm(35), seed);
    }
}
