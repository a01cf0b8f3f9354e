//! Winners of rows of costs beside the definition's.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::rows::Costs;
use super::{RowOfMaps, WinnerRow};
use crate::cpu::instructions::Instructions;
use crate::reference::{Volume, winner};
use crate::{Params, Subpixel};

/// The winners of a row whose costs lie in `least ..= most`.
fn check<T: Costs + TryFrom<u32> + std::fmt::Debug>(random: &mut ChaCha8Rng, most: u32, instructions: Instructions) {
    let disparities = [1usize, 2, 3, 4, 31, 32, 33, 64, 100, 256][random.random_range(0..10)];
    let mut params = Params::bm(disparities as u32);
    params.min_disparity = [0, 1, -1, 20, -20, -400][random.random_range(0..6)];
    params.uniqueness = [0, 1, 15, 99][random.random_range(0..4)];
    params.subpixel = [Subpixel::Off, Subpixel::Parabola, Subpixel::Equiangular][random.random_range(0..3)];
    params.opencv_rules = random.random();
    let width = [1, 2, 5, 33, 70][random.random_range(0..5)];
    let least = [0, most / 2, most, most - most.min(2)][random.random_range(0..4)];
    let costs: Vec<u32> = (0..width * disparities).map(|_| random.random_range(least..=most)).collect();
    let n = disparities.next_multiple_of(32);
    let number = |value: u32| T::try_from(value).ok().unwrap();
    let mut rows = vec![number(7); width * n];
    for (to, from) in rows.chunks_exact_mut(n).zip(costs.chunks_exact(disparities)) {
        to.iter_mut().zip(from).for_each(|(to, &from)| *to = number(from));
    }
    let (mut left, mut right, mut margins, mut labels) =
        (vec![1; width], vec![1; width], vec![1; width], vec![1; width]);
    let mut finder = WinnerRow::<T>::new(width, &params, instructions);
    for _ in 0..2 {
        let to = RowOfMaps { left: &mut left, right: &mut right, margins: &mut margins, labels: &mut labels };
        finder.row(&mut rows, &params, to);
    }
    let wanted = crate::reference::winner_of_row(&costs, &params);
    assert_eq!((left, right, margins, labels), wanted, "{width} columns, up to {most}, {params:?}");
    if most < 65536 {
        let volume = Volume { width, height: 1, disparities, data: costs.iter().map(|&cost| cost as u16).collect() };
        assert_eq!(winner(&volume, &params).labels, wanted.3);
    }
}

#[test]
fn rows_of_costs_have_the_winners_of_the_definition() {
    let instructions = Instructions::all();
    for seed in 0..200 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let set = instructions[seed as usize % instructions.len()];
        let most = [1, 300, 65534][random.random_range(0..3)];
        check::<u16>(&mut random, most, set);
        let most = [1, 300, 65534, (1 << 20) - 1][random.random_range(0..4)];
        check::<u32>(&mut random, most, set);
    }
}
