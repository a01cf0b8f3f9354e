//! What must hold whatever the implementation: shifts, mirrors, flat pairs, determinism. Each on the reference, on the native
//! schedule, and on the device where there is one.

use crate::support;
use gpu_stereo::reference::{self, points_inside};
use gpu_stereo::{
    DisparityMap, Energy, Image, Labels, Median, Method, Params, Paths, Pixels, Prefilter, Smoothness, StereoMatcher,
    Subpixel, wgpu,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const INVALID: i16 = DisparityMap::INVALID;

/// The reference's map, and the native schedule's and the device's, which must be the same.
fn compute(
    setup: &Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)>,
    left: &Image,
    right: &Image,
    params: &Params,
) -> DisparityMap {
    let expected = reference::compute_all(left, right, params).unwrap();
    support::assert_native(left, right, params, &expected, params);
    let expected = expected.map;
    if let Some((adapter, device, queue)) = setup {
        let matcher = support::matcher(device, queue, (left.width(), left.height()), left.format(), params).unwrap();
        let map = matcher.compute_blocking(left, right).unwrap().map;
        assert!(map == expected, "{} differs from the reference, {params:?}", adapter.get_info().name);
    }
    expected
}

/// An image from a formula.
fn image(width: u32, height: u32, mut sample: impl FnMut(i64, i64) -> u8) -> Image {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (i64::from(x), i64::from(y))));
    Image::new(width, height, Pixels::Gray8(pixels.map(|(x, y)| sample(x, y)).collect())).unwrap()
}

fn sample(image: &Image, x: i64, y: i64) -> u8 {
    let Pixels::Gray8(samples) = image.pixels() else { panic!("made from gray") };
    samples[(y * i64::from(image.width()) + x) as usize]
}

fn mirrored(original: &Image) -> Image {
    let last = i64::from(original.width()) - 1;
    image(original.width(), original.height(), |x, y| sample(original, last - x, y))
}

fn upside_down(original: &Image) -> Image {
    let last = i64::from(original.height()) - 1;
    image(original.width(), original.height(), |x, y| sample(original, x, last - y))
}

/// (x, y, value) of each pixel.
fn values(map: &DisparityMap) -> impl Iterator<Item = (i64, i64, i16)> {
    let width = i64::from(map.width);
    (0..).zip(&map.data).map(move |(i, &value)| (i % width, i / width, value))
}

fn value(map: &DisparityMap, x: i64, y: i64) -> i16 {
    map.data[(y * i64::from(map.width) + x) as usize]
}

/// Both methods, all prefilters, both numbers of paths.
fn chains(disparities: u32) -> Vec<Params> {
    let mut all = Vec::new();
    for prefilter in [Prefilter::XSobel, Prefilter::Sobel, Prefilter::None] {
        let mut eight = Params::sgm(disparities);
        eight.paths = Paths::Eight;
        for mut params in [Params::bm(disparities), Params::sgm(disparities), eight] {
            params.prefilter = prefilter;
            params.block = 5;
            all.push(params);
        }
    }
    all
}

/// The winner alone: whole pixels, no test.
fn whole_pixels(params: &Params) -> Params {
    let mut params = params.clone();
    (params.subpixel, params.uniqueness, params.lr_check, params.median) = (Subpixel::Off, 0, None, Median::Off);
    params
}

/// Noise shifted by k pixels has the disparity k, k where whole pixels are asked for and within half a pixel where
/// not. The border of 10 px covers the block, the prefilter and the start of the paths.
#[test]
fn a_shifted_pair_gives_the_shift() {
    let setup = support::device();
    let (width, height, border, seed) = (97, 31, 10, 1);
    for (shift, min_disparity) in
        [(0, 0), (1, 0), (5, 0), (13, 0), (15, 0), (-1, -8), (-6, -8), (0, -8), (20, 12), (-20, -27)]
    {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let noise: Vec<u8> = (0..(width + 80) * height).map(|_| random.random()).collect();
        let at = |x: i64, y: i64| noise[(y * i64::from(width + 80) + x + 40) as usize];
        let left = image(width, height, at);
        let right = image(width, height, |x, y| at(x + shift, y));
        for mut params in chains(16) {
            params.min_disparity = min_disparity;
            params.prefilter_cap = 127; // clipped noise is flat
            for subpixel in [Subpixel::Off, Subpixel::Parabola, Subpixel::Equiangular] {
                params.subpixel = subpixel;
                let map = compute(&setup, &left, &right, &params);
                let inside = |x: i64| x >= border && x < i64::from(width) - border;
                let interior = values(&map).filter(|&(x, _, _)| inside(x) && inside(x - shift));
                let mut pixels = 0;
                for (x, y, value) in interior {
                    let off = i64::from(value) - 16 * shift;
                    let most = if subpixel == Subpixel::Off { 0 } else { 8 };
                    assert!(off.abs() <= most, "{value}/16 px at ({x}, {y}) for {shift} px, {params:?}, seed {seed}");
                    pixels += 1;
                }
                assert!(pixels > 1000, "only {pixels} pixels were looked at");
            }
        }
    }
}

