//! What is aggregated, from what, and how.

use std::ops::Range;

use super::buffers::Buffers;
use crate::Params;
use crate::cpu::LANES;
use crate::cpu::cost::CostRows;
use crate::cpu::instructions::Instructions;
use crate::reference::Volume;

/// Gives the rows of the matching cost; each thread has its own.
pub(crate) trait CostSource {
    /// The cost of row `y` and the columns `columns`: `cost[(x - columns.start) * n + d]`, n the disparities rounded up to a
    /// multiple of [`LANES`], 255 beyond the disparities.
    fn row(&mut self, y: usize, columns: Range<usize>, cost: &mut [u8]);
}

impl CostSource for CostRows<'_> {
    fn row(&mut self, y: usize, columns: Range<usize>, cost: &mut [u8]) {
        Self::row(self, y, columns, cost);
    }
}

/// Makes a [`CostSource`] for a thread.
pub(crate) type Sources<'a> = &'a (dyn Fn() -> Box<dyn CostSource + Send + 'a> + Sync);

/// The stages that lie between the cost and the maps, for a comparison with the definition.
pub(crate) struct Record {
    /// Stage `matching_cost`.
    pub(crate) cost: Volume<u8>,
    /// Stage `sgm_aggregate`.
    pub(crate) sum: Volume<u16>,
}

impl Record {
    /// Room for a pair of this size.
    pub(crate) fn new(width: usize, height: usize, params: &Params) -> Self {
        let n = params.disparities as usize;
        Self { cost: Volume::new(width, height, n), sum: Volume::new(width, height, n) }
    }
}

/// What is aggregated, and how.
pub(crate) struct Aggregation<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Validated, with the method `sgm`.
    pub(crate) params: &'a Params,
    /// Stage `penalties` where P1 or P2 is adaptive.
    pub(crate) penalties: Option<&'a Volume<u8>>,
    pub(crate) instructions: Instructions,
    /// Kept from pair to pair.
    pub(crate) buffers: &'a Buffers,
    /// Bytes that T may take before parts of it are computed twice ([`BUDGET`]).
    pub(crate) budget: u64,
    /// Columns that are worth a thread ([`LEAST_COLUMNS`]).
    pub(crate) least_columns: usize,
}

/// The usual [`Aggregation::budget`].
pub(crate) const BUDGET: u64 = 1 << 30;

/// The usual [`Aggregation::least_columns`].
pub(crate) const LEAST_COLUMNS: usize = 64;

impl<'a> Aggregation<'a> {
    /// With the usual budget.
    pub(crate) fn new(
        [width, height]: [usize; 2],
        params: &'a Params,
        penalties: Option<&'a Volume<u8>>,
        instructions: Instructions,
        buffers: &'a Buffers,
    ) -> Self {
        Self { width, height, params, penalties, instructions, buffers, budget: BUDGET, least_columns: LEAST_COLUMNS }
    }

    /// Bytes a pixel of the cost.
    pub(super) fn n(&self) -> usize {
        (self.params.disparities as usize).next_multiple_of(LANES)
    }
}
