use crate::reference::{FeatureValues, Plane};

/// How bright an image is, and how much its brightness varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeatureStatistics {
    /// The mean, in 256ths of one of 256 levels.
    pub mean: u32,
    /// The standard deviation in units of four of these, at least 1.
    pub deviation: u32,
}

/// A value in 256ths of one of 256 levels; of an image of 16 bits the value itself.
fn deep(value: i32, unit: i32) -> u32 {
    if unit == 1 { 256 * value as u32 } else { value as u32 }
}

/// Stage `feature_statistics`, of the prefiltered image, whose unit is `unit`.
///
/// Of each value V, in 256ths of a level, h(k) pixels have k = V >> 6. These counts, shifted down by as many bits e as bring the number of
/// pixels to at most 8192, are h'(k) = (h(k) + floor(2^e / 2)) >> e, and n of them all. With a = sum h'(k) k:
///
/// - the mean is floor(64 a / n), and of an image of 16 bits 32 more, the middle of a bin;
/// - with K = floor(a / n), t = sum h'(k) (k - K)^2 and the rest b = floor(64 a / n) - 64 K, the deviation is
///   max(1, floor(sqrt(floor(256 t / n) - (b^2 >> 4)))).
///
/// n is at most 8192 + 512, so that t fits 32 bits.
pub fn feature_statistics(image: &Plane<u16>, unit: i32) -> FeatureStatistics {
    let mut counts = [0_u64; 1024];
    image.data.iter().for_each(|&value| counts[(deep(value.into(), unit) >> 6) as usize] += 1);
    let mut shift = 0;
    while image.data.len() >> shift > 8192 {
        shift += 1;
    }
    let counts = counts.map(|count| (count + ((1 << shift) >> 1)) >> shift);
    let number: u64 = counts.iter().sum();
    let sum: u64 = counts.iter().zip(0..).map(|(count, k)| count * k).sum();
    let (mean, centre) = (64 * sum / number, sum / number);
    let squares: u64 = counts.iter().zip(0..).map(|(count, k): (_, u64)| count * k.abs_diff(centre).pow(2)).sum();
    let rest = mean - 64 * centre;
    let variance = 256 * squares / number - ((rest * rest) >> 4);
    FeatureStatistics {
        mean: mean as u32 + if unit == 1 { 0 } else { 32 },
        deviation: (variance.isqrt() as u32).max(1),
    }
}

/// What the first layer reads: the prefiltered image, whose unit is `unit`, less its mean, 32 to a standard deviation.
///
/// With V as in [`feature_statistics`], m its mean and s its deviation,
/// sign(V - m) min(127, floor((16 |V - m| + s) / (2 s))).
pub fn feature_input(image: &Plane<u16>, unit: i32, statistics: FeatureStatistics) -> FeatureValues {
    let FeatureStatistics { mean, deviation } = statistics;
    let value = |&value: &u16| {
        let v = deep(value.into(), unit);
        let size = ((16 * v.abs_diff(mean) + deviation) / (2 * deviation)).min(127) as i16;
        if v < mean { -size } else { size }
    };
    let data = image.data.iter().map(value).collect();
    FeatureValues { width: image.width, height: image.height, channels: 1, data }
}
