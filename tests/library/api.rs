//! The library inside another program: its errors, its promises about the caller's encoder and device, and the proof
//! that the check finds a single wrong value.

use std::collections::{BTreeMap, BTreeSet};

use crate::support;
use gpu_stereo::cpu::CpuMatcher;
use gpu_stereo::reference::{self, Direction, Volume};
use gpu_stereo::{
    Camera, Cost, DepthMap, DisparityMap, Error, Image, Inputs, Matched, Median, Method, Outputs, Params, Paths,
    PixelFormat, Pixels, Prefilter, Preset, StageCheck, StageTime, StereoMatcher, StereoStream, StreamFrame, Subpixel,
    Wls, wgpu,
};

type Change = fn(&mut Params);

/// Each row of [`Params::validate`]: what is set, the parameter's name, the value given, and what is allowed.
const REFUSED: &[(Change, &str, &str, &str)] = &[
    (|p| p.min_disparity = -2048, "min-disp", "-2048", "-2047 to 2047"),
    (|p| p.min_disparity = 2048, "min-disp", "2048", "-2047 to 2047"),
    (|p| p.min_disparity = i32::MIN, "min-disp", "-2147483648", "-2047 to 2047"),
    (|p| p.disparities = 0, "disp", "0", "1 to 2048"),
    (|p| p.disparities = 2049, "disp", "2049", "1 to 2048"),
    (|p| p.disparities = u32::MAX, "disp", "4294967295", "1 to 2048"),
    (|p| (p.min_disparity, p.disparities) = (2040, 9), "disp", "9", "1 to 8"),
    (|p| p.block = 0, "block", "0", "odd and from 1 to 51"),
    (|p| p.block = 4, "block", "4", "odd and from 1 to 51"),
    (|p| p.block = 53, "block", "53", "odd and from 1 to 51"),
    (|p| p.prefilter_cap = 0, "prefilter-cap", "0", "1 to 127"),
    (|p| p.prefilter_cap = 128, "prefilter-cap", "128", "1 to 127"),
    (|p| p.p2 = 128, "p2", "128", "p1 to 127"),
    (|p| p.passes = 0, "passes", "0", "1 or 2"),
    (|p| p.passes = 3, "passes", "3", "1 or 2"),
    (|p| (p.method, p.passes, p.p2) = (Method::Sgm, 2, 111), "p2", "111", "p1 to 110 with passes 2 and cost sad"),
    (|p| (p.p1, p.p2) = (8, 7), "p1", "8", "0 to p2, which is 7"),
    (|p| p.smoothness_weight = 128, "smoothness-weight", "128", "0 to 127"),
    (|p| p.smoothness_truncation = 128, "smoothness-truncation", "128", "0 to 127"),
    (|p| p.smoothness_edge = Some(0), "smoothness-edge", "0", "off or from 1 to 255"),
    (|p| p.smoothness_edge = Some(256), "smoothness-edge", "256", "off or from 1 to 255"),
    (|p| p.bp_levels = 0, "bp-levels", "0", "1 to 10"),
    (|p| p.bp_levels = 11, "bp-levels", "11", "1 to 10"),
    (|p| p.bp_iterations = 0, "bp-iterations", "0", "1 to 1000"),
    (|p| p.bp_iterations = 1001, "bp-iterations", "1001", "1 to 1000"),
    (|p| p.bp_reweighting = 3, "bp-reweighting", "3", "4 to 16"),
    (|p| p.bp_reweighting = 17, "bp-reweighting", "17", "4 to 16"),
    (|p| p.uniqueness = 100, "uniqueness", "100", "0 (off) to 99"),
    (|p| p.lr_check = Some(4096), "lr-check", "4096", "0 to 4095"),
    (|p| p.prefilter_window = 1, "prefilter-window", "1", "odd and from 3 to 51"),
    (|p| p.prefilter_window = 8, "prefilter-window", "8", "odd and from 3 to 51"),
    (|p| p.ad_weight = 65, "ad-weight", "65", "0 to 64"),
    (|p| p.census_weight = 65, "census-weight", "65", "0 to 64"),
    (|p| p.learned_weight = 65, "learned-weight", "65", "0 to 64 64ths"),
    (|p| (p.learned_weight, p.census_weight) = (0, 0), "learned-weight", "0", "more than 0 if census-weight is 0"),
    (|p| p.p2_step = 0, "p2-step", "0", "from 1 to 255"),
    (|p| p.p2_step = 256, "p2-step", "256", "from 1 to 255"),
    (|p| p.texture = 330_328, "texture", "330328", "0 (off) to 330327"),
    (|p| p.speckle_window = 1 << 31, "speckle-window", "2147483648", "0 (off) to 2147483647"),
    (|p| p.speckle_range = 4096, "speckle-range", "4096", "0 to 4095"),
    (|p| p.weighted_median = Some(0), "weighted-median", "0", "off, or a radius from 1 to 15"),
    (|p| p.weighted_median = Some(16), "weighted-median", "16", "off, or a radius from 1 to 15"),
    (|p| p.weighted_median_sigma = 0, "weighted-median-sigma", "0", "1 to 255"),
    (|p| p.weighted_median_sigma = 256, "weighted-median-sigma", "256", "1 to 255"),
    (|p| p.wls = Some(Wls::new(-1.0, 1.0)), "wls-lambda", "-1", "0 to 1000000"),
    (|p| p.wls = Some(Wls::new(f32::NAN, 1.0)), "wls-lambda", "NaN", "0 to 1000000"),
    (|p| p.wls = Some(Wls::new(1.0, f32::INFINITY)), "wls-sigma", "inf", "0.1 to 1000"),
    (|p| p.wls = Some(Wls::new(1.0, -1.0)), "wls-sigma", "-1", "0.1 to 1000"),
    (|p| (p.method, p.cost) = (Method::Sgm, Cost::Ncc), "cost", "ncc", "another one with method sgm"),
    (|p| (p.method, p.cost) = (Method::Bp, Cost::Ncc), "cost", "ncc", "another one with method bp"),
    (|p| (p.method, p.cost, p.block) = (Method::Bm, Cost::Ncc, 1), "block", "1", "3 to 19 with cost ncc"),
    (|p| (p.method, p.cost, p.block) = (Method::Bm, Cost::Ncc, 21), "block", "21", "3 to 19 with cost ncc"),
    (|p| (p.color_cost, p.cost) = (true, Cost::Census), "color-cost", "on", "off with cost census"),
];

