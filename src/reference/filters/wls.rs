use crate::reference::Plane;
use crate::{DisparityMap, Params, Wls};

/// Of a map value v, (v - 16 min_disparity) << `bits` is below 2^31.
pub(crate) fn wls_bits(disparities: u32) -> u32 {
    31 - (16 * disparities - 1).checked_ilog2().map_or(0, |bit| bit + 1)
}

/// lambda exp(-difference / sigma), in 1/64, for the differences 0 to 255 and for each of three iterations, of which each has
/// a quarter of the lambda before: table `[256 iteration + difference]`. At least 1, so that a hole of one pixel is filled
/// even where it differs from all around it.
///
/// In doubles, of which only sums, products and quotients are taken: the same on every machine.
pub fn wls_couplings(wls: &Wls) -> Vec<u32> {
    let step = 1.0 / f64::from(wls.sigma);
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..=200 {
        term = term * step / f64::from(k);
        sum += term;
    }
    let decay = 1.0 / sum;
    let mut table = Vec::with_capacity(3 * 256);
    for divisor in [1.0, 4.0, 16.0] {
        let mut weight = 1.0;
        for _ in 0..256 {
            table.push((64.0 * f64::from(wls.lambda) / divisor * weight + 0.5).floor().max(1.0) as u32);
            weight *= decay;
        }
    }
    table
}

/// share / 65536 of a and the rest of b, to the nearest number, a half upwards.
fn blend(a: u32, b: u32, share: u32) -> u32 {
    let (a, b, share) = (u64::from(a), u64::from(b), u64::from(share));
    ((a * share + b * (65_536 - share) + 32_768) >> 16) as u32
}

/// One line: (1 + couplings) x = value for each of a pixel's two values, by elimination. Both sweeps are means with weights
/// between 0 and 1, so nothing grows.
fn solve(line: &mut [[u32; 2]], couplings: &[u32]) {
    let mut shares = Vec::with_capacity(line.len());
    let (mut mean, mut weight) = ([0; 2], 64);
    for (i, value) in line.iter_mut().enumerate() {
        let own = (64 << 16) / weight;
        mean = [blend(value[0], mean[0], own), blend(value[1], mean[1], own)];
        *value = mean;
        let coupling = couplings.get(i).copied().unwrap_or(0);
        let share = (weight << 16) / (weight + coupling);
        weight = 64 + (((65_536 - share) * weight) >> 16);
        shares.push(share);
    }
    let mut smooth = [0; 2];
    for (value, share) in line.iter_mut().zip(shares).rev() {
        smooth = [blend(value[0], smooth[0], share), blend(value[1], smooth[1], share)];
        *value = smooth;
    }
}

/// Stage `wls`: disparity times confidence and confidence, both smoothed within the edges of the left image, and the
/// quotient of the two. The confidence is 1 for a valid pixel and 0 for an invalid one.
///
/// Min et al., "Fast Global Image Smoothing Based on Weighted Least Squares", IEEE TIP 23(12), 2014: three iterations, each
/// solves all rows and then all columns, equations 6 to 9. As `DisparityWLSFilter` of OpenCV's ximgproc does, each
/// iteration has a quarter of the lambda before.
pub fn wls(map: &DisparityMap, gray: &Plane<u8>, wls: &Wls, params: &Params) -> DisparityMap {
    let (width, height) = (gray.width, gray.height);
    let bits = wls_bits(params.disparities);
    let start = |&v: &i16| match v {
        DisparityMap::INVALID => [0, 0],
        v => [((i32::from(v) - 16 * params.min_disparity) as u32) << bits, 1 << 30],
    };
    let mut values: Vec<[u32; 2]> = map.data.iter().map(start).collect();
    for table in wls_couplings(wls).chunks_exact(256) {
        let coupling = |p: usize, q: usize| table[usize::from(gray.data[p].abs_diff(gray.data[q]))];
        for y in 0..height {
            let row = y * width..(y + 1) * width;
            let couplings: Vec<u32> = row.clone().skip(1).map(|p| coupling(p - 1, p)).collect();
            solve(&mut values[row], &couplings);
        }
        for x in 0..width {
            let column = (0..height).map(|y| y * width + x);
            let mut line: Vec<[u32; 2]> = column.clone().map(|p| values[p]).collect();
            let couplings: Vec<u32> = column.clone().skip(1).map(|p| coupling(p - width, p)).collect();
            solve(&mut line, &couplings);
            column.zip(line).for_each(|(p, value)| values[p] = value);
        }
    }
    let finish = |&[product, confidence]: &[u32; 2]| {
        if confidence < 1 << 14 {
            return DisparityMap::INVALID;
        }
        let doubled = (u64::from(product) << (31 - bits)) / u64::from(confidence);
        let above = ((doubled + 1) >> 1).min(16 * (u64::from(params.disparities) - 1));
        (16 * params.min_disparity + above as i32) as i16
    };
    DisparityMap { data: values.iter().map(finish).collect(), ..*map }
}
