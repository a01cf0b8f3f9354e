//! What has no content has no disparity, whatever the settings are: what lies outside the image that was rectified, and
//! what is masked. On the reference, and on the device where there is one.

use crate::support;
use gpu_stereo::reference::{self, Content, Plane, validity};
use gpu_stereo::{
    Cost, DepthMap, DisparityMap, Fill, Image, Lens, Masks, Matched, Median, Params, PixelFormat, Preset,
    Rectification, RightView, StereoMatcher, StereoStream, Wls, wgpu,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const INVALID: i16 = DisparityMap::INVALID;

type Setup = Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)>;

/// All that the reference gives, and the device, which must be the same.
fn compute(setup: &Setup, left: &Image, right: &Image, params: &Params) -> Matched {
    let expected = reference::compute_all(left, right, params).unwrap();
    if let Some((adapter, device, queue)) = setup {
        let matcher = support::matcher(device, queue, (left.width(), left.height()), left.format(), params).unwrap();
        let found = matcher.compute_blocking(left, right).unwrap();
        assert!(found == expected, "differs on {}: {params:?}", adapter.get_info().name);
    }
    expected
}

/// Each pixel of a map with a disparity has content, and so have the pixels of the other view between which it leads, the
/// nearest ones where it leads out of it. How many there are.
fn keeps_to(map: &DisparityMap, here: &dyn Fn(u32, u32) -> bool, there: &dyn Fn(u32, u32) -> bool, sign: f64) -> usize {
    let mut valid = 0;
    for y in 0..map.height {
        for x in 0..map.width {
            let Some(disparity) = map.get(x, y) else { continue };
            valid += 1;
            assert!(here(x, y), "({x}, {y}) has no content, but the disparity {disparity}");
            let place = f64::from(x) + sign * f64::from(disparity);
            for seen in [place.floor(), place.ceil()] {
                let seen = seen.clamp(0.0, f64::from(map.width - 1));
                assert!(there(seen as u32, y), "({x}, {y}) leads to {seen} by {disparity}");
            }
        }
    }
    valid
}

/// The maps of both views, confidence and depth.
fn all_keep_to(matched: &Matched, left: &dyn Fn(u32, u32) -> bool, right: &dyn Fn(u32, u32) -> bool) -> usize {
    let valid = keeps_to(&matched.map, left, right, -1.0);
    keeps_to(matched.right.as_ref().unwrap(), right, left, 1.0);
    let of_pixels = matched.map.data.iter().zip(&matched.confidence.as_ref().unwrap().data);
    for ((value, confidence), depth) in of_pixels.zip(&matched.depth.as_ref().unwrap().data) {
        assert_eq!(*value == INVALID, *confidence == 0);
        assert_eq!(*value <= 0, *depth == DepthMap::NONE, "{value} {depth}");
    }
    valid
}

/// Every preset and block matching; with every filter that may give a pixel a disparity.
fn settings(disparities: u32) -> Vec<Params> {
    let presets = [Preset::Balanced, Preset::Dense, Preset::Strict, Preset::Classic, Preset::Fast, Preset::Accurate];
    let bases = presets.map(|preset| Params::preset(preset, disparities)).into_iter().chain([Params::bm(disparities)]);
    let more: [fn(&mut Params); 8] = [
        |_| (),
        |params| params.wls = Some(Wls::default()),
        |params| params.fill = Fill::Background,
        |params| params.fill = Fill::Rays,
        |params| params.fill = Fill::WeightedRays,
        |params| params.fill = Fill::Hirschmuller,
        |params| (params.median, params.lr_check, params.uniqueness) = (Median::Five, None, 0),
        |params| {
            (params.fill, params.weighted_median, params.wls) = (Fill::Background, Some(9), Some(Wls::default()));
            (params.cost, params.block) = match params.method {
                gpu_stereo::Method::Bm => (Cost::Ncc, 9),
                _ => (Cost::MutualInformation, 1),
            };
        },
    ];
    let all = bases.flat_map(|base| {
        more.map(|change| {
            let mut params = base.clone();
            change(&mut params);
            (params.right_map, params.confidence) = (true, true);
            params.depth = Some(gpu_stereo::Camera::new(100.0, 0.1));
            params
        })
    });
    all.collect()
}

/// Cameras without lenses, of which the rectified ones see `zoom` times as much.
fn zoomed_out(width: u32, height: u32, zoom: f64) -> Rectification {
    let (w, h) = (f64::from(width), f64::from(height));
    let matrix = |focal: f64| [focal, 0.0, w / 2.0, 0.0, focal, h / 2.0, 0.0, 0.0, 1.0];
    let rotation = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let lens = Lens::new(matrix(100.0), gpu_stereo::Distortion::NONE, rotation, matrix(100.0 / zoom));
    Rectification::new(width, height, [lens; 2]).unwrap()
}

