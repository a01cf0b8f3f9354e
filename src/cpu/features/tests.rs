//! The features of whole images beside the definition: networks and sizes at random.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cpu::features::FeatureRows;
use crate::cpu::images::{Channels, Samples};
use crate::cpu::instructions::Instructions;
use crate::features::FeatureNetwork;
use crate::params::Params;
use crate::reference::{Channel, deep_gray, depth_unit, feature_statistics, features_of};
use crate::{Image, Pixels};

#[allow(clippy::duplicate_mod)] // the tests of devices share it
#[path = "../../../tests/support/feature_network.rs"]
mod random;
pub(crate) use random::feature_network;

fn image(random: &mut ChaCha8Rng, width: u32, height: u32) -> Image {
    let flat = random.random_range(0..5) == 0;
    let mut values = (0..width * height).map(|_| if flat { 77 * 256 } else { random.random::<u16>() });
    let pixels = match width % 2 {
        0 => Pixels::Gray8(values.by_ref().map(|v| (v >> 8) as u8).collect()),
        _ => Pixels::Gray16(values.by_ref().collect()),
    };
    Image::new(width, height, pixels).unwrap()
}

#[test]
fn features_equal_the_definition() {
    let sizes = [(1, 1), (1, 9), (2, 3), (3, 2), (23, 1), (30, 7), (151, 53), (290, 9), (145, 1)];
    for (seed, (width, height)) in (0..).zip(sizes.iter().cycle().take(40)) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let network = if seed < 9 { FeatureNetwork::built_in() } else { feature_network(&mut random) };
        let image = image(&mut random, *width, *height);
        let (plane, unit) = (deep_gray(&image, Channel::Luma), depth_unit(&image));
        let expected = features_of(&plane, unit, &network);
        for set in Instructions::all() {
            let channels = Channels::new((&image).into(), &Params::sgm(1), set);
            let made = FeatureRows::new(&channels.channels[0], &network, set);
            assert_eq!(made.statistics, feature_statistics(&plane, unit), "{}, seed {seed}", set.name());
            assert!(made.descriptors() == expected, "{}, seed {seed}, {width} x {height}", set.name());
        }
    }
}

/// GMAC a second on this machine: `cargo test --release --lib measured_speed -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn measured_speed() {
    let image = image(&mut ChaCha8Rng::seed_from_u64(1), 1242, 375);
    let network = FeatureNetwork::built_in();
    for set in Instructions::all() {
        let channels = Channels::new((&image).into(), &Params::sgm(1), set);
        let samples: &Samples = &channels.channels[0];
        let time = || {
            let start = std::time::Instant::now();
            FeatureRows::new(samples, &network, set);
            start.elapsed().as_secs_f64()
        };
        let best = (0..7).map(|_| time()).fold(f64::INFINITY, f64::min);
        let work = (1242 * 375 * network.multiplications()) as f64;
        println!("{}: {:.1} ms, {:.1} GMAC/s", set.name(), 1e3 * best, work / best / 1e9);
    }
}
