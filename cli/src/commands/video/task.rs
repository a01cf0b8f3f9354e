//! The task: which frames go where, and the run over them.

use super::bag::{Bag, FromRecord};
use super::film::Film;
use super::numbered::Numbered;
use super::source::Source;
use crate::args::{self, DeviceArgs, InputArgs};
use crate::commands::summary::{Searched, Summary};
use crate::engine::compute::{ParamsBySize, ends};
use crate::engine::pipeline::{self, FailedPair, Ran, Sequence, Setup, Work};
use crate::engine::signals::stop_on_signals;
use crate::engine::store::Store;
use crate::engine::streams::Stream;
use crate::engine::trial;
use anyhow::{Result, bail};
use std::path::PathBuf;
use std::sync::Mutex;

/// One of so many frames is diagnosed: what is wrong with the cameras is wrong in all frames.
const DIAGNOSED: usize = 16;

/// A video, ready to start.
pub struct Video {
    pub device: DeviceArgs,
    pub input: InputArgs,
    pub params: ParamsBySize,
    /// How many of the first frames told the range, if the options leave it to them.
    pub first: Option<usize>,
    pub keeps_right: bool,
    pub in_flight: usize,
    pub task: Task,
    pub output: PathBuf,
    pub json: bool,
    pub quiet: bool,
}

/// Which frames go where.
pub enum Task {
    /// Files into a folder that knows which of them it has.
    Folder(Box<Store>),
    Numbered(Source, Numbered),
    Film(Source, Film),
    Bag(Box<Stream>, Box<Bag>),
}

impl Video {
    /// Computes all frames.
    pub fn run(self) -> Result<Summary<FailedPair>> {
        let stop = stop_on_signals();
        let threads = args::usual_threads();
        let setup = Setup {
            device: &self.device,
            params: &self.params,
            input: &self.input,
            diagnosed: DIAGNOSED,
            keeps_right: self.keeps_right,
            in_flight: self.in_flight,
            readers: threads,
            writers: if let Task::Film(..) | Task::Bag(..) = self.task { 1 } else { threads },
            mixed: false,
            kind: None,
            alone: false,
            unit: "frames",
            of_first: self.first.is_some(),
            quiet: self.quiet,
        };
        let (mut ran, skipped) = match self.task {
            Task::Folder(store) => {
                if store.mode.suspects.is_some() {
                    trial::stop_with_parent(stop)?;
                }
                let ran = trial::run(&store, &setup, stop);
                let closed = store.close();
                let ran = whole(ran, Some(store.pairs.len()), "were written: --resume computes the rest")?;
                closed?;
                (ran, store.skipped())
            }
            Task::Numbered(source, work) => {
                (whole(source.run(&setup, stop, &work as &dyn Work), source.len(), "were written")?, 0)
            }
            Task::Film(source, film) => {
                let ran = source.run(&setup, stop, &film);
                let is_whole = ran.stopped.is_none();
                match film.finish(is_whole) {
                    Err(why) if is_whole => return Err(why),
                    // ffmpeg's message is the cause.
                    Err(why) => {
                        bail!("{why:#}, after {}; no video was written", frames(&ran, source.len()))
                    }
                    Ok(()) => (whole(ran, source.len(), "were done, and no video was written")?, 0),
                }
            }
            Task::Bag(stream, bag) => {
                let name = stream.name.clone();
                let work = FromRecord { stream: &stream, bag: &bag, taken: Mutex::default() };
                let ran = pipeline::run(Sequence::Stream(&name), &setup, stop, &work);
                let ran = whole(ran, None, "were done, and no record was written")?;
                bag.finish()?;
                (ran, 0)
            }
        };
        let (size, failures) = (ran.size, std::mem::take(&mut ran.failed));
        let searched = match self.first {
            Some(frames) => Searched::OfFirst(ends(&self.params.common), frames),
            None => Searched::of(&self.params),
        };
        let summary = Summary::new("frames", ran, searched, self.output, failures);
        Ok(Summary { size: Some(size), skipped, ..summary })
    }
}

/// The results, or the error if the run was stopped.
fn whole(mut ran: Ran, all: Option<usize>, kept: &str) -> Result<Ran> {
    match ran.stopped.take() {
        Some(error) => bail!("{error:#}; {} {kept}", frames(&ran, all)),
        None => Ok(ran),
    }
}

/// How far a run came, in words.
fn frames(ran: &Ran, all: Option<usize>) -> String {
    let all = all.map(|all| format!(" of {all}")).unwrap_or_default();
    format!("{}{all} frames", ran.done)
}
