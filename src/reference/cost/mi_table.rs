/// The binomial weights of seven neighbours; they sum to 64.
const WEIGHTS: [u32; 7] = [1, 6, 15, 20, 15, 6, 1];

/// A `rows` x 256 table smoothed along one axis, continued by its border: WEIGHTS of seven values, 3 before to 3 after.
fn smoothed(table: &[u32], down: bool) -> Vec<u32> {
    let rows = table.len() / 256;
    let at =
        |row: i64, column: i64| table[row.clamp(0, rows as i64 - 1) as usize * 256 + column.clamp(0, 255) as usize];
    let sum = |i: usize| {
        let (row, column) = (i as i64 / 256, i as i64 % 256);
        let seven = (-3..=3).map(|k| if down { at(row + k, column) } else { at(row, column + k) });
        seven.zip(WEIGHTS).map(|(value, weight)| weight * value).sum()
    };
    (0..table.len()).map(sum).collect()
}

/// 4096 log2(v) of v >= 1, by a parabola between powers of two, at most 35 too small and 29 too large.
pub fn logarithm(v: u32) -> u32 {
    let whole = v.ilog2();
    let fraction = ((v << (31 - whole)) >> 19) & 4095;
    4096 * whole + fraction + ((fraction * (4096 - fraction) * 11) >> 17)
}

/// Bits by which the counts of an image of so many pixels are shifted down, so that their sum is below 2^20.
pub fn mi_narrowing(pixels: u64) -> u32 {
    (64 - pixels.leading_zeros()).saturating_sub(20)
}

/// What is added to each smoothed count of an image of so many pixels, in 4096ths: about one of 17 matches
/// may be of any two values.
pub fn mi_prior(pixels: u64) -> u32 {
    ((pixels >> mi_narrowing(pixels)) >> 8) as u32 + 1
}

/// Stage `mi_table`: what a match of a left value l with a right one r costs, `[l][r]`, from the counts of
/// [`crate::reference::mi_histogram`] in images of `pixels` pixels: Hirschmüller 2005, equations 3 to 8, in integers.
///
/// The counts, narrowed, are smoothed along both axes, and the prior is added: P(l, r); P(l) and P(r) are its sums. With
/// lg the smoothed [`logarithm`], the mutual information of two values is lg P(l, r) - lg P(l) - lg P(r); the largest
/// costs 0, the smallest 255. If all are equal, the cost is |l - r|.
pub fn mi_table(counts: &[u32], pixels: u64) -> Vec<u8> {
    let narrowed: Vec<u32> = counts.iter().map(|&count| count >> mi_narrowing(pixels)).collect();
    let joint: Vec<u32> = smoothed(&smoothed(&narrowed, false), true).iter().map(|v| v + mi_prior(pixels)).collect();
    let lefts = joint.chunks_exact(256).map(|row| row.iter().sum());
    let rights = (0..256).map(|r| joint[r..].iter().step_by(256).sum());
    let marginals: Vec<u32> = lefts.chain(rights).collect();

    let logarithms = |table: &[u32]| smoothed(&table.iter().map(|&v| logarithm(v)).collect::<Vec<_>>(), false);
    let joint: Vec<u32> = smoothed(&logarithms(&joint), true).iter().map(|v| (v + 2048) >> 12).collect();
    let marginals: Vec<u32> = logarithms(&marginals).iter().map(|v| (v + 32) >> 6).collect();
    let shared = |i: usize| joint[i] as i32 - marginals[i / 256] as i32 - marginals[256 + i % 256] as i32;
    let all = || (0..256 * 256).map(shared);
    let (least, most) = (all().min().unwrap_or(0), all().max().unwrap_or(0));
    let range = (most - least) as u32;
    let cost = |i: usize| match range {
        0 => (i / 256).abs_diff(i % 256) as u8,
        _ => ((255 * (most - shared(i)) as u32 + range / 2) / range) as u8,
    };
    (0..256 * 256).map(cost).collect()
}
