use super::*;
use crate::Error;
use rand::{Rng, SeedableRng};

/// Random tensors of all shapes of an architecture.
fn random(architecture: Architecture, prefix: &str, seed: u64) -> Tensors {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let tensor = |(name, shape): (String, Vec<usize>)| {
        let least = if name.ends_with("running_var") { 0.0 } else { -1.0 };
        let data = (0..shape.iter().product()).map(|_| random.random_range(least..1.0)).collect();
        (format!("{prefix}{name}"), Tensor::new(shape, data).unwrap())
    };
    architecture.tensors().into_iter().map(tensor).collect()
}

fn operation<'a>(operations: &'a [Operation], name: &str) -> &'a Operation {
    operations.iter().find(|operation| operation.name == name).unwrap_or_else(|| panic!("no {name}"))
}

/// The numbers of parameters and of tensors that the published models have.
#[test]
fn architectures_have_the_published_numbers_of_parameters() {
    for (architecture, parameters) in [(Architecture::StackHourglass, 5_224_768), (Architecture::Basic, 3_672_896)] {
        let tensors = architecture.tensors();
        let trained = tensors.iter().filter(|(name, _)| !name.contains(".running_"));
        let count: usize = trained.map(|(_, shape)| shape.iter().product::<usize>()).sum();
        assert_eq!(count, parameters, "{architecture}");
    }
    assert_eq!(Architecture::StackHourglass.tensors().len(), 429);
    let tensors = Architecture::StackHourglass.tensors();
    assert_eq!(tensors["feature_extraction.layer2.0.conv1.0.0.weight"], [64, 32, 3, 3]);
    assert_eq!(tensors["feature_extraction.layer3.0.downsample.0.weight"], [128, 64, 1, 1]);
    assert_eq!(tensors["dres0.0.0.weight"], [32, 64, 3, 3, 3]);
    assert_eq!(tensors["dres2.conv6.0.weight"], [64, 32, 3, 3, 3], "transposed: inputs first");
    assert_eq!(tensors["dres2.conv6.1.running_var"], [32]);
    assert_eq!(tensors["classif3.2.weight"], [1, 32, 3, 3, 3]);
}

/// Every operation reads earlier ones, adds what has its shape, and the weights fit what it reads.
#[test]
fn the_list_of_operations_fits_together() {
    let padded = Padded::new(512, 272, 192);
    for architecture in Architecture::ALL {
        let operations = architecture.operations();
        let mut names = std::collections::BTreeSet::new();
        for (at, operation) in operations.iter().enumerate() {
            assert!(names.insert(&operation.name), "{} is there twice", operation.name);
            assert!(operation.inputs.iter().chain(&operation.add).all(|&input| input < at), "{operation:?}");
            assert!(operation.shape(&padded).iter().all(|&side| side > 0), "{operation:?}");
            if let Some(add) = operation.add {
                assert_eq!(operations[add].shape(&padded), operation.shape(&padded), "{operation:?}");
            }
            let volumes = |&input: &usize| matches!(operations[input].extent, Extent::Volume(_));
            match operation.kind {
                Kind::Conv3d { .. } | Kind::TransposedConv3d | Kind::Regression => {
                    assert!(operation.inputs.iter().all(volumes), "{operation:?}");
                }
                _ => assert!(!operation.inputs.iter().any(volumes), "{operation:?}"),
            }
            if operation.kind == Kind::Concat {
                let channels: usize = operation.inputs.iter().map(|&input| operations[input].channels).sum();
                assert_eq!(channels, operation.channels);
            }
            assert_eq!(operation.parameters.is_some(), operation.weights(&operations).is_some(), "{operation:?}");
        }
        let last = Operation::last_reads(&operations);
        let unread: Vec<usize> = (0..last.len()).filter(|&at| last[at] == at).collect();
        assert_eq!(unread, [operations.len() - 1], "only the disparities are read by none");
    }
}

