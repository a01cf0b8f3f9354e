//! Settings, cameras and rectifications by serde: in JSON as people write it, and in CBOR, which is not text.

use std::fmt::Debug;

use crate::support;
use gpu_stereo::{
    Camera, Distortion, Lens, Masks, Params, Preset, Rectification, RightView, Schedule, Subpixel, Wls, reference,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;

/// A value that is written and read in both formats. serde_json reads numbers of more than 15 digits to the last bit with a feature of
/// its own only, so there are none here; CBOR holds every bit.
fn again<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + Debug>(value: &T, case: &dyn Debug) {
    let json = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&json).unwrap(), value, "{json}, {case:?}");
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).unwrap();
    assert_eq!(&ciborium::from_reader::<T, _>(bytes.as_slice()).unwrap(), value, "{case:?}");
}

/// A number in 1/1024.
fn short(number: f64) -> f64 {
    (number * 1024.0).round() / 1024.0
}

/// Lenses of numbers of few digits.
fn short_lenses() -> [Lens; 2] {
    support::lenses(40, 30).map(|lens| {
        Lens::new(lens.matrix.map(short), lens.distortion, lens.rotation.map(short), lens.projection.map(short))
    })
}

fn rectification() -> Rectification {
    Rectification::new(40, 30, short_lenses()).unwrap()
}

#[test]
fn all_settings_are_read_as_they_were_written() {
    for seed in 0..200 {
        let mut params = support::random_params(&mut ChaCha8Rng::seed_from_u64(seed));
        (params.masks, params.network) = (None, None);
        params.labels = seed % 3 == 0;
        params.rectify = (seed % 5 == 0).then(rectification);
        params.depth = params.depth.map(|camera| camera.with_doffs(short(camera.doffs)));
        params.validate().unwrap();
        again(&params, &format!("seed {seed}"));
    }
    let mut changed = Params::preset(Preset::Dense, 96);
    changed.wls = Some(Wls::new(1234.567, 0.1));
    (changed.confidence, changed.unrounded, changed.right_map) = (true, true, true);
    changed.depth = Some(Camera::new(994.978, 0.193_001).with_doffs(-3.1).with_principal_point(0.1, 1e-9));
    again(&changed, &"all that is beside the options");
}

/// The names and values of the command, and nothing else.
#[test]
fn the_names_are_those_of_the_options() {
    let params = Params::preset(Preset::Strict, 64);
    let serde_json::Value::Object(map) = serde_json::to_value(&params).unwrap() else { panic!("no map") };
    for option in Params::OPTIONS {
        assert_eq!(map[option.name], json!(option.get(&params)), "{}", option.name);
    }
    let beside: Vec<_> = map.keys().filter(|key| Params::OPTIONS.iter().all(|option| option.name != **key)).collect();
    assert_eq!(beside, ["confidence", "labels", "unrounded", "right-map"]);

    // As people write it: numbers are numbers, what is missing is as usual.
    let written = json!({
        "disp": 64, "preset": "strict", "p2": "80", "paths": 8, "wls": true, "wls-sigma": 2.5, "lr-check": "off",
        "subpixel": "on", "confidence": true, "depth": {"focal": 700, "baseline": 0.12},
    });
    let options =
        [("preset", "strict"), ("p2", "80"), ("paths", "8"), ("wls", "on"), ("wls-sigma", "2.5"), ("lr-check", "off")];
    let mut expected = Params::from_options(64, options).unwrap();
    (expected.subpixel, expected.confidence) = (Subpixel::Parabola, true);
    expected.depth = Some(Camera::new(700.0, 0.12));
    assert_eq!(serde_json::from_value::<Params>(written).unwrap(), expected);
    assert_eq!(serde_json::from_value::<Params>(json!({"disp": 64})).unwrap(), Params::default_for(64));
}