#[test]
fn a_refused_parameter_is_named_with_what_is_allowed() {
    let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor::default());
    let (left, right) = support::pair(4, 4, 0);
    for &(change, name, given, allowed) in REFUSED {
        for mut params in [Params::sgm(16), Params::bm(16)] {
            change(&mut params);
            let errors = [
                params.validate().unwrap_err(),
                StereoMatcher::new(&device, &queue, 4, 4, PixelFormat::Gray8, &params).unwrap_err(),
                reference::compute(&left, &right, &params).unwrap_err(),
                CpuMatcher::new(4, 4, PixelFormat::Gray8, &params).unwrap_err(),
            ];
            for error in errors {
                assert!(matches!(error, Error::Parameter { .. }), "{error:?}");
                let message = error.to_string();
                assert!(message.starts_with(&format!("{name} is {given}, but must be ")), "{message}");
                assert!(message.contains(allowed), "{message:?} does not say {allowed:?}");
                assert!(!message.contains('\n') && message.contains("; "), "no remedy, or no line: {message:?}");
            }
        }
    }
}

/// The last value that each rule allows, on both sides.
#[test]
fn the_ends_of_the_ranges_are_allowed() {
    let ends: [Change; 13] = [
        |p| (p.min_disparity, p.disparities) = (-2047, 4095),
        |p| (p.min_disparity, p.disparities) = (2047, 1),
        |p| p.disparities = 1,
        |p| p.disparities = 2048,
        |p| p.block = 1,
        |p| p.block = 51,
        |p| p.prefilter_cap = 1,
        |p| p.prefilter_cap = 127,
        |p| (p.p1, p.p2) = (0, 0),
        |p| (p.p1, p.p2) = (127, 127),
        |p| p.uniqueness = 99,
        |p| p.texture = Params::MAX_TEXTURE,
        |p| p.lr_check = Some(4095),
    ];
    let setup = support::device();
    let (left, right) = support::pair(21, 5, 4);
    for change in ends {
        for mut params in [Params::sgm(16), Params::bm(16)] {
            change(&mut params);
            let expected = reference::compute(&left, &right, &params).unwrap();
            if params.disparities > 256 {
                // Mesa's CPU driver takes minutes to compile these: what wgpu makes of them is all that is tested.
                let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor::default());
                StereoMatcher::new(&device, &queue, 21, 5, left.format(), &params).unwrap();
                continue;
            }
            let Some((_, device, queue)) = &setup else { continue };
            let matcher = support::matcher(device, queue, (21, 5), left.format(), &params).unwrap();
            assert!(matcher.compute_blocking(&left, &right).unwrap().map == expected, "{params:?}, seed 4");
        }
    }
}

