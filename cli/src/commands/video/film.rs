//! The film: left images beside their colour maps, as a video encoded by the `ffmpeg` on the PATH.

use crate::engine::pipeline::{MatchedPair, Refused, Work};
use crate::engine::streams::ffmpeg::{self, Ffmpeg};
use crate::engine::{disk, images, places};
use anyhow::{Result, ensure};
use gpu_stereo::Colors;
use gpu_stereo::files::encoders;
use gpu_stereo::files::encoders::ending;
use std::ffi::OsString;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Mutex, PoisonError};
use tempfile::TempPath;

/// A video to write, whole or not at all.
pub struct Film {
    path: PathBuf,
    place: PathBuf,
    fps: String,
    /// The disparities of the first and of the last colour, the same for all frames.
    range: (i32, i32),
    colors: Colors,
    encoder: Mutex<Option<Encoder>>,
}

/// A running ffmpeg, and the file that it writes.
struct Encoder {
    ffmpeg: Ffmpeg,
    file: TempPath,
}

/// Whether a name is that of a video.
pub fn is_film(path: &Path) -> bool {
    ["mp4", "mkv", "webm"].contains(&ending(path).as_str())
}

impl Film {
    /// A video of `fps` frames a second, once it is sure that it can be written.
    pub fn new(path: &Path, fps: String, range: (i32, i32), colors: Colors) -> Result<Self> {
        let place = places::writable_place(path)?;
        ensure!(
            ffmpeg::is_there(),
            "output {path:?} is a video, but no working ffmpeg is on the PATH; install ffmpeg, or give a folder"
        );
        Ok(Self { path: path.into(), place, fps, range, colors, encoder: Mutex::new(None) })
    }

    /// Adds a frame. All have the size of the first one.
    fn add(&self, frame: &MatchedPair) -> Result<()> {
        let left = images::drawn(&*images::rectified(&frame.left, &frame.params, 0)?);
        let map = encoders::picture(&frame.matched.map, self.range, self.colors);
        let row = 3 * map.width() as usize;
        let rows = left.as_raw().chunks_exact(row).zip(map.as_raw().chunks_exact(row));
        let pixels: Vec<u8> = rows.flat_map(|(left, map)| left.iter().chain(map)).copied().collect();
        let mut encoder = self.encoder.lock().unwrap_or_else(PoisonError::into_inner);
        let encoder = match &mut *encoder {
            Some(encoder) => encoder,
            none => none.insert(self.start(2 * map.width(), map.height())?),
        };
        ensure!(encoder.ffmpeg.take(&pixels), "ffmpeg ended before the last frame"); // its stderr says why
        Ok(())
    }

    fn start(&self, width: u32, height: u32) -> Result<Encoder> {
        let folder = self.place.parent().unwrap_or(Path::new("/"));
        let file = disk::temporary(folder, &format!(".{}", ending(&self.path)))?.into_temp_path();
        let size = format!("{width}x{height}");
        let raw = ["-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", &size, "-r", &self.fps, "-i", "-", "-an"];
        // Most players need yuv420p, which needs an even number of rows and columns.
        let even = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"];
        // The encoder of WebM takes a very low rate by itself.
        let quality: &[&str] = if ending(&self.path) == "webm" { &["-crf", "30", "-b:v", "0"] } else { &[] };
        let mut args: Vec<_> = [&raw[..], &even, quality].concat().into_iter().map(OsString::from).collect();
        args.push(file.as_os_str().into());
        let ffmpeg = Ffmpeg::start(&args, Stdio::piped(), Stdio::null())?;
        Ok(Encoder { ffmpeg, file })
    }

    /// Ends the video: names it if `whole`, else removes it. Without any frame there is no file.
    pub fn finish(self, whole: bool) -> Result<()> {
        let Some(encoder) = self.encoder.into_inner().unwrap_or_else(PoisonError::into_inner) else { return Ok(()) };
        let Encoder { ffmpeg, file } = encoder;
        let (succeeded, status, told) = ffmpeg.end(!whole)?;
        if !whole {
            ensure!(told.is_empty(), "ffmpeg said: {told}");
            return Ok(());
        }
        ensure!(
            succeeded,
            "output {:?} cannot be written: ffmpeg failed ({status}): {}; try another ending, or give a folder",
            self.path,
            if told.is_empty() { "it does not say why" } else { &told }
        );
        let published = File::open(&file).and_then(|contents| disk::publish(&contents, file, &self.place));
        published.map_err(|error| disk::unwritten(error, format_args!("output {:?}", self.path)))
    }
}

impl Work for Film {
    fn write(&self, frame: &MatchedPair) -> Result<(), Refused> {
        self.add(frame).map_err(Refused::All)
    }
}