#[test]
fn sizes_and_residuals_are_as_published() {
    let operations = Architecture::StackHourglass.operations();
    let padded = Padded::new(1242, 375, 192);
    assert_eq!((padded.width, padded.height, padded.disparities), (1248, 384, 192));
    assert_eq!((Padded::new(17, 300, 16).width, Padded::new(17, 300, 16).height), (256, 304));
    let at = |name: &str| operation(&operations, name);
    let number = |name: &str| operations.iter().position(|operation| operation.name == name);
    assert_eq!(at("feature_extraction.firstconv.4").shape(&padded), [32, 1, 192, 624]);
    assert_eq!(at("feature_extraction.lastconv.2").shape(&padded), [32, 1, 96, 312]);
    assert!(!at("feature_extraction.lastconv.2").relu);
    assert_eq!(at("feature_extraction.branch1.1").shape(&padded), [32, 1, 1, 4]);
    assert_eq!(at("dres0.0").shape(&padded), [32, 48, 96, 312]);
    assert_eq!(at("dres3.conv4").shape(&padded), [64, 12, 24, 78]);
    assert_eq!(operations.last().unwrap().shape(&padded), [1, 1, 384, 1248]);
    // No ReLU after a block of the features; the hourglasses add what earlier ones made.
    assert_eq!(at("feature_extraction.layer2.3.conv2").add, number("feature_extraction.layer2.2.conv2"));
    assert_eq!(at("feature_extraction.layer3.0.conv2").add, number("feature_extraction.layer3.0.downsample"));
    assert!(!at("feature_extraction.layer2.3.conv2").relu && !at("dres1.2").relu && !at("dres3.conv6").relu);
    for (name, add) in [
        ("dres1.2", "dres0.2"),
        ("dres2.conv5", "dres2.conv2"),
        ("dres3.conv2", "dres2.conv5"),
        ("dres3.conv5", "dres2.conv2"),
        ("dres4.conv2", "dres3.conv5"),
        ("dres4.conv5", "dres2.conv2"),
        ("dres4.conv6", "dres1.2"),
        ("classif3.2", "classif2.2"),
    ] {
        assert_eq!(at(name).add, number(add), "{name}");
    }
    assert!(["dres2.conv2", "dres2.conv5", "dres4.conv2"].iter().all(|name| at(name).relu));
    assert_eq!(at("dres2.conv2").add, None);
}

/// 185 billion multiplications at 256x512 with 192 disparities, of which 58 for the features.
#[test]
fn the_work_is_counted() {
    let operations = Architecture::StackHourglass.operations();
    let billions = |padded: Padded, sides: bool| {
        let of = operations.iter().filter(|operation| sides || !operation.both_sides);
        of.map(|operation| operation.multiplications(&operations, &padded)).sum::<u64>() as f64 / 1e9
    };
    let crop = Padded::new(512, 256, 192);
    let (all, volume) = (billions(crop, true), billions(crop, false));
    assert!((184.0..186.5).contains(&all) && (126.0..128.0).contains(&volume), "{all} {volume}");
    let frame = billions(Padded::new(1242, 375, 192), true);
    assert!((672.0..678.0).contains(&frame), "{frame}");
    // A volume of 32 channels at a quarter of the sides is 50 MB; some are needed at once.
    let values = operation(&operations, "dres0.0").values(&crop);
    assert_eq!(values, 32 * 48 * 64 * 128);
    assert!((2 * values..8 * values).contains(&Operation::peak(&operations, &crop)));
}