#[test]
fn images_of_the_wrong_size_or_format_are_refused() {
    let message = |error: Error| {
        assert!(matches!(error, Error::Image(_)), "{error:?}");
        error.to_string()
    };
    let refused = [
        (0, 1, Pixels::Gray8(vec![])),
        (1, 0, Pixels::Gray16(vec![])),
        (2, 2, Pixels::Gray8(vec![0; 3])),
        (2, 2, Pixels::Gray8(vec![0; 5])),
        (u32::MAX, u32::MAX, Pixels::Gray8(vec![0])),
        (2, 2, Pixels::Rgba8(vec![0; 12])),
        (2, 2, Pixels::Rgba8(vec![0; 17])), // a pixel and a quarter too many
        (2, 2, Pixels::Rgba16(vec![0; 19])),
    ];
    for (width, height, pixels) in refused {
        let case = format!("{width}x{height} from {pixels:?}");
        match Image::new(width, height, pixels) {
            Ok(_) => panic!("{case} was accepted"),
            Err(error) => assert!(message(error).contains(&format!("{width}x{height}")), "{case}"),
        }
    }

    let (left, right) = support::pair(8, 6, 0);
    let (other, _) = support::pair(8, 5, 0);
    let colour = support::as_format(&left, 2);
    let params = Params::sgm(16);
    let text = message(reference::compute(&left, &other, &params).unwrap_err());
    assert!(text.contains("8x6") && text.contains("8x5"), "{text}");

    let Some((_, device, queue)) = support::device() else { return };
    for (width, height) in [(0, 6), (8, 0), (70_000, 1), (1, 70_000)] {
        let matcher = StereoMatcher::new(&device, &queue, width, height, PixelFormat::Gray8, &params);
        let text = message(matcher.unwrap_err());
        assert!(text.contains(&format!("{width}x{height}")), "{text}");
    }
    let matcher = StereoMatcher::new(&device, &queue, 8, 6, PixelFormat::Gray8, &params).unwrap();
    for (left, right, expected) in [
        (&left, &other, ["8x6", "8x5"]),
        (&other, &other, ["8x5", "8x6"]),
        (&colour, &colour, ["Rgba8", "Gray8"]),
        (&left, &colour, ["Rgba8", "Gray8"]),
    ] {
        for error in [
            matcher.upload(left, right).unwrap_err(),
            matcher.compute_blocking(left, right).unwrap_err(),
            matcher.compute_timed_blocking(left, right).unwrap_err(),
            matcher.check_blocking(left, right).unwrap_err(),
        ] {
            let text = message(error);
            assert!(expected.iter().all(|part| text.contains(part)), "{text:?} does not say {expected:?}");
        }
    }
    assert!(matcher.compute_blocking(&left, &right).is_ok(), "a refused pair spoilt the matcher");
}

