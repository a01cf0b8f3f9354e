use crate::FeatureNetwork;
use crate::reference::{
    Descriptors, FeatureStatistics, FeatureValues, Plane, feature_input, feature_layer, feature_statistics,
};

/// Stage `features`: vectors of one length, in bytes. Of the values v(c) of a pixel after the last layer
///
/// - r is the smallest number with r^2 >= sum of v(c)^2;
/// - f(c) = sign(v(c)) min(127, floor((340 |v(c)| + r) / (2 r))), 0 where r is 0;
/// - the bytes are f(c) + 128.
///
/// So a vector has a length of about 170, and no more than 170 + sqrt(128) / 2: products of two, added up in any order, fit 16 bits with
/// a sign.
pub fn features(values: &FeatureValues) -> Descriptors {
    let FeatureValues { width, height, channels, .. } = *values;
    let pixels = width * height;
    let mut data = Vec::with_capacity(pixels * channels);
    for i in 0..pixels {
        let vector = || values.data[i..].iter().step_by(pixels).map(|&v| i32::from(v));
        let square: i32 = vector().map(|v| v * v).sum();
        let length = square.isqrt() + i32::from(square.isqrt().pow(2) < square);
        data.extend(vector().map(|v| {
            let size = if length == 0 { 0 } else { ((340 * v.abs() + length) / (2 * length)).min(127) };
            (128 + v.signum() * size) as u8
        }));
    }
    Descriptors { width, height, planes: channels, data }
}

/// From the prefiltered image, whose unit is `unit`, to the values of the last layer.
pub fn feature_values(
    image: &Plane<u16>,
    unit: i32,
    statistics: FeatureStatistics,
    network: &FeatureNetwork,
) -> FeatureValues {
    let mut values = feature_input(image, unit, statistics);
    let last = network.layers().len() - 1;
    for (at, layer) in network.layers().iter().enumerate() {
        values = feature_layer(&values, layer, at == last);
    }
    values
}

/// From the prefiltered image, whose unit is `unit`, to its features.
pub fn features_of(image: &Plane<u16>, unit: i32, network: &FeatureNetwork) -> Descriptors {
    features(&feature_values(image, unit, feature_statistics(image, unit), network))
}
