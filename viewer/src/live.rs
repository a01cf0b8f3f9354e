//! The matcher behind the window: what is wanted becomes what is shown, and the window never waits for it.
//!
//! Files are read and kernels compiled on a thread; the frame itself is recorded, submitted and read back here.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::Instant;

use gpu_stereo::{Error, Inputs, Matched, Outputs, Params, Reading, StereoMatcher, wgpu};

use crate::files::{self, Pair, Paths};
use crate::textures::Textures;

/// What is to be matched.
#[derive(Clone, PartialEq)]
pub struct Wanted {
    pub paths: Paths,
    pub params: Params,
}

/// The last map.
pub struct Shown {
    pub wanted: Wanted,
    pub pair: Arc<Pair>,
    pub matched: Matched,
    /// Milliseconds from the upload until the map was read back.
    pub frame_ms: f64,
    /// Milliseconds that the matcher took to take on its settings: the compilation of kernels that were new.
    pub prepare_ms: f64,
}

/// What the thread makes.
struct Prepared {
    matcher: Option<StereoMatcher>,
    pair: Result<Arc<Pair>, String>,
    ms: f64,
}

/// A frame that the device has been given.
struct Frame {
    matcher: StereoMatcher,
    reading: Reading,
    pair: Arc<Pair>,
    /// Where the frame goes, if not into those textures that are shown.
    textures: Option<Textures>,
    since: Instant,
    prepare_ms: f64,
}

#[allow(clippy::large_enum_variant)] // there is one of it
enum State {
    Idle(Option<StereoMatcher>),
    Preparing(Receiver<Prepared>),
    Computing(Frame),
}

pub struct Live {
    device: wgpu::Device,
    queue: wgpu::Queue,
    state: State,
    asked: Option<Wanted>,
    pub shown: Option<Shown>,
    pub textures: Option<Textures>,
    /// Why what was asked for last is not shown.
    pub error: Option<String>,
    /// Counts the changes of what is shown.
    pub changes: u64,
}

impl Live {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            state: State::Idle(None),
            asked: None,
            shown: None,
            textures: None,
            error: None,
            changes: 0,
        }
    }

    /// Whether something is under way, so that [`Live::advance`] should be called soon.
    pub fn doing(&self) -> Option<&'static str> {
        match self.state {
            State::Idle(_) => None,
            State::Preparing(_) => Some("preparing"),
            State::Computing(_) => Some("computing"),
        }
    }

    /// Goes as far towards `wanted` as it can without waiting. Whether there is something new to show.
    pub fn advance(&mut self, wanted: Option<&Wanted>) -> bool {
        let changes = self.changes;
        self.state = match std::mem::replace(&mut self.state, State::Idle(None)) {
            State::Idle(matcher) => match wanted {
                Some(wanted) if self.asked.as_ref() != Some(wanted) => self.prepare(matcher, wanted.clone()),
                _ => State::Idle(matcher),
            },
            State::Preparing(prepared) => match prepared.try_recv() {
                Ok(Prepared { matcher, pair: Err(error), .. }) => self.failed(matcher, error),
                Ok(Prepared { matcher: None, .. }) => self.failed(None, "no matcher was made".into()),
                Ok(Prepared { matcher: Some(matcher), pair: Ok(pair), ms }) => self.submit(matcher, pair, ms),
                Err(TryRecvError::Empty) => State::Preparing(prepared),
                Err(TryRecvError::Disconnected) => self.failed(None, "the thread that reads files ended".into()),
            },
            State::Computing(mut frame) => match frame.reading.try_take() {
                None => State::Computing(frame),
                Some(Err(error)) => self.failed(Some(frame.matcher), error.to_string()),
                Some(Ok(matched)) => {
                    let Frame { matcher, pair, textures, since, prepare_ms, .. } = frame;
                    let frame_ms = since.elapsed().as_secs_f64() * 1e3;
                    self.shown = self.asked.clone().map(|wanted| Shown { wanted, pair, matched, frame_ms, prepare_ms });
                    self.textures = textures.or(self.textures.take());
                    self.error = None;
                    self.changes += 1;
                    State::Idle(Some(matcher))
                }
            },
        };
        self.changes != changes
    }

    fn failed(&mut self, matcher: Option<StereoMatcher>, error: String) -> State {
        eprintln!("error: {error}");
        self.error = Some(error);
        self.changes += 1;
        State::Idle(matcher)
    }

    /// Reads the files if they are others, and brings the matcher to their size and to the settings, on a thread.
    fn prepare(&mut self, matcher: Option<StereoMatcher>, wanted: Wanted) -> State {
        let (device, queue) = (self.device.clone(), self.queue.clone());
        let known =
            self.shown.as_ref().filter(|shown| shown.wanted.paths == wanted.paths).map(|shown| shown.pair.clone());
        self.asked = Some(wanted.clone());
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            let pair = known.map_or_else(|| files::read(&wanted.paths).map(Arc::new), Ok);
            let since = Instant::now();
            let mut matcher = matcher;
            let pair = pair.and_then(|pair| {
                fit(&mut matcher, &device, &queue, &pair, &wanted.params).map_err(|error| error.to_string())?;
                Ok(pair)
            });
            // The receiver is gone only when the window is.
            let _ = sender.send(Prepared { matcher, pair, ms: since.elapsed().as_secs_f64() * 1e3 });
        });
        State::Preparing(receiver)
    }

    /// Uploads the pair, and submits its frame and the copy that is read back.
    fn submit(&mut self, matcher: StereoMatcher, pair: Arc<Pair>, prepare_ms: f64) -> State {
        let since = Instant::now();
        match self.record(&matcher, &pair) {
            Err(error) => self.failed(Some(matcher), error.to_string()),
            Ok(textures) => {
                let reading = matcher.read();
                State::Computing(Frame { matcher, reading, pair, textures, since, prepare_ms })
            }
        }
    }

    /// Gives back new textures where those that are shown have another size.
    fn record(&self, matcher: &StereoMatcher, pair: &Pair) -> Result<Option<Textures>, Error> {
        let (width, height) = (pair.left.width(), pair.left.height());
        let known = self.textures.as_ref().filter(|textures| textures.size == (width, height));
        let new = known.is_none().then(|| Textures::new(&self.device, width, height)).transpose()?;
        let Some(textures) = known.or(new.as_ref()) else { return Ok(None) };
        for (view, pixels) in [(&textures.left, &pair.shown[0]), (&textures.right, &pair.shown[1])] {
            let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * width), ..Default::default() };
            self.queue.write_texture(view.texture().as_image_copy(), pixels, layout, view.texture().size());
        }
        matcher.upload(&pair.left, &pair.right)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let outputs = Outputs::default().color(textures.colours.texture()).disparity(textures.disparity.texture());
        matcher.record(&mut encoder, &Inputs::Uploaded, &outputs)?;
        self.queue.submit([encoder.finish()]);
        Ok(new)
    }
}

/// Makes the matcher fit a pair and settings; what it has compiled before stays with it.
fn fit(
    matcher: &mut Option<StereoMatcher>,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    pair: &Pair,
    params: &Params,
) -> Result<(), Error> {
    let (width, height, format) = (pair.left.width(), pair.left.height(), pair.left.format());
    match matcher {
        Some(matcher) if matcher.format() == format => {
            if matcher.size() != [width, height] {
                matcher.resize(width, height)?;
            }
            if matcher.params() != params {
                matcher.set_params(params)?;
            }
        }
        _ => *matcher = Some(StereoMatcher::new(device, queue, width, height, format, params)?),
    }
    Ok(())
}
