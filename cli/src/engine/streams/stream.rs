//! Streams: pair after pair from videos, which ffmpeg decodes, from frames on stdin, or from a record.

use super::ffmpeg::{self, Ffmpeg};
use super::record::{Record, Taken};
use crate::args::InputArgs;
use crate::engine::pipeline::Refused;
use crate::terminal::{name, warnings};
use anyhow::{Error, Result, anyhow, bail, ensure};
use gpu_stereo::files::calibration::Calibration;
use gpu_stereo::files::frames::{FrameReader, RawFrames};
use gpu_stereo::files::images::{Bits, ImagePair, Split, split_frame};
use image::DynamicImage;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Pairs of frames, one after the other.
pub struct Stream {
    /// What it is called: the file that was named first, or `stdin`.
    pub name: PathBuf,
    /// The files that are read.
    pub files: Vec<PathBuf>,
    /// Frames a second, if they are known.
    pub rate: Option<f64>,
    /// The cameras, where a record says them.
    pub calibration: Option<Calibration>,
    input: InputArgs,
    state: Mutex<State>,
}

struct State {
    sides: Sides,
    /// Once a pair was read.
    bits: Option<u32>,
    ended: bool,
    /// Pairs that were looked at before it was their turn.
    ahead: VecDeque<Result<NextPair, Refused>>,
}

/// A pair, of a record with when it was taken.
type NextPair = (ImagePair, Option<Taken>);

enum Sides {
    /// Each frame shows both views.
    Both(Frames, Split),
    Two(Box<[Frames; 2]>),
    Record(Box<Record>),
}

/// Why there are no views.
enum Missing {
    /// The stream has ended.
    End,
    /// This pair cannot be read; the next one may.
    Pair(Error),
    /// Nor can those that follow.
    Rest(Error),
}

impl From<Error> for Missing {
    fn from(error: Error) -> Self {
        Self::Rest(error)
    }
}

/// The frames of one source.
struct Frames {
    name: PathBuf,
    reader: FrameReader<Box<dyn BufRead + Send>>,
    decoder: Option<Ffmpeg>,
}

impl Stream {
    /// Begins to read frames from stdin, each of which shows both views.
    pub fn stdin(input: &InputArgs, raw: Option<RawFrames>) -> Result<Self> {
        let split = split_of(input, "-")?;
        let source: Box<dyn BufRead + Send> = Box::new(BufReader::with_capacity(1 << 20, std::io::stdin()));
        let reader = FrameReader::open(source, raw).map_err(|error| anyhow!("stdin: {error}"))?;
        let (name, rate) = (PathBuf::from("stdin"), reader.rate());
        let frames = Frames { name: name.clone(), reader, decoder: None };
        Ok(Self::new(name, Vec::new(), rate, input, Sides::Both(frames, split)))
    }

    /// Begins to decode a video of both views, or two of one view each.
    pub fn videos(files: &[PathBuf], input: &InputArgs) -> Result<Self> {
        ensure!(
            ffmpeg::is_there(),
            "{:?} is a video, but no working ffmpeg is on the PATH; install ffmpeg, or give folders of images",
            files.first().map(PathBuf::as_path).unwrap_or(Path::new(""))
        );
        let sides = match files {
            [both] => Sides::Both(Frames::decode(both)?, split_of(input, &format!("{:?}", name(both)))?),
            [left, right] => {
                ensure!(
                    input.split.is_none(),
                    "--split is for one video that shows both views, but {left:?} and {right:?} are two; drop it"
                );
                Sides::Two(Box::new([Frames::decode(left)?, Frames::decode(right)?]))
            }
            more => bail!("{} videos were given, but one or two are needed", more.len()),
        };
        let rates: Vec<_> = files.iter().filter_map(|file| ffmpeg::rate(file)).collect();
        if let [left, right] = rates[..]
            && (left - right).abs() > 1e-3 * left
        {
            warnings::warn(&format!(
                "the left video has {left:.3} frames a second and the right one {right:.3}: frames are paired by their number"
            ));
        }
        Ok(Self::new(files[0].clone(), files.to_vec(), rates.first().copied(), input, sides))
    }

    /// Looks through a record for the pairs of two topics.
    pub fn record(path: &Path, topics: [Option<&str>; 2], input: &InputArgs) -> Result<Self> {
        ensure!(
            input.split.is_none(),
            "--split is for frames that show both views, but those of a record are of two topics; drop it"
        );
        let mut record = Record::open(path, topics)?;
        let calibration = record.calibration.take();
        let found = Self::new(path.into(), vec![path.into()], None, input, Sides::Record(Box::new(record)));
        Ok(Self { calibration, ..found })
    }

    fn new(name: PathBuf, files: Vec<PathBuf>, rate: Option<f64>, input: &InputArgs, sides: Sides) -> Self {
        let state = Mutex::new(State { sides, bits: None, ended: false, ahead: VecDeque::new() });
        Self { name, files, rate, calibration: None, input: input.clone(), state }
    }

