//! The threads that read pairs ahead, and those that write maps. They take turns, so that the order is kept, and no more is read
//! ahead or waits to be written than the channels hold.

use super::tally::{Doubt, Tally};
use super::work::{MatchedPair, Refused, Sequence, Setup, Work};
use crate::engine::compute::OfPair;
use crate::engine::diagnosis::{self, Evidence};
use crate::engine::pair::Pair;
use anyhow::{Context as _, Result, anyhow};
use gpu_stereo::Image;
use gpu_stereo::files::images::ImagePair;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::{self, Scope};

/// A pair as it was read, with what is doubtful about it.
pub struct ReadPair {
    /// The left image.
    pub left: Image,
    /// The right image.
    pub right: Image,
    /// Why its map may be wrong.
    pub doubts: Vec<Doubt>,
    /// Its corners, if it is its turn to be diagnosed.
    evidence: Option<Evidence>,
}

impl ReadPair {
    /// Reads a pair, and diagnoses it if it is its turn.
    pub fn read(work: &dyn Work, place: usize, pair: &Pair, setup: &Setup<'_>) -> Result<Self, Refused> {
        let ImagePair { left, right, doubts, .. } = work.read(place, pair, setup.input)?;
        let doubts = doubts.into_iter().map(|text| Doubt { text, kind: None }).collect();
        // What the cameras do not fit is refused later.
        let params = place.is_multiple_of(setup.diagnosed).then(|| setup.params.of([left.width(), left.height()]).ok());
        let evidence = params.flatten().and_then(|params| diagnosis::evidence(&left, &right, &params).ok());
        Ok(Self { left, right, doubts, evidence })
    }

    /// Adds what is doubtful about a map with these settings.
    pub fn examine(&mut self, settings: &OfPair) {
        self.doubts.extend(settings.doubt.clone().map(|text| Doubt { text, kind: None }));
        let evidence = self.evidence.take();
        let finding = evidence.and_then(|evidence| evidence.finding(&settings.params.searched()));
        self.doubts.extend(finding.as_ref().map(Doubt::of));
    }
}

type Read = Result<ReadPair, Refused>;

/// The threads that read.
pub struct Readers(Vec<Receiver<Read>>);

impl Readers {
    /// Starts them; none where each pair is written before the next one is read.
    pub fn start<'scope, 'env: 'scope>(
        scope: &'scope Scope<'scope, 'env>,
        sequence: Sequence<'env>,
        setup: &'env Setup<'env>,
        work: &'env dyn Work,
    ) -> Result<Self> {
        let threads = match sequence {
            Sequence::Stream(_) => 1,
            Sequence::Files(_) if setup.alone => 0,
            Sequence::Files(_) => setup.readers.max(1),
        };
        let start = |first| {
            let (sender, receiver) = sync_channel(1);
            spawn(scope, move || {
                for place in (first..).step_by(threads) {
                    let Some(pair) = sequence.pair(place) else { return };
                    let read = ReadPair::read(work, place, &pair, setup);
                    let is_last = matches!(read, Err(Refused::End));
                    // If nobody receives it, the pairs that follow are not wanted any more.
                    if sender.send(read).is_err() || is_last {
                        return;
                    }
                }
            })?;
            Ok(receiver)
        };
        Ok(Self((0..threads).map(start).collect::<Result<_>>()?))
    }

    /// A pair, if it was read.
    pub fn try_next(&self, place: usize) -> Result<Read, TryRecvError> {
        self.0[place % self.0.len()].try_recv()
    }

    /// A pair, once it is read.
    pub fn next(&self, place: usize) -> Result<Read> {
        self.0[place % self.0.len()].recv().map_err(|_| anyhow!("the thread that reads has ended"))
    }
}

/// The threads that write.
pub struct Writers(Vec<SyncSender<MatchedPair>>);

impl Writers {
    /// Starts them.
    pub fn start<'scope, 'env: 'scope>(
        scope: &'scope Scope<'scope, 'env>,
        setup: &Setup<'_>,
        work: &'env dyn Work,
        tally: &'env Tally<'env>,
    ) -> Result<Self> {
        let start = |_| {
            let (sender, receiver) = sync_channel::<MatchedPair>(1);
            spawn(scope, move || {
                for pair in receiver {
                    if tally.is_stopped() {
                        continue;
                    }
                    match work.write(&pair) {
                        Ok(()) => tally.done(),
                        Err(Refused::Pair(error)) => tally.failed(pair.place, &error),
                        Err(Refused::All(error)) => tally.stop(error),
                        Err(Refused::End) => {}
                    }
                }
            })?;
            Ok(sender)
        };
        Ok(Self((0..setup.writers.max(1)).map(start).collect::<Result<_>>()?))
    }

    /// Has a map written.
    pub fn write(&self, pair: MatchedPair) -> Result<()> {
        let writer = &self.0[pair.place % self.0.len()];
        writer.send(pair).map_err(|_| anyhow!("the thread that writes has ended"))
    }
}

/// Starts a thread, unless the system has no more.
fn spawn<'scope>(scope: &'scope Scope<'scope, '_>, work: impl FnOnce() + Send + 'scope) -> Result<()> {
    let started = thread::Builder::new().spawn_scoped(scope, work);
    started
        .map(drop)
        .context("a thread cannot be started; raise the limit of threads (ulimit -u), or give fewer (-j 1)")
}
