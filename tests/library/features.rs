//! The learned costs on devices: every stage equals the reference to the bit, with networks drawn at random and with the one that
//! comes with the library.

use crate::support;
use gpu_stereo::{Census, Cost, FeatureNetwork, Image, Method, Params, Prefilter, RightView, Schedule, wgpu};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Setup = (wgpu::Adapter, wgpu::Device, wgpu::Queue);

fn check((adapter, device, queue): &Setup, left: &Image, right: &Image, params: &Params, seed: u64) {
    let matcher = support::matcher(device, queue, (left.width(), left.height()), left.format(), params).unwrap();
    let case = (left.width(), left.height(), params, seed);
    let stages = matcher.check_blocking(left, right).unwrap();
    support::assert_equal(&stages, adapter, &case);
    for stage in ["feature_statistics", "feature_layer", "features"] {
        assert!(stages.iter().any(|check| check.stage == stage), "no {stage}, case {case:?}");
    }
    let matched = matcher.compute_blocking(left, right).unwrap();
    let expected = gpu_stereo::reference::compute_all(left, right, params).unwrap();
    assert!(matched == expected, "the whole chain differs from the reference, case {case:?}");
}

const COSTS: [Cost; 2] = [Cost::Learned, Cost::LearnedCensus];
const SCHEDULES: [Schedule; 2] = [Schedule::PerThread, Schedule::PerSubgroup];

/// Sgm with a learned cost, a pixel a block.
fn learned(cost: Cost, disparities: u32, network: Option<FeatureNetwork>) -> Params {
    let mut params = Params::sgm(disparities);
    (params.cost, params.features, params.block, params.prefilter) = (cost, network, 1, Prefilter::None);
    params
}

/// One pixel wide or high, odd, narrower than the range; disparities before and behind zero; all four formats; with and without
/// subgroups and shader checks.
#[test]
fn networks_at_random() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    let sizes = [(1, 1), (1, 9), (9, 1), (2, 3), (3, 2), (4, 4), (5, 33), (33, 17), (67, 13), (101, 37)];
    for (seed, (width, height)) in (0..).zip(sizes) {
        let (left, right) = support::pair(width, height, seed);
        let (left, right) = [left, right].map(|image| support::as_format(&image, seed as u32 % 4)).into();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for (i, setup) in [&full, &bare].into_iter().enumerate() {
            for (schedule, cost) in SCHEDULES.into_iter().flat_map(|schedule| COSTS.map(|cost| (schedule, cost))) {
                let network = support::feature_network(&mut random);
                let mut params = learned(cost, [1, 16, 21, 40][random.random_range(0..4)], Some(network));
                params.schedule = schedule;
                params.min_disparity = [0, -3, 5, -70, 1, 2, 3][random.random_range(0..7)];
                params.census = [Census::Five, Census::NineBySeven, Census::CentreSymmetric][random.random_range(0..3)];
                params.shader_checks = (seed + i as u64).is_multiple_of(3);
                params.learned_weight = random.random_range(1..=64);
                check(setup, &left, &right, &params, seed);
            }
        }
    }
}

/// Blocks, block matching and belief propagation; prefilters; a second match.
#[test]
fn other_methods() {
    let Some(setup) = support::device() else { return };
    for seed in 0..8 {
        let (left, right) = support::pair(45, 19, seed);
        let mut random = ChaCha8Rng::seed_from_u64(100 + seed);
        let nth = seed as usize;
        let mut params = learned(COSTS[nth / 3 % 2], 21, Some(support::feature_network(&mut random)));
        params.schedule = SCHEDULES[nth % 2];
        params.method = [Method::Bm, Method::Sgm, Method::Bp, Method::Bm][nth / 2];
        params.block = if nth / 2 == 2 { 1 } else { [1, 5, 17][nth % 3] };
        params.prefilter = [Prefilter::None, Prefilter::XSobel, Prefilter::Normalized][nth % 3];
        params.right_view = [RightView::Diagonal, RightView::Match][nth / 4];
        (params.prefilter_cap, params.min_disparity) = (31, -2);
        check(&setup, &left, &right, &params, seed);
    }
}

/// Bindings so small that planes are made for a few rows at a time.
#[test]
fn pieces_of_few_rows() {
    let small = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 24 << 10);
    let Some(small) = small else { return };
    for seed in 0..6 {
        let (left, right) = support::pair(37, 61, seed);
        let mut random = ChaCha8Rng::seed_from_u64(200 + seed);
        let network = support::feature_network(&mut random);
        let mut params = learned(COSTS[seed as usize / 3], 20, Some(network));
        (params.schedule, params.block) = (SCHEDULES[seed as usize % 2], [1, 1, 3][seed as usize % 3]);
        check(&small, &left, &right, &params, seed);
    }
}

/// The network that comes with the library.
#[test]
fn the_built_in_network() {
    let Some(setup) = support::device() else { return };
    let (left, right) = support::pair(83, 29, 7);
    for (schedule, cost) in SCHEDULES.into_iter().zip(COSTS) {
        let mut params = learned(cost, 33, None);
        params.schedule = schedule;
        check(&setup, &left, &right, &params, 7);
    }
}
