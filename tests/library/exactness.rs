//! Every stage of every chain equals the reference to the bit, on awkward sizes and random parameters. What the native schedule
//! gives is compared beside what the device gives, and stage by stage where the settings are random.

use crate::support;
use gpu_stereo::{
    Camera, Cost, Error, Fill, Image, Median, Params, Paths, Prefilter, Preset, Rectification, RightView, Schedule,
    Smoothness, StereoMatcher, Wls, reference, wgpu,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn check(setup: &(wgpu::Adapter, wgpu::Device, wgpu::Queue), left: &Image, right: &Image, params: &Params, seed: u64) {
    let (adapter, device, queue) = setup;
    let (width, height) = (left.width(), left.height());
    let mut params = params.clone();
    let roomy = device.limits().max_storage_buffer_binding_size >= 1 << 20; // maps lie behind each other in one binding
    params.labels = roomy && seed % 2 == 1;
    let params = &params;
    let matcher = support::matcher(device, queue, (width, height), left.format(), params).unwrap();
    let case = (width, height, params, seed);
    support::assert_equal(&matcher.check_blocking(left, right).unwrap(), adapter, &case);
    let matched = matcher.compute_blocking(left, right).unwrap();
    let expected = gpu_stereo::reference::compute_all(left, right, params).unwrap();
    assert!(matched == expected, "the whole chain differs from the reference, case {case:?}");
    support::assert_native(left, right, params, &expected, &case);
}

/// One pixel wide or high, odd, narrower than the disparity range, not a multiple of a word or a workgroup.
const SIZES: [(u32, u32); 12] =
    [(1, 1), (1, 9), (9, 1), (2, 2), (3, 5), (5, 33), (31, 32), (32, 31), (33, 17), (64, 40), (67, 13), (101, 37)];

const PATHS: [Paths; 5] = [Paths::Three, Paths::Four, Paths::Five, Paths::Eight, Paths::Sixteen];

/// Both schedules, with subgroups and 64-bit integers and without.
#[test]
fn awkward_sizes() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    for (seed, (width, height)) in (0..).zip(SIZES) {
        let (left, right) = support::pair(width, height, seed);
        for (setup, schedule) in
            [&full, &bare].into_iter().flat_map(|s| [(s, Schedule::PerThread), (s, Schedule::PerSubgroup)])
        {
            for (i, paths) in PATHS.into_iter().enumerate() {
                let mut params = Params::sgm(40);
                (params.paths, params.schedule) = (paths, schedule);
                params.adaptive_p2 = (seed as usize + i).is_multiple_of(2);
                params.adaptive_p1 = (seed as usize + i) % 3 == 1;
                params.passes = 1 + (seed as u32 + i as u32) / 2 % 2;
                check(setup, &left, &right, &params, seed);
            }
            for (disparities, min_disparity) in [(21, 0), (150, 0), (14, -3), (14, 1), (14, 3), (14, 6)] {
                let mut params = Params::bm(disparities);
                (params.min_disparity, params.schedule) = (min_disparity, schedule);
                check(setup, &left, &right, &params, seed);
            }
        }
    }
}

/// So many disparities that invocations share them, on either schedule; even and odd numbers of vectors, and members
/// that have none.
#[test]
fn shared_disparities() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    for (seed, disparities) in (0..).zip([97, 128, 193, 300]) {
        let (left, right) = support::pair(131, 9, seed);
        for (setup, schedule) in
            [(&full, Schedule::PerThread), (&full, Schedule::PerSubgroup), (&bare, Schedule::PerSubgroup)]
        {
            let block = if disparities == 193 { 17 } else { 5 };
            let mut params = if disparities == 128 { Params::bm(disparities) } else { Params::sgm(disparities) };
            (params.schedule, params.block, params.min_disparity) = (schedule, block, -70);
            check(setup, &left, &right, &params, seed);
        }
    }
}