#[test]
fn nothing_outside_the_given_image_has_a_disparity() {
    let setup = support::device();
    let (width, height) = (120, 80);
    let (left, right) = support::pair(width, height, 1);
    let rectification = zoomed_out(width, height, 1.4);
    let inside = |x: u32, y: u32| {
        let of = |at: u32, side: u32| (f64::from(at) - f64::from(side) / 2.0) * 1.4 + f64::from(side) / 2.0;
        let within = |place: f64, side: u32| place > -0.001 && place < f64::from(side - 1) + 0.001;
        within(of(x, width), width) && within(of(y, height), height)
    };
    let all = (0..width * height).filter(|i| inside(i % width, i / width)).count();
    assert!((3000..6000).contains(&all), "{all} of {}", width * height);
    for (i, mut params) in settings(16).into_iter().enumerate() {
        params.rectify = Some(rectification.clone());
        let matched = compute(if i % 7 == 0 { &setup } else { &None }, &left, &right, &params); // kernels compile slowly
        let valid = all_keep_to(&matched, &inside, &inside);
        assert!(valid * 3 > all, "{valid} of {all} pixels inside, {params:?}");
    }
    // A rectification that shows nothing but content changes nothing else.
    let mut params = Params::preset(Preset::Dense, 16);
    params.rectify = Some(zoomed_out(width, height, 1.0));
    let still = compute(&setup, &left, &right, &params);
    params.rectify = None;
    assert!(still == compute(&None, &left, &right, &params));
}

/// Random masks: every valid pixel is one of content, and leads to content.
#[test]
fn nothing_masked_has_a_disparity() {
    let setup = support::device();
    let (mut valid, mut all) = (0, 0);
    for seed in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = match seed % 2 {
            0 => support::random_params(&mut random),
            _ => settings(24).swap_remove(random.random_range(0..42)),
        };
        (params.right_map, params.confidence) = (true, true);
        params.depth = Some(gpu_stereo::Camera::new(100.0, 0.1));
        let (width, height) = (random.random_range(1..70), random.random_range(1..40));
        let (left, right) = support::pair(width, height, seed);
        let masks = support::masks(width, height, seed);
        params.masks = Some(masks.clone());
        let matched = compute(if seed < 8 { &setup } else { &None }, &left, &right, &params);
        let of = |side: usize, x: u32, y: u32| {
            masks.side(side).is_none_or(|mask| mask[y as usize * width as usize + x as usize] != 0)
        };
        println!("seed {seed}, {params:?}"); // shown if this fails
        valid += all_keep_to(&matched, &|x, y| of(0, x, y), &|x, y| of(1, x, y));
        all += (width * height) as usize;
    }
    assert!(valid * 5 > all, "{valid} of {all}");
}

/// Masks that hide nothing change no bit; masks that hide all leave nothing.
#[test]
fn full_and_empty_masks() {
    for (seed, (width, height)) in (0..).zip([(1, 1), (1, 9), (9, 1), (7, 5), (33, 17), (61, 40)]) {
        let (left, right) = support::pair(width, height, seed);
        let all = |value: u8| Some(vec![value; (width * height) as usize]);
        for mut params in settings(12) {
            let plain = compute(&None, &left, &right, &params);
            for full in [[all(255), all(255)], [all(1), None], [None, None]] {
                params.masks = Some(Masks::new(width, height, full).unwrap());
                assert!(compute(&None, &left, &right, &params) == plain, "{width}x{height}, {params:?}");
            }
            params.masks = Some(Masks::new(width, height, [all(0), None]).unwrap());
            let none = compute(&None, &left, &right, &params);
            assert!(none.map.data.iter().chain(&none.right.unwrap().data).all(|&value| value == INVALID), "{params:?}");
            assert_eq!(none.map.valid_fraction(), 0.0);
            params.masks = Some(Masks::new(width, height, [None, all(0)]).unwrap());
            let none = compute(&None, &left, &right, &params);
            assert!(none.map.data.iter().all(|&value| value == INVALID), "{params:?}");
        }
    }
}

/// The stage itself, where all have content, and by hand.
#[test]
fn the_stage_by_hand() {
    let row = |data: &[bool]| Plane { width: data.len(), height: 1, data: data.to_vec() };
    let map = |data: &[i16]| DisparityMap { width: data.len() as u32, height: 1, data: data.to_vec() };
    let (t, f) = (true, false);
    let content = Content { sides: [row(&[t, t, t, t, f, t]), row(&[t, t, f, t, t, t])] };
    // Of column 3, 1 px leads to the hidden column 2, 17/16 px to between 1 and 2, 15/16 px to between 2 and 3, 0 to 3.
    for (value, stays) in [(16, f), (17, f), (15, f), (0, t), (32, t), (33, t), (31, f), (160, t), (INVALID, f)] {
        let found = validity(&map(&[INVALID, INVALID, INVALID, value, INVALID, INVALID]), &content, 0);
        assert_eq!(found.data[3], if stays { value } else { INVALID }, "{value}");
    }
    assert_eq!(validity(&map(&[0, 0, 0, 0, 0, 0]), &content, 0).data, [0, 0, INVALID, 0, INVALID, 0]);
    assert_eq!(validity(&map(&[0, 32, 0, 16, 0, 0]), &content, 1).data, [0, 32, INVALID, INVALID, INVALID, 0]);
    // What leads out of the image leads to its border.
    let border = Content { sides: [row(&[t; 6]), row(&[f, t, t, t, t, t])] };
    assert_eq!(validity(&map(&[-16, 1, 40, 32, 5, -300]), &border, 0).data, [-16, INVALID, INVALID, 32, 5, -300]);
    let all = Content { sides: [row(&[t; 6]), row(&[t; 6])] };
    assert_eq!(validity(&map(&[INVALID, -7, 40, 9000, 5, 0]), &all, 0), map(&[INVALID, -7, 40, 9000, 5, 0]));
    let halved = content.halved(1);
    assert_eq!(halved.sides.map(|side| side.data), [vec![t, t, f], vec![t, f, t]]);
    assert_eq!(content.mirrored().sides[0].data, [t, t, t, f, t, t]);
}

