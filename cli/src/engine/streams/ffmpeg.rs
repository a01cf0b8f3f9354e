//! The `ffmpeg` on the PATH, which decodes and encodes videos.

use crate::terminal::one_line;
use anyhow::{Context as _, Result, bail};
use std::ffi::OsString;
use std::io::{BufReader, Read, Write as _};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::{self, JoinHandle};

/// What ffmpeg says is kept up to this length.
const MAX_TOLD: u64 = 1 << 16;

/// Whether there is an ffmpeg that can be started.
pub fn is_there() -> bool {
    let mut asked = Command::new("ffmpeg");
    asked.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

/// A running ffmpeg, which is stopped when this is dropped.
pub struct Ffmpeg {
    child: Child,
    stdin: Option<ChildStdin>,
    stdout: Option<ChildStdout>,
    told: Option<JoinHandle<String>>,
}

impl Ffmpeg {
    /// Starts it with these arguments, and with pipes where they are wanted.
    pub fn start<A: AsRef<std::ffi::OsStr>>(args: &[A], stdin: Stdio, stdout: Stdio) -> Result<Self> {
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error"]).args(args);
        command.stdin(stdin).stdout(stdout).stderr(Stdio::piped());
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt as _;
            command.process_group(0); // Ctrl-C is for this process, which ends it in order
        }
        let mut child = command.spawn().context("ffmpeg cannot be started")?;
        let Some(errors) = child.stderr.take() else { bail!("ffmpeg has no pipes") };
        let told = thread::Builder::new().spawn(move || told(errors));
        let told = told.context("a thread cannot be started; raise the limit of threads (ulimit -u)")?;
        Ok(Self { stdin: child.stdin.take(), stdout: child.stdout.take(), child, told: Some(told) })
    }

    /// Decodes the first video of a file into frames of PAM, each once.
    pub fn decode(path: &Path) -> Result<Self> {
        let mut file = OsString::from("file:"); // so that no name is taken for an option or a protocol
        file.push(path);
        let each_once = if is_before_5_1() { "-vsync" } else { "-fps_mode" };
        let from = ["-nostdin".into(), "-i".into(), file];
        let into =
            ["-map", "0:v:0", each_once, "passthrough", "-f", "image2pipe", "-c:v", "pam", "-"].map(OsString::from);
        Self::start(&[&from[..], &into].concat(), Stdio::null(), Stdio::piped())
    }

    /// What it writes.
    pub fn output(&mut self) -> Result<BufReader<ChildStdout>> {
        let stdout = self.stdout.take().context("ffmpeg has no pipe to read from")?;
        Ok(BufReader::with_capacity(1 << 20, stdout))
    }

    /// Gives it bytes; false if it takes no more, once it has ended and said why.
    pub fn take(&mut self, bytes: &[u8]) -> bool {
        let taken = self.stdin.as_mut().is_some_and(|stdin| stdin.write_all(bytes).is_ok());
        if !taken {
            self.stdin = None;
            let _ = self.child.wait();
        }
        taken
    }

    /// Waits for its end, or stops it. Returns whether it succeeded, how it ended, and what it said in one line.
    pub fn end(mut self, stop: bool) -> Result<(bool, String, String)> {
        if stop && self.child.try_wait()?.is_none() {
            self.child.kill()?;
        }
        self.stdin = None;
        self.stdout = None;
        let status = self.child.wait().context("ffmpeg cannot be waited for")?;
        let told = self.told.take().and_then(|told| told.join().ok()).unwrap_or_default();
        Ok((status.success(), status.to_string(), one_line(&told)))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// What ffmpeg says, as far as it is kept; the rest is read and dropped, so that it never waits.
fn told(mut errors: ChildStderr) -> String {
    let mut bytes = Vec::new();
    let _ = (&mut errors).take(MAX_TOLD).read_to_end(&mut bytes); // what was read by then
    let _ = std::io::copy(&mut errors, &mut std::io::sink());
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Whether its version is known to be one that has not yet `-fps_mode`.
fn is_before_5_1() -> bool {
    let Ok(told) = Command::new("ffmpeg").arg("-version").stdin(Stdio::null()).output() else { return false };
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let version = told.strip_prefix("ffmpeg version ").unwrap_or_default().trim_start_matches('n');
    let mut numbers = version.split(|c: char| !c.is_ascii_digit()).map(|number| number.parse::<u32>().ok());
    match (numbers.next().flatten(), numbers.next().flatten()) {
        (Some(major), Some(minor)) => (major, minor) < (5, 1),
        _ => false,
    }
}

/// Frames a second of the first video of a file, as `ffprobe` says.
pub fn rate(path: &Path) -> Option<f64> {
    let mut command = Command::new("ffprobe");
    command.args([
        "-v",
        "error",
        "-select_streams",
        "v:0",
        "-show_entries",
        "stream=avg_frame_rate",
        "-of",
        "csv=p=0",
        "-i",
    ]);
    let mut file = OsString::from("file:");
    file.push(path);
    let told = command.arg(file).stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    let told = String::from_utf8(told.stdout).ok()?;
    let (frames, seconds) = told.trim().trim_end_matches(',').split_once('/')?;
    let rate = frames.parse::<f64>().ok()? / seconds.parse::<f64>().ok()?;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}
