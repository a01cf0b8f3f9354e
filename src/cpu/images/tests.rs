//! Stages gray to descriptors beside the definition: every format, prefilter and cost, on odd sizes.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cpu::cost::tests::{pair, settings};
use crate::cpu::images::{Channels, Planes, Side, luma};
use crate::cpu::instructions::Instructions;
use crate::params::{Cost, Named};
use crate::reference::{self, Channel};

#[test]
fn stages_from_gray_to_descriptors_equal_the_definition() {
    for (number, cost) in Cost::VALUES.iter().flat_map(|&cost| [cost; 8]).enumerate() {
        let seed = number as u64;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let params = settings(&mut random, cost);
        let sizes = [(1, 1), (1, 9), (23, 1), (30, 7), (75, 11)];
        let (width, height) = sizes[random.random_range(0..sizes.len())];
        let what = format!("seed {seed}, {width} x {height}, {params:?}");
        let pair = pair(&mut random, width, height);
        let images = pair.each_ref().map(|image| reference::images(image, &params));
        let filtered = images.each_ref().map(|images| images.prefiltered(&params));
        let descriptors = filtered.each_ref().map(|filtered| filtered.descriptors(&params));
        for set in Instructions::all() {
            let what = format!("{}, {what}", set.name());
            for i in 0..2 {
                assert!(luma((&pair[i]).into(), set) == reference::gray(&pair[i], Channel::Luma), "luma, {what}");
                let channels = Channels::new((&pair[i]).into(), &params, set);
                assert!(channels.images() == images[i], "gray, {what}");
                let channels = channels.prefiltered(&params);
                assert!(channels.images() == filtered[i], "prefilter, {what}");
                let features = channels.features(&params);
                let features = features.as_ref();
                let left = channels.planes(Side::Left, features, &params);
                assert!(left.descriptors(&params) == descriptors[i], "descriptors, {what}");
                let right = channels.planes(Side::Right, features, &params);
                for (side, made) in [(Side::Left, left), (Side::Right, right)] {
                    let expected = Planes::of(&descriptors[i], side, &params);
                    assert!((0..i64::from(height)).all(|y| made.row(y) == expected.row(y)), "{side:?}, {what}");
                }
            }
        }
    }
}

/// What the cost reads of the right side is the pixel at each disparity, or the nearest one.
#[test]
fn right_planes_are_mirrored_and_continued() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..30 {
        let params = settings(&mut random, Cost::Sad);
        let params = crate::Params { color_cost: false, ..params };
        let [_, right] = pair(&mut random, 19, 3);
        let descriptors = reference::images(&right, &params).prefiltered(&params).descriptors(&params);
        let planes = Planes::of(&descriptors, Side::Right, &params);
        let (radius, n) = (i64::from(params.radius()), i64::from(params.disparities));
        for (column, d) in (0..19 + 2 * radius).flat_map(|c| (0..n).map(move |d| (c, d))) {
            let disparity = i64::from(params.min_disparity) + d;
            let expected = descriptors.clamped(column - radius - disparity, 1)[0];
            assert_eq!(planes.row(1)[(19 + 2 * radius - 1 - column + d) as usize], expected, "{params:?}");
        }
    }
}
