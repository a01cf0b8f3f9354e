//! Stage `features`.

use rayon::prelude::*;

use crate::FeatureNetwork;
use crate::cpu::features::input::Input;
use crate::cpu::features::prepared::prepared;
use crate::cpu::features::strip::{Scratch, Strip, strip_columns};
use crate::cpu::images::Samples;
use crate::cpu::instructions::Instructions;
use crate::reference::{Descriptors, FeatureStatistics};

/// The fewest rows of a piece: each computes some rows above and below it once more.
const FEWEST_ROWS: usize = 24;

/// The features of an image, in bytes: `[y][feature][x]`.
pub struct FeatureRows {
    pub statistics: FeatureStatistics,
    width: usize,
    channels: usize,
    data: Vec<u8>,
}

impl FeatureRows {
    /// Of a prefiltered image.
    pub fn new(samples: &Samples, network: &FeatureNetwork, instructions: Instructions) -> Self {
        let input = Input::new(samples);
        let ([width, height], channels, reach) = (input.size(), network.channels(), network.reach());
        let layers = prepared(network);
        let mut data = vec![0; width * height * channels];
        let pieces = 2 * rayon::current_num_threads();
        let rows = height.div_ceil(pieces).max(FEWEST_ROWS);
        let scratch = || Scratch::new(&layers, reach);
        data.par_chunks_mut(rows * width * channels).enumerate().for_each_init(scratch, |scratch, (piece, out)| {
            let rows = piece * rows..height.min((piece + 1) * rows);
            for start in (0..width).step_by(strip_columns(reach)) {
                let columns = start..width.min(start + strip_columns(reach));
                let strip = Strip { input: &input, layers: &layers, reach, columns, rows: rows.clone(), instructions };
                strip.compute(scratch, out);
            }
        });
        Self { statistics: input.statistics, width, channels, data }
    }

    /// A row of the image, feature by feature.
    pub fn row(&self, y: usize) -> impl Iterator<Item = &[u8]> {
        let len = self.width * self.channels;
        self.data[y * len..][..len].chunks_exact(self.width)
    }

    /// In the definition's layout.
    pub fn descriptors(&self) -> Descriptors {
        let Self { width, channels, ref data, .. } = *self;
        let height = data.len() / (width * channels);
        let at = |i: usize| data[(i / (width * channels) * channels + i % channels) * width + i / channels % width];
        Descriptors { width, height, planes: channels, data: (0..data.len()).map(at).collect() }
    }
}