#[test]
fn masks_of_another_size_are_refused() {
    for (width, height, masks) in [(0, 3, [None, None]), (3, 0, [None, None]), (3, 2, [Some(vec![1; 5]), None]), {
        (3, 2, [None, Some(vec![0; 7])])
    }] {
        let told = Masks::new(width, height, masks).unwrap_err().to_string();
        assert!(told.contains(&format!("{width}x{height}")) && told.lines().count() == 1, "{told}");
    }
    let (left, right) = support::pair(20, 10, 1);
    let mut params = Params::sgm(8);
    params.masks = Some(Masks::new(10, 20, [Some(vec![255; 200]), None]).unwrap());
    let told = reference::compute(&left, &right, &params).unwrap_err().to_string();
    assert!(told.contains("20x10") && told.contains("10x20") && told.lines().count() == 1, "{told}");
    let Some((_, device, queue)) = support::device() else { return };
    assert!(StereoMatcher::new(&device, &queue, 20, 10, PixelFormat::Gray8, &params).is_err());
    // The matcher goes on as it was.
    let mut matcher = StereoMatcher::new(&device, &queue, 20, 10, PixelFormat::Gray8, &Params::sgm(8)).unwrap();
    assert!(matcher.set_params(&params).is_err());
    let plain = reference::compute(&left, &right, &Params::sgm(8)).unwrap();
    assert!(matcher.compute_blocking(&left, &right).unwrap().map == plain);
}

/// A matcher whose masks come, change and go, for pairs of its size and of smaller ones.
#[test]
fn masks_come_and_go() {
    let Some((_, device, queue)) = support::device() else { return };
    for (cost, right_view) in [(Cost::Sad, RightView::Match), (Cost::MutualInformation, RightView::Match)] {
        let base = || {
            let mut params = Params::sgm(12);
            (params.cost, params.right_view, params.uniqueness) = (cost, right_view, 0);
            params
        };
        let mut matcher = StereoMatcher::new(&device, &queue, 70, 50, PixelFormat::Gray8, &base()).unwrap();
        for (seed, (width, height), masked) in [
            (0, (70, 50), false),
            (1, (70, 50), true),
            (2, (70, 50), true),
            (3, (40, 37), false),
            (4, (40, 37), true),
            (5, (40, 37), false),
            (6, (70, 50), true),
        ] {
            let mut params = base();
            matcher.set_params(&params).unwrap();
            matcher.resize(width, height).unwrap();
            params.masks = masked.then(|| support::masks(width, height, seed));
            matcher.set_params(&params).unwrap();
            assert_eq!(*matcher.params(), params);
            if masked {
                assert!(matcher.resize(33, 20).is_err());
            }
            let (left, right) = support::pair(width, height, seed);
            let expected = reference::compute(&left, &right, &params).unwrap();
            assert!(matcher.compute_blocking(&left, &right).unwrap().map == expected, "{width}x{height}, {seed}");
        }
    }
    // Several pairs in flight.
    let mut params = Params::preset(Preset::Balanced, 12);
    params.masks = Some(support::masks(70, 50, 2));
    let matcher = StereoMatcher::new(&device, &queue, 70, 50, PixelFormat::Gray8, &params).unwrap();
    let mut stream = StereoStream::new(matcher, 3).unwrap();
    let pairs: Vec<_> = (0..3).map(|seed| support::pair(70, 50, seed)).collect();
    pairs.iter().for_each(|(left, right)| assert!(stream.try_push(left, right).unwrap().is_some()));
    for (left, right) in &pairs {
        let found = stream.next_blocking().unwrap().result.unwrap();
        assert!(found == reference::compute_all(left, right, &params).unwrap());
    }
    let masks = support::masks(9, 9, 1);
    assert_eq!(masks, masks.clone());
    assert_eq!(masks, Masks::new(9, 9, [0, 1].map(|side| masks.side(side).map(<[u8]>::to_vec))).unwrap());
    assert_ne!(masks, support::masks(9, 9, 3));
    assert_eq!(masks.size(), [9, 9]);
}
