//! The results of the pairs so far, and their progress.

use super::work::{FailedPair, Ran, Sequence, Setup, Work};
use crate::engine::diagnosis::Finding;
use crate::terminal::{Pace, name, one_line};
use std::collections::{HashSet, VecDeque};
use std::mem::Discriminant;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Why a map is doubtful.
pub struct Doubt {
    /// In words.
    pub text: String,
    /// The kind of finding; none where the files are the cause.
    pub kind: Option<Discriminant<Finding>>,
}

impl Doubt {
    /// What is wrong with a pair.
    pub fn of(finding: &Finding) -> Self {
        Self { text: finding.to_string(), kind: Some(finding.kind()) }
    }
}

/// Counts results and shows the progress.
pub struct Tally<'a> {
    sequence: Sequence<'a>,
    work: &'a dyn Work,
    pace: Pace,
    counts: Mutex<Counts>,
}

#[derive(Default)]
struct Counts {
    ran: Ran,
    /// The kinds of doubts that were reported: a whole video has the same one.
    kinds: HashSet<Option<Discriminant<Finding>>>,
    /// The last pairs that were doubted: no more lie between two doubts of a pair than are in flight.
    doubted: VecDeque<usize>,
}

/// So many doubted pairs are kept, more than are ever in flight.
const KEPT: usize = 64;

/// So many doubts of a stream are listed.
const LISTED: usize = 1000;

impl<'a> Tally<'a> {
    /// Of no pair yet.
    pub fn new(sequence: Sequence<'a>, setup: &Setup<'_>, work: &'a dyn Work) -> Self {
        Self { sequence, work, pace: Pace::new(sequence.len(), setup.unit, setup.quiet), counts: Mutex::default() }
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A map is written.
    pub fn done(&self) {
        let mut counts = self.counts();
        counts.ran.done += 1;
        self.show(&counts);
    }

    /// A pair failed.
    pub fn failed(&self, place: usize, error: &anyhow::Error) {
        let left = &self.sequence.name(place);
        let error = one_line(&format!("{error:#}"));
        let mut counts = self.counts();
        self.pace.message(&format!("failed: {}: {error}", name(left)));
        if let Err(error) = self.work.failed(place, &error) {
            counts.ran.stopped.get_or_insert(error);
        }
        counts.ran.failed.push(FailedPair { place, frame: left.into(), error });
        self.show(&counts);
    }

    /// A map is doubtful.
    pub fn doubt(&self, place: usize, doubt: Doubt) {
        let left = &self.sequence.name(place);
        let mut counts = self.counts();
        if counts.kinds.insert(doubt.kind) {
            self.pace.message(&format!("note: {}: {}", name(left), doubt.text));
        }
        if !counts.doubted.contains(&place) {
            counts.doubted.push_front(place);
            counts.doubted.truncate(KEPT);
            counts.ran.doubtful_pairs += 1;
        }
        if self.sequence.len().is_some() || counts.ran.doubtful.len() < LISTED {
            counts.ran.doubtful.push((place, format!("{}: {}", left.to_string_lossy(), doubt.text)));
        }
    }

    /// Nothing more can be written.
    pub fn stop(&self, error: anyhow::Error) {
        self.counts().ran.stopped.get_or_insert(error);
    }

    /// Whether nothing more can be written.
    pub fn is_stopped(&self) -> bool {
        self.counts().ran.stopped.is_some()
    }

    /// Waits until all pairs before this one are written or failed.
    pub fn wait_for(&self, place: usize) {
        let is_behind = |ran: &Ran| ran.done + ran.failed.len() < place && ran.stopped.is_none();
        while is_behind(&self.counts().ran) {
            thread::sleep(Duration::from_millis(1));
        }
    }

    fn show(&self, counts: &Counts) {
        self.pace.show(counts.ran.done + counts.ran.failed.len());
    }

    /// All that was counted.
    pub fn finish(self) -> Ran {
        self.pace.finish();
        let mut ran = self.counts.into_inner().unwrap_or_else(PoisonError::into_inner).ran;
        ran.failed.sort_by_key(|failure| failure.place);
        ran.doubtful.sort();
        ran
    }
}
