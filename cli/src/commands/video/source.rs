//! The source: where the frames come from, files or a stream.

use crate::args::{InputArgs, VideoArgs};
use crate::engine::images;
use crate::engine::pair::Pair;
use crate::engine::pairs;
use crate::engine::pipeline::{self, MatchedPair, Ran, Refused, Sequence, Setup, Work};
use crate::engine::streams::{Stream, is_record};
use anyhow::{Result, bail, ensure};
use gpu_stereo::files::calibration::Calibration;
use gpu_stereo::files::images::{ImagePair, is_video};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Where the frames come from.
pub enum Source {
    /// Files of one pair each, numbered from this number on.
    Files(u64, Vec<Pair>),
    /// A stream of frames.
    Stream(Box<Stream>),
}

impl Source {
    /// What the names on the command line mean.
    pub fn find(args: &VideoArgs) -> Result<Self> {
        let names = &args.sides[..];
        let stdin = names.iter().filter(|name| *name == Path::new("-")).count();
        let videos: Vec<_> = names.iter().filter(|name| is_video(name)).collect();
        ensure!(
            args.raw_frames.is_none() || (stdin == 1 && names.len() == 1),
            "--raw-frames says what the frames on stdin are, but the frames are not read from there; drop it, or give - alone"
        );
        let topics = [args.left.as_deref(), args.right.as_deref()];
        let records = names.iter().map(|name| is_record(name)).collect::<Result<Vec<_>>>()?;
        if let ([path], [true]) = (names, &records[..]) {
            return Ok(Self::Stream(Box::new(Stream::record(path, topics, &args.input)?)));
        }
        ensure!(
            !records.contains(&true) && topics == [None, None],
            "--left and --right are topics of one record, an .mcap file that is given alone; drop the other names, or the options"
        );
        let pairs = match names {
            [_] if stdin == 1 => return Ok(Self::Stream(Box::new(Stream::stdin(&args.input, args.raw_frames)?))),
            [_] | [_, _] if videos.len() == names.len() => {
                return Ok(Self::Stream(Box::new(Stream::videos(names, &args.input)?)));
            }
            [left, right] if stdin + videos.len() > 0 => bail!(
                "{left:?} and {right:?} are given, but a video or stdin goes with nothing of another kind; give two videos, one with \
                 --split, or - with --split"
            ),
            [left, right] => pairs::find(left, right)?,
            [both] => images::find_in_one(both, &args.input.of_many())?,
            more => bail!(
                "{} names were given, but LEFT and RIGHT are needed; put a glob in quotes, or the shell replaces it by names",
                more.len()
            ),
        };
        let first = pairs.first().map_or(0, |(number, _)| *number);
        Ok(Self::Files(first, pairs.into_iter().map(|(_, pair)| pair).collect()))
    }

    /// The options for all frames: the first pair that can be read decides. A stream looks for itself.
    pub fn as_first(&self, input: &InputArgs) -> InputArgs {
        match self {
            Self::Files(_, pairs) => images::as_first(&input.of_many(), &pairs[..pairs.len().min(images::FIRST)]),
            Self::Stream(_) => input.clone(),
        }
    }

    /// Shows the first pairs that can be read to `see`, until it has seen enough or `most` were looked at.
    pub fn look_ahead(
        &self,
        input: &InputArgs,
        most: usize,
        see: &mut dyn FnMut(&ImagePair) -> Result<bool>,
    ) -> Result<()> {
        let pairs = match self {
            Self::Files(_, pairs) => pairs,
            Self::Stream(stream) => return stream.look_ahead(most, see),
        };
        for pair in pairs.iter().take(most) {
            // What cannot be read is reported in its turn.
            if let Ok(pair) = images::read_pair(&pair.left, &pair.right, input)
                && see(&pair)?
            {
                break;
            }
        }
        Ok(())
    }

    /// The cameras, where a record says them.
    pub fn calibration(&self) -> Option<&Calibration> {
        if let Self::Stream(stream) = self { stream.calibration.as_ref() } else { None }
    }

    /// The number of the first frame.
    pub fn first(&self) -> u64 {
        if let Self::Files(first, _) = self { *first } else { 0 }
    }

    /// How many frames there are, if that is known.
    pub fn len(&self) -> Option<usize> {
        if let Self::Files(_, pairs) = self { Some(pairs.len()) } else { None }
    }

    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let (pairs, videos) = match self {
            Self::Files(_, pairs) => (&pairs[..], &[][..]),
            Self::Stream(stream) => (&[][..], &stream.files[..]),
        };
        pairs.iter().flat_map(|pair| [pair.left.as_path(), &pair.right]).chain(videos.iter().map(|file| file.as_path()))
    }

    /// Has all frames matched and written by `sink`.
    pub fn run(&self, setup: &Setup<'_>, stop: &AtomicBool, sink: &dyn Work) -> Ran {
        match self {
            Self::Files(_, pairs) => pipeline::run(Sequence::Files(pairs), setup, stop, sink),
            Self::Stream(stream) => {
                pipeline::run(Sequence::Stream(&stream.name), setup, stop, &Streamed { stream, sink })
            }
        }
    }
}

/// Frames of a stream that go where others go.
struct Streamed<'a> {
    stream: &'a Stream,
    sink: &'a dyn Work,
}

impl Work for Streamed<'_> {
    fn read(&self, _place: usize, _pair: &Pair, _options: &InputArgs) -> Result<ImagePair, Refused> {
        self.stream.next_pair().map(|(pair, _)| pair)
    }

    fn write(&self, pair: &MatchedPair) -> Result<(), Refused> {
        self.sink.write(pair)
    }

    fn failed(&self, place: usize, error: &str) -> Result<()> {
        self.sink.failed(place, error)
    }
}