/// Turned upside down, a pair has its map turned upside down: no rule of any stage tells up from down.
#[test]
fn upside_down_pairs_have_upside_down_maps() {
    let setup = support::device();
    for (seed, (width, height)) in (0..).zip([(1, 1), (1, 8), (40, 1), (33, 18), (50, 27)]) {
        let (left, right) = support::pair(width, height, seed);
        for mut params in chains(19) {
            params.min_disparity = -4;
            params.uniqueness = 5;
            let map = compute(&setup, &left, &right, &params);
            let turned = compute(&setup, &upside_down(&left), &upside_down(&right), &params);
            for (x, y, v) in values(&map) {
                let other = value(&turned, x, i64::from(height) - 1 - y);
                assert_eq!(v, other, "at ({x}, {y}) of {width}x{height}, {params:?}, seed {seed}");
            }
        }
    }
}

/// The column sums of a pair: what both methods start from.
fn column_sums(left: &Image, right: &Image, params: &Params) -> reference::Volume<u32> {
    let descriptors =
        [left, right].map(|image| reference::images(image, params).prefiltered(params).descriptors(params));
    reference::cost_columns(&descriptors[0], &descriptors[1], &[], params)
}

/// Mirrored and swapped, a pair's left view is the mirror image of the original's right view.
///
/// The block cost of the mirrored pair at (x', d) is that of the original pair at (u + d, d), u = width - 1 - x' being
/// the right pixel. It holds for what is chosen from costs of single pixels: for block matching, and for semi-global
/// matching without penalties, where paths do not reach beyond a pixel (along a path the views see different
/// neighbours). The left view of the mirrored pair also looks at disparities whose left pixel lies outside the image,
/// and a winner among these is invalid; a valid one is the smallest of the smallest costs, so the right view has it.
#[test]
fn mirrored_and_swapped_the_left_view_is_the_right_view() {
    let setup = support::device();
    for (seed, (width, height)) in (0..).zip([(1, 3), (9, 9), (47, 20), (70, 13)]) {
        let (left, right) = support::pair(width, height, seed);
        for (params, min_disparity) in chains(14).into_iter().flat_map(|p| [0, -5, 3].map(|m| (p.clone(), m))) {
            let mut params = whole_pixels(&params);
            params.min_disparity = min_disparity;
            (params.p1, params.p2) = (0, 0);
            let columns = column_sums(&left, &right, &params);
            let views = match params.method {
                Method::Bm => reference::block_match(&columns, None, &params),
                _ => {
                    let cost = reference::matching_cost(&columns, &params);
                    reference::winner(&reference::sgm_aggregate(&cost, None, &params), &params)
                }
            };
            let turned = compute(&setup, &mirrored(&right), &mirrored(&left), &params);
            let mut valid = 0;
            for (x, y, v) in values(&turned) {
                let u = i64::from(width) - 1 - x;
                let sees = |d: i64| (0..i64::from(width)).contains(&(u + i64::from(min_disparity) + d));
                let case = format!("at ({x}, {y}) of {width}x{height}, {params:?}, seed {seed}");
                if v != INVALID {
                    assert_eq!(v, value(&views.right, u, y), "{case}");
                    valid += 1;
                } else {
                    assert!(!(0..14).all(sees), "{case}: invalid, although no disparity points outside");
                }
            }
            assert!(width < 20 || valid > 100, "only {valid} valid pixels, {params:?}, seed {seed}");
            // The device's right view is compared with the reference's by the check.
            if let Some((adapter, device, queue)) = &setup {
                let matcher = support::matcher(device, queue, (width, height), left.format(), &params).unwrap();
                support::assert_equal(&matcher.check_blocking(&left, &right).unwrap(), adapter, &(&params, seed));
            }
        }
    }
}

