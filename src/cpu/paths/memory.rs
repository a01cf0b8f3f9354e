//! The memory of an aggregation.

use super::across::Scratch;
use super::aggregation::Aggregation;
use super::team::Way;

/// How T is stored.
pub(super) struct Chunks {
    /// Rows of which a team stores T at once: all of its half, if they fit the budget.
    pub(super) rows: usize,
    /// Most chunks of a half; before each but the last the states of all paths are kept.
    pub(super) count: usize,
}

impl Chunks {
    /// Those of an aggregation whose paths lead both ways.
    pub(super) fn new(job: &Aggregation<'_>, way: &Way) -> Self {
        let half = job.height.div_ceil(2);
        let row = way.row_bytes() * way.planes as u64;
        if 2 * half as u64 * row <= job.budget {
            return Self { rows: half, count: 1 };
        }
        // So many that T of a chunk takes what all states take.
        let balanced = (half as u64 * way.state_bytes()).div_ceil(row.max(1)).isqrt() as usize;
        let rows = balanced.next_multiple_of(way.band).clamp(1, half);
        Self { rows, count: half.div_ceil(rows) }
    }
}

impl Aggregation<'_> {
    /// Bytes that [`super::aggregate`] allocates with so many threads, its maps and the cost of a second pass included, the sources
    /// of the cost not.
    pub(crate) fn bytes(&self, threads: usize) -> u64 {
        let way = Way::new(self, threads);
        let parts = way.parts.len() as u64;
        let scratch = parts * Scratch::bytes(self.width, way.n, way.across.group);
        let band = way.band as u64 * way.row_bytes() * (1 + way.planes as u64);
        let team = scratch + band + way.state_bytes();
        let second = if self.params.aggregates_twice() { self.n() } else { 0 };
        let maps = (7 + second as u64) * (self.width * self.height) as u64;
        if !way.meets {
            return maps + way.teams * team;
        }
        let chunks = Chunks::new(self, &way);
        let stored = chunks.rows as u64 * way.row_bytes() * way.planes as u64;
        let again = if chunks.count > 1 { way.state_bytes() + way.row_bytes() } else { 0 };
        maps + 2 * (team + stored + (chunks.count as u64 - 1) * way.state_bytes() + again)
    }
}