/// Belief propagation: every smoothness, levels down to a single pixel, shared disparities, bands, both schedules.
#[test]
fn belief_propagation() {
    let small = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 96 << 10);
    let (Some(full), Some(bare), Some(small)) = (support::device(), support::bare_device(), small) else { return };
    let kinds = [Smoothness::Linear, Smoothness::Quadratic, Smoothness::Potts];
    for (seed, (width, height)) in (0..).zip(SIZES) {
        let (left, right) = support::pair(width, height, seed);
        let nth = seed as usize;
        for (i, setup, schedule) in [(0, &full, Schedule::PerThread), (1, &bare, Schedule::PerSubgroup)] {
            let mut params = Params::bp([40, 17, 1, 97][(nth + i) % 4]);
            (params.schedule, params.smoothness) = (schedule, kinds[(nth + i) % 3]);
            (params.bp_levels, params.bp_iterations) = (1 + (3 * nth + i) as u32 % 10, 1 + nth as u32 % 5);
            (params.smoothness_weight, params.smoothness_truncation) = [(8, 40), (3, 127), (1, 20)][nth % 3];
            params.smoothness_edge = [None, Some(12)][(nth + i) % 2];
            params.bp_reweighting = [8, 16, 5][nth / 3 % 3];
            params.min_disparity = [0, -7, 3][nth / 2 % 3];
            params.confidence = nth % 4 == 1;
            check(setup, &left, &right, &params, seed);
        }
    }
    // Bands of a few rows, whose pixels send into each other.
    for (seed, (width, height), levels) in [(30, (31, 75), 3), (31, (18, 60), 4), (32, (45, 23), 1)] {
        let (left, right) = support::pair(width, height, seed);
        let mut params = Params::bp(21);
        (params.bp_levels, params.bp_iterations, params.smoothness_edge) = (levels, 6, Some(20));
        params.schedule = [Schedule::PerThread, Schedule::PerSubgroup][seed as usize % 2];
        check(&small, &left, &right, &params, seed);
    }
    // The extremes: the longest reach, no smoothness at all, and so many disparities that members share them in each way.
    let (left, right) = support::pair(39, 12, 40);
    for (setup, schedule, disparities, kind, weight, truncation) in [
        (&full, Schedule::PerSubgroup, 130, Smoothness::Linear, 1, 127),
        (&full, Schedule::PerThread, 300, Smoothness::Linear, 2, 127),
        (&full, Schedule::PerThread, 130, Smoothness::Quadratic, 1, 127),
        (&bare, Schedule::PerSubgroup, 60, Smoothness::Linear, 127, 127),
        (&full, Schedule::PerThread, 20, Smoothness::Quadratic, 0, 90),
        (&full, Schedule::PerThread, 20, Smoothness::Linear, 5, 0),
    ] {
        let mut params = Params::bp(disparities);
        (params.schedule, params.smoothness, params.bp_iterations) = (schedule, kind, 4);
        (params.smoothness_weight, params.smoothness_truncation) = (weight, truncation);
        params.shader_checks = disparities == 60;
        check(setup, &left, &right, &params, 40);
    }
}

/// More disparities than loops are unrolled for: lavapipe leaves an invocation after 65,535 rounds of its loops.
#[test]
fn a_long_row_of_many_disparities_is_finished() {
    let Some(setup) = support::bare_device() else { return };
    let (left, right) = support::pair(400, 2, 3);
    for mut params in [Params::sgm(530), Params::bm(530)] {
        params.schedule = Schedule::PerThread;
        check(&setup, &left, &right, &params, 3);
    }
}

