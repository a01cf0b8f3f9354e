//! The kernels of many settings, made on the first adapter and told in the order in which its driver compiled them, for what
//! benches/compilers.py makes of the driver's figures: `cargo bench --bench compilers -- [OPTIONS]`.
//!
//!     --settings NAME,..     presets, and sgm8, bm, bp; default all
//!     --disparities N,..     default 64,128,256,600
//!     --size WxH             default 741x500
//!     --schedule NAME        default auto: per-subgroup on a GPU
//!
//! On stderr, among what the driver prints: `== begin SETTING N` before the kernels are compiled, then `== kernel NAME` for each in the same
//! order, and `== end`; or `== refused SETTING N: WHY`. Nothing is computed.
#![allow(missing_docs, clippy::unwrap_used)]

use gpu_stereo::{Params, PixelFormat, StereoMatcher};

#[path = "../tests/support/mod.rs"]
mod support;

/// What is compiled unless told otherwise.
const SETTINGS: &str = "classic,balanced,strict,dense,sgm8,bm,bp";

fn params(setting: &str, disparities: u32, schedule: &str) -> Params {
    let options: &[(&str, &str)] = match setting {
        "sgm8" => &[("preset", "classic"), ("paths", "8")],
        "bm" | "bp" => &[("preset", "classic"), ("method", setting)],
        preset => &[("preset", preset)],
    };
    let schedule = [("schedule", schedule)];
    let options = options.iter().chain(&schedule).copied();
    Params::from_options(disparities, options).unwrap_or_else(|error| panic!("{setting}, {disparities}: {error}"))
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (mut settings, mut disparities) = (SETTINGS.to_string(), "64,128,256,600".to_string());
    let (mut size, mut schedule) = ("741x500".to_string(), "auto".to_string());
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} needs a value"));
        match argument.as_str() {
            "--bench" => (), // cargo's own
            "--settings" => settings = value(),
            "--disparities" => disparities = value(),
            "--size" => size = value(),
            "--schedule" => schedule = value(),
            _ => panic!("{argument} is unknown; the head of benches/compilers.rs lists the options"),
        }
    }
    let (width, height) = size.split_once('x').unwrap();
    let [width, height] = [width, height].map(|side| side.parse().unwrap());
    let (adapter, device, queue) = support::device().expect("a device");
    let info = adapter.get_info();
    eprintln!("== adapter {} | {} | {}", info.name, info.driver, info.driver_info);
    for setting in settings.split(',') {
        for disparities in disparities.split(',').map(|number| number.parse().unwrap()) {
            let params = params(setting, disparities, &schedule);
            eprintln!("\n== begin {setting} {disparities}");
            let matcher = StereoMatcher::new(&device, &queue, width, height, PixelFormat::Gray8, &params);
            eprintln!();
            let matcher = match matcher {
                Ok(matcher) => matcher,
                Err(error) => {
                    eprintln!("== refused {setting} {disparities}: {error}");
                    continue;
                }
            };
            matcher.shaders().iter().for_each(|(name, _)| eprintln!("== kernel {name}"));
            eprintln!("== end");
        }
    }
}
