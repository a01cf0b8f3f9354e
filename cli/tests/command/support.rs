//! What the tests of the command share: running it, judging what it says, and pairs to give it.
#![allow(dead_code, clippy::unwrap_used)]

use image::{GrayImage, Luma};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// The disparity of the pairs that [`pair`] makes.
pub const SHIFT: u32 = 5;

pub fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-stereo"));
    command.current_dir(folder).env("RUST_BACKTRACE", "1");
    command
}

pub fn run<A: AsRef<OsStr>>(folder: &Path, args: &[A]) -> Output {
    command(folder).args(args).output().unwrap()
}

/// Says what is not tested: past libtest's capture, which hides what a passing test prints.
pub fn not_tested(what: &str) {
    let _ = writeln!(std::io::stderr(), "NOT TESTED: {what}");
}

/// A folder of ../shared beside the checkout; where it is missing, says that `what` is not tested.
pub fn shared(folder: &str, what: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(folder).canonicalize().ok();
    if found.is_none() {
        not_tested(&format!("{what}, since there is no ../shared/{folder}"));
    }
    found
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[track_caller]
pub fn succeeds<A: AsRef<OsStr>>(folder: &Path, args: &[A]) -> Output {
    let output = run(folder, args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    output
}

/// Every file below a folder with its contents.
pub fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            all.extend(contents(&entry));
        } else {
            let bytes = if entry.is_file() { fs::read(&entry).unwrap() } else { Vec::new() };
            all.insert(entry, bytes);
        }
    }
    all
}

#[track_caller]
pub fn is_one_line_error(output: &Output, words: &[&str]) {
    let told = stderr(output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert_eq!(stdout(output), "");
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(told.starts_with("error: ") && told.ends_with('\n'), "{told}");
    assert!(!told.contains("panicked") && !told.contains("backtrace") && !told.contains("bug"), "{told}");
    for word in words {
        assert!(told.contains(word), "{word:?} is not in: {told}");
    }
}

/// The command says why not, in one line, and leaves the folder as it was.
#[track_caller]
pub fn refuses<A: AsRef<OsStr>>(folder: &Path, args: &[A], words: &[&str]) {
    let before = contents(folder);
    is_one_line_error(&run(folder, args), words);
    assert!(contents(folder) == before, "files were left behind or changed");
}

/// A texture without repetition.
pub fn texture(x: u32, y: u32) -> u8 {
    let mut hash = (x / 2).wrapping_mul(0x9e37_79b1) ^ (y / 2).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    (hash >> 13) as u8
}

/// A pair that is [`SHIFT`] apart.
pub fn pair(width: u32, height: u32) -> [GrayImage; 2] {
    [0, SHIFT].map(|shift| GrayImage::from_fn(width, height, |x, y| Luma([texture(x + shift, y)])))
}

/// A folder with such a pair, left.png and right.png.
pub fn scene() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (side, image) in ["left", "right"].into_iter().zip(pair(48, 30)) {
        image.save(folder.path().join(format!("{side}.png"))).unwrap();
    }
    folder
}

/// What `--json` names as adapter without one: the CPU with its instruction set.
pub fn cpu() -> String {
    let params = gpu_stereo::Params::sgm(1);
    let matcher = gpu_stereo::cpu::CpuMatcher::new(1, 1, gpu_stereo::PixelFormat::Gray8, &params).unwrap();
    format!("CPU with {}", matcher.instructions())
}

/// A run of two images of [`scene`] without an adapter.
pub fn on<'a>(left: &'a str, right: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[left, right, "--disp", "16", "--backend", "cpu"], more].concat()
}