/// The right view from a second match: odd widths, every format, bands, both methods.
#[test]
fn second_match() {
    let small = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 48 << 10);
    let (Some(full), Some(small)) = (support::device(), small) else { return };
    for (seed, (width, height)) in (0..).zip([(1, 1), (2, 5), (15, 4), (16, 3), (17, 9), (31, 8), (49, 20), (61, 33)]) {
        let (left, right) = support::pair(width, height, seed);
        let format = seed as u32 % 4;
        let (left, right) = (support::as_format(&left, format), support::as_format(&right, format));
        for (i, mut params) in [Params::sgm(21), Params::bm(21), {
            let mut wide = Params::sgm(21);
            wide.block = 17;
            wide
        }]
        .into_iter()
        .enumerate()
        {
            params.min_disparity = [0, -4, 3][(seed as usize + i) % 3];
            (params.right_view, params.adaptive_p2) = (RightView::Match, true);
            (params.adaptive_p1, params.passes) = (seed % 2 == 0, 1 + seed as u32 % 2);
            check(if seed % 3 == 0 { &small } else { &full }, &left, &right, &params, seed);
        }
    }
}

/// Of the native schedule every stage, without a device.
#[test]
fn native_stages() {
    for seed in 100..160 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = support::random_params(&mut random);
        let (left, right) = support::pair(random.random_range(1..90), random.random_range(1..50), seed);
        let format = random.random_range(0..4);
        params.masks = (seed % 4 == 3).then(|| support::masks(left.width(), left.height(), seed));
        params.labels = seed % 2 == 1;
        let [left, right] = [left, right].map(|image| support::as_format(&image, format));
        support::check_native(&left, &right, &params, &(left.width(), left.height(), &params, seed));
    }
}

#[test]
fn random_parameters() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    for seed in 0..40 {
        let setup = if seed % 3 == 0 { &bare } else { &full };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = support::random_params(&mut random);
        let (left, right) = support::pair(random.random_range(1..90), random.random_range(1..50), seed);
        let format = random.random_range(0..4);
        params.masks = (seed % 4 == 3).then(|| support::masks(left.width(), left.height(), seed));
        check(setup, &support::as_format(&left, format), &support::as_format(&right, format), &params, seed);
    }
}

/// Mutual information: images that are halved never, once, twice and, long ones, never; maps that are halved once, or not.
#[test]
fn mutual_information() {
    let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else { return };
    let sizes = [(1, 1), (1, 9), (9, 1), (50, 40), (67, 65), (64, 71), (131, 140), (20_000, 1), (1, 20_000)];
    for (seed, (width, height)) in (0..).zip(sizes) {
        let (left, right) = support::pair(width, height, seed);
        for (i, setup, schedule) in
            [(0, &full, Schedule::PerThread), (1, &full, Schedule::PerSubgroup), (2, &bare, Schedule::Auto)]
        {
            let mut params = if i == 1 { Params::bm(21) } else { Params::sgm(21) };
            (params.cost, params.schedule) = (Cost::MutualInformation, schedule);
            params.block = [1, 5, 17][(seed as usize + i) % 3];
            params.min_disparity = [0, -7, 3][(seed as usize + i / 2) % 3];
            params.prefilter = [Prefilter::None, Prefilter::XSobel][seed as usize % 2];
            params.shader_checks = seed % 3 == 0 && width < 1000;
            params.lr_check = if seed % 4 == 2 { None } else { Some(1) };
            params.right_view = if seed % 3 == 1 { RightView::Match } else { RightView::Diagonal };
            params.adaptive_p2 = seed % 2 == 0;
            (params.adaptive_p1, params.passes) = (seed % 3 == 0, 1 + seed as u32 % 2);
            let [left, right] = [&left, &right].map(|image| support::as_format(image, (seed as u32 + i as u32) % 4));
            check(setup, &left, &right, &params, seed);
        }
    }
}

/// So many pixels that their counts are narrowed.
#[test]
fn mutual_information_of_a_large_pair() {
    let Some(setup) = support::device() else { return };
    let (left, right) = support::pair(1301, 1201, 1);
    let mut params = Params::sgm(8);
    (params.cost, params.block, params.prefilter) = (Cost::MutualInformation, 1, Prefilter::None);
    check(&setup, &left, &right, &params, 1);
}

