//! What the memory that is left does not hold is refused in one line, before any work.

use gpu_stereo::Architecture;
use gpu_stereo::files::weights::encode;
use gpu_stereo::network::Tensor;
use std::process::{Command, Output};

/// Runs the command where the address space is so many KiB.
fn limited(kibibytes: u64, arguments: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_gpu-stereo");
    let line = format!("ulimit -v {kibibytes}; exec {program} {arguments}");
    Command::new("sh").args(["-c", &line]).current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).output().unwrap()
}

const PAIR: &str = "data/corridor/left.png data/corridor/right.png";

#[test]
fn what_computes_without_an_adapter_is_refused_before_it_allocates() {
    // 400 x 300 pixels at 2000 disparities: two bytes each are 0.5 GB, five are 1.2 GB.
    for (backend, kibibytes, what) in
        [("cpu", 450_000, "the native schedule"), ("reference", 600_000, "the CPU reference")]
    {
        let arguments =
            format!("{PAIR} --disp 2000 --backend {backend} --preset classic --paths 8 -o never-written.pfm");
        let out = limited(kibibytes, &arguments);
        let told = String::from_utf8_lossy(&out.stderr);
        assert!(!out.status.success(), "{told}");
        assert_eq!(told.lines().count(), 1, "{told}");
        let first = format!("{what} of 400x300 pixels at 2000 disparities needs");
        for part in [&first, "ulimit -v) leaves", "--disp", "crop"] {
            assert!(told.contains(part), "{told:?} does not say {part:?}");
        }
        // The same range where there is room for a few disparities.
        let out = limited(kibibytes, &format!("{PAIR} --disp 16 --backend {backend} --preset classic"));
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    }
}

#[test]
fn a_network_is_refused_before_it_allocates() {
    let zeros = |(name, shape): (String, Vec<usize>)| {
        let values = vec![0.0; shape.iter().product()];
        (name, Tensor::new(shape, values).unwrap())
    };
    let tensors = Architecture::Basic.tensors().into_iter().map(zeros).collect();
    let weights = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(&weights, encode(&tensors).unwrap()).unwrap();
    let network = format!("--method psmnet --weights {}", weights.path().display());
    // A volume of 32 channels at 128 x 76 x 100 is 124 MB, and several are needed at once.
    let out = limited(400_000, &format!("{PAIR} --disp 512 --backend cpu {network} -o never-written.pfm"));
    let told = String::from_utf8_lossy(&out.stderr);
    assert!(!out.status.success(), "{told}");
    for part in
        ["the network on the CPU of 400x300 pixels at 512 disparities needs", "ulimit -v) leaves", "--disp", "crop"]
    {
        assert!(told.contains(part), "{told:?} does not say {part:?}");
    }
}