/// Mirrored and not swapped, disparities change their sign: for any chain, wherever one disparity has the smallest
/// cost. Ties go to the smallest disparity, which is the largest one of the mirrored pair.
#[test]
fn mirrored_the_disparities_change_their_sign() {
    let setup = support::device();
    for (seed, (width, height)) in (0..).zip([(1, 3), (9, 9), (47, 20), (70, 13)]) {
        let (left, right) = support::pair(width, height, seed);
        for (params, min_disparity) in chains(14).into_iter().flat_map(|p| [0, -5, 3].map(|m| (p.clone(), m))) {
            let mut params = whole_pixels(&params);
            params.min_disparity = min_disparity;
            let mut turned = params.clone();
            turned.min_disparity = -(min_disparity + 13);
            let map = compute(&setup, &left, &right, &params);
            let turned = compute(&setup, &mirrored(&left), &mirrored(&right), &turned);

            let columns = column_sums(&left, &right, &params);
            let sums: Vec<u32> = match params.method {
                Method::Bm => (0..height as usize).flat_map(|y| reference::block_sums(&columns, y, &params)).collect(),
                _ => {
                    let cost = reference::matching_cost(&columns, &params);
                    reference::sgm_aggregate(&cost, None, &params).data.into_iter().map(u32::from).collect()
                }
            };
            let mut alone = 0;
            for ((x, y, v), sums) in values(&map).zip(sums.chunks_exact(14)) {
                let least = sums.iter().min().unwrap();
                if sums.iter().filter(|sum| *sum == least).count() > 1 {
                    continue;
                }
                let other = value(&turned, i64::from(width) - 1 - x, y);
                let expected = if v == INVALID { INVALID } else { -v };
                assert_eq!(other, expected, "at ({x}, {y}) of {width}x{height}, {params:?}, seed {seed}");
                alone += 1;
            }
            assert!(width < 20 || alone > 400, "only {alone} pixels without a tie, {params:?}, seed {seed}");
        }
    }
}

/// Belief propagation without smoothness takes the smallest cost of each pixel; with it, it finds a labelling of less energy than
/// that, and than semi-global matching does.
#[test]
fn beliefs_have_less_energy_than_costs_and_paths() {
    let (width, height) = (62, 37);
    let (left, right) = support::pair(width, height, 9);
    for (smoothness, weight, truncation) in
        [(Smoothness::Linear, 8, 40), (Smoothness::Quadratic, 4, 50), (Smoothness::Potts, 0, 20)]
    {
        let mut params = whole_pixels(&Params::bp(14));
        params.block = 1;
        (params.smoothness, params.smoothness_weight, params.smoothness_truncation) = (smoothness, weight, truncation);
        let columns = column_sums(&left, &right, &params);
        let cost = reference::matching_cost(&columns, &params);
        let labels = |volume: &reference::Volume<u16>| -> Vec<usize> {
            let best = |costs: &[u16]| (0..costs.len()).min_by_key(|&d| (costs[d], d)).unwrap();
            volume.data.chunks_exact(14).map(best).collect()
        };
        let v = |a: usize, b: usize| {
            let k = a.abs_diff(b) as u32;
            match smoothness {
                Smoothness::Linear => truncation.min(weight * k),
                Smoothness::Quadratic => truncation.min(weight * k * k),
                _ => truncation * k.min(1),
            }
        };
        let energy = |labels: &[usize]| -> u32 {
            let data: u32 = labels.iter().zip(cost.data.chunks_exact(14)).map(|(&d, costs)| u32::from(costs[d])).sum();
            let w = width as usize;
            let across = (0..labels.len()).filter(|i| (i + 1) % w > 0).map(|i| v(labels[i], labels[i + 1]));
            let down = (w..labels.len()).map(|i| v(labels[i], labels[i - w]));
            data + across.chain(down).sum::<u32>()
        };
        let beliefs = |params: &Params| {
            let coarse = reference::coarse_cost(&cost, params);
            let messages = reference::messages(&cost, &coarse, None, params);
            reference::beliefs(&cost, messages.last().unwrap())
        };
        let alone = reference::Volume { data: cost.data.iter().map(|&c| c.into()).collect(), ..cost_shape(&cost) };
        let found = energy(&labels(&beliefs(&params)));
        // The definition's figure is this one, of every method with this cost.
        for method in [Method::Bp, Method::Sgm, Method::Bm] {
            let told = told_energy(&left, &right, &params, method);
            let found: Vec<_> = told.0.data.iter().map(|&label| usize::from(label)).collect();
            assert_eq!(told.1.sum(), u64::from(energy(&found)), "{method:?}, {smoothness:?}");
            let alone: u32 = found.iter().zip(cost.data.chunks_exact(14)).map(|(&d, costs)| u32::from(costs[d])).sum();
            assert_eq!(told.1.data, u64::from(alone), "{method:?}, {smoothness:?}");
        }
        assert_eq!(told_energy(&left, &right, &params, Method::Bp).1.sum(), u64::from(found), "{smoothness:?}");
        let [plain, paths] =
            [alone.clone(), reference::sgm_aggregate(&cost, None, &params)].map(|s| energy(&labels(&s)));
        assert!(found < plain && found < paths, "{found}, {plain} of costs, {paths} of paths, {smoothness:?}");
        // More iterations gain little.
        let mut more = params.clone();
        more.bp_iterations = 200;
        let longer = energy(&labels(&beliefs(&more)));
        assert!(found <= longer + longer / 50, "{found} after 60 iterations, {longer} after 200, {smoothness:?}");
        params.smoothness_truncation = 0;
        assert_eq!(beliefs(&params), alone, "{smoothness:?}");
    }
}

