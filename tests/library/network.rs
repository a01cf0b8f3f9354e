//! The network beside PyTorch's: goldens that golden.py wrote, of single operations in the definition and of whole networks
//! in the native schedule and on the device. The weights are made by formulas on both sides.

use gpu_stereo::cpu::CpuMatcher;
use gpu_stereo::network::{Convolution, Tensor, Tensors};
use gpu_stereo::reference::{self, Values};
use gpu_stereo::{Architecture, Image, Matched, Network, Params, Pixels, StereoMatcher};
use serde_json::Value;
use std::path::Path;

use crate::support::{self, mixed};

/// Value i of tensor `seed`, from -1 to 1.
fn number(i: usize, seed: usize, c: u32) -> f64 {
    (f64::from(mixed(i as u32, seed as u32, c)) - 32768.0) / 32768.0
}

fn numbers(count: usize, seed: usize) -> Vec<f64> {
    (0..count).map(|i| number(i, seed, 0)).collect()
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/library/network").join(name)).unwrap()
}

fn sizes(value: &Value) -> Vec<usize> {
    value.as_array().unwrap().iter().map(|side| side.as_u64().unwrap() as usize).collect()
}

#[test]
fn operations_of_the_definition_are_those_of_pytorch() {
    let cases: Vec<Value> = serde_json::from_slice(&bytes("operations.json")).unwrap();
    for case in &cases {
        let input = |seed: usize| {
            let shape: [usize; 4] = sizes(&case["inputs"][seed - 1]).try_into().unwrap();
            Values { shape, data: numbers(shape.iter().product(), seed) }
        };
        let weights = || {
            let shape = sizes(&case["weights"]);
            let data = |count: usize, seed: usize| numbers(count, seed).into_iter().map(|v| v as f32).collect();
            let bias = data(shape[0], 9);
            Convolution::new(Tensor::new(shape.clone(), data(shape.iter().product(), 8)).unwrap(), bias)
        };
        let whole = |name: &str| case[name].as_u64().unwrap() as usize;
        let align = || case["align_corners"].as_bool().unwrap();
        let shape = sizes(&case["shape"]);
        let kind = case["kind"].as_str().unwrap();
        let made = match kind {
            "conv2d" | "conv3d" => reference::convolution(&input(1), &weights(), whole("stride"), whole("dilation")),
            "conv3d_transposed" => reference::conv3d_transposed(&input(1), &weights()),
            "feature_volume" => reference::feature_volume(&input(1), &input(2), whole("planes")),
            "average_pool" => reference::average_pool(&input(1), whole("side")),
            "upsample" => reference::upsample(&input(1), shape[2], shape[3], align()),
            "disparity_regression" => {
                let mut scores = input(1);
                scores.data.iter_mut().for_each(|score| *score *= 8.0);
                reference::disparity_regression(&scores, [16, shape[2], shape[3]], align())
            }
            other => panic!("there is no operation {other}"),
        };
        assert_eq!(made.shape[..], shape[..], "{kind}");
        let wanted = case["made"].as_array().unwrap();
        assert_eq!(made.data.len(), wanted.len());
        for (i, (made, wanted)) in made.data.iter().zip(wanted).enumerate() {
            let wanted = wanted.as_f64().unwrap();
            assert!((made - wanted).abs() < 1e-5, "{kind} {:?}: value {i} is {made}, not {wanted}", case["inputs"]);
        }
    }
    assert_eq!(cases.len(), 17);
}

