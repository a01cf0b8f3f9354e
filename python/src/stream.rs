//! Pair after pair, several of them in flight.

use crate::errors::{raised, wrong};
use crate::images::GivenPair;
use crate::matched::PyMatched;
use crate::matcher::{Computed, Matcher, format};
use crate::settings::Request;
use crate::work::Maker;
use gpu_stereo::files::images::Bits;
use gpu_stereo::{Error, Image, PixelFormat, StereoStream};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};
use std::sync::{Arc, Mutex, mpsc};
use std::thread;

/// An iterator of :class:`Matched` over pairs, see :func:`stream`.
#[pyclass(name = "Stream", module = "gpu_stereo", frozen)]
pub struct PyStream(Mutex<Running>);

/// A stream that is under way.
struct Running {
    pairs: Py<PyIterator>,
    source: Source,
    capacity: usize,
    /// The bits of all pairs, once the first one is there.
    bits: Option<Bits>,
    flow: Option<(PixelFormat, Flow)>,
    in_flight: usize,
    maker: Maker,
    /// Whether no more pairs come, and the exception that ended them.
    ended: Option<Option<PyErr>>,
}

/// What the pairs are matched with.
enum Source {
    /// A matcher.
    Matcher(Arc<Matcher>),
    /// One that is made for the first pair.
    Request(Option<Box<Request>>),
}

/// Pairs in flight.
enum Flow {
    /// On the adapter.
    Adapter(Box<StereoStream>),
    /// On another thread, one after the other.
    Thread { pairs: mpsc::Sender<(Image, Image)>, results: Mutex<mpsc::Receiver<Computed>> },
}

/// The most pairs in flight.
const MOST: i64 = 16;

impl PyStream {
    /// With a matcher.
    pub fn of_matcher(matcher: Arc<Matcher>, pairs: &Bound<'_, PyAny>, in_flight: i64) -> PyResult<Self> {
        Self::new(Source::Matcher(matcher), pairs, in_flight)
    }

    fn new(source: Source, pairs: &Bound<'_, PyAny>, in_flight: i64) -> PyResult<Self> {
        let capacity = usize::try_from(in_flight).ok().filter(|_| (1..=MOST).contains(&in_flight));
        let capacity = capacity.ok_or_else(|| {
            wrong(format!("in_flight is {in_flight}, but must be from 1 to {MOST}; 3 keep a device busy"))
        })?;
        let pairs = pairs.try_iter()?.unbind();
        Ok(Self(Mutex::new(Running {
            pairs,
            source,
            capacity,
            bits: None,
            flow: None,
            in_flight: 0,
            maker: Maker::here(),
            ended: None,
        })))
    }
}

#[pymethods]
impl PyStream {
    fn __iter__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PyMatched>> {
        let Ok(mut running) = self.0.try_lock() else {
            return Err(wrong("the stream is in use by another thread; give each thread one of its own"));
        };
        running.maker.ensure_here("the stream")?;
        running.next(py)
    }
}

impl Running {
    /// The next result; nothing after the last one.
    fn next(&mut self, py: Python<'_>) -> PyResult<Option<PyMatched>> {
        while self.ended.is_none() && self.in_flight < self.capacity {
            let pair = self.pairs.bind(py).clone().next();
            match pair.map(|pair| pair.and_then(|pair| self.push(py, &pair))) {
                Some(Ok(())) => self.in_flight += 1,
                Some(Err(error)) => self.ended = Some(Some(error)),
                None => self.ended = Some(None),
            }
        }
        if self.in_flight == 0 {
            return match self.ended.as_mut().and_then(Option::take) {
                Some(error) => Err(error),
                None => Ok(None),
            };
        }
        self.in_flight -= 1;
        let result = self.take(py);
        if result.is_err() {
            (self.in_flight, self.flow) = (0, None);
            self.ended = Some(None);
        }
        result.map(Some)
    }

    /// Begins to match a pair.
    fn push(&mut self, py: Python<'_>, pair: &Bound<'_, PyAny>) -> PyResult<()> {
        let images = || pair.try_iter().and_then(|images| images.take(3).collect::<PyResult<Vec<_>>>());
        let Ok([left, right]) = images().and_then(|images| <[_; 2]>::try_from(images).map_err(|_| wrong(""))) else {
            let kind = pair.get_type().name()?;
            return Err(wrong(format!("a pair is of the type {kind}, but must be two images: (left, right)")));
        };
        let given = GivenPair::new(&left, &right)?;
        let matcher = self.matcher(py, &given)?;
        let (left, right, bits) = matcher.images(&given, self.bits.unwrap_or(matcher.request.bits))?;
        if matcher.request.bits == Bits::Auto {
            self.bits.get_or_insert(Bits::OfFirst(bits));
        }
        let format = left.format();
        if self.flow.as_ref().is_some_and(|(of, _)| *of != format) {
            return Err(wrong(format!(
                "a pair has samples of the kind {format:?}, but those before have {:?}; convert all to one kind",
                self.flow.as_ref().map(|(of, _)| of)
            )));
        }
        if self.flow.is_none() {
            let stream = py.detach(|| matcher.stream(format, self.capacity)).map_err(raised)?;
            let flow = match stream {
                Some(stream) => Flow::Adapter(Box::new(stream)),
                None => Flow::on_thread(Arc::clone(&matcher)),
            };
            self.flow = Some((format, flow));
        }
        match &mut self.flow {
            Some((_, flow)) => py.detach(|| flow.push(&matcher, left, right)).map_err(raised),
            None => Err(raised(ended())),
        }
    }