/// The matcher without a device: pairs that it was not made for, other sizes and settings, times, and spoilt stages.
#[test]
fn a_matcher_without_a_device() {
    let (left, right) = support::pair(33, 21, 3);
    let (other, _) = support::pair(33, 20, 3);
    let colour = support::as_format(&left, 2);
    let mut params = Params::preset(Preset::Balanced, 16);
    (params.confidence, params.depth) = (true, Some(Camera::new(700.0, 0.2)));
    let mut matcher = CpuMatcher::new(33, 21, PixelFormat::Gray8, &params).unwrap();
    for (left, right, words) in [
        (&left, &other, ["33x21", "33x20"]),
        (&other, &other, ["33x20", "33x21"]),
        (&left, &colour, ["Rgba8", "Gray8"]),
    ] {
        let errors = [matcher.compute(left, right).unwrap_err(), matcher.check(left, right).unwrap_err()];
        for error in errors {
            assert!(matches!(error, Error::Image(_)) && words.iter().all(|word| error.to_string().contains(word)));
        }
    }
    let expected = reference::compute_all(&left, &right, &params).unwrap();
    let (matched, times) = matcher.compute_timed(&left, &right).unwrap();
    assert!(matched == expected);
    assert_eq!(times.iter().map(|time| time.name.as_str()).filter(|name| *name == "median").count(), 1, "{times:?}");

    let stages = matcher.check(&left, &right).unwrap();
    let names: Vec<&str> = stages.iter().map(|stage| stage.stage.as_str()).collect();
    for name in
        ["matching_cost", "sgm_aggregate", "winner", "lr_check", "speckle", "median", "confidence", "depth", "maps"]
    {
        assert!(names.contains(&name), "{name} is not in {names:?}");
        // A single bit of a single number is found in its stage, and in no other.
        let spoilt = matcher.check_with(&left, &right, |stage, bytes| bytes[11] ^= u8::from(stage == name)).unwrap();
        let wrong: Vec<_> = spoilt.iter().filter(|stage| stage.mismatches > 0).collect();
        assert!(wrong.len() == 1 && wrong[0].stage == name && wrong[0].mismatches == 1, "{name}: {wrong:?}");
    }

    matcher.set_params(&Params::bm(9)).unwrap();
    matcher.resize(33, 20).unwrap();
    assert!(
        matcher.set_params(&Params::bm(0)).is_err() && matcher.params().disparities == 9 && matcher.size() == [33, 20]
    );
    let expected = reference::compute_all(&other, &other, &Params::bm(9)).unwrap();
    assert!(matcher.compute(&other, &other).unwrap() == expected);
}

#[test]
fn what_does_not_fit_the_device_is_told_in_bytes() {
    let setup = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 24 << 10);
    let Some((_, device, queue)) = setup else { return };
    let mut confident = Params::bm(1);
    confident.confidence = true;
    let cases = [
        (200, 200, PixelFormat::Gray8, Params::sgm(1), 64 * 400, 24 << 10), // 64 rows of a map
        (100, 100, PixelFormat::Rgba8, confident, 64 << 10, 24 << 10), // two maps of 208 * 100, both in units of 16 KiB
        (100, 2, PixelFormat::Gray8, Params::sgm(500), 64 << 10, 16 << 10), // 100 * 512, both in units of 16 KiB
        (40, 20, PixelFormat::Gray8, Params::bp(16), 48 << 10, 16 << 10), // four volumes of 16 rows of 41 * 16, the same
    ];
    for (width, height, format, params, bytes, most) in cases {
        let error = StereoMatcher::new(&device, &queue, width, height, format, &params).unwrap_err();
        let Error::TooLarge { needed, allowed, .. } = error else { panic!("{error:?}") };
        assert_eq!((needed, allowed), (bytes, most), "{error}");
        let text = error.to_string();
        assert!(text.contains(&needed.to_string()) && text.contains(&allowed.to_string()), "{text}");
    }
}

#[test]
fn a_device_without_the_limits_is_told_all_that_it_lacks() {
    let setup = support::device_with(|_, limits| {
        limits.max_storage_buffers_per_shader_stage = 2;
        limits.max_compute_invocations_per_workgroup = 8;
    });
    let Some((_, device, queue)) = setup else { return };
    let error = StereoMatcher::new(&device, &queue, 8, 8, PixelFormat::Gray8, &Params::sgm(16)).unwrap_err();
    assert!(matches!(error, Error::Device(_)), "{error:?}");
    for part in ["max_storage_buffers_per_shader_stage is 2", "max_compute_invocations_per_workgroup is 8"] {
        assert!(error.to_string().contains(part), "{error}");
    }
}

/// No more is needed than every WebGPU device has.
#[test]
fn webgpu_default_limits_suffice() {
    let setup = support::device_with(|_, limits| *limits = wgpu::Limits::default());
    let Some((adapter, device, queue)) = setup else { return };
    let (left, right) = support::pair(70, 50, 11);
    for mut params in [Params::sgm(130), Params::bm(130)] {
        params.paths = Paths::Eight;
        let matcher = support::matcher(&device, &queue, (70, 50), left.format(), &params).unwrap();
        support::assert_equal(&matcher.check_blocking(&left, &right).unwrap(), &adapter, &(&params, 11));
        assert!(
            matcher.compute_blocking(&left, &right).unwrap().map == reference::compute(&left, &right, &params).unwrap()
        );
    }
}