/// The weights of `network` in golden.py, with a factor of the last ones and the statistics of the batch normalisations.
fn network(architecture: Architecture, goldens: &mut dyn Iterator<Item = f32>) -> Network {
    let basic = u32::from(architecture == Architecture::Basic);
    let factor = goldens.next().unwrap();
    let mut tensors = Tensors::new();
    for (seed, (name, shape)) in architecture.tensors().into_iter().enumerate() {
        let weight = name.ends_with(".weight");
        let inputs =
            if name.contains(".conv5.") || name.contains(".conv6.") { shape[0] } else { shape[1.min(shape.len() - 1)] };
        let taps: usize = shape.iter().skip(2).product();
        let last = name.starts_with("classif") && name.ends_with(".2.weight");
        let scaled = |i: usize| {
            let value = number(i, seed, 20 + basic);
            let value = match (weight, shape.len()) {
                (true, 1) => 1.0 + value / 4.0,
                (true, _) => value * (6.0 / (inputs * taps) as f64).sqrt(),
                _ => value / 4.0,
            };
            value as f32 * if last { factor } else { 1.0 }
        };
        let data = (0..shape.iter().product()).map(scaled).collect();
        tensors.insert(name, Tensor::new(shape, data).unwrap());
    }
    for part in [".running_mean", ".running_var"] {
        for tensor in tensors.iter_mut().filter(|(name, _)| name.ends_with(part)).map(|(_, tensor)| tensor) {
            let shape = tensor.shape().to_vec();
            *tensor = Tensor::new(shape.clone(), goldens.take(shape[0]).collect()).unwrap();
        }
    }
    Network::new(tensors).unwrap()
}

/// `pair` of golden.py.
fn pair() -> [Image; 2] {
    let left = |x: u32, y: u32, c: u32| ((mixed(x / 3, y / 3, c) + mixed(x, y, c + 4)) >> 9) as u8;
    let image = |shift: &dyn Fn(u32) -> u32| {
        let pixel = |i: u32| [0, 1, 2, 3].map(|c| if c == 3 { 0 } else { left(i % 256 + shift(i / 256), i / 256, c) });
        Image::new(256, 256, Pixels::Rgba8((0..256 * 256).flat_map(pixel).collect())).unwrap()
    };
    [image(&|_| 0), image(&|y| if y < 128 { 3 } else { 9 })]
}

/// Compares what `compute` makes of both networks with PyTorch's disparities, a value in 4x4.
fn whole_networks(name: &str, compute: &dyn Fn(&Image, &Image, &Params) -> Matched) {
    let [left, right] = pair();
    for architecture in Architecture::ALL {
        let goldens = bytes(&format!("{architecture}.f32"));
        let mut goldens = goldens.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()));
        let mut params = Params::psmnet(16, network(architecture, &mut goldens));
        params.align_corners = architecture == Architecture::StackHourglass;
        params.unrounded = true;
        let matched = compute(&left, &right, &params);
        let made = matched.unrounded.unwrap();
        assert_eq!((made.width, made.height, made.data.len()), (256, 256, 65536));
        let sampled = (0..65536).filter(|i| i % 4 == 0 && i / 256 % 4 == 0).map(|i| made.data[i]);
        let wanted: Vec<f32> = goldens.collect();
        assert_eq!(wanted.len(), 64 * 64);
        let differences: Vec<f32> = sampled.zip(&wanted).map(|(made, wanted)| (made - wanted).abs()).collect();
        let largest = differences.iter().copied().fold(0.0, f32::max);
        let mean = differences.iter().sum::<f32>() / differences.len() as f32;
        println!("{architecture}, {name}: at most {largest:.1e} px from PyTorch, {mean:.1e} on average");
        assert!(largest < 1e-3 && mean < 1e-4, "{architecture}, {name}: {largest} px, {mean} on average");
        // The map is rounded from them.
        for (map, made) in matched.map.data.iter().zip(&made.data) {
            assert_eq!(f64::from(*map), (16.0 * f64::from(*made) + 0.5).floor().clamp(0.0, 240.0));
        }
    }
}

#[test]
fn whole_networks_give_the_disparities_of_pytorch() {
    whole_networks("native", &|left, right, params| {
        let matcher = CpuMatcher::new(left.width(), left.height(), left.format(), params).unwrap();
        matcher.compute(left, right).unwrap()
    });
}

#[test]
fn whole_networks_give_them_on_the_device() {
    let Some((_, device, queue)) = support::device() else { return };
    whole_networks("device", &|left, right, params| {
        let matcher = StereoMatcher::new(&device, &queue, left.width(), left.height(), left.format(), params).unwrap();
        let matched = matcher.compute_blocking(left, right).unwrap();
        let network = params.network.as_ref().unwrap();
        assert_eq!(network.done(), params.multiplications(left.width(), left.height()), "its progress");
        matched
    });
}
