//! The order in which the rows are walked.
//!
//! **3 and 5 paths** lead downwards only. One team walks down the upper rows. A second one walks them, too, but only for the
//! states of the paths, and goes on through the lower rows. The teams share nothing, so they never wait for each other.
//!
//! **4, 8 and 16 paths** meet in the middle. One team walks down from the first row, another one up from the last. Up to the
//! middle they store T of their paths. Then each goes on through the rows of the other: it computes the cost a second time, its
//! own T, and adds what the other has stored. So each row is visited twice, and T of half the paths is stored once.
//!
//! Where T of all rows would take too much memory, it is stored of some rows only, and before the others the states of all
//! paths are kept. From these T is computed again when it is needed: a third visit.

use super::across::Goal;
use super::aggregation::{Aggregation, Record, Sources};
use super::front::Front;
use super::memory::Chunks;
use super::second_cost::SecondCost;
use super::team::{Keep, Planes, Target, Team, Way};
use crate::cpu::winner::RowOfMaps;
use crate::reference::Views;
use crate::{ConfidenceMap, DisparityMap};

/// The states of all fronts, and how many rows were walked.
type States = (Vec<Vec<Front>>, usize);

/// What a team leaves of its half of the rows.
struct Half {
    /// Rows that it has walked.
    rows: usize,
    /// Rows of a chunk; the last one may have fewer.
    chunk: usize,
    /// T of the last chunk.
    planes: Planes,
    /// The states before each of the other chunks.
    states: Vec<States>,
}

/// Aggregates and finds the winners of both views. Within the caller's thread pool.
pub(crate) fn aggregate(job: &Aggregation<'_>, sources: Sources<'_>, record: Option<&mut Record>) -> Views {
    let (width, height, disparities) = (job.width, job.height, job.params.disparities as usize);
    let pixels = width * height;
    let map = || DisparityMap { width: width as u32, height: height as u32, data: vec![0; pixels] };
    let margins = ConfidenceMap { width: width as u32, height: height as u32, data: vec![0; pixels] };
    let mut views = Views { left: map(), right: map(), margins, labels: vec![0; pixels] };
    let lefts = views.left.data.chunks_exact_mut(width).zip(views.right.data.chunks_exact_mut(width));
    let rows = lefts.zip(views.margins.data.chunks_exact_mut(width)).zip(views.labels.chunks_exact_mut(width));
    let goals = rows.map(|(((left, right), margins), labels)| Goal::Maps(RowOfMaps { left, right, margins, labels }));
    walk(job, sources, targets(goals, width * disparities, record));
    views
}

/// Stage `second_cost`. Within the caller's thread pool.
pub(crate) fn second_cost(job: &Aggregation<'_>, sources: Sources<'_>, record: Option<&mut Record>) -> SecondCost {
    let row = job.width * job.n();
    let mut data = job.buffers.take(job.height * row);
    let goals = data.chunks_exact_mut(row).map(Goal::SecondCost);
    walk(job, sources, targets(goals, job.width * job.params.disparities as usize, record));
    SecondCost { data, width: job.width, n: job.n() }
}

/// A target for each row; `row`: values of a row that is recorded.
fn targets<'a>(goals: impl Iterator<Item = Goal<'a>>, row: usize, record: Option<&'a mut Record>) -> Vec<Target<'a>> {
    let (costs, sums) = match record {
        Some(record) => (&mut record.cost.data[..], &mut record.sum.data[..]),
        None => (&mut [][..], &mut [][..]),
    };
    let records = costs.chunks_exact_mut(row).zip(sums.chunks_exact_mut(row));
    let records = records.map(Some).chain(std::iter::repeat_with(|| None));
    goals.zip(records).map(|(goal, record)| Target { goal, record }).collect()
}

