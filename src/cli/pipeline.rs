//! Pipeline: pairs are read ahead by some threads, matched several at a time, and written by other threads, so that the
//! device waits for no file.

use crate::adapter::Opened;
use crate::args::{DeviceArgs, InputArgs, Whole};
use crate::diagnosis::{self, Finding};
use crate::lossless::Name;
use crate::run::{self, Engine, OnAdapter};
use crate::views::{self, Views};
use crate::{disk, name, tell, warnings};
use anyhow::{Context as _, Result, anyhow, bail};
use gpu_stereo::{Error, Image, Matched, Params, PixelFormat, StereoMatcher, StereoStream, reference};
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use serde::{Deserialize, Serialize};
use std::collections::{HashSet, VecDeque};
use std::mem::Discriminant;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, Scope};
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
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// Where.
    pub device: &'a DeviceArgs,
    /// The settings.
    pub params: &'a Params,
    /// How they are read.
    pub input: &'a InputArgs,
    /// One of so many pairs is looked at whether it can be matched.
    pub looked_at: usize,
    /// Pairs on the device at a time.
    pub in_flight: usize,
    /// Threads that read.
    pub readers: usize,
    /// Threads that write; with one, the frames come in order.
    pub writers: usize,
    /// Whether pairs may differ in size and samples; else all must be as the first one.
    pub mixed: bool,
    /// What the first one must be, if that is known, unless they may differ.
    pub kind: Option<&'a Kind>,
    /// Whether each pair is written before the next one is read.
    pub alone: bool,
    /// What the progress counts.
    pub unit: &'static str,
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

/// Size and samples of a pair, in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kind(String);

impl Kind {
    /// That of an image.
    pub fn of(image: &Image) -> Self {
        Self(format!("{}x{} in {:?}", image.width(), image.height(), image.format()))
    }

    /// All frames are of the first one's kind.
    fn ensure(&self, image: &Image) -> Result<()> {
        let (Self(first), it) = (self, Self::of(image));
        if it != *self {
            let it = it.0;
            bail!(Error::Image(format!("it is {it}, but the first frame is {first}; give frames of one kind")));
        }
        Ok(())
    }
}

/// Why a frame could not be read or written.
pub enum Refused {
    /// Others can be.
    Frame(anyhow::Error),
    /// No other can be, either.
    All(anyhow::Error),
}

impl Refused {
    /// A failure to write: some last, as that of a full disk.
    pub fn of(error: anyhow::Error) -> Self {
        if disk::is_lasting(&error) { Self::All(error) } else { Self::Frame(error) }
    }
}

/// Where pairs come from, and where their maps go.
pub trait Work: Sync {
    /// Reads a pair.
    fn read(&self, _place: usize, pair: &Pair, options: &InputArgs) -> Result<Views, Refused> {
        views::read_pair(&pair.left, &pair.right, options).map_err(Refused::Frame)
    }

    /// Writes a frame.
    fn put(&self, frame: &Frame) -> Result<(), Refused>;

    /// Writes down that a pair failed, and why.
    fn failed(&self, _place: usize, _error: &str) -> Result<()> {
        Ok(())
    }
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
    /// Pairs whose map is doubtful, with why.
    pub doubtful: Vec<(usize, String)>,
    /// From the start to the last frame written.
    pub seconds: f64,
    /// What ended it before its time.
    pub stopped: Option<anyhow::Error>,
}

/// A frame that failed.
#[derive(Debug, Serialize)]
pub struct Failure {
    /// Which pair it was.
    #[serde(skip)]
    pub place: usize,
    /// The left image's path.
    pub frame: Name,
    /// Why.
    pub error: String,
}

const MAX_IN_FLIGHT: usize = 16;

/// The pairs on the device at a time.
pub fn in_flight(given: &Whole) -> Result<usize> {
    let in_flight = usize::try_from(given.value).ok().filter(|pairs| (1..=MAX_IN_FLIGHT).contains(pairs));
    in_flight
        .with_context(|| format!("--in-flight is {}, but must be from 1 to {MAX_IN_FLIGHT}; 3 is usual", given.text))
}

/// Half of the cores, at most 8: threads that read, and as many that write.
pub fn threads() -> usize {
    (thread::available_parallelism().map_or(1, usize::from) / 2).clamp(1, 8)
}

