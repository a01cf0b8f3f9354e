//! Rows of costs and of block sums beside the definition: random settings, sizes, orders of rows and pieces of them.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cpu::LANES;
use crate::cpu::cost::{CostRows, block_match};
use crate::cpu::features::tests::feature_network;
use crate::cpu::images::{Planes, Side};
use crate::cpu::instructions::Instructions;
use crate::params::{Census, Cost, Descriptor, Method, Named, Params, Prefilter, Subpixel};
use crate::reference::{self, block_statistics, block_sums, cost_columns, cost_table, images, matching_cost};
use crate::{Image, Pixels};

/// Settings of this cost, all of which are allowed.
pub(crate) fn settings(random: &mut ChaCha8Rng, cost: Cost) -> Params {
    let prefilters = [Prefilter::XSobel, Prefilter::Sobel, Prefilter::Normalized, Prefilter::None];
    let mut params = Params { cost, ..Params::sgm(random.random_range(1..70)) };
    params.method = cost.row().methods[random.random_range(0..cost.row().methods.len())];
    params.min_disparity = random.random_range(-20..20);
    params.prefilter = prefilters[random.random_range(0..4)];
    params.prefilter_window = [3, 5, 21][random.random_range(0..3)];
    params.census = Census::VALUES[random.random_range(0..4)];
    params.color_cost = cost.row().color && random.random();
    params.block = [1, 1, 3, 5, 7, 9, 15, 31, 51][random.random_range(0..9)];
    params.block = params.block.clamp(*cost.row().blocks.start(), *cost.row().blocks.end());
    params.prefilter_cap = random.random_range(1..=params.largest_cap());
    params.ad_weight = random.random_range(0..=Params::MAX_WEIGHT);
    params.census_weight = random.random_range(1..=Params::MAX_WEIGHT);
    params.learned_weight = random.random_range(0..=Params::MAX_WEIGHT);
    if cost.row().descriptors.contains(&Descriptor::Features) {
        params.features = Some(feature_network(random)).filter(|_| random.random());
    }
    params.validate().unwrap();
    params
}

/// A pair of any format whose neighbours differ by anything, also by the most.
pub(crate) fn pair(random: &mut ChaCha8Rng, width: u32, height: u32) -> [Image; 2] {
    let (kind, smooth) = (random.random_range(0..4), random.random_range(1..40));
    [(); 2].map(|()| {
        let samples = (width * height) as usize * if kind < 2 { 1 } else { 4 };
        let mut value = || match random.random_range(0..smooth) {
            0 => u16::MAX * random.random_range(0..2),
            _ => random.random(),
        };
        let deep: Vec<u16> = (0..samples).map(|_| value()).collect();
        let bytes = || deep.iter().map(|v| (v >> 8) as u8).collect();
        let pixels = match kind {
            0 => Pixels::Gray8(bytes()),
            1 => Pixels::Gray16(deep),
            2 => Pixels::Rgba8(bytes()),
            _ => Pixels::Rgba16(deep),
        };
        Image::new(width, height, pixels).unwrap()
    })
}

/// Rows in the order in which they are asked for: mostly neighbours.
fn order(random: &mut ChaCha8Rng, height: usize) -> Vec<usize> {
    let mut y = random.random_range(0..height);
    (0..2 * height + 2)
        .map(|i| {
            y = match random.random_range(0..8) {
                0 => random.random_range(0..height),
                _ if i % 16 < 8 => (y + 1) % height,
                _ => (y + height - 1) % height,
            };
            y
        })
        .collect()
}

#[test]
fn rows_of_every_cost_equal_the_definition() {
    for (number, cost) in Cost::VALUES.iter().flat_map(|&cost| [cost; 8]).enumerate() {
        let seed = 100 + number as u64;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let params = settings(&mut random, cost);
        let sizes = [(1, 1), (1, 9), (23, 1), (30, 7), (75, 11)];
        let (width, height) = sizes[random.random_range(0..sizes.len())];
        let what = format!("seed {seed}, {width} x {height}, {params:?}");
        let pair = pair(&mut random, width, height);
        let sides = pair.each_ref().map(|image| images(image, &params).prefiltered(&params).descriptors(&params));
        let sgm = Params { method: Method::Sgm, ..params.clone() };
        let table = if params.has_table() { cost_table(&sides, None, &sgm) } else { Vec::new() };
        let columns = cost_columns(&sides[0], &sides[1], &table, &params);
        let planes = [Planes::of(&sides[0], Side::Left, &params), Planes::of(&sides[1], Side::Right, &params)];
        for instructions in Instructions::all() {
            let mut rows = CostRows::new(planes.each_ref(), &table, &params, instructions);
            let orders = order(&mut random, height as usize);
            check(&mut rows, &columns, orders, &params, &mut random, &format!("{} {what}", instructions.name()));
        }
    }
}

