//! The guard of speed that runs a clock; src/gpu/kernels/tests/unrolling.rs holds the one that needs none. Other work on the
//! machine changes a time by any factor, so no time is compared with a number of milliseconds: frames of several
//! settings alternate in one process, and the least times of their stages are compared with each other, until they are
//! as they should be or a limit of rounds and of processes is reached. Noise only adds to a time, so more rounds bring
//! every time nearer to what it is; a kernel that became slow stays slow in all of them.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::io::Write as _;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use gpu_stereo::{Image, Params, Paths, PixelFormat, StereoMatcher, wgpu};

mod support;

/// Enough for the times that others are compared with.
const LEAST_ROUNDS: usize = 10;
const MOST_ROUNDS: usize = 120;

/// Processes: where a process has its buffers can make a kernel slower for as long as it lives.
const MOST_PROCESSES: usize = 4;

/// One test at a time.
static TURN: Mutex<()> = Mutex::new(());

/// Set for the child process of a test.
const CHILD: &str = "GPU_STEREO_PERFORMANCE_CHILD";

/// Whether this is the child process in which the test `name` runs; otherwise starts it and waits. lavapipe then works
/// with one thread, so that a time does not depend on how a dispatch divides among the cores.
fn in_child(name: &str) -> bool {
    if std::env::var_os(CHILD).is_some() {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", name, "--nocapture"]).env(CHILD, "1").env("LP_NUM_THREADS", "1");
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    for process in 1.. {
        let output = command.output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
        for line in stderr.lines().filter(|line| line.contains("TESTED: ")) {
            let _ = writeln!(std::io::stderr(), "{line}");
        }
        if output.status.success() {
            assert!(stdout.contains("1 passed"), "the test {name} did not run:\n{stdout}\n{stderr}");
            break;
        }
        assert!(process < MOST_PROCESSES, "in each of {process} processes; the last one:\n{stdout}\n{stderr}");
    }
    false
}

/// Settings, and the least time of each stage so far.
struct Case {
    name: String,
    matcher: StereoMatcher,
    pair: (Image, Image),
    pixels: f64,
    disparities: f64,
    least: BTreeMap<String, f64>,
}

impl Case {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue, width: u32, height: u32, params: &Params) -> Self {
        let pair = support::pair(width, height, 3);
        let matcher = StereoMatcher::new(device, queue, width, height, PixelFormat::Gray8, params).unwrap();
        let case = Self {
            name: format!("{:?} {width}x{height}, {} disparities", params.method, params.disparities),
            matcher,
            pair,
            pixels: f64::from(width * height),
            disparities: f64::from(params.disparities),
            least: BTreeMap::new(),
        };
        case.matcher.compute_blocking(&case.pair.0, &case.pair.1).unwrap(); // the first frame compiles
        case
    }

    /// One more frame. Without timestamps the whole frame is the only stage.
    fn run(&mut self) {
        let start = std::time::Instant::now();
        let (_, times) = self.matcher.compute_timed_blocking(&self.pair.0, &self.pair.1).unwrap();
        let frame = ("frame".to_string(), start.elapsed().as_secs_f64() * 1e3);
        let times = times.into_iter().map(|time| (time.name, time.ms));
        for (stage, ms) in times.chain([frame]) {
            let least = self.least.entry(stage).or_insert(f64::INFINITY);
            *least = least.min(ms);
        }
    }
}

/// Runs frames of all cases in turn until `judge` finds nothing, or the limit is reached.
fn until_good(cases: &mut [Case], judge: impl Fn(&[Case]) -> Vec<String>) {
    for round in 1.. {
        cases.iter_mut().for_each(Case::run);
        if round < LEAST_ROUNDS {
            continue;
        }
        let wrong = judge(cases);
        if wrong.is_empty() {
            return;
        }
        assert!(round < MOST_ROUNDS, "after {round} rounds:\n{}", wrong.join("\n"));
    }
}

/// Between them they run every kernel that holds the disparities of a pixel.
fn settings(disparities: u32) -> [Params; 4] {
    let (sgm, bm) = (Params::sgm(disparities), Params::bm(disparities));
    let mut all = [sgm.clone(), sgm, bm.clone(), bm];
    all[0].paths = Paths::Eight;
    all[1].block = 17;
    all[3].block = 17;
    all
}

fn stages(params: &Params) -> &'static [&'static str] {
    match (params.method, params.block > 15) {
        (gpu_stereo::Method::Bm, true) => &["cost_columns", "block_match"],
        (gpu_stereo::Method::Bm, false) => &["block_match"],
        (_, true) => &["cost_columns", "matching_cost", "sgm_aggregate", "winner"],
        _ => &["matching_cost", "sgm_aggregate", "winner"],
    }
}

/// The times grow with the pixels and with the disparities, not faster: four times as many of either take at most
/// `MOST` times four times as long. A stage that is quadratic in one takes four times four times as long.
#[test]
fn times_grow_linearly() {
    const MOST: f64 = 2.5;
    if !in_child("times_grow_linearly") {
        return;
    }
    let Some((adapter, device, queue)) = support::device() else { return };
    if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        let name = adapter.get_info().name;
        let _ = writeln!(std::io::stderr(), "PARTLY TESTED: {name} has no timestamps: whole frames in place of stages");
    }
    for params in settings(32) {
        let mut deep = params.clone();
        deep.disparities = 128;
        let mut cases = [(125, 60, &params), (250, 120, &params), (125, 60, &deep)]
            .map(|(w, h, p)| Case::new(&device, &queue, w, h, p));
        until_good(&mut cases, |cases| {
            let [small, large, deep] = cases else { unreachable!() };
            let mut wrong = Vec::new();
            for (other, all) in [(large, true), (deep, false)] {
                let growth = other.pixels * other.disparities / (small.pixels * small.disparities);
                for (stage, ms) in &other.least {
                    // The other stages do not depend on the disparities, and the frame is made of all.
                    if all || stages(&params).contains(&stage.as_str()) || other.least.len() == 1 {
                        let factor = ms / small.least[stage] / growth;
                        if factor > MOST {
                            wrong.push(format!(
                                "{stage}, {}: {factor:.2} times what {} takes a pixel and disparity",
                                other.name, small.name
                            ));
                        }
                    }
                }
            }
            wrong
        });
    }
}