/// Aggregates into `targets`, one for each row.
fn walk(job: &Aggregation<'_>, sources: Sources<'_>, targets: Vec<Target<'_>>) {
    let way = &Way::new(job, rayon::current_num_threads());
    if !way.meets {
        let split = if way.teams == 1 { job.height } else { upper_rows(job.height) };
        let mut above = targets;
        let below = above.split_off(split);
        rayon::join(|| downwards(job, way, sources, 0, above), || downwards(job, way, sources, split, below));
        return;
    }
    let chunk = Chunks::new(job, way).rows;
    let middle = job.height / 2;
    let mut above = targets;
    let below = above.split_off(middle);
    let first = |up: bool, rows: usize| {
        let mut team = Team::new(job, way, sources, up, true);
        let half = first_visit(job, &mut team, rows, chunk);
        (team, half)
    };
    let ((mut down, upper), (mut up, lower)) =
        rayon::join(|| first(false, middle), || first(true, job.height - middle));
    rayon::join(
        || second_visit(&mut down, lower, || Team::new(job, way, sources, true, false), below.into_iter()),
        || second_visit(&mut up, upper, || Team::new(job, way, sources, false, false), above.into_iter().rev()),
    );
}

/// Rows of the team above: so many that both teams end together, where cost and paths that cross rows take about 0.4 of the time of
/// a row.
fn upper_rows(height: usize) -> usize {
    height - height * 3 / 8
}

/// Walks down to row `first` for the states of the paths, then through the rows of `targets`.
fn downwards(job: &Aggregation<'_>, way: &Way, sources: Sources<'_>, first: usize, targets: Vec<Target<'_>>) {
    let mut team = Team::new(job, way, sources, false, true);
    let (rows, mut targets) = (targets.len(), targets.into_iter());
    bands(if rows == 0 { 0 } else { first }, way.band, |count| team.down(count, Keep::Nothing));
    bands(rows, way.band, |count| {
        team.down(count, Keep::Band(None));
        team.across(count, None, &mut targets);
    });
}

/// Calls `walk` with the rows of one band after the other.
fn bands(rows: usize, band: usize, mut walk: impl FnMut(usize)) {
    let mut left = rows;
    while left > 0 {
        let count = band.min(left);
        walk(count);
        left -= count;
    }
}

/// Up to the middle: stores T of the last chunk, and keeps the states before each of the others.
fn first_visit(job: &Aggregation<'_>, team: &mut Team<'_, '_>, rows: usize, chunk: usize) -> Half {
    let mut states = Vec::new();
    for _ in 0..rows.saturating_sub(1) / chunk {
        states.push(team.states());
        bands(chunk, team.way().band, |count| team.down(count, Keep::Nothing));
    }
    let mut planes = Planes::new(team.way(), chunk, job.buffers);
    store(team, rows - team.walked(), &mut planes);
    Half { rows, chunk, planes, states }
}

/// Walks `rows` rows and stores their T.
fn store(team: &mut Team<'_, '_>, rows: usize, planes: &mut Planes) {
    planes.top = team.top(rows);
    bands(rows, team.way().band, |count| team.down(count, Keep::Store(planes)));
}

/// Beyond the middle: through the rows of the other half, the last chunk first. `again`: a team that walks as the other half's.
fn second_visit<'a, 's, 't>(
    team: &mut Team<'_, '_>,
    half: Half,
    again: impl FnOnce() -> Team<'a, 's>,
    mut targets: impl Iterator<Item = Target<'t>>,
) {
    let Half { rows, chunk, mut planes, states } = half;
    let mut walk = |rows: usize, planes: &Planes| {
        bands(rows, team.way().band, |count| {
            team.down(count, Keep::Band(Some(planes)));
            team.across(count, Some(planes), &mut targets);
        });
    };
    walk(rows - states.len() * chunk, &planes);
    let mut again = (!states.is_empty()).then(again);
    for states in states.into_iter().rev() {
        if let Some(again) = &mut again {
            again.resume(states);
            store(again, chunk, &mut planes);
            walk(chunk, &planes);
        }
    }
}
