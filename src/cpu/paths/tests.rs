//! The native aggregation and its winners beside the definition's, to the bit, on small random volumes.

use std::ops::Range;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::aggregation::Sources;
use super::{Aggregation, Buffers, CostSource, Record, aggregate, penalties, second_cost};
use crate::cpu::instructions::Instructions;
use crate::reference::{self, Plane, Volume};
use crate::{Params, Paths, Subpixel};

/// The rows of a volume.
struct Given<'a>(&'a Volume<u8>, usize);

impl CostSource for Given<'_> {
    fn row(&mut self, y: usize, columns: Range<usize>, cost: &mut [u8]) {
        let Self(volume, n) = self;
        let width = columns.len();
        let pixels = volume.data[y * volume.row_len()..][..volume.row_len()].chunks_exact(volume.disparities);
        cost.fill(255);
        for (to, from) in cost[..width * *n].chunks_exact_mut(*n).zip(pixels.skip(columns.start)) {
            to[..from.len()].copy_from_slice(from);
        }
    }
}

/// A case from a seed.
struct Case {
    width: usize,
    height: usize,
    threads: usize,
    budget: u64,
    least_columns: usize,
    params: Params,
    cost: Volume<u8>,
    gray: Plane<u8>,
}

impl Case {
    fn new(random: &mut ChaCha8Rng) -> Self {
        let pick = |random: &mut ChaCha8Rng, values: &[usize]| values[random.random_range(0..values.len())];
        let disparities = pick(random, &[1, 2, 3, 5, 31, 32, 33, 63, 64, 65, 90, 96, 127, 128, 129, 200]);
        let mut params = Params::sgm(disparities as u32);
        params.min_disparity = [0, 0, 0, 3, -2, -20, 40, -300, 300][random.random_range(0..9)];
        params.paths =
            [Paths::Three, Paths::Four, Paths::Five, Paths::Eight, Paths::Sixteen][random.random_range(0..5)];
        params.passes = random.random_range(1..=2);
        params.p2 = random.random_range(0..=if params.passes == 2 { 110 } else { 127 });
        params.p1 = random.random_range(0..=params.p2);
        params.adaptive_p2 = random.random_bool(0.4);
        params.p2_step = random.random_range(1..=255);
        params.adaptive_p1 = random.random_bool(0.4);
        params.uniqueness = [0, 1, 10, 50, 99][random.random_range(0..5)];
        params.subpixel = [Subpixel::Off, Subpixel::Parabola, Subpixel::Equiangular][random.random_range(0..3)];
        let width = pick(random, &[1, 2, 3, 4, 7, 16, 23, 40, 61]);
        let height = pick(random, &[1, 2, 3, 4, 5, 8, 13, 21]);
        // From flat to noisy, so that ties and saturated steps occur.
        let (least, most) = [(0, 89), (0, 1), (89, 89), (40, 60), (0, 0)][random.random_range(0..5)];
        let mut cost = Volume::new(width, height, disparities);
        cost.data.fill_with(|| random.random_range(least..=most));
        let steps = [1, 256][random.random_range(0..2)];
        let data =
            (0..width * height).map(|i| ((i / 3 * 37) as u8).wrapping_add((random.random_range(0..steps)) as u8));
        Self {
            gray: Plane { width, height, data: data.collect() },
            threads: pick(random, &[1, 2, 3, 5, 8]),
            budget: [0, 3000, u64::MAX][random.random_range(0..3)],
            least_columns: pick(random, &[1, 1, 7, 1000]),
            width,
            height,
            params,
            cost,
        }
    }

