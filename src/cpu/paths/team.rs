//! A team of threads walks the rows of an image one way, a band of rows at a time.
//!
//! The columns are split among the threads for the cost and the paths that cross rows, then the rows of the band for the others.
//! A thread's paths need what its neighbours' paths come from: at the start of a band each gives its neighbours the states at its
//! edges, and each walks some columns beyond its own, as far as paths that begin at their ends can lead within a band. So
//! threads wait for each other twice a band, never within.

use std::ops::Range;

use rayon::prelude::*;

use super::across::{Across, AcrossRow, Goal, RowsOf, Scratch, Segment, TOGETHER};
use super::aggregation::{Aggregation, CostSource, Sources};
use super::buffers::{Buffers, Lent};
use super::down::{Down, DownRow, down_for};
use super::front::Front;
use super::penalties::PenaltyRow;
use super::second_cost::second_for;

use crate::Paths;
use crate::reference::Direction;

/// Where a row of the result goes.
pub(super) struct Target<'a> {
    pub(super) goal: Goal<'a>,
    /// Its cost and its sum, `[x][d]`, if they are recorded.
    pub(super) record: Option<(&'a mut [u8], &'a mut [u16])>,
}

/// What it takes to walk: the same for every team.
pub(super) struct Way {
    /// Whether two teams walk towards each other.
    pub(super) meets: bool,
    /// One or two.
    pub(super) teams: u64,
    /// The steps of the paths that cross rows; forward ones, for teams that walk downwards.
    pub(super) steps: Vec<Direction>,
    pub(super) parts: Vec<PartColumns>,
    /// Rows of a band.
    pub(super) band: usize,
    pub(super) n: usize,
    /// Planes of T that a band has, half the directions rounded up.
    pub(super) planes: usize,
    down: Down,
    pub(super) across: Across,
    second: RowsOf,
}

/// The columns of a thread.
#[derive(Clone)]
pub(super) struct PartColumns {
    pub(super) own: Range<usize>,
    /// With those that it walks besides.
    pub(super) window: Range<usize>,
}

impl Way {
    /// For all threads of the pool.
    pub(super) fn new(job: &Aggregation<'_>, threads: usize) -> Self {
        let meets = job.params.paths.count().is_multiple_of(2);
        let teams = if threads == 1 && !meets { 1 } else { 2 };
        let threads = threads.div_ceil(2);
        let steps = steps_across_rows(job.params.paths);
        let (n, width) = (job.n(), job.width);
        let threads = threads.clamp(1, width.div_ceil(job.least_columns.max(1)));
        // With several threads longer bands, so that they wait less often.
        let band = TOGETHER * if threads == 1 || steps.len() == 1 { threads } else { 2 * threads };
        let reach = steps.iter().map(|step| step.dx.unsigned_abs() as usize * band).max().unwrap_or(0);
        let threads = threads.min(width / reach.max(1)).max(1);
        let reach = if threads == 1 { 0 } else { reach };
        let parts = (0..threads).map(|i| {
            let own = i * width / threads..(i + 1) * width / threads;
            let window = own.start.saturating_sub(reach)..(own.end + reach).min(width);
            PartColumns { own, window }
        });
        let planes = steps.len().div_ceil(2);
        let down = down_for(steps.len(), n);
        let (paths, disparities) = (job.params.paths.count() as usize, job.params.disparities as usize);
        let (across, second) = (Across::new(paths, disparities), second_for(paths, disparities));
        Self { meets, teams, parts: parts.collect(), band, n, planes, down, across, second, steps }
    }

    /// Bytes of a row of the window of all parts.
    pub(super) fn row_bytes(&self) -> u64 {
        self.parts.iter().map(|part| (part.window.len() * self.n) as u64).sum()
    }

    /// Bytes of the states of all paths that cross rows.
    pub(super) fn state_bytes(&self) -> u64 {
        let of =
            |part: &PartColumns| self.steps.iter().map(|s| Front::bytes(*s, part.window.len(), self.n)).sum::<u64>();
        self.parts.iter().map(of).sum()
    }
}

/// The steps downwards of the paths that cross rows.
fn steps_across_rows(paths: Paths) -> Vec<Direction> {
    Direction::all(paths).into_iter().filter(|step| step.dy > 0).collect()
}

/// The planes of T of some rows, for each part: `planes[part][plane]`, `[row][column of the window][n]`.
pub(super) struct Planes {
    pub(super) parts: Vec<Vec<Lent>>,
    /// The first row.
    pub(super) top: usize,
}

impl Planes {
    pub(super) fn new(way: &Way, rows: usize, buffers: &Buffers) -> Self {
        let part =
            |part: &PartColumns| (0..way.planes).map(|_| buffers.take(rows * part.window.len() * way.n)).collect();
        Self { parts: way.parts.iter().map(part).collect(), top: 0 }
    }
}

/// A thread's share of a team.
struct Part<'a> {
    columns: PartColumns,
    source: Box<dyn CostSource + Send + 'a>,
    fronts: Vec<Front>,
    /// `[row of the band][column of the window][n]`.
    cost: Lent,
    planes: Vec<Lent>,
    /// The states at its left and its right end, for its neighbours.
    edges: [Vec<u8>; 2],
}