#[test]
fn matchers_may_be_sent_and_shared() {
    fn send_and_sync<T: Send + Sync + 'static>() {}
    send_and_sync::<StereoMatcher>();
    send_and_sync::<CpuMatcher>();
    send_and_sync::<StereoStream>();
    send_and_sync::<StreamFrame>();
    send_and_sync::<(Params, Image, Matched, StageCheck, StageTime)>();
    send_and_sync::<(Inputs<'static>, Outputs<'static>)>();
    send_and_sync::<Error>();
}

/// The bytes of a buffer, by the caller's own means.
fn download(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &wgpu::Buffer) -> Vec<u8> {
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
    queue.submit([encoder.finish()]);
    staging.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    staging.get_mapped_range(..).unwrap().to_vec()
}

/// `record` only records: nothing happens before the caller submits, and then `output` holds what `compute` returns,
/// laid out as its documentation says.
#[test]
fn record_leaves_the_submission_to_the_caller() {
    let Some((_, device, queue)) = support::device() else { return };
    for (seed, width) in [(1, 33), (2, 40)] {
        let (left, right) = support::pair(width, 21, seed);
        for params in [Params::sgm(24), Params::bm(24)] {
            let matcher = StereoMatcher::new(&device, &queue, width, 21, left.format(), &params).unwrap();
            let sentinel = vec![0x5a; matcher.output().size() as usize];
            queue.write_buffer(matcher.output(), 0, &sentinel);

            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            matcher.upload(&left, &right).unwrap();
            matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
            assert!(download(&device, &queue, matcher.output()) == sentinel, "something was submitted, {params:?}");
            queue.submit([encoder.finish()]);
            let bytes = download(&device, &queue, matcher.output());

            let expected = matcher.compute_blocking(&left, &right).unwrap().map;
            let stride = (2 * width as usize).next_multiple_of(16);
            assert!(bytes.len() >= 21 * stride, "each row is padded to a multiple of 16 bytes");
            for (row, expected) in bytes.chunks_exact(stride).zip(expected.data.chunks_exact(width as usize)) {
                let row: Vec<i16> = row.chunks_exact(2).map(|v| i16::from_le_bytes([v[0], v[1]])).collect();
                assert_eq!(row[..width as usize], *expected, "{params:?}, seed {seed}");
            }
        }
    }
}

/// Two frames of two matchers in one encoder of the caller's.
#[test]
fn several_matchers_share_an_encoder() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(48, 19, 6);
    let chains = [Params::sgm(20), Params::bm(31)];
    let matchers =
        chains.clone().map(|params| StereoMatcher::new(&device, &queue, 48, 19, left.format(), &params).unwrap());
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    for matcher in &matchers {
        matcher.upload(&left, &right).unwrap();
        matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
    }
    queue.submit([encoder.finish()]);
    for (matcher, params) in matchers.iter().zip(&chains) {
        let expected = reference::compute(&left, &right, params).unwrap();
        let bytes = download(&device, &queue, matcher.output());
        let data: Vec<i16> = bytes.chunks_exact(2).map(|v| i16::from_le_bytes([v[0], v[1]])).collect();
        assert!(data[..expected.data.len()] == expected.data, "{params:?}, seed 6");
    }
}

