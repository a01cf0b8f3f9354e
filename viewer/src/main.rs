//! A window on the matcher: the pair, the live colour map, every setting, depth under the pointer, a cloud of points.
//!
//!     cargo run --release -p gpu-stereo-viewer [-- LEFT RIGHT] [--disp N]
//!
//! LEFT and RIGHT are two files, or two folders for a sequence; both may be dropped on the window as well. It shows how
//! a program with a device of its own takes the library in: live.rs is the part to read.

mod app;
mod files;
mod live;
mod options;
mod panel;
mod points;
mod textures;
mod window;

use std::process::ExitCode;

const USAGE: &str = "gpu-stereo-viewer [LEFT RIGHT] [--disp N] [--tab images|points] [--one-to-one] [--trace]

  LEFT RIGHT     two images, or two folders of images; without them the pair of data/motorcycle
  --disp N       disparities to search, 64 unless given
  --tab TAB      what is shown first
  --one-to-one   the map with a pixel of the screen for each pixel of it
  --trace        a line on stdout whenever something else is shown, and where it is: for tests";

fn main() -> ExitCode {
    let run = match options::parse() {
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
