//! Semi-global matching, from the rows of the cost to the winners of both views: the stages `sgm_aggregate` and `winner`.
//!
//! A path's cost is L = C + T, so the sum over P paths is P C plus all T, and only T, at most P2 <= 127, is kept: of two paths in
//! a byte. ARCHITECTURE.md shows how the rows are walked.

mod across;
mod down;
mod front;
mod meet;
mod memory;
mod penalties;
mod step;
mod team;
#[cfg(test)]
mod tests;

pub(crate) use memory::Buffers;
pub(crate) use penalties::penalties;

use std::ops::Range;

use crate::cpu::LANES;
use crate::cpu::cost::CostRows;
use crate::cpu::instructions::Instructions;
use crate::cpu::winner::RowOfMaps;
use crate::reference::{Direction, Views, Volume};
use crate::{ConfidenceMap, DisparityMap, Params, Paths};
use team::Target;

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
    /// Stage `penalties` where P2 is adaptive.
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
    fn n(&self) -> usize {
        (self.params.disparities as usize).next_multiple_of(LANES)
    }
}

/// The steps downwards of the paths that cross rows.
fn steps_across_rows(paths: Paths) -> Vec<Direction> {
    Direction::all(paths).into_iter().filter(|step| step.dy > 0).collect()
}

/// Aggregates and finds the winners of both views. Within the caller's thread pool.
pub(crate) fn aggregate(job: &Aggregation<'_>, sources: Sources<'_>, record: Option<&mut Record>) -> Views {
    let (width, height, disparities) = (job.width, job.height, job.params.disparities as usize);
    let pixels = width * height;
    let map = || DisparityMap { width: width as u32, height: height as u32, data: vec![0; pixels] };
    let margins = ConfidenceMap { width: width as u32, height: height as u32, data: vec![0; pixels] };
    let mut views = Views { left: map(), right: map(), margins, labels: vec![0; pixels] };
    let (costs, sums) = match record {
        Some(record) => (&mut record.cost.data[..], &mut record.sum.data[..]),
        None => (&mut [][..], &mut [][..]),
    };
    let records = costs.chunks_exact_mut(width * disparities).zip(sums.chunks_exact_mut(width * disparities));
    let records = records.map(Some).chain(std::iter::repeat_with(|| None));
    let lefts = views.left.data.chunks_exact_mut(width).zip(views.right.data.chunks_exact_mut(width));
    let rows = lefts.zip(views.margins.data.chunks_exact_mut(width)).zip(views.labels.chunks_exact_mut(width));
    let targets = rows.zip(records).map(|((((left, right), margins), labels), record)| Target {
        maps: RowOfMaps { left, right, margins, labels },
        record,
    });
    meet::aggregate(job, sources, targets.collect());
    views
}