#[test]
fn timings_name_the_stages_and_change_nothing() {
    let Some((adapter, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(50, 30, 8);
    for params in [Params::sgm(16), Params::bm(16)] {
        let matcher = StereoMatcher::new(&device, &queue, 50, 30, left.format(), &params).unwrap();
        let stages: Vec<String> = matcher.check_blocking(&left, &right).unwrap().into_iter().map(|s| s.stage).collect();
        for _ in 0..2 {
            let (matched, times) = matcher.compute_timed_blocking(&left, &right).unwrap();
            assert!(matched.map == matcher.compute_blocking(&left, &right).unwrap().map, "{params:?}, seed 8");
            if adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
                let names: Vec<&String> = times.iter().map(|time| &time.name).collect();
                assert_eq!(names, stages.iter().collect::<Vec<_>>());
                assert!(times.iter().all(|time| time.ms >= 0.0 && time.ms.is_finite()), "{times:?}");
            } else {
                assert!(times.is_empty(), "times without timestamps: {times:?}");
            }
        }
    }
}

/// A device that is gone is an error of the call, not a panic of the caller's error handler.
#[test]
fn a_destroyed_device_is_an_error() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(20, 10, 0);
    let params = Params::sgm(16);
    let matcher = StereoMatcher::new(&device, &queue, 20, 10, left.format(), &params).unwrap();
    device.destroy();
    for result in [
        matcher.compute_blocking(&left, &right).map(|_| ()),
        matcher.compute_timed_blocking(&left, &right).map(|_| ()),
        matcher.check_blocking(&left, &right).map(|_| ()),
        StereoMatcher::new(&device, &queue, 20, 10, left.format(), &params).map(|_| ()),
    ] {
        let error = result.unwrap_err();
        assert!(matches!(error, Error::Lost(_)), "{error:?}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }
}

/// What the reference says of an element of a stage's first buffer.
fn expected_values(left: &Image, right: &Image, params: &Params) -> impl Fn(&str, u32, u32, Option<u32>) -> i64 {
    let gray = reference::gray(left, reference::Channel::Luma);
    let prefiltered = [left, right].map(|image| reference::images(image, params).prefiltered(params));
    let descriptors = [0, 1].map(|side: usize| prefiltered[side].descriptors(params));
    let columns = reference::cost_columns(&descriptors[0], &descriptors[1], &[], params);
    let cost = reference::matching_cost(&columns, params);
    let paths = [0, 1].map(|i| reference::aggregate_direction(&cost, None, Direction::all(params.paths)[i], params));
    let sum = reference::sgm_aggregate(&cost, None, params);
    let winner = reference::winner(&sum, params);
    let block_match = reference::block_match(&columns, None, params);
    let finished = reference::compute(left, right, params).unwrap();
    let views = if params.method == gpu_stereo::Method::Sgm { winner.clone() } else { block_match.clone() };
    let checked = reference::lr_check(&views.left, &views.right, params.lr_check.unwrap());
    let radius = i64::from(params.block / 2);
    move |stage, x, y, d| {
        fn volume<T: Copy + Into<i64>>(volume: &Volume<T>, x: u32, y: u32, d: Option<u32>) -> i64 {
            let (x, y, d) = (x as usize, y as usize, d.expect("a value for each disparity") as usize);
            volume.data[(y * volume.width + x) * volume.disparities + d].into()
        }
        let map = |map: &DisparityMap| i64::from(map.data[(y * map.width + x) as usize]);
        match stage {
            "gray" => gray.clamped(i64::from(x) - 16, y.into()).into(),
            "prefilter" => descriptors[0].clamped(i64::from(x) - radius, y.into())[0].into(),
            "cost_columns" => volume(&columns, x, y, d),
            "matching_cost" => volume(&cost, x, y, d),
            // The device keeps L - C, of two directions together.
            "sgm_aggregate" => paths.iter().map(|path| volume(path, x, y, d) - volume(&cost, x, y, d)).sum(),
            "winner" => map(&winner.left),
            "block_match" => map(&block_match.left),
            "lr_check" => map(&checked),
            "median" => map(&finished),
            other => panic!("no reference for {other}: add it here"),
        }
    }
}

/// Where the check has found what was spoilt, of each stage: y, x and d.
type Reached = BTreeMap<String, BTreeSet<(u32, u32, Option<u32>)>>;

/// Every byte in use of every stage's first buffer, spoilt: one mismatch in that stage, at a place where the reference has the value
/// that the mismatch says, and none in a stage that is not spoilt; none for padding. Each element is reached.
#[test]
fn the_check_finds_each_spoilt_byte() {
    let Some((_, device, queue)) = support::device() else { return };
    let (width, height, seed) = (3, 3, 12);
    let (left, right) = support::pair(width, height, seed);
    for mut params in [Params::sgm(3), Params::bm(3)] {
        (params.block, params.min_disparity, params.prefilter_cap) = (3, -1, 90);
        let expected = expected_values(&left, &right, &params);
        let matcher = StereoMatcher::new(&device, &queue, width, height, left.format(), &params).unwrap();
        let mut lengths: BTreeMap<String, usize> = BTreeMap::new();
        let clean = matcher
            .check_with(&left, &right, |stage, bytes| {
                lengths.entry(stage.into()).or_insert(bytes.len());
            })
            .unwrap();
        assert!(clean.iter().all(|stage| stage.mismatches == 0), "{clean:?}");
        assert_eq!(lengths.len(), clean.len(), "a stage reads nothing back");

        // Byte `at` of the stages that are `wanted`: what the check finds.
        let mut reached: Reached = BTreeMap::new();
        let spoil = |at: usize, wanted: &dyn Fn(&str) -> bool, reached: &mut Reached| {
            let mut spoilt = BTreeSet::new();
            let stages = matcher
                .check_with(&left, &right, |stage, bytes| {
                    if wanted(stage) && at < lengths[stage] && spoilt.insert(stage.to_string()) {
                        bytes[at] ^= 0x41;
                    }
                })
                .unwrap();
            for stage in &stages {
                let case = format!("byte {at} of {spoilt:?} spoilt, {params:?}, seed {seed}: {stages:?}");
                let Some(found) = stage.first.filter(|_| spoilt.contains(stage.stage.as_str())) else {
                    assert_eq!((stage.mismatches, stage.first), (0, None), "{case}");
                    continue;
                };
                assert_eq!(stage.mismatches, 1, "{case}");
                assert_eq!(found.expected, expected(&stage.stage, found.x, found.y, found.d), "{case}");
                let change = (found.expected ^ found.got) & 0xffff;
                assert!(change == 0x41 || change == 0x4100, "{case}");
                reached.entry(stage.stage.clone()).or_default().insert((found.y, found.x, found.d));
            }
        };
        // Each alone, then all together. All that is in use lies in the first KiB; of the padding after it, every 509th byte.
        for (alone, &length) in &lengths {
            (0..length.min(16)).for_each(|at| spoil(at, &|stage| stage == alone, &mut reached));
            assert!(reached.contains_key(alone), "no byte of {alone} that is in use was spoilt alone");
        }
        let longest = lengths.values().copied().max().unwrap();
        (0..1024).chain((1024..longest).step_by(509)).for_each(|at| spoil(at, &|_| true, &mut reached));

        for stage in &clean {
            let (spoilt, elements, reached) = (&stage.stage, stage.elements, &reached[&stage.stage]);
            assert!(reached.len() > 1 && reached.len() as u64 <= elements, "{spoilt}: {reached:?}");
            let (last_y, ..) = reached.last().unwrap();
            assert_eq!(*last_y, height - 1, "{spoilt}: {reached:?}");
            // A stage with a disparity each has all of them at each place.
            let places: BTreeSet<_> = reached.iter().map(|(y, x, _)| (y, x)).collect();
            let disparities: BTreeSet<_> = reached.iter().map(|(_, _, d)| d).collect();
            assert_eq!(reached.len(), places.len() * disparities.len(), "{spoilt}: {reached:?}");
        }
    }
}

/// The confidence beside the map: only where it is asked for, the reference's, and 0 just where there is no disparity.
#[test]
fn the_confidence_comes_with_the_map() {
    let (left, right) = support::pair(61, 23, 6);
    for mut params in [Params::sgm(16), Params::bm(16)] {
        params.texture = 100;
        assert_eq!(reference::compute_all(&left, &right, &params).unwrap().confidence, None);
        params.confidence = true;
        let expected = reference::compute_all(&left, &right, &params).unwrap();
        assert_eq!(expected.map, reference::compute(&left, &right, &params).unwrap());
        let confidence = expected.confidence.as_ref().unwrap();
        let zeros = confidence.data.iter().map(|&c| c == 0);
        assert!(zeros.eq(expected.map.data.iter().map(|&v| v == DisparityMap::INVALID)), "{params:?}, seed 6");
        let kinds: BTreeSet<u8> = confidence.data.iter().copied().collect();
        assert!(kinds.len() > 20, "only {kinds:?} for {params:?}, seed 6");

        let Some((_, device, queue)) = support::device() else { continue };
        let matcher = StereoMatcher::new(&device, &queue, 61, 23, left.format(), &params).unwrap();
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected, "{params:?}, seed 6");
        assert!(matcher.confidence().is_some_and(|buffer| buffer.size() >= 64 * 23));
        params.confidence = false;
        let matcher = StereoMatcher::new(&device, &queue, 61, 23, left.format(), &params).unwrap();
        assert!(matcher.confidence().is_none());
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap().confidence, None);
    }
}

