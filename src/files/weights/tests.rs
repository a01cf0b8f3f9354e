use super::*;
use crate::files::damage::damaged;
use crate::network::{Architecture, Network, Tensor, Tensors};
use made::{Storage, archive, dict, legacy, pickled, tensor, zip};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::{Duration, Instant};

mod made;

fn parse(bytes: &[u8]) -> crate::files::Result<Weights> {
    Weights::parse(Path::new("made"), bytes)
}

fn error(bytes: &[u8]) -> String {
    let told = parse(bytes).map(drop).unwrap_err().to_string();
    assert!(told.contains("\"made\"") && told.len() < 1000 && !told.contains('\n'), "{told}");
    told
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// A storage of 8 floats, two views of it, a counter, and a half.
fn storages() -> Vec<Storage> {
    let eight = floats(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    vec![
        Storage { kind: "FloatStorage", key: "0", bytes: eight },
        Storage { kind: "LongStorage", key: "1", bytes: 7_i64.to_le_bytes().into() },
        Storage { kind: "HalfStorage", key: "94", bytes: vec![0, 0x3c, 0, 0xc0] },
    ]
}

fn state(storages: &[Storage]) -> Vec<u8> {
    dict(&[
        ("module.a.weight", tensor(&storages[0], 0, &[2, 3], &[3, 1])),
        ("module.a.turned", tensor(&storages[0], 1, &[2, 3], &[1, 2])),
        ("module.a.num_batches_tracked", tensor(&storages[1], 0, &[], &[])),
        ("module.b", tensor(&storages[2], 0, &[2], &[1])),
    ])
}

/// As checkpoints are: with the epoch and the loss.
fn checkpoint(state: &[u8]) -> Vec<u8> {
    dict(&[("epoch", b"M\x2c\x01".to_vec()), ("state_dict", state.to_vec()), ("loss", [b"G", &[0; 8][..]].concat())])
}

/// Small good files of every format.
fn seeds() -> Vec<(WeightsFormat, Vec<u8>)> {
    let storages = storages();
    let (bare, whole) = (pickled(&state(&storages)), pickled(&checkpoint(&state(&storages))));
    let tensors = parse(&archive(&bare, &storages, false)).unwrap().tensors;
    vec![
        (WeightsFormat::Archive, archive(&bare, &storages, false)),
        (WeightsFormat::Archive, archive(&whole, &storages, true)),
        (WeightsFormat::Legacy, legacy(&bare, &storages)),
        (WeightsFormat::Legacy, legacy(&whole, &storages)),
        (WeightsFormat::SafeTensors, encode(&tensors).unwrap()),
    ]
}

#[test]
fn every_format_gives_the_same_tensors() {
    for (format, file) in seeds() {
        let weights = parse(&file).unwrap();
        assert_eq!(weights.format, format);
        let names: Vec<_> = weights.tensors.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            ["module.a.num_batches_tracked", "module.a.turned", "module.a.weight", "module.b"],
            "{format}"
        );
        let get = |name: &str| (weights.tensors[name].shape(), weights.tensors[name].data());
        assert_eq!(get("module.a.weight"), (&[2, 3][..], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0][..]), "{format}");
        assert_eq!(get("module.a.turned"), (&[2, 3][..], &[1.0, 3.0, 5.0, 2.0, 4.0, 6.0][..]), "{format}");
        assert_eq!(get("module.a.num_batches_tracked"), (&[][..], &[7.0][..]), "{format}");
        assert_eq!(get("module.b"), (&[2][..], &[1.0, -2.0][..]), "{format}");
        let half = if format == WeightsFormat::SafeTensors { Element::F32 } else { Element::F16 };
        assert_eq!((weights.elements["module.a.weight"], weights.elements["module.b"]), (Element::F32, half));
    }
}