/// What is no setting is refused with the text that the library has for it.
#[test]
fn wrong_settings_are_refused_in_the_words_of_the_library() {
    let text = |value: serde_json::Value| {
        let error = serde_json::from_value::<Params>(value).unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error:?}");
        error
    };
    let of_options = |disp: u32, options: &[(&str, &str)]| {
        Params::from_options(disp, options.iter().copied()).unwrap_err().to_string()
    };
    for (json, disp, options) in [
        (json!({"disp": 64, "p2": 128}), 64, &[("p2", "128")] as &[(&str, &str)]),
        (json!({"disp": 64, "p2": -1}), 64, &[("p2", "-1")]),
        (json!({"disp": 64, "p2": 12.5}), 64, &[("p2", "12.5")]),
        (json!({"disp": 64, "p2": "many"}), 64, &[("p2", "many")]),
        (json!({"disp": 64, "p2": u64::MAX}), 64, &[("p2", "18446744073709551615")]),
        (json!({"disp": 64, "cost": "sadd"}), 64, &[("cost", "sadd")]),
        (json!({"disp": 64, "wls": "perhaps"}), 64, &[("wls", "perhaps")]),
        (json!({"disp": 64, "preset": "best"}), 64, &[("preset", "best")]),
        (json!({"disp": 64, "block": 4}), 64, &[("block", "4")]),
        (json!({"disp": 0}), 0, &[("disp", "0")]),
        (json!({"disp": 64, "blok": 4}), 64, &[("blok", "4")]),
        (json!({"disp": 64, "network": {"any": ["thing"]}}), 64, &[("network", "")]),
        (json!({"disp": 64, "masks": null}), 64, &[("masks", "")]),
        (json!({"disp": 64, "method": "sgm", "cost": "ncc"}), 64, &[("method", "sgm"), ("cost", "ncc")]),
    ] {
        assert_eq!(text(json.clone()), of_options(disp, options), "{json}");
    }
    let camera = Camera::new(-1.0, 0.1).validate().unwrap_err().to_string();
    assert_eq!(text(json!({"disp": 64, "depth": {"focal": -1, "baseline": 0.1}})), camera);
    for (wrong, parts) in [
        (json!({}), ["missing field", "disp"]),
        (json!({"disp": 64, "confidence": "yes"}), ["confidence is yes", "one of on, off"]),
        (json!({"disp": 64, "depth": {"focal": 1, "baseline": 1, "fov": 2}}), ["fov", "focal"]),
        (json!({"disp": [64]}), ["sequence", "text, a number, true or false"]),
        (json!({"disp": null}), ["null", "text, a number, true or false"]),
        (json!([64]), ["sequence", "options"]),
        (
            json!({"disp": 64, "method": "psmnet", "right-view": "match", "lr-check": "off", "confidence": "on"}),
            ["confidence is on", "off with method psmnet"],
        ),
    ] {
        let error = text(wrong);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    let twice = serde_json::from_str::<Params>(r#"{"disp": 64, "p2": 80, "p2": 90}"#).unwrap_err().to_string();
    assert!(twice.contains("p2 is given twice"), "{twice}");
}

/// Weights and masks are no settings that fit a file: they are not dropped in silence.
#[test]
fn what_cannot_be_written_is_an_error() {
    let mut params = Params::sgm(16);
    params.masks = Some(Masks::new(2, 1, [Some(vec![0, 1]), None]).unwrap());
    let error = serde_json::to_string(&params).unwrap_err().to_string();
    assert!(error.contains("Params::masks") && error.contains("take it out"), "{error}");
    params.masks = None;
    assert!(serde_json::to_string(&params).is_ok());
}

#[test]
fn values_of_settings_are_their_names() {
    assert_eq!(serde_json::to_value(RightView::Diagonal).unwrap(), json!("diagonal"));
    assert_eq!(serde_json::to_value(Schedule::PerSubgroup).unwrap(), json!("per-subgroup"));
    for (name, _) in Preset::NAMES {
        again(&name.parse::<Preset>().unwrap(), name);
    }
    let error = serde_json::from_str::<Preset>("\"best\"").unwrap_err().to_string();
    assert_eq!(error, "best".parse::<Preset>().unwrap_err().to_string());
}

/// A rectification that was read rectifies as the one that was written; turned ones, too.
#[test]
fn rectifications_do_the_same_again() {
    let lenses = short_lenses();
    let (left, _) = support::pair(40, 30, 5);
    for rectification in [
        rectification(),
        Rectification::of_size([40, 30], [33, 21], lenses).unwrap(),
        Rectification::vertical([40, 30], [33, 21], lenses).unwrap(),
        Rectification::turn([40, 30]).unwrap(),
    ] {
        again(&rectification, &"rectification");
        let json = serde_json::to_string(&rectification).unwrap();
        let copy: Rectification = serde_json::from_str(&json).unwrap();
        assert_eq!(
            (copy.rectified_size(), copy.is_turned()),
            (rectification.rectified_size(), rectification.is_turned())
        );
        let [first, second] =
            [&rectification, &copy].map(|rectification| reference::rectify(&left, rectification, 0).unwrap());
        assert!(first == second, "{json}");
    }
    for distortion in
        [Distortion::Fisheye([0.1, 0.2, 0.3, 0.4]), Distortion::DoubleSphere([0.1, 0.6]), Distortion::NONE]
    {
        again(&distortion, &"distortion");
    }
    let mut json = serde_json::to_value(rectification()).unwrap();
    json["size"] = json!([u32::MAX, u32::MAX]);
    let error = serde_json::from_value::<Rectification>(json.clone()).unwrap_err().to_string();
    assert!(error.contains("4294967295x4294967295") && error.contains("at most 268435456"), "{error}");
    (json["size"], json["rectified"]) = (json!([40, 0]), json!([40, 30]));
    assert!(serde_json::from_value::<Rectification>(json.clone()).unwrap_err().to_string().contains("40x0"));
    (json["size"], json["lenses"][0]["matrix"][0]) = (json!([40, 30]), json!(-5.0));
    let refused = Rectification::new(
        40,
        30,
        [
            Lens::new(
                [-5.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0],
                Distortion::NONE,
                lenses[0].rotation,
                lenses[0].projection,
            ),
            lenses[1],
        ],
    );
    assert_eq!(
        serde_json::from_value::<Rectification>(json).unwrap_err().to_string(),
        refused.unwrap_err().to_string()
    );
}
