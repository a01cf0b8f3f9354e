use crate::FeatureNetwork;
use crate::features::{Layer, LayerKind};
use crate::reference::{
    FeatureStatistics, FeatureValues, Plane, feature_input, feature_layer, feature_statistics, features,
};

fn plane(width: usize, data: Vec<u16>) -> Plane<u16> {
    Plane { width, height: data.len() / width, data }
}

fn statistics(mean: u32, deviation: u32) -> FeatureStatistics {
    FeatureStatistics { mean, deviation }
}

#[test]
fn statistics_are_those_of_hand() {
    // Half black, half white: the mean is 127.5 levels, and so is the deviation, of which 64 are a level.
    let two = plane(2, vec![0, 255]);
    assert_eq!(feature_statistics(&two, 1), statistics(32640, 8160));
    // The same in 16 bits: bins 0 and 1023.
    assert_eq!(feature_statistics(&plane(2, vec![0, 65535]), 257), statistics(32736 + 32, 8184));
    // All alike.
    assert_eq!(feature_statistics(&plane(1, vec![7; 5]), 1), statistics(1792, 1));
    // Values 10, 10, 13: of bins 40, 40, 52 the mean is 44; (16 + 16 + 64) / 3 = 32, 256 times that 8192.
    assert_eq!(feature_statistics(&plane(3, vec![10, 10, 13]), 1), statistics(2816, 90));
    // Of more than 8192 pixels counts are halved, upwards: of 8192 and 1 they are 4096 and 1.
    let mut many = vec![0; 8193];
    many[5] = 255;
    assert_eq!(feature_statistics(&plane(8193, many), 1), statistics(64 * 1020 / 4097, 254));
}

#[test]
fn every_bin_alike_leaves_none_out() {
    // 4 million pixels over all values of 16 bits.
    let all = plane(1 << 11, (0..1_u32 << 22).map(|i| (i % 65536) as u16).collect());
    let FeatureStatistics { mean, deviation } = feature_statistics(&all, 257);
    assert_eq!((mean, deviation), (32736 + 32, 4729)); // 65536 / sqrt(12) / 4 = 4729.6
}

#[test]
fn the_input_has_32_to_a_deviation() {
    let input = |values: &[u16], of| feature_input(&plane(values.len(), values.to_vec()), 1, of).data;
    // A deviation of 10 levels.
    assert_eq!(input(&[100, 110, 90, 255, 0], statistics(25600, 640)), [0, 32, -32, 127, -127]);
    // A half is rounded away from the mean: a level is half of 1 where the deviation is 64 levels.
    assert_eq!(input(&[101, 99, 102], statistics(25600, 4096)), [1, -1, 1]);
    let deep = feature_input(&plane(2, vec![65535, 0]), 257, statistics(0, 1));
    assert_eq!(deep.data, [127, 0]);
}

/// A layer of eight outputs that all are alike.
fn layer(kind: LayerKind, inputs: usize, weights: &[i8]) -> Layer {
    let [bias, multiplier, shift] = [5, 3, 2].map(|v| vec![v; 8]);
    Layer { kind, relu: false, inputs, outputs: 8, weights: weights.repeat(8), bias, multiplier, shift }
}

#[test]
fn layers_are_those_of_hand() {
    let input = FeatureValues { width: 2, height: 1, channels: 1, data: vec![10, -20] };
    let convolution = layer(LayerKind::Convolution, 1, &[1, 0, 0, 0, 2, 0, 0, 0, 4]);
    assert!(FeatureNetwork::new(vec![convolution.clone()]).is_ok());
    // (0, 0): 10 + 2 * 10 - 4 * 20 + 5 = -45; (-45 * 3 + 2) >> 2 = -34. (1, 0): 10 - 40 - 80 + 5 = -105; -79.
    let made = feature_layer(&input, &convolution, true);
    assert_eq!((made.channels, &made.data[..4]), (8, &[-34, -79, -34, -79][..]));
    let relu = Layer { relu: true, ..convolution };
    assert_eq!(feature_layer(&input, &relu, false).data, [0; 16]);
    let depthwise = layer(LayerKind::Depthwise, 8, &[0, 0, 0, 0, 0, 1, 0, 0, 0]);
    // The pixel to the right: (-79 + 5) * 3 >> 2 = -55.
    assert_eq!(feature_layer(&made, &depthwise, false).data[..2], [-55, -55]);
    let points = layer(LayerKind::Point, 8, &[-100; 8]);
    // 800 * 34 + 5 = 27205, three quarters of it.
    assert_eq!(feature_layer(&made, &points, false).data[..2], [127, 127]);
    assert_eq!(feature_layer(&made, &points, true).data[..2], [2047, 2047]);
}

#[test]
fn features_have_one_length() {
    let of = |data: Vec<i16>| features(&FeatureValues { width: 1, height: 1, channels: data.len(), data }).data;
    assert_eq!(of(vec![3, 4, 0, 0]), [128 + 102, 255, 128, 128]); // 170 * 4 / 5 is clamped
    assert_eq!(of(vec![-3, 4, 0, 12]), [128 - 39, 128 + 52, 128, 255]); // 170 / 13 = 13.08
    assert_eq!(of(vec![0; 8]), [128; 8]);
    assert_eq!(of(vec![1, -1]), [128 + 85, 128 - 85]); // the root of 2 is 2, upwards
    assert_eq!(of(vec![1; 8]), [128 + 57; 8]); // of 8 it is 3
}