/// The labels beside the map: only where they are asked for, the reference's, of every pixel, and the map's own disparities
/// where nothing but a test comes after the winner.
#[test]
fn the_labels_come_with_the_map() {
    let (left, right) = support::pair(61, 23, 6);
    for (method, mut params) in (0..).zip([Params::sgm(21), Params::bm(21), Params::sgm(21)]) {
        (params.min_disparity, params.subpixel, params.median) = (-3, Subpixel::Off, Median::Off);
        if method == 2 {
            (params.cost, params.prefilter, params.block) = (Cost::MutualInformation, Prefilter::None, 1);
        }
        assert_eq!(reference::compute_all(&left, &right, &params).unwrap().labels, None);
        params.labels = true;
        let expected = reference::compute_all(&left, &right, &params).unwrap();
        assert_eq!(expected.map, reference::compute(&left, &right, &params).unwrap());
        let labels = expected.labels.as_ref().unwrap();
        assert_eq!((labels.width, labels.height, labels.data.len()), (61, 23, 61 * 23));
        assert_eq!(labels.table.len(), if method == 2 { 256 * 256 } else { 0 });
        let mut valid = 0;
        for (&label, &value) in labels.data.iter().zip(&expected.map.data) {
            assert!(u32::from(label) < params.disparities);
            if value != DisparityMap::INVALID {
                assert_eq!(16 * (params.min_disparity + i32::from(label)), i32::from(value), "{params:?}, seed 6");
                valid += 1;
            }
        }
        assert!(valid > 300 && valid < 61 * 23, "{valid} are valid, {params:?}, seed 6");

        let Some((_, device, queue)) = support::device() else { continue };
        let matcher = StereoMatcher::new(&device, &queue, 61, 23, left.format(), &params).unwrap();
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected, "{params:?}, seed 6");
        params.labels = false;
        let matcher = StereoMatcher::new(&device, &queue, 61, 23, left.format(), &params).unwrap();
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap().labels, None);
    }
}

