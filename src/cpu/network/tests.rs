//! Every operation beside the definition, on odd sizes.

use super::activation::{Activation, Source};
use super::convolutions::{Finish, convolution};
use super::images::{average_pool, concat, input, stored, upsample};
use super::regression::disparity_regression;
use super::transposed::transposed;
use crate::network::{Convolution, Padded, Tensor};
use crate::reference::{self, Values};
use crate::{Image, Pixels};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn values(random: &mut ChaCha8Rng, shape: [usize; 4]) -> Values {
    let mut value = || f64::from(random.random_range(-1.0_f32..1.0));
    Values { shape, data: (0..shape.iter().product()).map(|_| value()).collect() }
}

fn weights(random: &mut ChaCha8Rng, shape: &[usize]) -> Convolution {
    let mut numbers = |count: usize| (0..count).map(|_| random.random_range(-1.0_f32..1.0)).collect::<Vec<_>>();
    let bias = numbers(shape[0]);
    Convolution { weights: Tensor::new(shape.to_vec(), numbers(shape.iter().product())).unwrap(), bias }
}

/// `add` and ReLU as the definition's `operation` does them.
fn finished(mut values: Values, add: Option<&Values>, relu: bool) -> Values {
    for (i, value) in values.data.iter_mut().enumerate() {
        *value += add.map_or(0.0, |add| add.data[i]);
        *value = if relu { value.max(0.0) } else { *value };
    }
    values
}

fn assert_close(made: &Activation, wanted: &Values, what: &str) {
    assert_eq!(made.shape, wanted.shape, "{what}");
    let wanted = stored(wanted);
    for (i, (made, wanted)) in made.data.iter().zip(&wanted.data).enumerate() {
        assert!((made - wanted).abs() < 1e-4, "{what}: value {i} is {made}, not {wanted}");
    }
}

#[test]
fn convolutions_are_those_of_the_definition() {
    let mut random = ChaCha8Rng::seed_from_u64(14);
    // Channels, planes, rows and columns of the input; output channels, side, stride, dilation.
    for (shape, [outputs, side, stride, dilation]) in [
        ([3, 1, 7, 300], [5, 3, 1, 1]),
        ([3, 1, 37, 11], [32, 3, 1, 2]),
        ([5, 1, 9, 17], [4, 3, 2, 1]),
        ([9, 1, 8, 14], [11, 1, 1, 1]),
        ([9, 1, 8, 13], [11, 1, 2, 1]),
        ([2, 1, 1, 1], [3, 3, 1, 2]),
        ([3, 5, 7, 19], [9, 3, 1, 1]),
        ([3, 6, 7, 20], [9, 3, 2, 1]),
        ([8, 3, 5, 9], [1, 3, 1, 1]),
    ] {
        let volume = shape[1] > 1;
        let taps: &[usize] = if volume { &[side; 3] } else { &[side; 2] };
        let weights = weights(&mut random, &[&[outputs, shape[0]], taps].concat());
        let from = values(&mut random, shape);
        let plain = reference::convolution(&from, &weights, stride, dilation);
        let add = values(&mut random, plain.shape);
        for (add, relu) in [(None, true), (Some(&add), true), (Some(&add), false)] {
            let stored_add = add.map(stored);
            let finish = Finish { bias: &weights.bias, add: stored_add.as_ref(), relu };
            let made = convolution(Source::One(&stored(&from)), &weights, [stride, dilation], finish);
            assert_close(&made, &finished(plain.clone(), add, relu), &format!("{shape:?}, {outputs} of {side}"));
        }
    }
}

#[test]
fn the_volume_of_features_is_read_without_being_stored() {
    let mut random = ChaCha8Rng::seed_from_u64(15);
    // With more planes than columns, too.
    for (columns, planes) in [(21, 6), (5, 8)] {
        let [left, right] = [(); 2].map(|()| values(&mut random, [4, 1, 6, columns]));
        let weights = weights(&mut random, &[7, 8, 3, 3, 3]);
        let wanted = reference::convolution(&reference::feature_volume(&left, &right, planes), &weights, 1, 1);
        let finish = Finish { bias: &weights.bias, add: None, relu: false };
        let made = convolution(Source::Pair(&stored(&left), &stored(&right), planes), &weights, [1, 1], finish);
        assert_close(&made, &wanted, "volume");
    }
}

#[test]
fn transposed_convolutions_are_those_of_the_definition() {
    let mut random = ChaCha8Rng::seed_from_u64(16);
    for shape in [[3, 2, 5, 70], [4, 3, 1, 1], [2, 1, 9, 3]] {
        let from = values(&mut random, shape);
        let weights = weights(&mut random, &[5, shape[0], 3, 3, 3]);
        let plain = reference::conv3d_transposed(&from, &weights);
        let add = values(&mut random, plain.shape);
        let stored_add = stored(&add);
        let finish = Finish { bias: &weights.bias, add: Some(&stored_add), relu: true };
        let made = transposed(&stored(&from), &weights, finish);
        assert_close(&made, &finished(plain, Some(&add), true), &format!("{shape:?}"));
    }
}

#[test]
fn what_is_beside_convolutions_is_that_of_the_definition() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let image = values(&mut random, [3, 1, 20, 27]);
    assert_close(&average_pool(&stored(&image), 4), &reference::average_pool(&image, 4), "average_pool");
    for align_corners in [true, false] {
        let wanted = reference::upsample(&image, 31, 64, align_corners);
        assert_close(&upsample(&stored(&image), 31, 64, align_corners), &wanted, "upsample");
        let mut scores = values(&mut random, [1, 4, 5, 7]);
        scores.data.iter_mut().for_each(|score| *score *= 9.0);
        let wanted = reference::disparity_regression(&scores, [16, 20, 28], align_corners);
        assert_close(&disparity_regression(&stored(&scores), 16, align_corners), &wanted, "disparity_regression");
    }
    let other = values(&mut random, [2, 1, 20, 27]);
    let wanted = Values { shape: [5, 1, 20, 27], data: [&image.data[..], &other.data].concat() };
    assert_close(&concat(&[&stored(&image), &stored(&other)]), &wanted, "concat");
    let pixels = Pixels::Rgba8((0..40 * 3 * 4).map(|i| (i * 31 % 251) as u8).collect());
    let (image, padded) = (Image::new(40, 3, pixels).unwrap(), Padded::new(40, 3, 16));
    assert_close(&input((&image).into(), &padded), &reference::network_input(&image, &padded), "network_input");
}
