//! Winners by keys of 16 bits: the cost of a disparity, then its index in its group. So the smallest key is the winner, of
//! equal costs the smallest index, and the right view takes a single minimum for each cost.

use crate::{DisparityMap, Params};

/// The smallest keys that the pixels of the right view of a row have seen.
///
/// Left pixel x and index d are a candidate for the right pixel x - D(d). The disparities fall into groups of G. For a group the
/// key of its l-th index is kept at W - 1 - x + l: contiguous for a left pixel.
pub(crate) struct RightKeys {
    keys: Vec<u16>,
    /// Of a group.
    len: usize,
    width: usize,
    best: Vec<u16>,
    index: Vec<u16>,
}

impl RightKeys {
    /// For rows of `width` pixels and `n` disparities in groups of `group`.
    pub(crate) fn new(width: usize, n: usize, group: usize) -> Self {
        let len = (width + group).next_multiple_of(32);
        Self { keys: vec![u16::MAX; n / group * len], len, width, best: vec![0; width], index: vec![0; width] }
    }

    /// Before a row.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.keys.fill(u16::MAX);
    }

    /// The keys that the left pixel x votes for from index d on, up to the end of its group.
    #[inline(always)]
    pub(crate) fn seen<const G: usize>(&mut self, x: usize, d: usize) -> &mut [u16] {
        &mut self.keys[d / G * self.len + self.width - 1 - x + d % G..][..G - d % G]
    }

    /// The right view of the row.
    #[inline(always)]
    pub(crate) fn finish<const G: usize>(&mut self, params: &Params, right: &mut [i16]) {
        let width = self.width;
        let bits = G.trailing_zeros();
        self.best[..width].fill(u16::MAX >> bits);
        self.index[..width].fill(0);
        for (group, keys) in self.keys.chunks_exact(self.len).enumerate() {
            // Counted from the right border, the pixel i has seen the key i - shift.
            let shift = i64::from(params.min_disparity) + (group * G) as i64;
            let first = shift.clamp(0, width as i64) as usize;
            let from = (first as i64 - shift).clamp(0, self.len as i64) as usize;
            let keys = &keys[from..];
            let count = keys.len().min(width - first);
            let (best, index) = (&mut self.best[first..][..count], &mut self.index[first..][..count]);
            for i in 0..count {
                let cost = keys[i] >> bits;
                let found = (group * G) as u16 | (keys[i] & (G as u16 - 1));
                // Earlier groups win where the costs are equal.
                index[i] = if cost < best[i] { found } else { index[i] };
                best[i] = best[i].min(cost);
            }
        }
        let (best, index, right) = (&self.best[..width], &self.index[..width], &mut right[..width]);
        for i in 0..width {
            let value = 16 * (params.min_disparity as i16 + index[i] as i16);
            right[width - 1 - i] = if best[i] == u16::MAX >> bits { DisparityMap::INVALID } else { value };
        }
    }
}