/// The extremes of what an accumulator holds.
#[test]
fn largest_sums() {
    let Some(setup) = support::device() else { return };
    let (left, right) = support::pair(61, 23, 7);
    for paths in PATHS {
        for mut params in [Params::sgm(20), Params::bm(20)] {
            params.paths = paths;
            params.block = 51;
            params.prefilter = Prefilter::None;
            params.p1 = 127;
            params.p2 = 127;
            check(&setup, &left, &right, &params, 7);
        }
    }
    // Blocks of black and white, which correlate wholly, in part, and not at all.
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let bits: Vec<bool> = (0..61 * 23).map(|i| random.random() || i % 61 > 45).collect();
    let image = |on: u8| {
        Image::new(61, 23, gpu_stereo::Pixels::Gray8(bits.iter().map(|&bit| if bit { on } else { !on }).collect()))
    };
    for (block, right) in [(3, 0), (19, 0), (19, 255)] {
        let mut params = ncc(20);
        (params.prefilter, params.block) = (Prefilter::None, block);
        check(&setup, &image(0).unwrap(), &image(right).unwrap(), &params, 7);
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
    let setup = support::device_with(|_, limits| limits.max_texture_dimension_2d = 2048);
    let Some(setup) = setup else { return };
    for (seed, (width, height)) in (0..).zip([(3, 2100), (9001, 3), (33_001, 2)]) {
        let (left, right) = support::pair(width, height, seed);
        check(&setup, &left, &right, &Params::sgm(9), seed);
        check(&setup, &left, &right, &Params::bm(9), seed);
    }
}

fn ncc(disparities: u32) -> Params {
    let mut params = Params::bm(disparities);
    params.cost = Cost::Ncc;
    params
}

/// The longest rows: lavapipe leaves an invocation after 65,535 rounds of its loops.
#[test]
fn longest_rows() {
    let Some(setup) = support::device() else { return };
    let (adapter, device, queue) = &setup;
    for (seed, (width, height)) in (0..).zip([(40_000, 2), (60_000, 1), (1, 60_000)]) {
        let (left, right) = support::pair(width, height, seed);
        let cases = [(Params::sgm(5), -2047), (Params::bm(5), -2047), (Params::bm(16), 500), (Params::bm(32), 2000)];
        for (mut params, min_disparity) in cases {
            params.min_disparity = min_disparity;
            let matcher = support::matcher(device, queue, (width, height), left.format(), &params).unwrap();
            support::assert_equal(&matcher.check_blocking(&left, &right).unwrap(), adapter, &(width, height, &params));
        }
    }
    // An adaptive P2 is loaded now and then, and that must take no round of its own.
    for (seed, (width, height)) in (10..).zip([(60_000, 3), (58_257, 1), (3, 60_000)]) {
        let (left, right) = support::pair(width, height, seed);
        for (schedule, min_disparity) in
            [(Schedule::PerThread, 0), (Schedule::PerThread, 2000), (Schedule::PerSubgroup, -2047)]
        {
            let mut params = Params::sgm(6);
            (params.adaptive_p2, params.schedule, params.min_disparity) = (true, schedule, min_disparity);
            (params.adaptive_p1, params.passes) = (seed % 2 == 0, 2);
            check(&setup, &left, &right, &params, seed);
        }
    }
    let (adapter, device, queue) = setup;
    let (params, format) = (Params::sgm(5), gpu_stereo::PixelFormat::Gray8);
    let refused = StereoMatcher::new(&device, &queue, 60_001, 1, format, &params).unwrap_err();
    assert!(refused.to_string().contains("60000"), "{refused}");
    // With checks some loops stay loops: what would not be finished is refused, what is taken is right.
    for (width, mut params, schedule, taken) in [
        (13_000, Params::sgm(33), Schedule::PerThread, true),
        (1638, Params::sgm(128), Schedule::PerThread, true),
        (13_000, Params::sgm(17), Schedule::PerSubgroup, true),
        (1638, Params::sgm(2000), Schedule::PerThread, false),
        (2184, Params::bm(90), Schedule::PerThread, true),
        (5000, ncc(64), Schedule::PerThread, true),
        (1560, ncc(90), Schedule::PerThread, true),
        (13_000, ncc(64), Schedule::PerSubgroup, true),
    ] {
        (params.shader_checks, params.schedule, params.block) = (true, schedule, 15);
        let (left, right) = support::pair(width, 2, 3);
        let matcher = StereoMatcher::new(&device, &queue, width, 2, left.format(), &params);
        match matcher {
            Ok(matcher) if taken => {
                support::assert_equal(&matcher.check_blocking(&left, &right).unwrap(), &adapter, &(width, 2, &params));
            }
            Err(error) if !taken => assert!(error.to_string().contains("shader checks"), "{error}"),
            other => panic!("{params:?}: {:?}", other.err()),
        }
    }
}

/// A device whose bindings are so small that volumes are cut into many bands.
#[test]
fn bands() {
    let setup = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 24 << 10);
    let Some(setup) = setup else { return };
    for (seed, (width, height)) in (0..).zip([(40, 37), (7, 61), (61, 50)]) {
        let (left, right) = support::pair(width, height, seed);
        for (i, paths) in PATHS.into_iter().chain([Paths::Eight, Paths::Sixteen]).enumerate() {
            let mut params = Params::sgm(35);
            params.paths = paths;
            params.schedule = if i < PATHS.len() { Schedule::PerThread } else { Schedule::PerSubgroup };
            params.adaptive_p2 = i.is_multiple_of(2);
            (params.adaptive_p1, params.passes) = (i % 3 == 0, 1 + (i as u32 + seed as u32) % 2);
            params.min_disparity = -3;
            check(&setup, &left, &right, &params, seed);
        }
        for params in [Params::bm(35), ncc(35)] {
            check(&setup, &left, &right, &params, seed);
        }
    }
}

