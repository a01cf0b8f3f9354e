//! Each operation on values that can be computed by hand.

use super::*;
use crate::network::{Convolution, Padded, Tensor};
use crate::reference::Plane;
use crate::{Image, Pixels};

fn values(shape: [usize; 4], data: &[f64]) -> Values {
    assert_eq!(shape.iter().product::<usize>(), data.len());
    Values { shape, data: data.to_vec() }
}

/// 1, 2, 3 ..
fn counted(shape: [usize; 4]) -> Values {
    let data: Vec<f64> = (1..=shape.iter().product::<usize>()).map(|i| i as f64).collect();
    values(shape, &data)
}

fn weights(shape: &[usize], data: &[f32], bias: &[f32]) -> Convolution {
    Convolution { weights: Tensor::new(shape.to_vec(), data.to_vec()).unwrap(), bias: bias.to_vec() }
}

/// One tap of 3x3: what it reads, shifted by one to the right and one down, is left over.
#[test]
fn convolutions_read_zeros_beyond_the_border() {
    let image = counted([1, 1, 3, 4]);
    let tap = |at: usize| {
        let mut data = [0.0; 9];
        data[at] = 2.0;
        weights(&[1, 1, 3, 3], &data, &[0.5])
    };
    // The first tap is above and to the left: no flip.
    let made = convolution(&image, &tap(0), 1, 1);
    let wanted = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 0.0, 5.0, 6.0, 7.0].map(|value| 2.0 * value + 0.5);
    assert_eq!(made, values([1, 1, 3, 4], &wanted));
    // Every second one, centred on 0 and 2.
    let made = convolution(&image, &tap(8), 2, 1);
    assert_eq!(made, values([1, 1, 2, 2], &[12.5, 16.5, 0.5, 0.5]));
    let made = convolution(&image, &tap(4), 2, 1);
    assert_eq!(made, values([1, 1, 2, 2], &[2.5, 6.5, 18.5, 22.5]));
    // Two apart.
    let made = convolution(&image, &tap(5), 1, 2);
    let wanted = [3.0, 4.0, 0.0, 0.0, 7.0, 8.0, 0.0, 0.0, 11.0, 12.0, 0.0, 0.0].map(|value| 2.0 * value + 0.5);
    assert_eq!(made, values([1, 1, 3, 4], &wanted));
    // 1x1, from two channels to two.
    let image = counted([2, 1, 1, 3]);
    let made = convolution(&image, &weights(&[2, 2, 1, 1], &[1.0, 10.0, 0.0, -1.0], &[0.0, 100.0]), 1, 1);
    assert_eq!(made, values([2, 1, 1, 3], &[41.0, 52.0, 63.0, 96.0, 95.0, 94.0]));
    assert_eq!(
        convolution(&image, &weights(&[1, 2, 1, 1], &[1.0, 1.0], &[0.0]), 2, 1),
        values([1, 1, 1, 2], &[5.0, 9.0])
    );
}

#[test]
fn convolutions_of_volumes_have_planes_first() {
    let volume = counted([1, 3, 2, 2]);
    let mut data = [0.0; 27];
    data[9 + 4] = 1.0; // the middle
    data[18 + 3 + 2] = 100.0; // the next plane, the next column
    let weights = weights(&[1, 1, 3, 3, 3], &data, &[0.0]);
    let wanted = [601.0, 2.0, 803.0, 4.0, 1005.0, 6.0, 1207.0, 8.0, 9.0, 10.0, 11.0, 12.0];
    assert_eq!(convolution(&volume, &weights, 1, 1), values([1, 3, 2, 2], &wanted));
    assert_eq!(convolution(&volume, &weights, 2, 1), values([1, 2, 1, 1], &[601.0, 9.0]));
}

#[test]
fn transposed_convolutions_double_the_sides() {
    let mut data = [0.0; 27];
    for (tap, value) in [(12, 1.0), (13, 10.0), (14, 100.0)] {
        data[tap] = value; // the middle plane and row
    }
    data[26] = 0.5; // the last of all
    let made = conv3d_transposed(&values([1, 1, 1, 2], &[2.0, 3.0]), &weights(&[1, 1, 3, 3, 3], &data, &[7.0]));
    assert_eq!(made.shape, [1, 2, 2, 4]);
    assert_eq!(made.row(0, 0, 0), [27.0, 7.0 + 200.0 + 3.0, 37.0, 307.0]);
    assert_eq!(made.row(0, 0, 1), [7.0; 4]);
    assert_eq!(made.row(0, 1, 0), [7.0; 4]);
    assert_eq!(made.row(0, 1, 1), [7.0, 8.0, 7.0, 8.5]);
}

#[test]
fn the_volume_pairs_columns_of_a_disparity() {
    let (left, right) = (counted([1, 1, 1, 3]), values([1, 1, 1, 3], &[10.0, 20.0, 30.0]));
    let volume = feature_volume(&left, &right, 4);
    assert_eq!(volume.shape, [2, 4, 1, 3]);
    assert_eq!(
        [0, 1, 2, 3].map(|i| volume.row(0, i, 0).to_vec()),
        [[1.0, 2.0, 3.0], [0.0, 2.0, 3.0], [0.0, 0.0, 3.0], [0.0; 3]]
    );
    assert_eq!(
        [0, 1, 2, 3].map(|i| volume.row(1, i, 0).to_vec()),
        [[10.0, 20.0, 30.0], [0.0, 10.0, 20.0], [0.0, 0.0, 10.0], [0.0; 3]]
    );
}