#[test]
fn batch_normalisation_is_folded_in_doubles() {
    for (architecture, prefix) in [(Architecture::StackHourglass, "module."), (Architecture::Basic, "")] {
        let mut tensors = random(architecture, prefix, 1);
        let counter = Tensor::new(vec![], vec![7.0]).unwrap();
        tensors.insert(format!("{prefix}dres0.0.1.num_batches_tracked"), counter);
        let network = Network::new(tensors.clone()).unwrap();
        assert_eq!(network.architecture(), architecture);
        let get = |name: &str| tensors[&format!("{prefix}{name}")].data();
        let conv = network.convolution("dres0.2").unwrap();
        assert_eq!(conv.weights.shape(), [32, 32, 3, 3, 3]);
        let part = |part: &str, output: usize| f64::from(get(&format!("dres0.2.1.{part}"))[output]);
        for (output, tap) in [(0, 0), (5, 100), (31, 863)] {
            let scale = part("weight", output) / (part("running_var", output) + 1e-5).sqrt();
            let at = output * 864 + tap;
            assert_eq!(conv.weights.data()[at], (f64::from(get("dres0.2.0.weight")[at]) * scale) as f32);
            assert_eq!(conv.bias[output], (part("bias", output) - scale * part("running_mean", output)) as f32);
        }
        let last = network.convolution("feature_extraction.lastconv.2").unwrap();
        assert!(last.weights.data() == get("feature_extraction.lastconv.2.weight") && last.bias == [0.0; 32]);
        if architecture == Architecture::StackHourglass {
            let turned = network.convolution("dres3.conv6").unwrap();
            assert_eq!(turned.weights.shape(), [32, 64, 3, 3, 3]);
            let (input, output, tap) = (41, 3, 17);
            let given = f64::from(get("dres3.conv6.0.weight")[(input * 32 + output) * 27 + tap]);
            let scale = f64::from(get("dres3.conv6.1.weight")[output])
                / (f64::from(get("dres3.conv6.1.running_var")[output]) + 1e-5).sqrt();
            assert_eq!(turned.weights.data()[(output * 64 + input) * 27 + tap], (given * scale) as f32);
        }
        assert_eq!(network, Network::new(tensors.clone()).unwrap());
        assert_ne!(network, Network::new(random(architecture, "", 2)).unwrap());
    }
}

#[test]
fn every_tensor_is_checked() {
    let whole = random(Architecture::Basic, "", 3);
    let fails = |change: &dyn Fn(&mut Tensors), parts: &[&str]| {
        let mut tensors = whole.clone();
        change(&mut tensors);
        let Err(Error::Network(text)) = Network::new(tensors) else { panic!("{parts:?} was taken") };
        assert!(parts.iter().all(|part| text.contains(part)) && !text.contains('\n'), "{text}");
    };
    let name = "dres3.2.0.weight";
    let one = Tensor::new(vec![1], vec![0.0]).unwrap();
    fails(&|tensors| drop(tensors.remove(name)), &["dres3.2.0.weight [32, 32, 3, 3, 3] is missing"]);
    fails(&|tensors| drop(tensors.insert("dres9.bias".into(), one.clone())), &["dres9.bias is unknown"]);
    fails(&|tensors| drop(tensors.insert(name.into(), one.clone())), &["dres3.2.0.weight is [1], but must be [32, 32"]);
    fails(&|tensors| tensors.retain(|name, _| name.starts_with("classify")), &["is missing", "and ", " more"]);
    fails(&|tensors| tensors.clear(), &["0 tensors", "no network"]);
    fails(&|tensors| tensors.retain(|name, _| name.starts_with("dres0")), &["dres0.0.0.weight", "no network"]);
    let odd = |name: &str, value: f32| {
        let shape = whole[name].shape().to_vec();
        let mut data = whole[name].data().to_vec();
        data[3] = value;
        Tensor::new(shape, data).unwrap()
    };
    for (name, value, wanted) in [
        (name, f32::NAN, "value NaN, but must be finite"),
        (name, f32::INFINITY, "value inf, but must be finite"),
        ("dres1.0.1.running_var", -0.5, "value -0.5, but must be 0 or more"),
    ] {
        fails(&|tensors| drop(tensors.insert(name.into(), odd(name, value))), &[name, wanted]);
    }
    assert!(Tensor::new(vec![2, 3], vec![0.0; 5]).is_err());
    assert!(Tensor::new(vec![usize::MAX, 2], vec![]).is_err());
}