/// The labels that a method gives a pair, and their energy, by the definition.
fn told_energy(left: &Image, right: &Image, params: &Params, method: Method) -> (Labels, Energy) {
    let mut params = params.clone();
    (params.labels, params.method) = (true, method);
    let labels = reference::compute_all(left, right, &params).unwrap().labels.unwrap();
    let energy = reference::energy(left, right, &labels, &params).unwrap();
    (labels, energy)
}

/// In a single row plain messages find the smallest energy there is, which is that of the best of all ways through the row;
/// no method's labels have less.
#[test]
fn the_energy_of_a_row_is_no_less_than_that_of_the_best_way_through_it() {
    let (width, count) = (34, 9);
    let mut reached = 0;
    for seed in 0..30 {
        let (left, right) = support::pair(width, 1, seed);
        let mut params = whole_pixels(&Params::bp(count));
        params.smoothness = [Smoothness::Linear, Smoothness::Quadratic, Smoothness::Potts][seed as usize % 3];
        (params.smoothness_weight, params.smoothness_truncation) = (3 + seed as u32, 20 + seed as u32);
        params.smoothness_edge = (seed % 2 > 0).then_some(8);
        (params.bp_levels, params.bp_iterations, params.bp_reweighting) = (1, 2 * width + 2, 16);
        let cost = reference::matching_cost(&column_sums(&left, &right, &params), &params);
        let gray = reference::gray(&left, reference::Channel::Luma).data;
        let v = |x: usize, k: u32| {
            let edge = params.smoothness_edge.is_some_and(|edge| u32::from(gray[x].abs_diff(gray[x - 1])) >= edge);
            let [a, b] = [params.smoothness_weight, params.smoothness_truncation].map(|value| value >> u32::from(edge));
            match params.smoothness {
                Smoothness::Linear => b.min(a * k),
                Smoothness::Quadratic => b.min(a * k * k),
                _ => b * k.min(1),
            }
        };
        let mut best: Vec<u32> = vec![0; count as usize];
        for (x, costs) in cost.data.chunks_exact(count as usize).enumerate() {
            let way = |d: u32| (0..count).map(|e| best[e as usize] + if x > 0 { v(x, d.abs_diff(e)) } else { 0 }).min();
            best = (0..count).map(|d| way(d).unwrap() + u32::from(costs[d as usize])).collect();
        }
        let least = u64::from(*best.iter().min().unwrap());
        for method in [Method::Bp, Method::Sgm, Method::Bm] {
            let energy = told_energy(&left, &right, &params, method).1.sum();
            assert!(energy >= least, "{energy}, but {least} is the least, {method:?}, seed {seed}");
            reached += u32::from(method == Method::Bp && energy == least);
        }
    }
    // Where two disparities of a pixel are equally good, neighbours may choose those of different ways.
    assert!(reached > 20, "only {reached} of 30 rows have the least energy");
}

