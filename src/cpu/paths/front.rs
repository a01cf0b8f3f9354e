//! The states of all paths of a direction that cross a row.

use std::ops::Range;

use super::buffers::{Buffers, Lent};
use super::penalties::PenaltyRow;
use super::step::{PAD, Stepping};
use crate::reference::Direction;

/// The paths of a direction that leads from row to row, in a window of columns.
///
/// A path keeps its place from row to row, its slot, so that a diagonal path is computed where it lies: after `j` steps the path
/// at column x of the window has the slot (x - dx j) mod the window's columns. A path that begins takes the slot of one that has
/// left the window on the other side. Of a direction that skips a row, even and odd rows have states of their own.
#[derive(Clone)]
pub(super) struct Front {
    /// The step from pixel to pixel: rows are counted in the order in which they are walked.
    step: Direction,
    window: Range<usize>,
    width: usize,
    n: usize,
    /// One for each row that a step spans.
    sets: Vec<Set>,
}

#[derive(Clone)]
struct Set {
    states: Lent,
    leasts: Vec<u8>,
}

/// A front in a row.
pub(super) struct FrontRow<'a> {
    states: &'a mut [u8],
    leasts: &'a mut [u8],
    slot: usize,
    n: usize,
    penalties: PenaltyRow<'a>,
    first: usize,
}

impl Front {
    /// Before the first row: a path starts at every pixel.
    pub(super) fn new(step: Direction, window: Range<usize>, width: usize, n: usize, buffers: &Buffers) -> Self {
        let mut states = buffers.take(PAD + window.len() * (n + PAD));
        states.fill(255);
        states[PAD..].chunks_exact_mut(n + PAD).for_each(|state| state[..n].fill(0));
        let set = Set { states, leasts: vec![0; window.len()] };
        Self { step, window, width, n, sets: vec![set; step.dy.unsigned_abs() as usize] }
    }

    /// Bytes of its states.
    pub(super) fn bytes(step: Direction, columns: usize, n: usize) -> u64 {
        u64::from(step.dy.unsigned_abs()) * columns as u64 * (n + PAD + 1) as u64
    }

    /// The step in the image, of a team that walks up or down.
    pub(super) fn step(&self, up: bool) -> Direction {
        Direction { dx: self.step.dx, dy: if up { -self.step.dy } else { self.step.dy } }
    }

    fn slot(&self, x: usize, steps: usize) -> usize {
        let columns = self.window.len() as i64;
        let at = (x - self.window.start) as i64 - i64::from(self.step.dx) * steps as i64;
        at.rem_euclid(columns) as usize
    }

    /// The front before the row that is walked as the `row`-th, from 0.
    pub(super) fn row<'a>(&'a mut self, row: usize, penalties: PenaltyRow<'a>) -> FrontRow<'a> {
        let (steps, set) = (row / self.sets.len(), row % self.sets.len());
        let dx = self.step.dx.unsigned_abs() as usize;
        let begins = match self.step.dx {
            0 => 0..0,
            1.. => 0..dx.min(self.width),
            _ => self.width.saturating_sub(dx)..self.width,
        };
        for x in begins.filter(|x| self.window.contains(x)) {
            let slot = self.slot(x, steps);
            let set = &mut self.sets[set];
            set.states[PAD + slot * (self.n + PAD)..][..self.n].fill(0);
            set.leasts[slot] = 0;
        }
        let (slot, first, n) = (self.slot(self.window.start, steps), self.window.start, self.n);
        let set = &mut self.sets[set];
        FrontRow { states: &mut set.states, leasts: &mut set.leasts, slot, n, penalties, first }
    }

    /// Appends the states of some columns before the `row`-th row.
    pub(super) fn export(&self, columns: Range<usize>, row: usize, to: &mut Vec<u8>) {
        for (slot, set) in self.places(columns, row) {
            to.extend(&self.sets[set].states[PAD + slot * (self.n + PAD)..][..self.n]);
            to.push(self.sets[set].leasts[slot]);
        }
    }

    /// Takes the states of some columns from what [`Front::export`] has appended; gives the rest.
    pub(super) fn import<'a>(&mut self, columns: Range<usize>, row: usize, mut from: &'a [u8]) -> &'a [u8] {
        for (slot, set) in self.places(columns, row) {
            let (state, rest) = from.split_at(self.n);
            self.sets[set].states[PAD + slot * (self.n + PAD)..][..self.n].copy_from_slice(state);
            self.sets[set].leasts[slot] = rest[0];
            from = &rest[1..];
        }
        from
    }

    /// Slot and set of the states of some columns, of those rows that have been walked.
    fn places(&self, columns: Range<usize>, row: usize) -> Vec<(usize, usize)> {
        let rows = row.saturating_sub(self.sets.len())..row;
        let of_row = |row: usize| (row / self.sets.len(), row % self.sets.len());
        rows.map(of_row)
            .flat_map(|(steps, set)| columns.clone().map(move |x| (x, steps, set)))
            .map(|(x, steps, set)| (self.slot(x, steps), set))
            .collect()
    }
}

/// The states of the next column of several fronts, at `x` of the window. (The compiler leaves `map` of an array out of line.)
pub(super) trait Fronts<const K: usize> {
    fn next(&mut self, x: usize) -> [Stepping<'_>; K];
}

macro_rules! fronts {
    ($($count:literal: $($front:ident)+;)+) => {$(
        impl Fronts<$count> for [FrontRow<'_>; $count] {
            #[inline(always)]
            fn next(&mut self, x: usize) -> [Stepping<'_>; $count] {
                let [$($front),+] = self;
                [$($front.next(x)),+]
            }
        }
    )+};
}

fronts! {
    1: a;
    3: a b c;
    7: a b c d e f g;
}

impl FrontRow<'_> {
    /// The state of the next column, at `x` of the window.
    #[inline(always)]
    pub(super) fn next(&mut self, x: usize) -> Stepping<'_> {
        let slot = self.slot;
        self.slot += 1;
        if self.slot == self.leasts.len() {
            self.slot = 0;
        }
        let at = PAD + slot * (self.n + PAD);
        Stepping {
            state: &mut self.states[at - 1..at + self.n + PAD],
            least: &mut self.leasts[slot],
            penalties: self.penalties.at(self.first + x),
        }
    }
}