    /// The next pair. A frame that is damaged is the last one.
    pub fn next_pair(&self) -> Result<NextPair, Refused> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match state.ahead.pop_front() {
            Some(read) => read,
            None => self.read(&mut state),
        }
    }

    /// Shows the next pairs that can be read to `see`, until it has seen enough or `most` were looked at. They are still the next ones.
    pub fn look_ahead(&self, most: usize, see: &mut dyn FnMut(&ImagePair) -> Result<bool>) -> Result<()> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        while state.ahead.len() < most && !state.ended {
            let read = match self.read(&mut state) {
                Err(Refused::All(error)) => return Err(error),
                Err(Refused::End) => break,
                read => read,
            };
            let seen = read.as_ref().map_or(Ok(false), |(pair, _)| see(pair));
            state.ahead.push_back(read);
            if seen? {
                break;
            }
        }
        Ok(())
    }

    fn read(&self, state: &mut State) -> Result<NextPair, Refused> {
        if state.ended {
            return Err(Refused::End);
        }
        let is_first = state.bits.is_none();
        let (images, taken) = match state.sides.next_views() {
            Ok(read) => read,
            Err(Missing::Pair(error)) if !is_first => return Err(Refused::Pair(error)),
            Err(missing) => {
                state.ended = true;
                return Err(match missing {
                    Missing::End if is_first => Refused::All(self.empty()),
                    Missing::End => Refused::End,
                    Missing::Pair(error) | Missing::Rest(error) if is_first => Refused::All(error),
                    Missing::Pair(error) | Missing::Rest(error) => Refused::Pair(error),
                });
            }
        };
        let images = if self.input.swap {
            let [left, right] = images;
            [right, left]
        } else {
            images
        };
        let bits = match (self.input.bits, state.bits) {
            (Bits::Auto, Some(bits)) => Bits::OfFirst(bits),
            (given, _) => given,
        };
        let pair = ImagePair::of(images, state.sides.names(), bits).map_err(|error| Refused::Pair(error.into()))?;
        state.bits = Some(pair.bits);
        Ok((pair, taken))
    }

    /// Whether it is a record.
    pub fn is_record(&self) -> bool {
        matches!(self.state.lock().unwrap_or_else(PoisonError::into_inner).sides, Sides::Record(_))
    }

    fn empty(&self) -> Error {
        anyhow!("{} has no frame; give a video that has one", name(&self.name))
    }
}

impl Sides {
    fn names(&self) -> [&Path; 2] {
        match self {
            Self::Record(record) => [record.path(); 2],
            Self::Both(frames, _) => [&frames.name; 2],
            Self::Two(sides) => sides.each_ref().map(|side| side.name.as_path()),
        }
    }

    /// The views of the next pair, and of a record when they were taken.
    fn next_views(&mut self) -> Result<([DynamicImage; 2], Option<Taken>), Missing> {
        let views = match self {
            Self::Record(record) => {
                let (images, taken) = record.next_pair()?.ok_or(Missing::End)?;
                return Ok((images.map_err(Missing::Pair)?, Some(taken)));
            }
            Self::Both(frames, split) => {
                let frame = frames.next_frame()?.ok_or(Missing::End)?;
                let what = format!("a frame of {}", name(&frames.name));
                split_frame(&frame, *split, &what).map_err(Error::from)?
            }
            Self::Two(sides) => {
                let [left, right] = &mut **sides;
                match (left.next_frame()?, right.next_frame()?) {
                    (Some(left), Some(right)) => [left, right],
                    (None, None) => return Err(Missing::End),
                    (one, _) => {
                        let (short, long) = if one.is_none() { (left, right) } else { (right, left) };
                        warnings::warn(&format!(
                            "{} has fewer frames than {}, whose others have no partner and are skipped",
                            name(&short.name),
                            name(&long.name)
                        ));
                        return Err(Missing::End);
                    }
                }
            }
        };
        Ok((views, None))
    }
}

impl Frames {
    fn decode(path: &Path) -> Result<Self> {
        let mut decoder = Ffmpeg::decode(path)?;
        let output: Box<dyn BufRead + Send> = Box::new(decoder.output()?);
        match FrameReader::open(output, None) {
            Ok(reader) => Ok(Self { name: path.into(), reader, decoder: Some(decoder) }),
            Err(error) => {
                let (_, status, told) = decoder.end(false)?;
                let told = if told.is_empty() { error.to_string() } else { told };
                bail!(
                    "{path:?} cannot be decoded: ffmpeg ended ({status}): {told}; give a video that ffmpeg can decode"
                )
            }
        }
    }

    /// The next frame; at the end also what ffmpeg had to say.
    fn next_frame(&mut self) -> Result<Option<DynamicImage>> {
        let read = self.reader.next_frame();
        if let Ok(Some(frame)) = read {
            return Ok(Some(frame));
        }
        let Some(decoder) = self.decoder.take() else {
            return Ok(read?);
        };
        let (succeeded, status, told) = decoder.end(false)?;
        ensure!(
            succeeded,
            "{} cannot be decoded to its end: ffmpeg failed ({status}): {}",
            name(&self.name),
            if told.is_empty() { "it does not say why" } else { &told }
        );
        if !told.is_empty() {
            warnings::warn(&format!("ffmpeg says of {}: {told}", name(&self.name)));
        }
        Ok(read?)
    }
}

/// How frames show both views, which no stream says by itself.
fn split_of(input: &InputArgs, source: &str) -> Result<Split> {
    match input.split {
        Some(split @ Split::Both { .. }) => Ok(split),
        _ => bail!(
            "{source} is given alone, but how its frames show both views is not said; give --split sbs (the left view in the left \
             half), sbs-swapped, tb or interlaced, or two videos"
        ),
    }
}
