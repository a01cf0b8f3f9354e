//! What is typed: a file for the command line of each verb, and for each group of options that several of them have.

mod batch;
mod bench;
mod bulk;
mod cameras;
mod choices;
mod device;
mod eval;
mod formats;
mod headings;
mod input;
mod names;
mod numbers;
mod settings;
mod single;
mod study;
mod truth;
mod video;
mod weights;

pub use batch::{BatchArgs, HELP as BATCH_HELP, Shard, USAGE as BATCH_USAGE};
pub use bench::{BenchArgs, HELP as BENCH_HELP};
pub use cameras::{CalibArgs, CameraArgs, HELP as CALIB_HELP};
pub use device::DeviceArgs;
pub use eval::{EvalArgs, HELP as EVAL_HELP};
pub use formats::{LookArgs, MapsArgs};
pub use input::InputArgs;
#[cfg(test)]
pub use names::FOREIGN;
pub use names::{near, ours, squeezed, value, word};
pub use numbers::{in_flight, repeat, threads, usual_threads};
pub use settings::{Range, by_option, ensure_disparities, params, report_unused};
pub use single::{HELP as SINGLE_HELP, SingleArgs};
pub use study::{COMPARE_HELP, CompareArgs, SWEEP_HELP, StudyArgs};
pub use video::{HELP as VIDEO_HELP, USAGE as VIDEO_USAGE, VideoArgs};
pub use weights::{HELP as WEIGHTS_HELP, NetworkArgs, WeightsArgs};