/// Threads that walk together.
pub(super) struct Team<'a, 's> {
    job: &'a Aggregation<'a>,
    way: &'a Way,
    up: bool,
    parts: Vec<Part<'s>>,
    scratch: Vec<Scratch>,
    /// Rows walked.
    walked: usize,
}

/// Where the T of a band goes, and what is added to it.
pub(super) enum Keep<'p> {
    /// Nothing is kept but the states.
    Nothing,
    /// It is stored.
    Store(&'p mut Planes),
    /// It stays in the band, with the T of paths that come from the other side, if there are any.
    Band(Option<&'p Planes>),
}

impl<'a, 's> Team<'a, 's> {
    /// A team at the first row of those that it walks. `across`: whether it walks along rows, too.
    pub(super) fn new(job: &'a Aggregation<'a>, way: &'a Way, sources: Sources<'s>, up: bool, across: bool) -> Self {
        let turned = |step: &Direction| Direction { dx: if up { -step.dx } else { step.dx }, dy: step.dy };
        let part = |columns: &PartColumns| {
            let window = columns.window.clone();
            let (rows, bytes) = (if across { way.band } else { 1 }, window.len() * way.n);
            let planes = (0..if across { way.planes } else { 0 }).map(|_| job.buffers.take(rows * bytes));
            let front = |step: &Direction| Front::new(turned(step), window.clone(), job.width, way.n, job.buffers);
            Part {
                columns: columns.clone(),
                source: sources(),
                fronts: way.steps.iter().map(front).collect(),
                cost: job.buffers.take(rows * bytes),
                planes: planes.collect(),
                edges: Default::default(),
            }
        };
        let threads = if across { way.parts.len() } else { 0 };
        let scratch = (0..threads)
            .map(|_| Scratch::new(job.width, job.params.disparities as usize, way.across.group, job.buffers))
            .collect();
        Self { job, way, up, parts: way.parts.iter().map(part).collect(), scratch, walked: 0 }
    }

    /// Its states, to go on from later.
    pub(super) fn states(&self) -> (Vec<Vec<Front>>, usize) {
        (self.parts.iter().map(|part| part.fronts.clone()).collect(), self.walked)
    }

    /// Goes on from such states.
    pub(super) fn resume(&mut self, (fronts, walked): (Vec<Vec<Front>>, usize)) {
        self.walked = walked;
        self.parts.iter_mut().zip(fronts).for_each(|(part, fronts)| part.fronts = fronts);
    }

    pub(super) fn way(&self) -> &'a Way {
        self.way
    }

    pub(super) fn walked(&self) -> usize {
        self.walked
    }

    /// The uppermost of the next `count` rows.
    pub(super) fn top(&self, count: usize) -> usize {
        if self.up { self.job.height - self.walked - count } else { self.walked }
    }

    /// The row that is walked `ahead` rows after the `walked`-th.
    fn row(&self, ahead: usize, walked: usize) -> usize {
        if self.up { self.job.height - 1 - walked - ahead } else { walked + ahead }
    }

    /// The next `count` rows, at most those of a band: cost and paths that cross rows.
    pub(super) fn down(&mut self, count: usize, keep: Keep<'_>) {
        self.exchange_edges();
        let ys = (0..count).map(|i| self.row(i, self.walked)).collect();
        let step = Walk { job: self.job, way: self.way, up: self.up, walked: self.walked, ys };
        let parts = self.parts.par_iter_mut();
        match keep {
            Keep::Nothing => parts.for_each(|part| part.walk(&step, PartKeep::Nothing)),
            Keep::Store(Planes { parts: planes, top }) => {
                parts.zip(planes).for_each(|(part, planes)| part.walk(&step, PartKeep::Store(planes, *top)));
            }
            Keep::Band(None) => parts.for_each(|part| part.walk(&step, PartKeep::Band(None))),
            Keep::Band(Some(Planes { parts: planes, top })) => {
                let last = planes.par_iter().map(|planes| &planes[planes.len() - 1][..]);
                parts.zip(last).for_each(|(part, last)| part.walk(&step, PartKeep::Band(Some((last, *top)))));
            }
        }
        self.walked += count;
    }

    /// Each part gets the states beyond its columns from its neighbours.
    fn exchange_edges(&mut self) {
        let (walked, count) = (self.walked, self.parts.len());
        if count == 1 {
            return;
        }
        for (i, part) in self.parts.iter_mut().enumerate() {
            let PartColumns { own, window } = part.columns.clone();
            // What the neighbours' windows have of this part's columns.
            let left = own.start..if i > 0 { self.way.parts[i - 1].window.end } else { own.start };
            let right = if i + 1 < count { self.way.parts[i + 1].window.start } else { own.end }..own.end;
            for (edge, columns) in part.edges.iter_mut().zip([left, right]) {
                debug_assert!(columns.start >= window.start && columns.end <= window.end);
                edge.clear();
                part.fronts.iter().for_each(|front| front.export(columns.clone(), walked, edge));
            }
        }
        for i in 1..count {
            let (before, after) = self.parts.split_at_mut(i);
            let (left, right) = (&mut before[i - 1], &mut after[0]);
            let beyond = |part: &Part<'_>| {
                let PartColumns { own, window } = part.columns.clone();
                [window.start..own.start, own.end..window.end]
            };
            let ([_, columns], mut states) = (beyond(left), &right.edges[0][..]);
            for front in &mut left.fronts {
                states = front.import(columns.clone(), walked, states);
            }
            let ([columns, _], mut states) = (beyond(right), &left.edges[1][..]);
            for front in &mut right.fronts {
                states = front.import(columns.clone(), walked, states);
            }
        }
    }

    /// The paths along the rows of the last band, and their winners, into the next `targets`. `other`: what the band's planes lack
    /// of the paths from the other side.
    pub(super) fn across(
        &mut self,
        count: usize,
        other: Option<&Planes>,
        targets: &mut dyn Iterator<Item = Target<'_>>,
    ) {
        let (job, way) = (self.job, self.way);
        let mut scratch = std::mem::take(&mut self.scratch);
        let right = Direction { dx: 1, dy: 0 };
        let row = |(i, Target { goal, record })| {
            let y = self.row(i, self.walked - count);
            let segment = |(part, columns): (usize, &PartColumns)| self.segment(part, columns, i, y, other);
            let steps = [right, right.opposite()];
            let penalties = steps.map(|step| PenaltyRow::new(job.penalties, step, y, job.params));
            AcrossRow { segments: way.parts.iter().enumerate().map(segment).collect(), penalties, goal, record }
        };
        let mut rows: Vec<AcrossRow<'_>> = targets.take(count).enumerate().map(row).collect();
        let share = count.div_ceil(scratch.len()).next_multiple_of(TOGETHER);
        scratch.par_iter_mut().zip(rows.par_chunks_mut(share)).for_each(|(scratch, rows)| {
            rows.chunks_mut(TOGETHER).for_each(|rows| {
                let compute = match rows[0].goal {
                    Goal::Maps(_) => way.across.rows,
                    Goal::SecondCost(_) => way.second,
                };
                compute(rows, scratch, job.params, job.instructions);
            });
        });
        drop(rows);
        self.scratch = scratch;
    }

    /// A part's own columns of the `i`-th row of the band, which is row `y`.
    fn segment<'t>(
        &'t self,
        part: usize,
        columns: &PartColumns,
        i: usize,
        y: usize,
        other: Option<&'t Planes>,
    ) -> Segment<'t> {
        let (n, window) = (self.way.n, &columns.window);
        let own = |row: usize, values: &'t [u8]| {
            &values[(row * window.len() + columns.own.start - window.start) * n..][..columns.own.len() * n]
        };
        let ready = other.map_or(&[][..], |other| other.parts[part].split_last().map_or(&[][..], |(_, ready)| ready));
        let here = self.parts[part].planes.iter().map(|plane| own(i, plane));
        let planes = here.chain(ready.iter().map(|plane| own(y - other.map_or(0, |other| other.top), plane))).collect();
        Segment { cost: own(i, &self.parts[part].cost), planes }
    }
}