/// Images of which a binding holds a part of the rows: planes in pieces, maps by lots, trees in parts, whatever follows.
#[test]
fn images_beyond_a_binding() {
    let setup = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 28 << 10);
    let Some(setup) = setup else { return };
    let camera = Camera::new(700.0, 0.2);
    for (seed, (width, height)) in (0..).zip([(45, 320), (31, 500), (13, 1000)]) {
        let (left, right) = support::pair(width, height, seed);
        for (i, preset) in [Preset::Balanced, Preset::Dense, Preset::Strict, Preset::Classic].into_iter().enumerate() {
            let format = (seed as u32 + i as u32) % 4;
            let [left, right] = [&left, &right].map(|image| support::as_format(image, format));
            let mut params = Params::preset(preset, 20);
            params.schedule = [Schedule::PerThread, Schedule::PerSubgroup][(seed as usize + i) % 2];
            params.wls = (i % 2 == 0).then(Wls::default);
            params.depth = (i % 2 == 1).then_some(camera);
            params.texture = if i == 3 { 40 } else { 0 };
            params.median = if i == 1 { Median::Five } else { Median::Three };
            params.fill = [Fill::WeightedRays, params.fill, Fill::None, Fill::Hirschmuller][i];
            (params.right_map, params.min_disparity) = (i == 0, [0, -3, 2, 0][i]);
            params.adaptive_p1 = false; // two penalties a step are more than such a binding holds
            check(&setup, &left, &right, &params, seed);
        }
        for (block, schedule) in [(9, Schedule::PerThread), (9, Schedule::PerSubgroup), (17, Schedule::PerThread)] {
            let mut params = Params::bm(20);
            (params.block, params.schedule, params.fill) = (block, schedule, Fill::Rays);
            check(&setup, &left, &right, &params, seed);
        }
        check(&setup, &left, &right, &ncc(20), seed);
        let mut wide = Params::sgm(20);
        (wide.block, wide.color_cost) = (19, true);
        check(&setup, &support::as_format(&left, 2), &support::as_format(&right, 2), &wide, seed);
    }
}