/// The depth beside the map: the reference's, where it is asked for; other cameras need no new kernel; what is no camera is
/// refused.
#[test]
fn the_depth_comes_with_the_map() {
    let (left, right) = support::pair(61, 23, 6);
    let mut params = Params::sgm(21);
    params.min_disparity = -4;
    assert_eq!(reference::compute_all(&left, &right, &params).unwrap().depth, None);
    let camera = Camera::new(1000.0, 0.1).with_doffs(0.5);
    params.depth = Some(camera);
    let expected = reference::compute_all(&left, &right, &params).unwrap();
    let depth = expected.depth.as_ref().unwrap();
    let mut some = 0;
    for (i, (&value, &depth)) in expected.map.data.iter().zip(&depth.data).enumerate() {
        let pixels = f64::from(value) / 16.0 + 0.5;
        if value == DisparityMap::INVALID || pixels <= 0.0 {
            assert_eq!(depth, DepthMap::NONE, "pixel {i}");
        } else {
            let [x, y, z] = camera.point(i as u32 % 61, i as u32 / 61, depth);
            assert!((z - 100.0 / pixels).abs() < 1e-6, "pixel {i}: {z} m for {pixels} px");
            assert!((x - z * (i % 61) as f64 / 1000.0).abs() < 1e-9 && (y - z * (i / 61) as f64 / 1000.0).abs() < 1e-9);
            some += 1;
        }
    }
    assert!(some > 300, "{some}");
    for (wrong, named) in [
        (Camera::new(-1.0, 0.1), "focal"),
        (Camera::new(f64::NAN, 0.1), "focal"),
        (Camera::new(1000.0, 0.0), "baseline"),
        (Camera::new(1000.0, -0.1), "baseline"),
        (camera.with_doffs(f64::INFINITY), "doffs"),
        (camera.with_principal_point(f64::NAN, 0.0), "cx"),
        (camera.with_principal_point(0.0, 2e6), "cy"),
    ] {
        let mut params = params.clone();
        params.depth = Some(wrong);
        assert!(matches!(params.validate(), Err(Error::Parameter { name, .. }) if name == named), "{wrong:?}");
    }

    let Some((_, device, queue)) = support::device() else { return };
    let mut matcher = StereoMatcher::new(&device, &queue, 61, 23, left.format(), &params).unwrap();
    assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected);
    assert!(matcher.depth().is_some_and(|buffer| buffer.size() >= 4 * 64 * 23));
    params.depth = Some(Camera::new(500.0, 2.0));
    matcher.set_params(&params).unwrap();
    let expected = reference::compute_all(&left, &right, &params).unwrap();
    assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected);
    params.depth = None;
    matcher.set_params(&params).unwrap();
    assert!(matcher.depth().is_none());
    assert_eq!(matcher.compute_blocking(&left, &right).unwrap().depth, None);
}