#[test]
fn squares_that_are_not_whole_are_left_out() {
    let made = average_pool(&counted([2, 1, 3, 5]), 2);
    assert_eq!(made, values([2, 1, 1, 2], &[4.0, 6.0, 19.0, 21.0]));
}

#[test]
fn corners_or_ends_lie_on_each_other() {
    let of = |align| (0..6).map(|at| neighbours(at, 3, 6, align)).collect::<Vec<_>>();
    let places = |align: bool| of(align).iter().map(|&(first, _, share)| first as f64 + share).collect::<Vec<_>>();
    assert_eq!(places(false), [0.0, 0.25, 0.75, 1.25, 1.75, 2.25]);
    for (place, at) in places(true).iter().zip(0..) {
        assert!((place - 0.4 * f64::from(at)).abs() < 1e-12, "{place}");
    }
    // The last one has no next.
    assert_eq!((of(true)[5], of(false)[5]), ((2, 2, 0.0), (2, 2, 0.25)));
    assert_eq!(neighbours(5, 1, 9, true), (0, 0, 0.0));
    assert_eq!(neighbours(0, 4, 1, true), (0, 1, 0.0));
    let small = values([1, 1, 2, 2], &[0.0, 3.0, 6.0, 9.0]);
    let made = upsample(&small, 2, 4, true);
    for (made, wanted) in made.data.iter().zip([0.0, 1.0, 2.0, 3.0, 6.0, 7.0, 8.0, 9.0]) {
        assert!((made - wanted).abs() < 1e-12);
    }
    assert_eq!(upsample(&small, 4, 2, false).data, [0.0, 3.0, 1.5, 4.5, 4.5, 7.5, 6.0, 9.0]);
}

#[test]
fn disparities_are_means_of_a_softmax() {
    // Equal scores: the mean of 0 to 15.
    let flat = disparity_regression(&values([1, 4, 1, 1], &[5.0; 4]), [16, 1, 1], true);
    assert!((flat.data[0] - 7.5).abs() < 1e-12);
    // Scores that rise by ln 2 from plane to plane; without corners the first and last two of each end are equal.
    let scores = values([1, 4, 1, 1], &[0.0, 1.0, 2.0, 3.0].map(|d| 5.0 * d * f64::ln(2.0)));
    let made = disparity_regression(&scores, [16, 1, 1], true).data[0];
    let all: f64 = (0..16).map(|d| f64::exp2(f64::from(d))).sum();
    let wanted = (0..16).map(|d| f64::from(d) * f64::exp2(f64::from(d))).sum::<f64>() / all;
    assert!((made - wanted).abs() < 1e-9, "{made} {wanted}");
    let made = disparity_regression(&scores, [16, 1, 1], false).data[0];
    let place = |d: u32| 5.0 * ((f64::from(d) + 0.5) / 4.0 - 0.5).clamp(0.0, 3.0);
    let all: f64 = (0..16).map(|d| place(d).exp2()).sum();
    let wanted = (0..16).map(|d| f64::from(d) * place(d).exp2()).sum::<f64>() / all;
    assert!((made - wanted).abs() < 1e-9, "{made} {wanted}");
    // Huge scores do not overflow.
    assert_eq!(disparity_regression(&values([1, 4, 1, 1], &[0.0, 0.0, 0.0, 1e6]), [16, 1, 1], true).data, [15.0]);
}

#[test]
fn disparities_are_rounded_to_sixteenths() {
    let near = f32::from_bits((1.0_f32 / 32.0).to_bits() - 1); // 16 p + 1/2 would become 1 in f32
    let data = vec![0.0, near, 1.0 / 32.0, 3.0 / 32.0, 14.99, 15.2, -1.0];
    let map = round_disparities(&Plane { width: 7, height: 1, data }, 16);
    assert_eq!(map.data, [0, 0, 1, 2, 240, 240, 0]);
}

#[test]
fn images_are_normalised_and_padded_above_and_to_the_right() {
    let padded = Padded::new(2, 1, 16);
    let normalised = |value: f64, channel: usize| (value - Padded::MEAN[channel]) / Padded::DEVIATION[channel];
    for (pixels, wanted) in [
        (Pixels::Gray8(vec![0, 255]), [[0.0, 1.0]; 3]),
        (Pixels::Gray16(vec![65535, 13107]), [[1.0, 0.2]; 3]),
        (Pixels::Rgba8(vec![0, 51, 102, 9, 255, 0, 0, 9]), [[0.0, 1.0], [0.2, 0.0], [0.4, 0.0]]),
        (Pixels::Rgba16(vec![0, 13107, 0, 9, 65535, 0, 0, 9]), [[0.0, 1.0], [0.2, 0.0], [0.0, 0.0]]),
    ] {
        let image = Image::new(2, 1, pixels).unwrap();
        let values = network_input(&image, &padded);
        assert_eq!(values.shape, [3, 1, 256, 256]);
        for (channel, wanted) in wanted.iter().enumerate() {
            assert_eq!(values.row(channel, 0, 255)[..2], wanted.map(|value| normalised(value, channel)));
            assert!(values.row(channel, 0, 255)[2..].iter().all(|&value| value == 0.0));
            assert!((0..255).all(|row| values.row(channel, 0, row).iter().all(|&value| value == 0.0)));
        }
        let crop = cropped(&Values { shape: [1, 1, 256, 256], data: counted([1, 1, 256, 256]).data }, &image);
        assert_eq!(crop, Plane { width: 2, height: 1, data: vec![255.0 * 256.0 + 1.0, 255.0 * 256.0 + 2.0] });
    }
}