/// Random settings on images beyond a binding: right, or refused in bytes.
#[test]
fn random_parameters_beyond_a_binding() {
    let setup = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 24 << 10);
    let Some(setup) = setup else { return };
    let mut taken = 0;
    for seed in 100..130 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let params = support::random_params(&mut random);
        let (width, height) = (random.random_range(1..47), random.random_range(200..420));
        let (left, right) = support::pair(width, height, seed);
        let format = random.random_range(0..4);
        let [left, right] = [&left, &right].map(|image| support::as_format(image, format));
        match support::matcher(&setup.1, &setup.2, (width, height), left.format(), &params) {
            Err(Error::TooLarge { .. }) => continue,
            _ => check(&setup, &left, &right, &params, seed),
        }
        taken += 1;
    }
    assert!(taken >= 8, "{taken} of 30 settings were taken");
}

/// Pairs that are rectified first: every format, with a second match and without; the picture is not the given one.
#[test]
fn rectified() {
    let Some(setup) = support::device() else { return };
    for (seed, (width, height)) in (0..).zip([(1, 1), (3, 5), (33, 17), (64, 40), (67, 13), (1, 9), (101, 37), (9, 1)])
    {
        let (left, right) = support::pair(width, height, seed);
        for format in 0..4 {
            let [left, right] = [&left, &right].map(|image| support::as_format(image, format));
            let mut params = Params::sgm(20);
            let rectification = Rectification::new(width, height, support::lenses(width, height)).unwrap();
            let given = reference::rectify(&left, &rectification, 0).unwrap();
            assert!(given != left || width < 10, "{width}x{height} in format {format}");
            params.rectify = Some(rectification);
            params.right_view = if seed % 2 == 0 { RightView::Match } else { RightView::Diagonal };
            params.cost = if format == 3 { Cost::MutualInformation } else { Cost::Census };
            check(&setup, &left, &right, &params, seed);
        }
    }
}

/// Pairs of which parts are masked: sizes, formats, both schedules, bands, a right view of its own, rounds that are halved,
/// with a rectification and without.
#[test]
fn masked() {
    let small = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 48 << 10);
    let (Some(full), Some(bare), Some(small)) = (support::device(), support::bare_device(), small) else { return };
    for (seed, (width, height)) in (0..).zip(SIZES) {
        let (left, right) = support::pair(width, height, seed);
        let [left, right] = [&left, &right].map(|image| support::as_format(image, seed as u32 % 4));
        let choices = [
            (Preset::Dense, &full, Schedule::PerThread, Cost::CensusSobel, seed % 2 == 0),
            (Preset::Balanced, &bare, Schedule::PerSubgroup, Cost::Sad, false),
            (Preset::Classic, &small, Schedule::Auto, Cost::Sad, seed % 2 == 1),
            (Preset::Strict, &full, Schedule::PerSubgroup, Cost::MutualInformation, false),
        ];
        for (preset, setup, schedule, cost, rectifies) in choices {
            let mut params = Params::preset(preset, 24);
            (params.schedule, params.cost, params.min_disparity) = (schedule, cost, [0, -5, 2][seed as usize % 3]);
            (params.right_map, params.confidence, params.uniqueness) = (true, true, 0);
            params.wls = (seed % 3 == 0).then(|| Wls::new(50.0, 20.0));
            params.masks = Some(support::masks(width, height, seed));
            if rectifies {
                params.rectify = Some(Rectification::new(width, height, support::lenses(width, height)).unwrap());
            }
            check(setup, &left, &right, &params, seed);
        }
    }
}

/// Rounds of mutual information whose images are halved once and twice, of odd sizes.
#[test]
fn masked_mutual_information() {
    let Some(setup) = support::device() else { return };
    for (seed, (width, height)) in (0..).zip([(35, 33), (67, 71), (131, 140)]) {
        let (left, right) = support::pair(width, height, seed);
        for right_view in [RightView::Diagonal, RightView::Match] {
            let mut params = Params::sgm(21);
            (params.cost, params.prefilter, params.block) = (Cost::MutualInformation, Prefilter::None, 1);
            (params.right_view, params.min_disparity) = (right_view, -3);
            params.masks = Some(support::masks(width, height, seed));
            check(&setup, &left, &right, &params, seed);
        }
    }
}