/// As Python 2 wrote it, and as protocol 4 does.
#[test]
fn other_pickles_of_the_same_are_read() {
    let storages = [storages().swap_remove(0)];
    let one = tensor(&storages[0], 0, &[8], &[1]);
    // OrderedDict([['a', ..]]) with short texts, its attributes, and a parameter.
    let older = [&b"ccollections\nOrderedDict\n]](U\x01a"[..], &one, b"ea\x85R}(U\x01xK\x01ub"].concat();
    let parameter =
        [&b"ctorch._utils\n_rebuild_parameter\n("[..], &one, b"\x89ccollections\nOrderedDict\n)RtR"].concat();
    let four = [
        &b"ctorch._utils\n_rebuild_tensor\n((X\x07\0\0\0storagectorch\nFloatStorage\n"[..],
        b"X\x01\0\0\x000NK\x08NtQK\0K\x08\x85K\x01\x85tR",
    ]
    .concat();
    for state in [older, dict(&[("a", parameter)]), dict(&[("a", four)])] {
        for file in [archive(&pickled(&state), &storages, false), legacy(&pickled(&state), &storages)] {
            assert_eq!(parse(&file).unwrap().tensors["a"].shape(), [8]);
        }
    }
    let global = |module: &str, name: &str| {
        let text = |text: &str| [&[0x8c, text.len() as u8], text.as_bytes()].concat();
        [text(module), text(name), vec![0x93, 0x94]].concat()
    };
    let newer = [
        &b"\x80\x04\x95\x00\x00\x00\x00\x00\x00\x00\x00}\x94\x8c\x01a"[..],
        &global("torch._utils", "_rebuild_tensor_v2"),
        b"((\x8c\x07storage",
        &global("torch", "FloatStorage"),
        b"\x8c\x010\x8c\x03cpuK\x08tQK\x02K\x03K\x02\x86K\x02K\x01\x86\x89NtRs.",
    ]
    .concat();
    assert_eq!(parse(&archive(&newer, &storages, false)).unwrap().tensors["a"].data(), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    // A part of a storage, as PyTorch before 0.4 has them.
    let part = tensor(&storages[0], 1, &[2], &[1]);
    let at = part.windows(2).position(|bytes| bytes == b"tQ").unwrap();
    let part = [&part[..at], b"(X\x01\0\0\x003K\x04K\x03t", &part[at..]].concat();
    let state = dict(&[("a", part)]);
    assert_eq!(parse(&legacy(&pickled(&state), &storages)).unwrap().tensors["a"].data(), [5.0, 6.0]);
}

#[test]
fn what_asks_for_more_than_tensors_is_refused_by_name() {
    let storages = storages();
    let run = b"cos\nsystem\nX\x04\0\0\0true\x85R".to_vec();
    let evil = dict(&[("a", tensor(&storages[0], 0, &[8], &[1])), ("b", run)]);
    for file in [archive(&pickled(&evil), &storages, false), legacy(&pickled(&evil), &storages)] {
        let told = error(&file);
        assert!(told.contains("\"os.system\", which is refused") && told.contains("state_dict"), "{told}");
    }
    let module = pickled(b"(X\x06\0\0\0moduleNNtQ");
    assert!(error(&archive(&module, &[], false)).contains("whole module"));
    let long = [&b"c"[..], &b"x\x1b[31m".repeat(999), b"\ny\n"].concat();
    assert!(error(&archive(&pickled(&long), &[], false)).contains("\\u{1b}"));
    for code in [&b"i"[..], b"o", b"\x82\0", b"P0\n", b"\x97"] {
        assert!(error(&archive(&pickled(code), &[], false)).contains("instruction"), "{code:?}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let storages = storages();
    let of = |state: &[u8]| error(&archive(&pickled(state), &storages, false));
    let one =
        |offset, shape: &[u32], strides: &[u32]| of(&dict(&[("a", tensor(&storages[0], offset, shape, strides))]));
    assert!(
        one(0, &[9], &[1]).contains("tensor \"a\": with shape [9] and strides [1] it ends behind its storage of 8")
    );
    assert!(one(8, &[1], &[1]).contains("behind its storage"));
    assert!(one(0, &[60_000, 60_000], &[0, 0]).contains("more values than the file has bytes"));
    assert!(one(0, &[1; 17], &[1; 17]).contains("17 dimensions"));
    let twice = dict(&[("module.a", tensor(&storages[0], 0, &[8], &[1])), ("a", tensor(&storages[0], 0, &[8], &[1]))]);
    assert!(of(&twice).contains("the tensor \"a\" twice"));
    assert!(of(b"}").contains("no tensors") && of(b"N").contains("no dictionary"));
    let lost = Storage { kind: "FloatStorage", key: "9", bytes: vec![] };
    assert!(of(&dict(&[("a", tensor(&lost, 0, &[1], &[1]))])).contains("storage \"9\" is missing"));
    // The archive itself.
    let pickle = pickled(&state(&storages));
    assert!(error(&zip(&[("a/data.pkl", &pickle), ("a/byteorder", b"big")], false, 0)).contains("big endian"));
    assert!(error(&zip(&[("a/data.pkl", &pickle)], false, 8)).contains("compressed"));
    assert!(error(&zip(&[("a/b", b"")], false, 0)).contains("without data.pkl"));
    assert!(error(&zip(&[], false, 0)).contains("without files"));
    let repeated = [("a/data.pkl", &pickle[..]), ("a/data/0", b""), ("a/data/0", b"")];
    assert!(error(&zip(&repeated, false, 0)).contains("\"0\" twice"));
    assert!(error(b"PK\x03\x04").contains("its end is missing"));
    // Other files.
    assert!(error(b"\x80\x02K\x01.").contains("none that torch.save wrote"));
    assert!(error(b"\x1f\x8b\x08").contains("compressed (gzip)") && error(b"GIF89a").contains("no known format"));
    assert!(error(b"<!DOCTYPE html>").contains("page of the web"));
    assert!(error(&[&[b'.'; 257][..], b"ustar"].concat()).contains("(tar)"));
}

#[test]
fn headers_of_safetensors_are_checked() {
    let file = |header: &str, data: &[u8]| [&(header.len() as u64).to_le_bytes(), header.as_bytes(), data].concat();
    let one = |kind: &str, shape: &str, end: &str| {
        format!("{{\"a\":{{\"dtype\":\"{kind}\",\"shape\":{shape},\"data_offsets\":[0,{end}]}}}}")
    };
    let bf16 = parse(&file(&one("BF16", "[2]", "4"), &[0x80, 0x3f, 0x20, 0xc0])).unwrap();
    assert_eq!((bf16.tensors["a"].data(), bf16.elements["a"]), (&[1.0, -2.5][..], Element::Bf16));
    assert!(error(&file(&one("F32", "[2]", "4"), &[0; 4])).contains("damaged or cut short"));
    assert!(error(&file(&one("F32", "[2]", "8"), &[0; 4])).contains("damaged or cut short"));
    assert!(error(&file(&one("F8_E4M3", "[2]", "2"), &[0; 2])).contains("F8_E4M3, but floats"));
    // The library would add this to the length of the header.
    let most = "18446744073709551615";
    assert!(error(&file(&one("U8", &format!("[{most}]"), most), &[])).contains("more than 19 digits"));
    assert!(error(b"\xff\0\0\0\0\0\0\0{").contains("no known format"));
    // A header of 640 bytes: its length begins as a pickle does.
    let header = format!("{:640}", one("U8", "[2]", "2"));
    assert_eq!(parse(&file(&header, &[7, 9])).unwrap().tensors["a"].data(), [7.0, 9.0]);
}

/// Tensors of all names and shapes of an architecture.
fn whole(architecture: Architecture) -> Tensors {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let tensor = |(name, shape): (String, Vec<usize>)| {
        let data = (0..shape.iter().product()).map(|_| random.random_range(0.0..1.0)).collect();
        (name, Tensor::new(shape, data).unwrap())
    };
    architecture.tensors().into_iter().map(tensor).collect()
}

#[test]
fn a_network_is_loaded_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    for architecture in Architecture::ALL {
        let tensors = whole(architecture);
        let path = folder.path().join(format!("{architecture}.any"));
        std::fs::write(&path, encode(&tensors).unwrap()).unwrap();
        let network = Network::load(&path).unwrap();
        assert_eq!((network.architecture(), &network), (architecture, &Network::new(tensors).unwrap()));
    }
    let mut tensors = whole(Architecture::Basic);
    tensors.remove("classify.2.weight");
    let path = folder.path().join("less");
    std::fs::write(&path, encode(&tensors).unwrap()).unwrap();
    let told = Network::load(&path).unwrap_err().to_string();
    assert!(told.contains("less\": these are no weights") && told.contains("classify.2.weight [1, 32, 3"), "{told}");
    assert!(Network::load(folder.path()).unwrap_err().to_string().contains("is a folder; give the path of weights"));
    assert!(Network::load("/none").unwrap_err().to_string().contains("does not exist"));
}

/// A second; GPU_STEREO_FUZZ_SECONDS says how long else.
#[test]
fn damaged_weights_are_refused_or_read_and_never_panic() {
    let seconds = std::env::var("GPU_STEREO_FUZZ_SECONDS").map_or(1, |text| text.parse().unwrap());
    let (end, seeds) = (Instant::now() + Duration::from_secs(seconds), seeds());
    let (mut read, mut refused) = (0_u64, 0_u64);
    for number in 0.. {
        if Instant::now() > end {
            break;
        }
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let bytes = damaged(&seeds[random.random_range(0..seeds.len())].1, &mut random, b"()tR.}ue2");
        match std::panic::catch_unwind(|| parse(&bytes)) {
            Ok(Ok(weights)) => {
                let values: usize = weights.tensors.values().map(|tensor| tensor.data().len()).sum();
                assert!(values <= bytes.len(), "{number}");
                read += 1;
            }
            Ok(Err(error)) => {
                let error = error.to_string();
                assert!(error.len() < 1000, "{number}: {error}");
                refused += 1;
            }
            Err(_) => panic!("the damage of seed {number} panics: {bytes:?}"),
        }
    }
    assert!(read > 10 && refused > 10, "{read} read, {refused} refused");
}

/// The published file, where GPU_STEREO_WEIGHTS names it. Its number of tensors and a sum over all values, in doubles, as
/// PyTorch reads them.
#[test]
fn the_published_file_is_read() {
    let Some(path) = std::env::var_os("GPU_STEREO_WEIGHTS") else {
        eprintln!("NOT TESTED: GPU_STEREO_WEIGHTS does not name the published weights (docs/NETWORKS.md)");
        return;
    };
    let weights = Weights::read(Path::new(&path)).unwrap();
    assert_eq!(weights.tensors.len(), 429);
    assert_eq!(weights.network().unwrap().architecture(), Architecture::StackHourglass);
}
