//! The film: left images beside their colour maps, as a video encoded by the `ffmpeg` on the PATH.

use crate::engine::pipeline::{MatchedPair, Refused, Work};
use crate::engine::{disk, images, places};
use crate::terminal::one_line;
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use gpu_stereo::files::encoders;
use gpu_stereo::files::encoders::ending;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use tempfile::TempPath;

/// A video to write, whole or not at all.
pub struct Film {
    path: PathBuf,
    place: PathBuf,
    fps: String,
    /// The disparities of the first and of the last colour, the same for all frames.
    range: (i32, i32),
    encoder: Mutex<Option<Encoder>>,
}

/// A running ffmpeg.
struct Encoder {
    child: Child,
    frames: ChildStdin,
    told: JoinHandle<String>,
    file: TempPath,
}

/// Whether a name is that of a video.
pub fn is_film(path: &Path) -> bool {
    ["mp4", "mkv", "webm"].contains(&ending(path).as_str())
}

impl Film {
    /// A video of `fps` frames a second, once it is sure that it can be written.
    pub fn new(path: &Path, fps: &str, range: (i32, i32)) -> Result<Self> {
        let place = places::writable_place(path)?;
        let asked = ffmpeg().arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        ensure!(
            asked.is_ok_and(|status| status.success()),
            "output {path:?} is a video, but no working ffmpeg is on the PATH; install ffmpeg, or give a folder"
        );
        Ok(Self { path: path.into(), place, fps: fps.into(), range, encoder: Mutex::new(None) })
    }

    /// Adds a frame. All have the size of the first one.
    fn add(&self, frame: &MatchedPair) -> Result<()> {
        let left = images::drawn(&*images::rectified(&frame.left, &frame.params, 0)?);
        let map = encoders::picture(&frame.matched.map, self.range);
        let row = 3 * map.width() as usize;
        let rows = left.as_raw().chunks_exact(row).zip(map.as_raw().chunks_exact(row));
        let pixels: Vec<u8> = rows.flat_map(|(left, map)| left.iter().chain(map)).copied().collect();
        let mut encoder = self.encoder.lock().unwrap_or_else(PoisonError::into_inner);
        let encoder = match &mut *encoder {
            Some(encoder) => encoder,
            none => none.insert(self.start(2 * map.width(), map.height())?),
        };
        if encoder.frames.write_all(&pixels).is_err() {
            // ffmpeg has ended; its stderr says why.
            let status = encoder.child.wait()?;
            bail!("ffmpeg ended before the last frame ({status})");
        }
        Ok(())
    }

    fn start(&self, width: u32, height: u32) -> Result<Encoder> {
        let folder = self.place.parent().unwrap_or(Path::new("/"));
        let file = disk::temporary(folder, &format!(".{}", ending(&self.path)))?.into_temp_path();
        let mut command = ffmpeg();
        command.args(["-hide_banner", "-loglevel", "error", "-y"]);
        command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", &format!("{width}x{height}"), "-r", &self.fps]);
        // Most players need yuv420p, which needs an even number of rows and columns.
        command.args(["-i", "-", "-an", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]);
        if ending(&self.path) == "webm" {
            command.args(["-crf", "30", "-b:v", "0"]); // or its encoder takes a very low rate
        }
        command.arg(&file).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt as _;
            command.process_group(0); // Ctrl-C is for this process, which ends it in order
        }
        let mut child = command.spawn().context("ffmpeg cannot be started")?;
        let (Some(frames), Some(mut errors)) = (child.stdin.take(), child.stderr.take()) else {
            bail!("ffmpeg has no pipes");
        };
        let told = thread::Builder::new().spawn(move || {
            let mut bytes = Vec::new();
            let _ = errors.read_to_end(&mut bytes); // what was read by then
            String::from_utf8_lossy(&bytes).into_owned()
        });
        let told = told.context("a thread cannot be started; raise the limit of threads (ulimit -u)")?;
        Ok(Encoder { child, frames, told, file })
    }

    /// Ends the video: names it if `whole`, else removes it. Without any frame there is no file.
    pub fn finish(self, whole: bool) -> Result<()> {
        let Some(encoder) = self.encoder.into_inner().unwrap_or_else(PoisonError::into_inner) else { return Ok(()) };
        let Encoder { mut child, frames, told, file } = encoder;
        if !whole && child.try_wait()?.is_none() {
            child.kill()?;
        }
        drop(frames);
        let status = child.wait().context("ffmpeg cannot be waited for")?;
        let told = told.join().map_err(|_| anyhow!("what ffmpeg said is lost"))?;
        let told = one_line(&told);
        if !whole {
            ensure!(told.is_empty(), "ffmpeg said: {told}");
            return Ok(());
        }
        ensure!(
            status.success(),
            "output {:?} cannot be written: ffmpeg failed ({status}): {}; try another ending, or give a folder",
            self.path,
            if told.is_empty() { "it does not say why" } else { &told }
        );
        let written = || -> std::io::Result<()> {
            disk::sync(&File::open(&file)?)?;
            file.persist(&self.place).map_err(|error| error.error)?;
            disk::sync_folder(self.place.parent().unwrap_or(Path::new("/")))
        };
        written().with_context(|| format!("output {:?} cannot be written", self.path))
    }
}

impl Work for Film {
    fn write(&self, frame: &MatchedPair) -> Result<(), Refused> {
        self.add(frame).map_err(Refused::All)
    }
}

fn ffmpeg() -> Command {
    Command::new("ffmpeg")
}