    fn check(&self, instructions: Instructions, name: &str) {
        let Self { width, height, threads, budget, least_columns, params, cost, gray } = self;
        let name = format!(
            "{name}: {width}x{height}, {threads} threads, budget {budget}, {least_columns} columns, {params:?}"
        );
        let made = params.adapts_penalties().then(|| penalties(gray, params));
        let wanted = params.adapts_penalties().then(|| reference::penalties(gray, params));
        assert_eq!(made, wanted, "penalties, {name}");
        let mut sum = reference::sgm_aggregate(cost, wanted.as_ref(), params);
        let second = params.aggregates_twice().then(|| reference::second_cost(cost, &sum, params));
        if let Some(cost) = &second {
            sum = reference::sgm_aggregate(cost, wanted.as_ref(), params);
        }
        let views = reference::winner(&sum, params);
        let n = (params.disparities as usize).next_multiple_of(32);
        let buffers = Buffers::default();
        let job = Aggregation {
            budget: *budget,
            least_columns: *least_columns,
            ..Aggregation::new([*width, *height], params, made.as_ref(), instructions, &buffers)
        };
        let source = || Box::new(Given(cost, n)) as Box<dyn CostSource + Send + '_>;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(*threads).build().unwrap();
        let mut record = Record::new(*width, *height, params);
        let made = second.as_ref().map(|_| pool.install(|| second_cost(&job, &source, Some(&mut record))));
        let given = || Box::new(made.as_ref().unwrap()) as Box<dyn CostSource + Send + '_>;
        let (cost, sources): (_, Sources<'_>) = match (&second, &made) {
            (Some(second), Some(made)) => {
                let first = reference::sgm_aggregate(cost, wanted.as_ref(), params);
                assert_same(&record.cost.data, &cost.data, cost.disparities, &format!("matching_cost, {name}"));
                assert_same(&record.sum.data, &first.data, cost.disparities, &format!("first sgm_aggregate, {name}"));
                let made = made.volume(params).data;
                assert_same(&made, &second.data, cost.disparities, &format!("second_cost, {name}"));
                (second, &given)
            }
            _ => (cost, &source),
        };
        let recorded = pool.install(|| aggregate(&job, sources, Some(&mut record)));
        assert_same(&record.cost.data, &cost.data, cost.disparities, &format!("matching_cost, {name}"));
        assert_same(&record.sum.data, &sum.data, cost.disparities, &format!("sgm_aggregate, {name}"));
        for made in [recorded, pool.install(|| aggregate(&job, sources, None))] {
            assert_same(&made.left.data, &views.left.data, 1, &format!("left, {name}"));
            assert_same(&made.right.data, &views.right.data, 1, &format!("right, {name}"));
            assert_same(&made.margins.data, &views.margins.data, 1, &format!("margins, {name}"));
            assert_same(&made.labels, &views.labels, 1, &format!("labels, {name}"));
        }
    }
}

/// Names the first pixel and disparity that differ.
fn assert_same<T: PartialEq + std::fmt::Debug>(made: &[T], wanted: &[T], disparities: usize, name: &str) {
    assert_eq!(made.len(), wanted.len(), "{name}");
    if let Some(i) = (0..made.len()).find(|&i| made[i] != wanted[i]) {
        let (pixel, d) = (i / disparities, i % disparities);
        panic!("pixel {pixel}, disparity {d}: {:?}, not {:?}: {name}", made[i], wanted[i]);
    }
}

#[test]
fn equals_the_definition() {
    let instructions = Instructions::all();
    for seed in 0..160 {
        let case = Case::new(&mut ChaCha8Rng::seed_from_u64(seed));
        case.check(instructions[seed as usize % instructions.len()], &format!("seed {seed}"));
    }
}

/// More disparities than a key of 16 bits counts blocks of.
#[test]
fn equals_the_definition_at_thousands_of_disparities() {
    let instructions = Instructions::all();
    for (seed, paths) in [Paths::Three, Paths::Eight, Paths::Sixteen].into_iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(seed as u64);
        let mut case = Case::new(&mut random);
        case.params.paths = paths;
        (case.params.min_disparity, case.params.disparities) = (-2000, 4000);
        (case.width, case.height) = (5, 3);
        (case.cost, case.gray) = (Volume::new(5, 3, 4000), Plane { width: 5, height: 3, data: (0..15).collect() });
        case.cost.data.fill_with(|| random.random_range(60..=62));
        for d in [2500, 3999] {
            case.cost.data[7 * 4000 + d] = 0;
        }
        case.check(instructions[instructions.len() - 1], &format!("seed {seed}"));
    }
}

#[test]
fn large_pairs_fit_the_memory() {
    let instructions = Instructions::all()[0];
    let buffers = Buffers::default();
    for (paths, gigabytes) in [(Paths::Three, 1.0), (Paths::Four, 2.0), (Paths::Eight, 2.0), (Paths::Sixteen, 4.0)] {
        let params = Params { paths, ..Params::sgm(256) };
        let job = Aggregation::new([8000, 6000], &params, None, instructions, &buffers);
        let bytes = job.bytes(2) as f64 / f64::from(1 << 30);
        assert!((0.3..gigabytes).contains(&bytes), "{paths:?}: {bytes} GiB");
        // Where all fits, nothing is computed twice.
        let small = Aggregation::new([741, 500], &params, None, instructions, &buffers);
        assert!(small.bytes(2) < 1 << 30, "{paths:?}: {}", small.bytes(2));
    }
}

/// The test of the test: one cost that differs is found.
#[test]
fn a_single_cost_that_differs_is_found() {
    let case = Case::new(&mut ChaCha8Rng::seed_from_u64(3));
    let instructions = Instructions::all()[0];
    let n = (case.params.disparities as usize).next_multiple_of(32);
    let mut other = case.cost.clone();
    other.data[0] ^= 1;
    let source = || Box::new(Given(&other, n)) as Box<dyn CostSource + Send + '_>;
    let buffers = Buffers::default();
    let job = Aggregation::new([case.width, case.height], &case.params, None, instructions, &buffers);
    let mut record = Record::new(case.width, case.height, &case.params);
    aggregate(&job, &source, Some(&mut record));
    let sum = reference::sgm_aggregate(&case.cost, None, &case.params);
    assert!(record.sum.data != sum.data && record.cost.data == other.data);
}
