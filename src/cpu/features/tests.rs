//! The features of whole images beside the definition: networks and sizes at random.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cpu::features::FeatureRows;
use crate::cpu::images::{Channels, Samples};
use crate::cpu::instructions::Instructions;
use crate::features::{FeatureNetwork, Layer, LayerKind};
use crate::params::Params;
use crate::reference::{Channel, deep_gray, depth_unit, feature_statistics, features_of};
use crate::{Image, Pixels};

/// A network of a few channels, with weights that make most of their range of the values.
pub(crate) fn network(random: &mut ChaCha8Rng) -> FeatureNetwork {
    let count = random.random_range(1..=6);
    let mut inputs = 1;
    let layers = (0..count).map(|at| {
        let kind = if at == 0 { LayerKind::Convolution } else { LayerKind::ALL[random.random_range(0..3)] };
        let outputs = if kind == LayerKind::Depthwise { inputs } else { 4 * random.random_range(2..=5) };
        let each = kind.weights(inputs);
        let weights = (0..outputs * each).map(|_| random.random_range(-127..=127)).collect();
        // Sums of about 40 * 73 * the root of their number become about 50, or 500 in the end.
        let typical = 2920.0 * f64::from(each as u32).sqrt() / if at + 1 == count { 500.0 } else { 50.0 };
        let numbers = |random: &mut ChaCha8Rng| -> (i32, i32) {
            let shift = random.random_range(9..=13);
            ((f64::from(1 << shift) / typical * random.random_range(0.5..2.0)) as i32 + 1, shift)
        };
        let (multiplier, shift) = (0..outputs).map(|_| numbers(random)).unzip();
        let bias = (0..outputs).map(|_| random.random_range(-3000..3000)).collect();
        let relu = at + 1 < count && random.random();
        let layer = Layer { kind, relu, inputs, outputs, weights, bias, multiplier, shift };
        inputs = outputs;
        layer
    });
    FeatureNetwork::new(layers.collect()).unwrap()
}

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
        let network = if seed < 9 { FeatureNetwork::built_in() } else { network(&mut random) };
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
