//! Normalised cross correlation: from sums of products to costs, the twin of stage `block_statistics` and of
//! `correlation_cost`.

use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::cpu::images::Planes;
use crate::cpu::instructions::Instructions;
use crate::params::Params;

/// Sums and roots of the blocks of one row, in f64, which holds all of these integers.
struct Statistics {
    sums: Aligned<f64>,
    roots: Aligned<f64>,
    /// Sums over columns of values and of their squares.
    columns: [Vec<u32>; 2],
}

/// Makes costs of rows of sums of products.
pub struct Correlation<'a> {
    sides: [&'a Planes; 2],
    statistics: [Statistics; 2],
    block: usize,
    /// Disparities, and the same rounded up to a multiple of [`LANES`].
    disparities: usize,
    padded: usize,
    instructions: Instructions,
}

impl<'a> Correlation<'a> {
    /// For rows of these sides.
    pub fn new(sides: [&'a Planes; 2], params: &Params, instructions: Instructions) -> Self {
        let statistics = sides.map(|side| Statistics {
            sums: Aligned::zeroed(side.stride()),
            roots: Aligned::zeroed(side.stride()),
            columns: [vec![0; side.stride()], vec![0; side.stride()]],
        });
        let disparities = params.disparities as usize;
        let padded = disparities.next_multiple_of(LANES);
        Self { sides, statistics, block: params.block as usize, disparities, padded, instructions }
    }

    /// Of row y, with `sums` of products, `[x][n]`, which become costs. What lies beyond the disparities stays as it is.
    pub fn row(&mut self, y: usize, sums: &mut [u32]) {
        let Self { sides, statistics, block, disparities, padded, instructions } = self;
        let [left, right] = statistics;
        instructions.run(
            #[inline(always)]
            || {
                left.row(sides[0], y, *block);
                right.row(sides[1], y, *block);
                let pixels = (*block * *block) as f64;
                let last = sums.len() / *padded - 1;
                for (x, sums) in sums.chunks_exact_mut(*padded).enumerate() {
                    // The blocks of left pixel x and of those that it is compared with begin at these columns.
                    let there = last - x;
                    let of_right = (&right.sums[there..][..*disparities], &right.roots[there..][..*disparities]);
                    costs(pixels, [left.sums[x], left.roots[x]], of_right, &mut sums[..*disparities]);
                }
            },
        );
    }
}

/// The costs of one pixel. All numbers are integers below 2^53, so products and sums are exact. A quotient that is not whole is
/// at least 1 / divisor > 2^-32 below the next integer, which is at most 4096 where it counts, and f64 near there are 2^-41
/// apart: it is rounded down from the right number.
#[inline(always)]
fn costs(pixels: f64, [left_sum, left_root]: [f64; 2], (sums, roots): (&[f64], &[f64]), products: &mut [u32]) {
    for ((product, &sum), &root) in products.iter_mut().zip(sums).zip(roots) {
        let covariance = pixels * f64::from(*product as i32) - left_sum * sum;
        let divisor = left_root * root;
        let part = (4096.0 * covariance.abs() / divisor.max(1.0)).min(4096.0) as i32;
        let part = if divisor == 0.0 { 0 } else { part };
        *product = (4096 - if covariance < 0.0 { -part } else { part }) as u32;
    }
}

impl Statistics {
    /// Those of row y, of the block that begins at each column.
    #[inline(always)]
    fn row(&mut self, side: &Planes, y: usize, block: usize) {
        let (y, radius) = (y as i64, (block / 2) as i64);
        let [values, squares] = &mut self.columns;
        values.fill(0);
        squares.fill(0);
        for y in y - radius..=y + radius {
            for ((value, square), &v) in values.iter_mut().zip(squares.iter_mut()).zip(side.row(y)) {
                *value += u32::from(v);
                *square += u32::from(v) * u32::from(v);
            }
        }
        let pixels = (block * block) as f64;
        let [mut sum, mut sum_of_squares] = [&*values, &*squares].map(|column| column[..block - 1].iter().sum::<u32>());
        let blocks = values.len() + 1 - block;
        for i in 0..blocks {
            sum += values[i + block - 1];
            sum_of_squares += squares[i + block - 1];
            self.sums[i] = f64::from(sum);
            self.roots[i] = f64::from(sum_of_squares);
            sum -= values[i];
            sum_of_squares -= squares[i];
        }
        // Below 2^32, and the root of what is not a square is further from the next integer than f64 there are apart.
        let (sums, roots) = (&self.sums[..blocks], &mut self.roots[..blocks]);
        for (root, &sum) in roots.iter_mut().zip(sums) {
            *root = (pixels * *root - sum * sum).sqrt().floor();
        }
    }
}
