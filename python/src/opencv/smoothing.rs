//! The edge-preserving smoother of D. Min et al., "Fast Global Image Smoothing Based on Weighted Least Squares", 2014, in 32-bit
//! floats as ximgproc has it: three rounds of rows and columns, lambda quartered after each.

const ROUNDS: usize = 3;
const ATTENUATION: f32 = 0.25;

/// The smoother of maps for one guide image.
pub struct Smoother {
    width: usize,
    height: usize,
    /// Minus the weight between a pixel and the one to its right, and the one below it; 0 at the last column and row.
    rightwards: Vec<f32>,
    downwards: Vec<f32>,
    lambda: f32,
}

impl Smoother {
    /// `guide` has `channels` bytes a pixel, row by row.
    pub fn new(guide: &[u8], width: usize, channels: usize, lambda: f64, sigma: f64) -> Self {
        let sigma = sigma as f32;
        let weights: Vec<f32> =
            (0..channels * 255 * 255 + 1).map(|square| -(-(square as f32).sqrt() / sigma).exp()).collect();
        let pixels = guide.len() / channels;
        let height = pixels / width;
        let pixel = |at: usize| &guide[at * channels..][..channels];
        let weight = |a: usize, b: usize| {
            let square: usize = pixel(a).iter().zip(pixel(b)).map(|(&a, &b)| usize::from(a.abs_diff(b)).pow(2)).sum();
            weights[square]
        };
        let rightwards = (0..pixels).map(|at| if at % width + 1 < width { weight(at, at + 1) } else { 0.0 }).collect();
        let downwards = (0..pixels).map(|at| if at + width < pixels { weight(at, at + width) } else { 0.0 }).collect();
        Self { width, height, rightwards, downwards, lambda: lambda as f32 }
    }

    /// Smooths a map of the guide's size in place.
    pub fn smooth(&self, map: &mut [f32]) {
        let mut lambda = self.lambda;
        let mut shares = vec![0.0; map.len()];
        for _ in 0..ROUNDS {
            self.rows(map, &mut shares, lambda);
            self.columns(map, &mut shares, lambda);
            lambda *= ATTENUATION;
        }
    }

    /// Solves each row, a tridiagonal system, by elimination from the left and substitution from the right.
    fn rows(&self, map: &mut [f32], shares: &mut [f32], lambda: f32) {
        let width = self.width;
        let lines =
            map.chunks_exact_mut(width).zip(shares.chunks_exact_mut(width)).zip(self.rightwards.chunks_exact(width));
        for ((row, shares), weights) in lines {
            let mut before = lambda * weights[0];
            shares[0] = before / (1.0 - before);
            row[0] /= 1.0 - before;
            for x in 1..width {
                let coupling = lambda * weights[x];
                let pivot = (1.0 - (coupling + before)) - shares[x - 1] * before;
                shares[x] = coupling / pivot;
                row[x] = (row[x] - row[x - 1] * before) / pivot;
                before = coupling;
            }
            for x in (0..width - 1).rev() {
                row[x] -= shares[x] * row[x + 1];
            }
        }
    }

    /// The same for the columns, all of a row at a time.
    fn columns(&self, map: &mut [f32], shares: &mut [f32], lambda: f32) {
        let width = self.width;
        for x in 0..width {
            let coupling = lambda * self.downwards[x];
            shares[x] = coupling / (1.0 - coupling);
            map[x] /= 1.0 - coupling;
        }
        for at in width..map.len() {
            let before = lambda * self.downwards[at - width];
            let coupling = lambda * self.downwards[at];
            let pivot = 1.0 - ((before + coupling) + shares[at - width] * before);
            shares[at] = coupling / pivot;
            map[at] = (map[at] - map[at - width] * before) / pivot;
        }
        for at in (0..(self.height - 1) * width).rev() {
            map[at] -= shares[at] * map[at + width];
        }
    }
}