fn cost_shape(cost: &reference::Volume<u8>) -> reference::Volume<u16> {
    reference::Volume { width: cost.width, height: cost.height, disparities: cost.disparities, data: Vec::new() }
}

/// Upside down, the map of belief propagation on one level is upside down, where the colours of the chessboard stay the same.
#[test]
fn upside_down_beliefs_are_upside_down() {
    let setup = support::device();
    for (seed, (width, height)) in (0..).zip([(40, 21), (33, 9)]) {
        let (left, right) = support::pair(width, height, seed);
        let mut params = Params::bp(14);
        (params.bp_levels, params.bp_iterations) = (1, 9);
        let map = compute(&setup, &left, &right, &params);
        let turned = compute(&setup, &upside_down(&left), &upside_down(&right), &params);
        for (x, y, v) in values(&map) {
            assert_eq!(
                v,
                value(&turned, x, i64::from(height) - 1 - y),
                "at ({x}, {y}) of {width}x{height}, seed {seed}"
            );
        }
    }
}

/// On a flat pair all costs are 0: no disparity is unique, and the smallest one wins where uniqueness is not asked for.
#[test]
fn a_flat_pair_has_the_smallest_disparity_or_none() {
    let setup = support::device();
    for (width, height) in [(1, 1), (40, 9), (65, 4)] {
        let flat = image(width, height, |_, _| 117);
        for mut params in chains(20) {
            for min_disparity in [0, 7, -39, 64, -100] {
                params.min_disparity = min_disparity;
                params.uniqueness = 0;
                for (x, y, v) in values(&compute(&setup, &flat, &flat, &params)) {
                    let seen = x - i64::from(min_disparity);
                    let inside = (0..i64::from(width)).contains(&seen);
                    let expected = if inside { 16 * min_disparity as i16 } else { INVALID };
                    assert_eq!(v, expected, "at ({x}, {y}) of {width}x{height}, {params:?}");
                }
            }
            for uniqueness in [1, 99] {
                (params.min_disparity, params.uniqueness) = (0, uniqueness);
                let map = compute(&setup, &flat, &flat, &params);
                assert!(map.data.iter().all(|&v| v == INVALID), "{width}x{height}, {params:?}");
            }
            (params.disparities, params.uniqueness) = (2, 99); // the winner and its neighbour: no rival
            let map = compute(&setup, &flat, &flat, &params);
            assert!(map.data.iter().all(|&v| v == 0), "{width}x{height}, {params:?}");
        }
    }
}

/// The right image moved by m pixels, with a minimum disparity moved by m, gives the map moved by m, except where one
/// of the two points outside. The right image has flat margins, so that what moves over the border is what the border
/// is continued by, and this holds for each pixel and each stage but the median, which looks at neighbours.
#[test]
fn the_minimum_disparity_moves_the_map() {
    let setup = support::device();
    let (width, height, margin, seed) = (83, 24, 30, 3);
    let (left, noise) = support::pair(width, height, seed);
    let last = i64::from(width) - 1;
    let right = image(width, height, |x, y| sample(&noise, x.clamp(margin, last - margin), y));
    for mut params in chains(18) {
        for (lr_check, uniqueness) in [(None, 0), (Some(1), 0), (Some(0), 10)] {
            (params.median, params.lr_check, params.uniqueness) = (Median::Off, lr_check, uniqueness);
            params.min_disparity = -2;
            let map = compute(&setup, &left, &right, &params);
            for shift in [1, -11, 28] {
                params.min_disparity = -2 + shift;
                let moved_right = image(width, height, |x, y| sample(&right, (x + i64::from(shift)).clamp(0, last), y));
                let moved = compute(&setup, &left, &moved_right, &params);
                let by = 16 * shift as i16;
                let mut both = 0;
                for ((x, y, v), &w) in values(&map).zip(&moved.data) {
                    let expected = |v: i16, by: i16| match v {
                        INVALID => INVALID,
                        v if points_inside(x, v + by, width as usize) => v + by,
                        _ => INVALID,
                    };
                    let case = format!("at ({x}, {y}), moved by {shift}, {params:?}, seed {seed}");
                    match (v, w) {
                        (INVALID, w) => assert_eq!(expected(w, -by), INVALID, "{case}"),
                        (v, w) => assert_eq!(expected(v, by), w, "{case}"),
                    }
                    both += u32::from(v != INVALID && w != INVALID);
                }
                assert!(both > 100, "only {both} pixels are valid in both maps, {params:?}");
            }
        }
    }
}

