//! The pipeline: some threads read pairs ahead, this one has several at a time on the device, and other threads write the maps,
//! so that the device never waits for a file.

mod flow;
mod tally;
mod threads;
mod work;

use crate::engine::diagnosis;
use anyhow::{Result, anyhow};
use flow::Flow;
use gpu_stereo::{Error, Image, Params};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::TryRecvError;
use std::thread;
use std::time::Instant;
use tally::{Doubt, Tally};
use threads::{ReadPair, Readers, Writers};
pub use work::{FailedPair, MatchedPair, PairKind, Ran, Refused, Sequence, Setup, Work};

/// Matches all pairs. A failure is reported at once, and the rest goes on. Once `stop` is true, no further pair is begun.
pub fn run(sequence: Sequence<'_>, setup: &Setup<'_>, stop: &AtomicBool, work: &dyn Work) -> Ran {
    let start = Instant::now();
    let tally = Tally::new(sequence, setup, work);
    let mut flow = None;
    let ended = thread::scope(|scope| {
        let readers = Readers::start(scope, sequence, setup, work)?;
        let writers = Writers::start(scope, setup, work, &tally)?;
        Run { sequence, setup, stop, work, tally: &tally, readers, writers, flow: &mut flow }.all()
    });
    let mut ran = tally.finish();
    ran.seconds = start.elapsed().as_secs_f64();
    if let Some(flow) = flow {
        ran.size = Some(flow.size);
        ran.device_bytes = flow.device_bytes();
        ran.names = Some(flow.names);
    }
    // The first cause comes first.
    ran.stopped = ran.stopped.or(ended.err());
    // A stream that is interrupted ends there.
    let is_cut = sequence.len().is_some_and(|all| ran.done + ran.failed.len() < all);
    if ran.stopped.is_none() && stop.load(Ordering::Relaxed) && is_cut {
        ran.stopped = Some(anyhow!("interrupted"));
    }
    ran
}

/// The state of the thread that feeds the device.
struct Run<'a> {
    sequence: Sequence<'a>,
    setup: &'a Setup<'a>,
    stop: &'a AtomicBool,
    work: &'a dyn Work,
    tally: &'a Tally<'a>,
    readers: Readers,
    writers: Writers,
    flow: &'a mut Option<Flow>,
}

impl Run<'_> {
    /// Reads, admits and begins one pair after another.
    fn all(mut self) -> Result<()> {
        for place in 0..self.sequence.len().unwrap_or(usize::MAX) {
            let read = self.read(place)?;
            if self.stop.load(Ordering::Relaxed) || self.tally.is_stopped() {
                break;
            }
            let pair = match read.and_then(|pair| self.ensure_kind(pair)) {
                Ok(pair) => pair,
                Err(Refused::Pair(error)) => {
                    self.tally.failed(place, &error);
                    continue;
                }
                Err(Refused::All(error)) => return Err(error),
                Err(Refused::End) => break,
            };
            if let Some(pair) = self.with_room(place, pair)? {
                self.begin(place, pair)?;
            }
        }
        while self.in_flight() > 0 && !self.tally.is_stopped() {
            self.hand_on()?;
        }
        Ok(())
    }

    /// Waits until a pair is read, and hands on results meanwhile.
    fn read(&mut self, place: usize) -> Result<Result<ReadPair, Refused>> {
        if self.setup.alone {
            self.hand_on_all()?;
            self.tally.wait_for(place);
            return Ok(match self.tally.is_stopped() {
                true => Err(Refused::Pair(anyhow!("stopped"))),
                false => match self.sequence.pair(place) {
                    Some(pair) => ReadPair::read(self.work, place, &pair, self.setup),
                    None => Err(Refused::End),
                },
            });
        }
        loop {
            match self.readers.try_next(place) {
                Ok(pair) => return Ok(pair),
                Err(TryRecvError::Empty) if self.in_flight() > 0 => self.hand_on()?,
                Err(_) => return self.readers.next(place),
            }
        }
    }

    /// The pair, unless it must be of the kind that is known beforehand, or as the first one, and is not.
    fn ensure_kind(&self, pair: ReadPair) -> Result<ReadPair, Refused> {
        let kind = self.setup.kind.or(self.flow.as_ref().map(|flow| &flow.kind));
        if let Some(kind) = kind.filter(|_| !self.setup.mixed) {
            kind.ensure(&pair.left).map_err(Refused::Pair)?;
        }
        Ok(pair)
    }

    /// The pair, once the engine is fit for it; none if that failed, which is counted.
    fn with_room(&mut self, place: usize, mut pair: ReadPair) -> Result<Option<ReadPair>> {
        let fits = match self.setup.params.of_pair([&pair.left, &pair.right]) {
            Ok(settings) => {
                pair.examine(&settings);
                self.make_room(&pair.left, &settings.params)?
            }
            Err(error) => Err(error),
        };
        match fits {
            Ok(()) => Ok(Some(pair)),
            Err(error) if is_of_the_pair(&error) && (self.setup.mixed || self.flow.is_some()) => {
                self.tally.failed(place, &error);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    fn make_room(&mut self, left: &Image, params: &Arc<Params>) -> Result<Result<()>> {
        let Some(flow) = &self.flow else {
            return Ok(Flow::open(self.setup, left, params).map(|flow| *self.flow = Some(flow)));
        };
        // Other streams give their results in an order of their own.
        if self.setup.mixed && flow.is_other(left, params) {
            self.hand_on_all()?;
        }
        let fits = self.fit(left, params);
        if self.setup.mixed && self.in_flight() > 0 && fits.as_ref().is_err_and(is_of_the_pair) {
            self.hand_on_all()?;
            return Ok(self.fit(left, params));
        }
        Ok(fits)
    }

    fn fit(&mut self, left: &Image, params: &Arc<Params>) -> Result<()> {
        self.flow.as_mut().map_or(Ok(()), |flow| flow.fit(left, params))
    }

    /// Begins to match a pair, once fewer than the most are in flight.
    fn begin(&mut self, place: usize, pair: ReadPair) -> Result<()> {
        while self.flow.as_ref().is_some_and(|flow| flow.in_flight() >= flow.capacity()) {
            self.hand_on()?;
        }
        let ReadPair { left, right, doubts, .. } = pair;
        if let Some(flow) = self.flow {
            flow.push(place, left, right, self.setup.keeps_right)?;
        }
        doubts.into_iter().for_each(|doubt| self.tally.doubt(place, doubt));
        Ok(())
    }

    fn in_flight(&self) -> usize {
        self.flow.as_ref().map_or(0, Flow::in_flight)
    }

    /// Has the next result written.
    fn hand_on(&mut self) -> Result<()> {
        match self.flow.as_mut().map(Flow::next).transpose()?.flatten() {
            Some(mut pair) => {
                self.setup.params.cut(&mut pair.matched);
                if let Some(pressed) =
                    self.setup.of_first.then(|| diagnosis::pressed(&pair.matched.map, &pair.params)).flatten()
                {
                    self.tally.doubt(pair.place, Doubt::of(&pressed));
                }
                self.writers.write(pair)
            }
            None => Ok(()),
        }
    }

    fn hand_on_all(&mut self) -> Result<()> {
        while self.in_flight() > 0 {
            self.hand_on()?;
        }
        Ok(())
    }
}

/// Whether an error concerns one pair alone, so that others can still be matched.
fn is_of_the_pair(error: &anyhow::Error) -> bool {
    matches!(
        error.downcast_ref(),
        Some(Error::Image(_) | Error::TooLarge { .. } | Error::Memory { .. } | Error::OutOfMemory)
    )
}