    /// The matcher, which is made for the first pair if there is none yet.
    fn matcher(&mut self, py: Python<'_>, given: &GivenPair<'_>) -> PyResult<Arc<Matcher>> {
        match &mut self.source {
            Source::Matcher(matcher) => Ok(Arc::clone(matcher)),
            Source::Request(request) => {
                let Some(request) = request.take() else { return Err(wrong("the stream has ended")) };
                let matcher = Arc::new(Matcher::new(py, *request, given.size(), format(given))?);
                self.source = Source::Matcher(Arc::clone(&matcher));
                Ok(matcher)
            }
        }
    }

    /// The result of the pair that has been in flight for longest.
    fn take(&mut self, py: Python<'_>) -> PyResult<PyMatched> {
        let (Some((_, flow)), Source::Matcher(matcher)) = (&mut self.flow, &self.source) else {
            return Err(wrong("the stream has ended"));
        };
        py.detach(|| flow.take(matcher)).map_err(raised)
    }
}

impl Flow {
    /// Another thread computes.
    fn on_thread(matcher: Arc<Matcher>) -> Self {
        let (pairs, given) = mpsc::channel::<(Image, Image)>();
        let (found, results) = mpsc::channel();
        thread::spawn(move || {
            for (left, right) in given {
                if found.send(matcher.compute(&left, &right)).is_err() {
                    break; // nobody waits any more
                }
            }
        });
        Self::Thread { pairs, results: Mutex::new(results) }
    }

    fn push(&mut self, matcher: &Matcher, left: Image, right: Image) -> Result<(), Error> {
        match self {
            Self::Adapter(stream) => {
                let (left, right) = matcher.prepared(&left, &right)?;
                let pushed = stream.try_push(&left, &right);
                matcher.fault()?;
                pushed?.map(drop).ok_or_else(|| Error::Misuse("the stream is full before its time".into()))
            }
            Self::Thread { pairs, .. } => pairs.send((left, right)).map_err(|_| ended()),
        }
    }

    fn take(&mut self, matcher: &Matcher) -> Computed {
        match self {
            Self::Adapter(stream) => {
                let frame = stream.next_blocking();
                matcher.fault()?;
                let maps = frame.ok_or_else(ended)?.result?;
                Ok(PyMatched::new(matcher.before.upright(maps), &matcher.params, None))
            }
            Self::Thread { results, .. } => results.get_mut().map_err(|_| ended())?.recv().map_err(|_| ended())?,
        }
    }
}

fn ended() -> Error {
    Error::Lost("the stream gave no result".into())
}

/// Matches pair after pair of one size, several of them in flight: while one is computed, the next one is fetched.
///
/// Args:
///     pairs: an iterable of ``(left, right)``, images as :meth:`StereoMatcher.compute` takes them.
///     disparities, preset, device, **options: as of :class:`StereoMatcher`, which is made for the first pair's size.
///     in_flight: pairs in flight at most, from 1 to 16.
///
/// Returns:
///     An iterator of :class:`Matched` in the order of the pairs.
///
/// >>> import gpu_stereo, numpy
/// >>> pairs = numpy.random.default_rng(0).integers(0, 256, (3, 2, 40, 60), dtype="uint8")
/// >>> for matched in gpu_stereo.stream(pairs, disparities=16, device="cpu"):
/// ...     print(matched.shape)
/// (40, 60)
/// (40, 60)
/// (40, 60)
#[pyfunction]
#[pyo3(signature = (pairs, disparities=None, preset=None, device=None, in_flight=3, **options))]
pub fn stream(
    py: Python<'_>,
    pairs: &Bound<'_, PyAny>,
    disparities: Option<&Bound<'_, PyAny>>,
    preset: Option<&str>,
    device: Option<&Bound<'_, PyAny>>,
    in_flight: i64,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyStream> {
    let request = Request::new(py, disparities, preset, device, options)?;
    PyStream::new(Source::Request(Some(Box::new(request))), pairs, in_flight)
}
