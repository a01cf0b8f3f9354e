//! `weights` and `--weights` as a user meets them: what is in a file, what is wrong with it, its conversion, and which settings
//! take a network.

use crate::support::{command, contents, is_one_line_error, refuses, run, scene, stderr, stdout, succeeds};
use gpu_stereo::files::weights::{Weights, encode};
use gpu_stereo::network::{Tensor, Tensors};
use gpu_stereo::{Architecture, FeatureNetwork};
use std::fs;
use std::path::Path;

/// Tensors of all names and shapes of an architecture.
fn tensors(architecture: Architecture, prefix: &str) -> Tensors {
    let tensor = |(name, shape): (String, Vec<usize>)| {
        let count: usize = shape.iter().product();
        let data = (0..count).map(|at| ((at * 7919 % 127) as f32 - 63.0) / 512.0).map(f32::abs).collect();
        (format!("{prefix}{name}"), Tensor::new(shape, data).unwrap())
    };
    architecture.tensors().into_iter().map(tensor).collect()
}

fn write(folder: &Path, name: &str, tensors: &Tensors) {
    fs::write(folder.join(name), encode(tensors).unwrap()).unwrap();
}

#[test]
fn a_file_is_listed_and_converted() {
    let folder = scene();
    let mut given = tensors(Architecture::Basic, "module.");
    given.insert("module.dres0.0.1.num_batches_tracked".into(), Tensor::new(vec![], vec![3.0]).unwrap());
    write(folder.path(), "a.tar", &given);
    let told = stdout(&succeeds(folder.path(), &["weights", "a.tar"]));
    for part in [
        "format        safetensors\n",
        "architecture  PSMNet basic\n",
        "parameters    3672896\n",
        "| module.classify.2.weight ",
        " 1 x 32 x 3 x 3 x 3 |",
    ] {
        assert!(told.contains(part), "{part:?} is not in: {told}");
    }
    let told = stdout(&succeeds(folder.path(), &["weights", "a.tar", "--convert", "b.safetensors", "--json"]));
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!((&told["architecture"], &told["outputs"][0]), (&"basic".into(), &"b.safetensors".into()));
    assert_eq!(told["tensors"][0]["type"], "f32");
    assert!(told["problems"].as_array().unwrap().is_empty());
    let converted = Weights::read(&folder.path().join("b.safetensors")).unwrap();
    assert_eq!(converted.tensors, tensors(Architecture::Basic, ""));
    let again = stdout(&succeeds(folder.path(), &["weights", "b.safetensors", "--convert", "c.safetensors"]));
    assert!(again.contains("written       c.safetensors"), "{again}");
    assert_eq!(
        fs::read(folder.path().join("b.safetensors")).unwrap(),
        fs::read(folder.path().join("c.safetensors")).unwrap()
    );
}