/// Matches all pairs. What fails is reported at once, and the rest goes on. Once `stop` is true, no further pair is begun.
pub fn run(pairs: &[Pair], setup: &Setup<'_>, stop: &AtomicBool, work: &impl Work) -> Ran {
    let start = Instant::now();
    let tally = Tally::new(pairs, setup, work);
    let mut flow: Option<Flow> = None;
    let ended = thread::scope(|scope| {
        // The threads take turns, so the order is kept, and no more is read ahead than the channels hold.
        let readers = if setup.alone { 0 } else { setup.readers.max(1) };
        let read = |first| {
            let (sender, receiver) = sync_channel(1);
            spawn(scope, move || {
                for (place, pair) in pairs.iter().enumerate().skip(first).step_by(readers) {
                    if sender.send(Read::pair(work, place, pair, setup)).is_err() {
                        return; // the pairs that follow are not wanted any more
                    }
                }
            })?;
            anyhow::Ok(receiver)
        };
        let read = (0..readers).map(read).collect::<Result<Vec<Receiver<_>>>>()?;
        let write = |_| {
            let (sender, receiver) = sync_channel::<Frame>(1);
            let tally = &tally;
            spawn(scope, move || {
                for frame in receiver {
                    if tally.is_stopped() {
                        continue;
                    }
                    match work.put(&frame) {
                        Ok(()) => tally.done(),
                        Err(Refused::Frame(error)) => tally.failed(frame.place, &error),
                        Err(Refused::All(error)) => tally.stop(error),
                    }
                }
            })?;
            anyhow::Ok(sender)
        };
        let written = (0..setup.writers.max(1)).map(write).collect::<Result<Vec<_>>>()?;
        let hand_on = |frame: Option<(usize, Image, Matched)>| -> Result<()> {
            let Some((place, left, matched)) = frame else { return Ok(()) };
            let writer = &written[place % written.len()];
            writer.send(Frame { place, left, matched }).map_err(|_| anyhow!("the thread that writes has ended"))
        };

        for (place, pair) in pairs.iter().enumerate() {
            let pair = loop {
                if setup.alone {
                    while let Some(flow) = flow.as_mut().filter(|flow| flow.in_flight() > 0) {
                        hand_on(flow.next()?)?;
                    }
                    tally.wait_for(place);
                    break if tally.is_stopped() {
                        Err(Refused::Frame(anyhow!("stopped")))
                    } else {
                        Read::pair(work, place, pair, setup)
                    };
                }
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
            let pair = pair.and_then(|pair| match setup.kind {
                Some(kind) if !setup.mixed => kind.ensure(&pair.left).map(|()| pair).map_err(Refused::Frame),
                _ => Ok(pair),
            });
            let Read { left, right, doubts } = match pair {
                Ok(pair) => pair,
                Err(Refused::Frame(error)) => {
                    tally.failed(place, &error);
                    continue;
                }
                Err(Refused::All(error)) => return Err(error),
            };
            let ready = match &mut flow {
                Some(flow) => {
                    // Streams of other samples give their results in an order of their own.
                    while setup.mixed && flow.in_flight() > 0 && flow.format != left.format() {
                        hand_on(flow.next()?)?;
                    }
                    let mut ready = flow.fit(setup, &left);
                    if setup.mixed && flow.in_flight() > 0 && ready.as_ref().is_err_and(is_of_the_pair) {
                        while flow.in_flight() > 0 {
                            hand_on(flow.next()?)?;
                        }
                        ready = flow.fit(setup, &left);
                    }
                    ready
                }
                none => Flow::open(setup, &left).map(|opened| *none = Some(opened)),
            };
            match ready {
                Ok(()) => {}
                Err(error) if is_of_the_pair(&error) && (setup.mixed || flow.is_some()) => {
                    tally.failed(place, &error);
                    continue;
                }
                Err(error) => return Err(error),
            }
            let Some(flow) = &mut flow else { continue };
            while flow.in_flight() >= flow.capacity() {
                hand_on(flow.next()?)?;
            }
            flow.push(place, left, &right)?;
            doubts.into_iter().for_each(|doubt| tally.doubt(place, doubt));
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

/// A pair as it was read, with what is doubtful about it.
struct Read {
    left: Image,
    right: Image,
    doubts: Vec<Doubt>,
}

/// Why a map is doubtful, and what kind of cause it is.
struct Doubt {
    text: String,
    kind: Option<Discriminant<Finding>>,
}

impl Read {
    fn pair(work: &impl Work, place: usize, pair: &Pair, setup: &Setup<'_>) -> Result<Self, Refused> {
        let Views { left, right, doubts, .. } = work.read(place, pair, setup.input)?;
        let mut doubts: Vec<_> = doubts.into_iter().map(|text| Doubt { text, kind: None }).collect();
        // What cannot be rectified is refused later.
        if place.is_multiple_of(setup.looked_at)
            && let Ok(Some(finding)) = diagnosis::finding(&left, &right, setup.params)
        {
            doubts.push(Doubt { text: finding.to_string(), kind: Some(finding.kind()) });
        }
        Ok(Self { left, right, doubts })
    }
}

/// Starts a thread, unless the system has no more.
fn spawn<'scope>(scope: &'scope Scope<'scope, '_>, work: impl FnOnce() + Send + 'scope) -> Result<()> {
    let started = thread::Builder::new().spawn_scoped(scope, work);
    started
        .map(drop)
        .context("a thread cannot be started; raise the limit of threads (ulimit -u), or give fewer (-j 1)")
}

/// Whether others can be matched where this happened.
fn is_of_the_pair(error: &anyhow::Error) -> bool {
    matches!(
        error.downcast_ref(),
        Some(Error::Image(_) | Error::TooLarge { .. } | Error::Memory { .. } | Error::OutOfMemory)
    )
}

/// What matches, and the pairs in it.
struct Flow {
    matcher: Matcher,
    names: (String, String, String),
    /// Of the first pair.
    size: (u32, u32),
    kind: Kind,
    /// Of the pairs in it.
    format: PixelFormat,
    waiting: VecDeque<(usize, Image)>,
}

enum Matcher {
    Streams(Box<Streams>),
    /// With the result of the pair that was pushed.
    Reference(Box<Params>, Option<Matched>),
}

/// A stream for each kind of samples, so that kernels are compiled once. The last one is in use.
struct Streams {
    opened: Opened,
    all: Vec<StereoStream>,
    params: Params,
    in_flight: usize,
    peak_bytes: u64,
}

impl Streams {
    fn current(&mut self) -> Result<&mut StereoStream> {
        self.all.last_mut().ok_or_else(|| anyhow!("there is no stream"))
    }

    /// Takes pairs that are as `left` is from now on. If it is `idle`, streams may be dropped for it.
    fn fit(&mut self, left: &Image, idle: bool) -> Result<()> {
        let mut turned = self.turn(left);
        if idle && matches!(turned, Err(Error::TooLarge { .. } | Error::Image(_))) {
            turned = self.renew(left); // a wide pair and a high one need less room one after the other
        }
        if idle && matches!(turned, Err(Error::OutOfMemory | Error::Memory { .. })) {
            self.all.clear();
            turned = self.renew(left);
        }
        self.opened.fault()?;
        turned?;
        self.peak_bytes = self.peak_bytes.max(self.all.iter().map(|stream| stream.matcher().device_bytes()).sum());
        Ok(())
    }

    /// By the stream for such samples.
    fn turn(&mut self, left: &Image) -> Result<(), Error> {
        let (width, height) = (left.width(), left.height());
        let Some(place) = self.all.iter().position(|stream| stream.matcher().format() == left.format()) else {
            return self.renew(left);
        };
        self.all[place..].rotate_left(1);
        match self.all.last_mut() {
            Some(stream) if stream.matcher().size() != (width, height) => stream.resize(width, height),
            _ => Ok(()),
        }
    }

    /// By a new stream in the place of that for such samples.
    fn renew(&mut self, left: &Image) -> Result<(), Error> {
        let (width, height, format) = (left.width(), left.height(), left.format());
        let Opened { device, queue, .. } = &self.opened;
        let matcher = StereoMatcher::new(device, queue, width, height, format, &self.params)?;
        let stream = StereoStream::new(matcher, self.in_flight)?;
        self.all.retain(|stream| stream.matcher().format() != format);
        self.all.push(stream);
        Ok(())
    }
}

impl Flow {
    /// For pairs that are as `left` is.
    fn open(setup: &Setup<'_>, left: &Image) -> Result<Self> {
        let engine = Engine::open(setup.device, false, left, setup.params)?;
        let names = engine.names();
        let params = setup.params.clone();
        let matcher = match engine {
            Engine::Reference => Matcher::Reference(Box::new(params), None),
            Engine::Adapter(on) => {
                let OnAdapter { opened, matcher } = *on;
                let stream = StereoStream::new(matcher, setup.in_flight);
                opened.fault()?;
                let stream = stream?;
                let peak_bytes = stream.matcher().device_bytes();
                let in_flight = setup.in_flight;
                Matcher::Streams(Box::new(Streams { opened, all: vec![stream], params, in_flight, peak_bytes }))
            }
        };
        let size = (left.width(), left.height());
        Ok(Self { matcher, names, size, kind: Kind::of(left), format: left.format(), waiting: VecDeque::new() })
    }

    /// Makes sure that a pair can be pushed, which must be as the first one unless they are mixed. Those in it have the
    /// same samples.
    fn fit(&mut self, setup: &Setup<'_>, left: &Image) -> Result<()> {
        let format = left.format();
        if !setup.mixed {
            self.kind.ensure(left)?;
        }
        match &mut self.matcher {
            Matcher::Streams(on) => on.fit(left, self.waiting.is_empty())?,
            Matcher::Reference(params, _) => run::ensure_reference(params, left)?,
        }
        self.format = format;
        Ok(())
    }

    fn in_flight(&self) -> usize {
        self.waiting.len()
    }

    fn capacity(&self) -> usize {
        match &self.matcher {
            Matcher::Streams(on) => on.in_flight,
            Matcher::Reference(..) => 1,
        }
    }

    fn device_bytes(&self) -> u64 {
        match &self.matcher {
            Matcher::Streams(on) => on.peak_bytes,
            Matcher::Reference(..) => 0,
        }
    }

    /// Begins with a pair that fits; there is room for it.
    fn push(&mut self, place: usize, left: Image, right: &Image) -> Result<()> {
        match &mut self.matcher {
            Matcher::Streams(on) => {
                let pushed = on.current()?.try_push(&left, right);
                on.opened.fault()?;
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
            Matcher::Streams(on) => {
                let frame = on.current()?.next_blocking();
                on.opened.fault()?;
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
    unit: &'static str,
    work: &'a dyn Work,
    bar: ProgressBar,
    lines: bool,
    start: Instant,
    counts: Mutex<Counts>,
}

struct Counts {
    ran: Ran,
    /// The kinds of doubts that were told: a whole video has the same one.
    kinds: HashSet<Option<Discriminant<Finding>>>,
    told: Instant,
}

impl Ran {
    /// All that is doubtful, as `--json` lists it.
    pub fn warnings(&self) -> Vec<String> {
        let of_pairs = self.doubtful.iter().map(|(_, text)| crate::one_line(text));
        warnings::all().into_iter().chain(of_pairs).collect()
    }

    /// The line of the summary on doubtful pairs; empty if there are none.
    pub fn doubts(&self, unit: &str) -> String {
        let pairs: HashSet<_> = self.doubtful.iter().map(|(place, _)| place).collect();
        match pairs.len() {
            0 => String::new(),
            pairs => format!("doubtful {pairs} {unit}: see the notes; --json lists them all\n"),
        }
    }
}

impl<'a> Tally<'a> {
    fn new(pairs: &'a [Pair], setup: &Setup<'_>, work: &'a dyn Work) -> Self {
        let quiet = setup.quiet;
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(pairs.len() as u64) };
        let style = ProgressStyle::with_template("{bar:24} {pos}/{len}  {msg}");
        let bar = bar.with_finish(ProgressFinish::AndClear).with_style(style.unwrap_or(ProgressStyle::default_bar()));
        let lines = bar.is_hidden() && !quiet;
        let start = Instant::now();
        Self {
            pairs,
            unit: setup.unit,
            work,
            bar,
            lines,
            start,
            counts: Mutex::new(Counts { ran: Ran::default(), kinds: HashSet::new(), told: start }),
        }
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
        let frame = Name::from(&self.pairs[place].left);
        let error = crate::one_line(&format!("{error:#}"));
        let mut counts = self.counts();
        self.bar.suspend(|| tell(&format!("failed: {}: {error}", name(&self.pairs[place].left))));
        if let Err(error) = self.work.failed(place, &error) {
            counts.ran.stopped.get_or_insert(error);
        }
        counts.ran.failed.push(Failure { place, frame, error });
        self.show(&mut counts);
    }

    fn doubt(&self, place: usize, doubt: Doubt) {
        let left = &self.pairs[place].left;
        let mut counts = self.counts();
        if counts.kinds.insert(doubt.kind) {
            self.bar.suspend(|| tell(&format!("note: {}: {}", name(left), doubt.text)));
        }
        counts.ran.doubtful.push((place, format!("{}: {}", left.to_string_lossy(), doubt.text)));
    }

    fn stop(&self, error: anyhow::Error) {
        self.counts().ran.stopped.get_or_insert(error);
    }

    /// Until all pairs before this one are written or failed.
    fn wait_for(&self, place: usize) {
        let is_behind = |ran: &Ran| ran.done + ran.failed.len() < place && ran.stopped.is_none();
        while is_behind(&self.counts().ran) {
            thread::sleep(Duration::from_millis(1));
        }
    }

    fn is_stopped(&self) -> bool {
        self.counts().ran.stopped.is_some()
    }

    fn show(&self, counts: &mut Counts) {
        let (position, all) = (counts.ran.done + counts.ran.failed.len(), self.pairs.len());
        let rate = position as f64 / self.start.elapsed().as_secs_f64().max(1e-9);
        let left = (all - position) as f64 / rate;
        let message = format!("{rate:.1} {} a second, {} left", self.unit, time(left));
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
        ran.doubtful.sort();
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
        tell("interrupted: finishing what was begun");
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