/// Rows that a team walks.
struct Walk<'a> {
    job: &'a Aggregation<'a>,
    way: &'a Way,
    up: bool,
    walked: usize,
    ys: Vec<usize>,
}

/// [`Keep`] for a part.
enum PartKeep<'p> {
    Nothing,
    /// Planes, and their first row.
    Store(&'p mut [Lent], usize),
    /// The plane that is added, and its first row.
    Band(Option<(&'p [u8], usize)>),
}

impl Part<'_> {
    fn walk(&mut self, walk: &Walk<'_>, mut keep: PartKeep<'_>) {
        let (way, window) = (walk.way, self.columns.window.clone());
        let bytes = window.len() * way.n;
        for (i, &y) in walk.ys.iter().enumerate() {
            let at = if matches!(keep, PartKeep::Band(_)) { i } else { 0 };
            let cost = &mut self.cost[at * bytes..][..bytes];
            self.source.row(y, window.clone(), cost);
            fn slices(planes: &mut [Lent], row: usize, bytes: usize) -> Vec<&mut [u8]> {
                planes.iter_mut().map(|plane| &mut plane[row * bytes..][..bytes]).collect()
            }
            let (planes, other) = match &mut keep {
                PartKeep::Nothing => (Vec::new(), None),
                PartKeep::Store(planes, top) => (slices(planes, y - *top, bytes), None),
                PartKeep::Band(other) => {
                    let other = other.map(|(plane, top)| &plane[(y - top) * bytes..][..bytes]);
                    (slices(&mut self.planes, i, bytes), other)
                }
            };
            let fronts = self.fronts.iter_mut().map(|front| {
                let step = front.step(walk.up);
                front.row(walk.walked + i, PenaltyRow::new(walk.job.penalties, step, y, walk.job.params))
            });
            let row = DownRow { fronts: fronts.collect(), cost, n: way.n, planes, other };
            (way.down)(row, walk.job.instructions);
        }
    }
}