/// The rows in this order, whole or in parts, as costs or, for block matching, as sums.
fn check(
    rows: &mut CostRows<'_>,
    columns: &reference::Volume<u32>,
    order: Vec<usize>,
    params: &Params,
    random: &mut ChaCha8Rng,
    what: &str,
) {
    let (disparities, width) = (columns.disparities, columns.width + 1 - params.block as usize);
    let costs = (!params.correlates()).then(|| matching_cost(columns, params));
    let n = disparities.next_multiple_of(LANES);
    let mut piece = 0..width;
    for y in order {
        if random.random_range(0..6) == 0 {
            let start = random.random_range(0..width);
            piece = start..random.random_range(start + 1..=width);
        }
        let sums = block_sums(columns, y, params);
        let expected = |values: &dyn Fn(usize) -> u32, beyond: u32| -> Vec<u32> {
            let lane = |x: usize, d: usize| if d < disparities { values(x * disparities + d) } else { beyond };
            piece.clone().flat_map(|x| (0..n).map(move |d| (x, d))).map(|(x, d)| lane(x, d)).collect()
        };
        let made: Vec<u32>;
        let wanted;
        if let Some(costs) = costs.as_ref().filter(|_| params.method == Method::Sgm || random.random()) {
            let mut row = vec![7; piece.len() * n];
            rows.row(y, piece.clone(), &mut row);
            let here = &costs.data[y * costs.row_len()..];
            (made, wanted) = (row.into_iter().map(u32::from).collect(), expected(&|i| here[i].into(), 255));
        } else if rows.sums_are_narrow() {
            let mut row = vec![7; piece.len() * n];
            rows.narrow_sums(y, piece.clone(), &mut row);
            (made, wanted) = (row.into_iter().map(u32::from).collect(), expected(&|i| sums[i], 0xffff));
        } else {
            let mut row = vec![7; piece.len() * n];
            rows.wide_sums(y, piece.clone(), &mut row);
            (made, wanted) = (row, expected(&|i| sums[i], u32::MAX));
        }
        assert!(made == wanted, "row {y}, columns {piece:?}, {what}");
    }
}

#[test]
fn block_matching_equals_the_definition() {
    let costs = Cost::VALUES.iter().filter(|cost| cost.row().methods.contains(&Method::Bm));
    for (number, cost) in costs.flat_map(|&cost| [cost; 5]).enumerate() {
        let seed = 300 + number as u64;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut params = Params { method: Method::Bm, ..settings(&mut random, cost) };
        params.uniqueness = random.random_range(0..2) * random.random_range(1..100);
        params.subpixel = Subpixel::VALUES[random.random_range(0..Subpixel::VALUES.len())];
        params.validate().unwrap();
        let sizes = [(1, 1), (1, 9), (23, 1), (30, 7), (75, 11)];
        let (width, height) = sizes[random.random_range(0..sizes.len())];
        let pair = pair(&mut random, width, height);
        let sides = pair.each_ref().map(|image| images(image, &params).prefiltered(&params).descriptors(&params));
        let table = if params.has_table() { cost_table(&sides, None, &params) } else { Vec::new() };
        let columns = cost_columns(&sides[0], &sides[1], &table, &params);
        let statistics = params.correlates().then(|| block_statistics(&sides[0], &sides[1], &params));
        let expected = reference::block_match(&columns, statistics.as_ref(), &params);
        let planes = [Planes::of(&sides[0], Side::Left, &params), Planes::of(&sides[1], Side::Right, &params)];
        for set in Instructions::all() {
            let made = block_match(planes.each_ref(), &table, &params, set);
            assert!(made == expected, "{}, seed {seed}, {width} x {height}, {params:?}", set.name());
        }
    }
}
