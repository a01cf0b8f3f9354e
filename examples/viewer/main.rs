//! A window on the matcher: the pair, the live colour map, every setting, depth under the pointer, a cloud of points.
//!
//!     cargo run --release --example viewer [-- LEFT RIGHT] [--disp N]
//!
//! LEFT and RIGHT are two files, or two folders for a sequence; both may be dropped on the window as well. It shows how
//! a program with a device of its own takes the library in: live.rs is the part to read.

mod app;
mod files;
mod live;
mod panel;
mod points;
mod window;

use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "viewer [LEFT RIGHT] [--disp N] [--tab images|points] [--one-to-one] [--trace]

  LEFT RIGHT     two images, or two folders of images; without them the pair of data/motorcycle
  --disp N       disparities to search, 64 unless given
  --tab TAB      what is shown first
  --one-to-one   the map with a pixel of the screen for each pixel of it
  --trace        a line on stdout whenever something else is shown, and where it is: for tests";

/// What was asked for at the start.
pub(crate) struct Options {
    pub pair: Option<[PathBuf; 2]>,
    pub disparities: String,
    pub tab: app::Tab,
    pub one_to_one: bool,
    pub trace: bool,
}

fn options() -> Result<Option<Options>, String> {
    let data = [env!("CARGO_MANIFEST_DIR"), "data", "motorcycle"].iter().collect::<PathBuf>();
    let mut paths = Vec::new();
    let mut options =
        Options { pair: None, disparities: "64".into(), tab: app::Tab::Images, one_to_one: false, trace: false };
    let mut arguments = std::env::args_os().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().and_then(|value| value.into_string().ok()).unwrap_or_default();
        match argument.to_str() {
            Some("-h" | "--help") => return Ok(None),
            Some("--disp") => options.disparities = value(),
            Some("--tab") => {
                let name = value();
                options.tab = app::Tab::named(&name)
                    .ok_or_else(|| format!("--tab is {name:?}, but must be one of images, points"))?;
            }
            Some("--one-to-one") => options.one_to_one = true,
            Some("--trace") => options.trace = true,
            Some(other) if other.starts_with("--") => {
                return Err(format!("{other:?} is no option; see viewer --help"));
            }
            _ => paths.push(PathBuf::from(argument)),
        }
    }
    options.pair = match <[PathBuf; 2]>::try_from(paths) {
        Ok(pair) => Some(pair),
        Err(none) if none.is_empty() => {
            let pair = ["left.png", "right.png"].map(|name| data.join(name));
            pair.iter().all(|path| path.exists()).then_some(pair)
        }
        Err(other) => {
            return Err(format!("{} paths were given, but must be 2 or none; see viewer --help", other.len()));
        }
    };
    Ok(Some(options))
}

fn main() -> ExitCode {
    let run = match options() {
        Ok(None) => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        Ok(Some(options)) => window::run(options),
        Err(error) => Err(error),
    };
    match run {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