#[test]
fn what_is_wrong_is_named_and_nothing_is_converted() {
    let folder = scene();
    let mut given = tensors(Architecture::StackHourglass, "");
    given.remove("dres3.conv6.0.weight");
    given.insert("classif1.2.weight".into(), Tensor::new(vec![2], vec![0.0; 2]).unwrap());
    given.insert("dres1.\u{1b}[2J\u{202e}\n".into(), Tensor::new(vec![1], vec![0.0]).unwrap());
    write(folder.path(), "a b\n.pth", &given);
    let before = contents(folder.path());
    let output = run(folder.path(), &["weights", "a b\n.pth", "--convert", "b.safetensors"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("nothing was converted") && contents(folder.path()) == before);
    let told = stdout(&output);
    for part in [
        "\"a b\\n.pth\"",
        "problem: dres3.conv6.0.weight [64, 32, 3, 3, 3] is missing\n",
        "problem: classif1.2.weight is [2], but must be [1, 32, 3, 3, 3]\n",
        "problem: dres1.\\u{1b}[2J\\u{202e}\\n is unknown\n",
    ] {
        assert!(told.contains(part), "{part:?} is not in: {told}");
    }
    given.retain(|name, _| name.starts_with("dres1."));
    write(folder.path(), "other", &given);
    let output = run(folder.path(), &["weights", "other", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let told: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(told["architecture"], serde_json::Value::Null);
    assert!(told["problems"][0].as_str().unwrap().contains("no network that is known"));
}

#[test]
fn files_that_hold_no_weights_are_refused() {
    let folder = scene();
    write(folder.path(), "a.safetensors", &tensors(Architecture::Basic, ""));
    let pickle = b"\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.\x80\x02M\xe9\x03.\x80\x02}.\x80\x02cos\nsystem\nX\x02\0\0\0ls\x85R.";
    fs::write(folder.path().join("evil.tar"), pickle).unwrap();
    let refuses = |args: &[&str], words: &[&str]| refuses(folder.path(), &[&["weights"], args].concat(), words);
    refuses(&["left.png"], &["\"left.png\" is in no known format", "torch.save"]);
    refuses(&["none"], &["\"none\" does not exist"]);
    refuses(&["."], &["is a folder; give the path of weights"]);
    refuses(&["evil.tar"], &["\"os.system\", which is refused", "state_dict"]);
    refuses(&["a.safetensors", "--convert", "b.pth"], &["--convert is \"b.pth\"", ".safetensors"]);
    refuses(&["a.safetensors", "--convert", "a.safetensors"], &["is an input, too"]);
    refuses(&["a.safetensors", "--convert", "none/b.safetensors"], &["none/b.safetensors", "does not exist"]);
    refuses(&["a.safetensors", "b.safetensors"], &["unexpected argument 'b.safetensors'"]);
    // Of two faults the output's comes first, since it costs nothing to see.
    refuses(&["none", "--convert", "b.pth"], &["--convert is"]);
}

/// Every verb that computes, with all that it needs but weights.
fn verbs() -> Vec<Vec<&'static str>> {
    let on = ["--disp", "16", "--backend", "cpu"];
    let of = |start: &[&'static str], method: &[&'static str]| [start, &on, method].concat();
    let network = ["--method", "psmnet"];
    vec![
        of(&["left.png", "right.png"], &network),
        of(&["sweep", "left.png", "right.png"], &["--method", "bm,psmnet"]),
        of(&["compare", "left.png", "right.png"], &["--variants", "sgm,psmnet"]),
        of(&["video", "left.png", "right.png", "-o", "out"], &network),
        of(&["batch", "left.png", "right.png", "-o", "out"], &network),
        of(&["bench", "m.json", "--layout", "manifest"], &["--variants", "bp,psmnet"]),
    ]
}

#[test]
fn every_verb_takes_weights_with_the_method_that_needs_them() {
    let folder = scene();
    fs::write(folder.path().join("m.json"), r#"[{"name": "a", "left": "left.png", "right": "right.png"}]"#).unwrap();
    let mut less = tensors(Architecture::Basic, "");
    less.remove("classify.2.weight");
    write(folder.path(), "less", &less);
    for verb in verbs() {
        refuses(folder.path(), &verb, &["--method psmnet needs the weights", "--weights FILE", "docs/NETWORKS.md"]);
        let with = |weights: &'static str| [&verb[..], &["--weights", weights]].concat();
        refuses(folder.path(), &with("less"), &["\"less\": ", "classify.2.weight [1, 32, 3, 3, 3] is missing"]);
        refuses(folder.path(), &with("none"), &["\"none\" does not exist; give the path of weights"]);
    }
    let eval = run(folder.path(), &["eval", "a.png", "b.png", "--weights", "less"]);
    is_one_line_error(&eval, &["--weights <FILE> is an option of a single run"]);
}

#[test]
fn weights_without_such_a_method_have_no_effect() {
    let folder = scene();
    let args = ["left.png", "right.png", "--disp", "16", "--backend", "cpu", "--weights", "none", "-o", "a.png"];
    let told = stderr(&succeeds(folder.path(), &args));
    assert!(told.contains("note: --weights has no effect with --method sgm"), "{told}");
    let help = command(folder.path()).arg("--help").output().unwrap();
    assert!(stdout(&help).contains("--weights <FILE>"));
}

#[test]
fn an_output_never_replaces_the_weights() {
    let folder = scene();
    write(folder.path(), "a.png", &tensors(Architecture::Basic, ""));
    let args = ["left.png", "right.png", "--disp", "16", "--method", "psmnet", "--weights", "a.png", "-o", "a.png"];
    refuses(folder.path(), &args, &["output \"a.png\" is an input, too"]);
}

/// Once without an adapter, with weights that were never trained.
#[test]
fn maps_are_computed_and_other_weights_are_other_settings() {
    let folder = scene();
    let mut given = tensors(Architecture::Basic, "module.");
    write(folder.path(), "a.tar", &given);
    write(folder.path(), "same", &tensors(Architecture::Basic, ""));
    given.insert("module.classify.2.weight".into(), Tensor::new(vec![1, 32, 3, 3, 3], vec![0.0; 864]).unwrap());
    write(folder.path(), "other", &given);
    let batch = |weights: &'static str, resume: &'static [&'static str]| {
        let start = ["batch", "left.png", "right.png", "-o", "out", "--disp", "16", "--backend", "cpu"];
        [&start[..], &["--method", "psmnet", "--weights", weights], resume].concat()
    };
    let told = stdout(&succeeds(folder.path(), &batch("a.tar", &["--json"])));
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!((&told["adapter"], &told["done"]), (&"CPU".into(), &1.into()));
    let kept = stdout(&succeeds(folder.path(), &batch("same", &["--resume"])));
    assert!(kept.contains("0 done, 0 failed, 1 there already"), "{kept}");
    refuses(folder.path(), &batch("other", &["--resume"]), &["maps made with other settings: weights "]);
}

/// A network of features in a file gives the map that it gives in the library; files of other networks are refused.
#[test]
fn the_learned_costs_take_a_network_of_features() {
    let folder = scene();
    let path = |name: &str| folder.path().join(name);
    let network = FeatureNetwork::built_in();
    fs::write(path("same"), network.encode().unwrap()).unwrap();
    let mut layers = network.layers().to_vec();
    layers[0].bias[0] += 1000;
    fs::write(path("other"), FeatureNetwork::new(layers).unwrap().encode().unwrap()).unwrap();
    write(folder.path(), "psmnet", &tensors(Architecture::Basic, ""));
    let batch = |more: &'static [&'static str]| {
        let start = ["batch", "left.png", "right.png", "-o", "out", "--disp", "16", "--backend", "cpu", "--cost"];
        [&start[..], more].concat()
    };
    for cost in ["learned", "learned-census"] {
        let single = ["left.png", "right.png", "--disp", "16", "--backend", "cpu", "--cost", cost, "-o"];
        succeeds(folder.path(), &[&single[..], &["a.pfm"]].concat());
        succeeds(folder.path(), &[&single[..], &["b.pfm", "--weights", "same"]].concat());
        assert_eq!(fs::read(path("a.pfm")).unwrap(), fs::read(path("b.pfm")).unwrap(), "{cost}");
        refuses(folder.path(), &[&single[..], &["c.pfm", "--weights", "none"]].concat(), &["\"none\" does not exist"]);
        let parts = ["\"psmnet\" cannot be read as a network of features", "metadata format is \"missing\""];
        refuses(folder.path(), &[&single[..], &["c.pfm", "--weights", "psmnet"]].concat(), &parts);
    }
    succeeds(folder.path(), &batch(&["learned", "--weights", "same"]));
    let kept = stdout(&succeeds(folder.path(), &batch(&["learned", "--weights", "same", "--resume"])));
    assert!(kept.contains("0 done, 0 failed, 1 there already"), "{kept}");
    let other = batch(&["learned", "--weights", "other", "--resume"]);
    refuses(folder.path(), &other, &["maps made with other settings: weights "]);
}
