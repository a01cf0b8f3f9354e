//! Pipeline: pairs are read ahead by some threads, matched several at a time, and written by other threads, so that the
//! device waits for no file.

use crate::adapter::Opened;
use crate::args::DeviceArgs;
use crate::run::{Engine, OnAdapter};
use crate::{input, tell};
use anyhow::{Result, anyhow};
use gpu_stereo::{Error, Image, Matched, Params, StereoStream, reference};
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use serde::Serialize;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Between two lines of progress where there is no terminal.
const A_LINE: Duration = Duration::from_secs(1);

/// A pair to match.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// The left image.
    pub left: PathBuf,
    /// The right image.
    pub right: PathBuf,
}

/// How to match them.
pub struct Setup<'a> {
    /// Where.
    pub device: &'a DeviceArgs,
    /// The settings.
    pub params: &'a Params,
    /// Pairs on the device at a time.
    pub in_flight: usize,
    /// Threads that read.
    pub readers: usize,
    /// Threads that write; with one, the frames come in order.
    pub writers: usize,
    /// No progress.
    pub quiet: bool,
}

/// A pair's left image and what was found.
pub struct Frame {
    /// Which pair it was.
    pub place: usize,
    /// The left image.
    pub left: Image,
    /// The map.
    pub matched: Matched,
}

/// Why a frame could not be written.
pub enum Refused {
    /// Others can be.
    Frame(anyhow::Error),
    /// No other can be, either.
    All(anyhow::Error),
}

/// What came of all pairs.
#[derive(Debug, Default)]
pub struct Ran {
    /// Adapter, backend and driver, if there was anything to compute.
    pub names: Option<(String, String, String)>,
    /// Columns and rows.
    pub size: Option<(u32, u32)>,
    /// Bytes in use on the device.
    pub device_bytes: u64,
    /// Frames that were written.
    pub done: usize,
    /// Frames that were not.
    pub failed: Vec<Failure>,
    /// From the start to the last frame written.
    pub seconds: f64,
    /// What ended it before its time.
    pub stopped: Option<anyhow::Error>,
}

/// A frame that failed.
#[derive(Debug, Serialize)]
pub struct Failure {
    #[serde(skip)]
    place: usize,
    /// The left image's path.
    pub frame: String,
    /// Why.
    pub error: String,
}

/// Half of the cores, at most 8: threads that read, and as many that write.
pub fn threads() -> usize {
    (thread::available_parallelism().map_or(1, usize::from) / 2).clamp(1, 8)
}

