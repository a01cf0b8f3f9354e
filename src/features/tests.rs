use super::*;
use crate::Error;

/// A network of the fewest features.
fn smallest() -> Layer {
    Layer {
        kind: LayerKind::Convolution,
        relu: false,
        inputs: 1,
        outputs: 8,
        weights: vec![1; 72],
        bias: vec![0; 8],
        multiplier: vec![1; 8],
        shift: vec![1; 8],
    }
}

fn point() -> Layer {
    Layer { kind: LayerKind::Point, inputs: 8, weights: vec![1; 64], ..smallest() }
}

#[test]
fn the_built_in_network_is_one() {
    let network = FeatureNetwork::built_in();
    assert_eq!((network.layers().len(), network.channels(), network.reach()), (9, 64, 5));
    assert_eq!(network.multiplications(), 19_264);
    assert_eq!(network, FeatureNetwork::new(network.layers().to_vec()).unwrap());
    assert!(network != FeatureNetwork::new(vec![smallest()]).unwrap());
}

/// What could overflow, or cannot be computed, is refused with the value, what is allowed and a remedy.
#[test]
fn what_might_overflow_is_refused() {
    type Change = fn(&mut Vec<Layer>);
    let cases: &[(Change, &str)] = &[
        (|layers| layers.clear(), "has 0 layers, but must have 1 to 16"),
        (|layers| *layers = vec![point(); 17], "has 17 layers"),
        (
            |layers| layers[0].kind = LayerKind::Point,
            "layer 0 of the network of features is point, but must be convolution",
        ),
        (|layers| layers[1].inputs = 12, "layer 1 of the network of features reads channels: 12, but must be 8"),
        (|layers| layers[1].outputs = 6, "makes channels: 6, but must be a multiple of 4 up to 128"),
        (|layers| layers[1].outputs = 132, "makes channels: 132"),
        (|layers| layers[1].outputs = 0, "makes channels: 0"),
        (|layers| (layers[1].kind, layers[1].outputs) = (LayerKind::Depthwise, 4), "makes channels: 4, but must be 8"),
        (|layers| layers[1].relu = true, "layer 1 of the network of features is relu, but must be linear"),
        (|layers| layers[1].weights.truncate(63), "has weights: 63, but must be 64"),
        (|layers| layers[0].bias.push(0), "has biases: 9, but must be 8"),
        (|layers| layers[0].multiplier.truncate(1), "has multipliers: 1, but must be 8"),
        (|layers| layers[0].shift.truncate(1), "has shifts: 1, but must be 8"),
        (|layers| layers[0].weights[3] = -128, "has a weight of -128, but must be -127 to 127"),
        (|layers| layers[0].multiplier[2] = 0, "has for output 2 a multiplier of 0, but must be 1 to 32767"),
        (|layers| layers[0].multiplier[2] = 32768, "a multiplier of 32768"),
        (|layers| layers[0].shift[7] = 31, "has for output 7 a shift of 31, but must be 1 to 30"),
        (|layers| layers[0].shift[7] = 0, "a shift of 0"),
        (|layers| layers[0].bias[1] = i32::MIN, "has for output 1 sums of up to 2147484791, but must be below 2^24"),
        (|layers| layers[0].bias[1] = (1 << 24) - 9 * 127, "sums of up to 16777216"),
        (
            |layers| (layers[1].bias[0], layers[1].multiplier[0]) = (70_000, 32_767),
            "has for output 0 products of sums and multiplier of up to 2326981273, but must be below 2^31",
        ),
        (
            |layers| {
                *layers = vec![Layer {
                    outputs: 4,
                    weights: vec![1; 36],
                    bias: vec![0; 4],
                    multiplier: vec![1; 4],
                    shift: vec![1; 4],
                    ..smallest()
                }]
            },
            "makes features: 4, but must be at least 8",
        ),
    ];
    for (change, text) in cases {
        let mut layers = vec![smallest(), point()];
        assert!(FeatureNetwork::new(layers.clone()).is_ok());
        change(&mut layers);
        let Err(Error::Network(error)) = FeatureNetwork::new(layers) else { panic!("accepted, but wanted: {text}") };
        assert!(error.contains(text) && error.contains("; ") && error.lines().count() == 1, "{error}\nwanted: {text}");
    }
    let mut layers = vec![smallest(), point()];
    layers[0].bias[1] = (1 << 24) - 9 * 127 - 1;
    assert!(FeatureNetwork::new(layers).is_ok());
}