/// More disparities than columns: every valid one still points into the right image.
#[test]
fn a_range_wider_than_the_image() {
    let setup = support::device();
    for (seed, (width, height)) in (0..).zip([(1, 1), (2, 5), (7, 6), (23, 9)]) {
        let (left, right) = support::pair(width, height, seed);
        for mut params in chains(70) {
            for min_disparity in [0, -35, -2000, 1900] {
                params.min_disparity = min_disparity;
                let map = compute(&setup, &left, &right, &params);
                for (x, y, v) in values(&map).filter(|&(_, _, v)| v != INVALID) {
                    let case = format!("{v}/16 px at ({x}, {y}) of {width}x{height}, {params:?}, seed {seed}");
                    assert!(points_inside(x, v, width as usize), "{case}");
                    let range = 16 * min_disparity..=16 * (min_disparity + 69);
                    assert!(range.contains(&i32::from(v)), "{case}");
                }
                if min_disparity.abs() > 1000 {
                    assert!(map.data.iter().all(|&v| v == INVALID), "{params:?} points far outside, seed {seed}");
                }
            }
        }
    }
}

/// The same gray values give the same map in every format: the weights of luma sum to 1.
#[test]
fn formats_of_the_same_gray_agree() {
    let setup = support::device();
    let (width, height, seed) = (31, 30, 9);
    let all = image(width, height, |x, y| ((y * 31 + x) % 256) as u8); // each of the 256 levels
    let (noise, right) = support::pair(width, height, seed);
    for left in [all, noise] {
        let expected = compute(&setup, &left, &right, &Params::sgm(16));
        type Convert = fn(Vec<u8>) -> Pixels;
        let formats: [Convert; 3] = [
            |gray| Pixels::Gray16(gray.into_iter().map(|v| 257 * u16::from(v)).collect()),
            |gray| Pixels::Rgba8(gray.into_iter().flat_map(|v| [v, v, v, !v]).collect()),
            |gray| Pixels::Rgba16(gray.into_iter().flat_map(|v| [v, v, v, !v].map(|v| 257 * u16::from(v))).collect()),
        ];
        for convert in formats {
            let [left, right] = [&left, &right].map(|image| {
                let Pixels::Gray8(gray) = image.pixels() else { panic!("made from gray") };
                Image::new(width, height, convert(gray.clone())).unwrap()
            });
            let map = compute(&setup, &left, &right, &Params::sgm(16));
            assert!(map == expected, "{:?} differs from Gray8, seed {seed}", left.format());
        }
    }
}

/// One pair has one map: again, after another pair, and while another matcher works on the same device.
#[test]
fn the_same_pair_has_the_same_map() {
    let Some((adapter, device, queue)) = support::device() else { return };
    let work = |params: Params, width: u32, height: u32, seed: u64| {
        let pairs = [seed, seed + 100].map(|seed| support::pair(width, height, seed));
        let expected = pairs.clone().map(|(left, right)| reference::compute(&left, &right, &params).unwrap());
        assert!(expected[0] != expected[1], "the two pairs have one map, seed {seed}");
        let matcher = StereoMatcher::new(&device, &queue, width, height, pairs[0].0.format(), &params).unwrap();
        for round in 0..12 {
            let i = [0, 0, 1][round % 3];
            let map = matcher.compute_blocking(&pairs[i].0, &pairs[i].1).unwrap().map;
            let on = &adapter.get_info().name;
            assert!(map == expected[i], "round {round} differs on {on}, {width}x{height}, {params:?}, seed {seed}");
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(|| work(Params::sgm(33), 120, 77, 1));
        scope.spawn(|| work(Params::bm(48), 91, 64, 2));
        scope.spawn(|| work(Params::sgm(16), 64, 48, 3));
    });
}
