use crate::Params;
use crate::reference::Volume;
use rayon::prelude::*;

/// Stage `second_cost`: the cost of the second pass of aggregation, the mean of the cost and of the mean of the path costs of the first
/// pass, of which `sum` is the sum, rounded to the nearest, halves upwards. With n paths
///
/// C2(d) = floor((S(d) + n C(d) + n) / (2 n)), which is C(d) + floor((sum of T(d) + n) / (2 n)), since S = n C + sum of T.
///
/// At most the largest C and half of P2, rounded up.
pub fn second_cost(cost: &Volume<u8>, sum: &Volume<u16>, params: &Params) -> Volume<u8> {
    let n = params.paths.count();
    let mean = |(&c, &s): (&u8, &u16)| ((u32::from(s) + n * u32::from(c) + n) / (2 * n)) as u8;
    let data = cost.data.par_iter().zip(&sum.data).with_min_len(1 << 16).map(mean).collect();
    Volume { data, ..*cost }
}