/// Matches all pairs and hands each result to `put`. What fails is told at once, and the rest goes on. Once `stop` is
/// true, no further pair is begun.
pub fn run(
    pairs: &[Pair],
    setup: &Setup<'_>,
    stop: &AtomicBool,
    put: impl Fn(&Frame) -> Result<(), Refused> + Sync,
) -> Ran {
    let start = Instant::now();
    let tally = Tally::new(pairs, setup.quiet);
    let mut flow: Option<Flow> = None;
    let ended = thread::scope(|scope| {
        // The threads take turns, so the order is kept, and no more is read ahead than the channels hold.
        let readers = setup.readers.max(1);
        let read = |first| {
            let (sender, receiver) = sync_channel(1);
            scope.spawn(move || {
                for pair in pairs.iter().skip(first).step_by(readers) {
                    if sender.send(input::read_pair(&pair.left, &pair.right)).is_err() {
                        return; // the pairs that follow are not wanted any more
                    }
                }
            });
            receiver
        };
        let read: Vec<Receiver<_>> = (0..readers).map(read).collect();
        let write = |_| {
            let (sender, receiver) = sync_channel::<Frame>(1);
            let (tally, put) = (&tally, &put);
            scope.spawn(move || {
                for frame in receiver {
                    if tally.is_stopped() {
                        continue;
                    }
                    match put(&frame) {
                        Ok(()) => tally.done(),
                        Err(Refused::Frame(error)) => tally.failed(frame.place, &error),
                        Err(Refused::All(error)) => tally.stop(error),
                    }
                }
            });
            sender
        };
        let written: Vec<_> = (0..setup.writers.max(1)).map(write).collect();
        let hand_on = |frame: Option<(usize, Image, Matched)>| -> Result<()> {
            let Some((place, left, matched)) = frame else { return Ok(()) };
            let writer = &written[place % written.len()];
            writer.send(Frame { place, left, matched }).map_err(|_| anyhow!("the thread that writes has ended"))
        };

        for place in 0..pairs.len() {
            let pair = loop {
                match (read[place % readers].try_recv(), &mut flow) {
                    (Ok(pair), _) => break pair,
                    // Time for a result while the pair is read.
                    (Err(TryRecvError::Empty), Some(flow)) if flow.in_flight() > 0 => hand_on(flow.next()?)?,
                    _ => break read[place % readers].recv().map_err(|_| anyhow!("the thread that reads has ended"))?,
                }
            };
            if stop.load(Ordering::Relaxed) || tally.is_stopped() {
                break;
            }
            let (left, right) = match pair {
                Ok(pair) => pair,
                Err(error) => {
                    tally.failed(place, &error);
                    continue;
                }
            };
            let flow = match &mut flow {
                Some(flow) => flow,
                none => none.insert(Flow::open(setup, &left)?),
            };
            if let Err(error) = flow.ensure_fits(&left) {
                tally.failed(place, &error);
                continue;
            }
            while flow.in_flight() >= flow.capacity() {
                hand_on(flow.next()?)?;
            }
            flow.push(place, left, &right)?;
        }
        while let Some(flow) = flow.as_mut().filter(|flow| flow.in_flight() > 0 && !tally.is_stopped()) {
            hand_on(flow.next()?)?;
        }
        anyhow::Ok(())
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
    if ran.stopped.is_none() && stop.load(Ordering::Relaxed) && ran.done + ran.failed.len() < pairs.len() {
        ran.stopped = Some(anyhow!("interrupted"));
    }
    ran
}

/// What matches, and the pairs in it.
struct Flow {
    matcher: Matcher,
    names: (String, String, String),
    size: (u32, u32),
    format: gpu_stereo::PixelFormat,
    waiting: VecDeque<(usize, Image)>,
}

enum Matcher {
    Stream(Box<(Opened, StereoStream)>),
    /// With the result of the pair that was pushed.
    Reference(Params, Option<Matched>),
}

impl Flow {
    /// For pairs that are as `left` is.
    fn open(setup: &Setup<'_>, left: &Image) -> Result<Self> {
        let engine = Engine::open(setup.device, false, left, setup.params)?;
        let names = engine.names();
        let matcher = match engine {
            Engine::Reference => Matcher::Reference(setup.params.clone(), None),
            Engine::Adapter(on) => {
                let OnAdapter { opened, matcher } = *on;
                let stream = StereoStream::new(matcher, setup.in_flight);
                opened.fault()?;
                Matcher::Stream(Box::new((opened, stream?)))
            }
        };
        let size = (left.width(), left.height());
        Ok(Self { matcher, names, size, format: left.format(), waiting: VecDeque::new() })
    }

    fn ensure_fits(&self, left: &Image) -> Result<()> {
        let (size, format) = ((left.width(), left.height()), left.format());
        if (size, format) == (self.size, self.format) {
            return Ok(());
        }
        let told = |(width, height), format| format!("{width}x{height} in {format:?}");
        Err(anyhow!(
            "it is {}, but the first frame is {}; give frames of one kind",
            told(size, format),
            told(self.size, self.format)
        ))
    }

    fn in_flight(&self) -> usize {
        self.waiting.len()
    }

    fn capacity(&self) -> usize {
        match &self.matcher {
            Matcher::Stream(on) => on.1.capacity(),
            Matcher::Reference(..) => 1,
        }
    }

    fn device_bytes(&self) -> u64 {
        match &self.matcher {
            Matcher::Stream(on) => on.1.matcher().device_bytes(),
            Matcher::Reference(..) => 0,
        }
    }

    /// Begins with a pair that fits; there is room for it.
    fn push(&mut self, place: usize, left: Image, right: &Image) -> Result<()> {
        match &mut self.matcher {
            Matcher::Stream(on) => {
                let (opened, stream) = on.as_mut();
                let pushed = stream.try_push(&left, right);
                opened.fault()?;
                pushed?.ok_or_else(|| anyhow!("the stream is full before its time"))?;
            }
            Matcher::Reference(params, result) => {
                *result = Some(reference::compute_all(&left, right, params)?);
            }
        }
        self.waiting.push_back((place, left));
        Ok(())
    }

    /// The next result. What fails here is the device, so all that follows would fail, too.
    fn next(&mut self) -> Result<Option<(usize, Image, Matched)>> {
        let matched = match &mut self.matcher {
            Matcher::Stream(on) => {
                let (opened, stream) = on.as_mut();
                let frame = stream.next_blocking();
                opened.fault()?;
                frame.map(|frame| frame.result).transpose()?
            }
            Matcher::Reference(_, result) => result.take(),
        };
        let ended = || Error::Lost("the stream gave no result".into());
        let Some((place, left)) = self.waiting.pop_front() else { return Ok(None) };
        Ok(Some((place, left, matched.ok_or_else(ended)?)))
    }
}

/// Counts, and shows a bar on a terminal and a line a second elsewhere, both on stderr.
struct Tally<'a> {
    pairs: &'a [Pair],
    bar: ProgressBar,
    lines: bool,
    start: Instant,
    counts: Mutex<Counts>,
}

struct Counts {
    ran: Ran,
    told: Instant,
}

impl<'a> Tally<'a> {
    fn new(pairs: &'a [Pair], quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(pairs.len() as u64) };
        let style = ProgressStyle::with_template("{bar:24} {pos}/{len}  {msg}");
        let bar = bar.with_finish(ProgressFinish::AndClear).with_style(style.unwrap_or(ProgressStyle::default_bar()));
        let lines = bar.is_hidden() && !quiet;
        let start = Instant::now();
        Self { pairs, bar, lines, start, counts: Mutex::new(Counts { ran: Ran::default(), told: start }) }
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn done(&self) {
        let mut counts = self.counts();
        counts.ran.done += 1;
        self.show(&mut counts);
    }

    fn failed(&self, place: usize, error: &anyhow::Error) {
        let frame = self.pairs[place].left.to_string_lossy().into_owned();
        let error = crate::one_line(&format!("{error:#}"));
        let mut counts = self.counts();
        self.bar.suspend(|| tell(&format!("failed: {frame}: {error}")));
        counts.ran.failed.push(Failure { place, frame, error });
        self.show(&mut counts);
    }

    fn stop(&self, error: anyhow::Error) {
        self.counts().ran.stopped.get_or_insert(error);
    }

    fn is_stopped(&self) -> bool {
        self.counts().ran.stopped.is_some()
    }

    fn show(&self, counts: &mut Counts) {
        let (position, all) = (counts.ran.done + counts.ran.failed.len(), self.pairs.len());
        let rate = position as f64 / self.start.elapsed().as_secs_f64().max(1e-9);
        let left = (all - position) as f64 / rate;
        let message = format!("{rate:.1} frames a second, {} left", time(left));
        self.bar.set_message(message.clone());
        self.bar.set_position(position as u64);
        if self.lines && (counts.told.elapsed() >= A_LINE || position == all) {
            counts.told = Instant::now();
            tell(&format!("{position}/{all}  {message}"));
        }
    }

    fn finish(self) -> Ran {
        self.bar.finish_and_clear();
        let mut ran = self.counts.into_inner().unwrap_or_else(PoisonError::into_inner).ran;
        ran.failed.sort_by_key(|failure| failure.place);
        ran
    }
}

/// Seconds in words.
fn time(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s:02} s"),
        (h, m, _) => format!("{h} h {m:02} min"),
    }
}

/// Once it is true, a run ends: after Ctrl-C, and where the system asks it to. The second time the process ends at once.
pub fn stop_on_signals() -> &'static AtomicBool {
    static STOP: AtomicBool = AtomicBool::new(false);
    let handler = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(2);
        }
        tell("interrupted: finishing the frames that were begun");
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        tell(&format!("note: signals cannot be caught ({error}), so an interrupted run may leave temporary files"));
    }
    &STOP
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_in_words() {
        assert_eq!([0.4, 59.6, 3599.0, 7384.0].map(time), ["0 s", "1 min 00 s", "59 min 59 s", "2 h 03 min"]);
    }
}
