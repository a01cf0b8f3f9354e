//! The guard of speed that runs a clock; src/kernels/tests/unrolling.rs holds the one that needs none. Other work on the
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
        case.matcher.compute(&case.pair.0, &case.pair.1).unwrap(); // the first frame compiles
        case
    }

    /// One more frame. Without timestamps the whole frame is the only stage.
    fn run(&mut self) {
        let start = std::time::Instant::now();
        let (_, times) = self.matcher.compute_timed(&self.pair.0, &self.pair.1).unwrap();
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
fn settings(disparities: u32) -> [Params; 3] {
    let mut all = [Params::sgm(disparities), Params::sgm(disparities), Params::bm(disparities)];
    all[0].paths = Paths::Eight;
    all[1].block = 17;
    all
}

fn stages(params: &Params) -> &'static [&'static str] {
    match (params.method, params.block > 15) {
        (gpu_stereo::Method::Bm, _) => &["sad_columns", "block_match"],
        (_, true) => &["sad_columns", "sad_cost", "sgm_aggregate", "winner"],
        _ => &["sad_cost", "sgm_aggregate", "winner"],
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

/// The stages that hold a pixel's disparities in local arrays, beside those of the same frame that hold none and so
/// cannot fall out of the registers: the sum of `gray`, `prefilter`, `lr_check` and `median`. The limits lie between
/// what the stages took in five runs on a busy machine, written beside them, and what they take with arrays in memory.
///
/// That is how it was tried: with `shader_checks`, which keeps Mesa from unrolling, `sad_cost` took 16 to 22,
/// `sad_columns` 7 to 10 and `winner` 4.6 to 7.3. An index that stays unknown, such as `[min(q, pass_.rows)]` in place of
/// `[q]`, costs less than that in some kernels; src/kernels/tests/unrolling.rs finds every one of them.
#[test]
fn stages_keep_their_proportions() {
    const MOST: [&[(&str, f64)]; 3] = [
        &[("sad_cost", 7.0), ("sgm_aggregate", 13.0), ("winner", 5.4)], // 3.8 to 4.1, 7.2 to 7.9, 3.3 to 3.9
        &[("sad_columns", 5.8), ("sad_cost", 6.5), ("sgm_aggregate", 5.5), ("winner", 3.7)], // 3.8, 4.1, 3.2, 2.5
        &[("sad_columns", 5.8), ("block_match", 20.0)],                 // 3.5 to 3.7, 11.2 to 11.8
    ];
    if !in_child("stages_keep_their_proportions") {
        return;
    }
    let Some((adapter, device, queue)) = support::device() else { return };
    let info = adapter.get_info();
    if info.device_type != wgpu::DeviceType::Cpu || !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        let _ = writeln!(
            std::io::stderr(),
            "NOT TESTED: proportions of stages, which need timestamps of a CPU adapter; this is {}",
            info.name
        );
        return;
    }
    for (params, most) in settings(64).into_iter().zip(MOST) {
        until_good(&mut [Case::new(&device, &queue, 250, 120, &params)], |cases| {
            let least = &cases[0].least;
            let others: f64 = ["gray", "prefilter", "lr_check", "median"].iter().map(|stage| least[*stage]).sum();
            let found = most.iter().map(|(stage, most)| (stage, least[*stage] / others, most));
            let wrong = found.filter(|(_, ratio, most)| ratio > most);
            wrong
                .map(|(stage, ratio, most)| {
                    format!("{}: {stage} is {ratio:.2} of the small stages, at most {most} wanted", cases[0].name)
                })
                .collect()
        });
    }
}
