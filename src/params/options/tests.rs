use super::*;
use crate::params::Filter;
use crate::params::names::Named;
use crate::params::{Cost, Median, Prefilter, RightView, Wls};

const PRESETS: &[Preset] = <Preset as Named>::VALUES;

/// Values of an option: its words, or numbers at both ends of what it may hold.
fn values(option: &ParamOption) -> Vec<&'static str> {
    let words = option.values.iter().map(|(name, _)| *name);
    let numbers: &[&str] = match option.name {
        "min-disp" => &["-2047", "0", "12"],
        "wls-lambda" | "wls-sigma" => &["0.1", "8000", "off"],
        _ if !option.values.is_empty() => &[],
        _ if option.placeholder.ends_with("|off") => &["1", "15", "off"],
        _ => &["3", "51"],
    };
    words.chain(numbers.iter().copied()).collect()
}

#[test]
fn every_option_gives_back_what_it_was_set_to() {
    for option in Params::OPTIONS {
        let values = values(option);
        assert!(values.len() > 1 && !option.help.is_empty() && !option.heading.is_empty(), "{option:?}");
        let mut got = Vec::new();
        for value in &values {
            let before = Params::sgm(64);
            let mut params = before.clone();
            params.set(option.name, value).unwrap();
            assert_eq!(params.get(option.name).unwrap(), *value, "{}", option.name);
            let others = Params::OPTIONS.iter().filter(|other| !other.name.starts_with("wls"));
            for other in others.filter(|other| other.name != option.name) {
                assert_eq!(other.get(&params), other.get(&before), "{} changes {}", option.name, other.name);
            }
            got.push(params);
        }
        assert!(got.windows(2).all(|pair| pair[0] != pair[1]), "{} changes nothing", option.name);
    }
}

#[test]
fn all_that_an_option_holds_makes_the_same_parameters_again() {
    for &preset in PRESETS {
        let params = Params::preset(preset, 48);
        let told: Vec<_> = Params::OPTIONS.iter().map(|option| (option.name, option.get(&params))).collect();
        let told = || told.iter().map(|(name, value)| (*name, value.as_str()));
        let mut copy = Params::bm(1);
        told().for_each(|(name, value)| copy.set(name, value).unwrap());
        assert_eq!(copy, params);
        assert_eq!(Params::from_options(1, told()).unwrap(), params);
    }
}

#[test]
fn names_are_known_once() {
    for (i, option) in Params::OPTIONS.iter().enumerate() {
        assert!(Params::OPTIONS[..i].iter().all(|other| other.name != option.name), "{}", option.name);
        let words: Vec<_> = option.values.iter().map(|(name, _)| name).collect();
        assert!(words.iter().enumerate().all(|(i, word)| !words[..i].contains(word)), "{words:?}");
        assert!(!option.placeholder.is_empty(), "{}", option.name);
        for params in PRESETS.iter().map(|&preset| Params::preset(preset, 8)).chain([Params::bm(8)]) {
            assert_eq!((option.idle)(&params).is_some(), option.idle(&params).is_some(), "{}", option.name);
        }
    }
}

#[test]
fn what_is_no_value_is_refused_with_what_is_one() {
    for option in Params::OPTIONS {
        for value in ["", " ", "magic", "1 2", "٣", "0x10", "--1", "+", "\n"] {
            let mut params = Params::sgm(64);
            let error = params.set(option.name, value).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{} is ", option.name)) && error.contains("must be "), "{error}");
            assert!(option.values.iter().all(|(word, _)| error.contains(word)), "{error}");
            assert_eq!((error.lines().count(), &params), (1, &Params::sgm(64)), "{error}");
        }
    }
    let error = Params::sgm(64).set("frobnicate", "1").unwrap_err().to_string();
    assert!(error.contains("\"frobnicate\"") && error.contains("min-disp, "), "{error}");
}

/// A number that no type holds is never taken for another one that is allowed.
#[test]
fn numbers_beyond_every_type_are_refused_as_they_were_given() {
    let numbers = Params::OPTIONS.iter().filter(|option| option.values.is_empty());
    for option in numbers.filter(|option| !option.name.starts_with("wls")) {
        for value in ["99999999999999999999999", "-99999999999999999999999", "4294967296", "4294967295", "1e39", "nan"]
        {
            let error = Params::from_options(64, [(option.name, value)]).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{} is {value}, but must be ", option.name)), "{error}");
        }
    }
    for value in ["nan", "inf", "-inf", "-1", "1e99"] {
        for (name, allowed) in [("wls-lambda", "from 0 to 1000000"), ("wls-sigma", "from 0.1 to 1000")] {
            let error = Params::from_options(64, [(name, value)]).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{name} is {value}, but must be {allowed}")), "{error}");
        }
    }
}

#[test]
fn presets_are_valid_and_options_override_them_in_any_order() {
    let of = |options: &[(&'static str, &'static str)]| Params::from_options(64, options.iter().copied()).unwrap();
    for &preset in PRESETS {
        let name = preset.name();
        assert_eq!(of(&[("preset", name)]), Params::preset(preset, 64));
        let changed = Params { p2: 70, median: Median::Off, ..Params::preset(preset, 64) };
        let (p2, median) = (("p2", "70"), ("median", "off"));
        assert_eq!(of(&[("preset", name), p2, median]), changed);
        assert_eq!(of(&[median, p2, ("preset", name)]), changed);
        // Block matching has a cost and a block of its own, and the preset's filters.
        let (bm, plain) = (of(&[("method", "bm"), ("preset", name)]), Params::bm(64));
        assert_eq!((bm.method, bm.cost, bm.block, bm.uniqueness), (Method::Bm, Cost::Sad, 15, 15));
        assert_eq!((bm.prefilter, bm.fill), (plain.prefilter, changed.fill));
        assert_eq!(of(&[("block", "7"), ("method", "bm"), ("preset", name)]).block, 7);
    }
    assert_eq!(of(&[]), Params::preset(Preset::default(), 64));
    assert_eq!(of(&[("p2", "70"), ("p2", "80")]).p2, 80);
}

/// A network has no costs: no filter unless a preset or an option asks for one, and the right view by a second run.
#[test]
fn a_network_takes_the_filters_that_are_asked_for() {
    let of = |options: &[(&'static str, &'static str)]| {
        let options = options.iter().copied().chain([("method", "psmnet")]);
        Params::from_options(192, options)
    };
    let alone = of(&[]).unwrap();
    assert!(Filter::ALL.iter().all(|filter| !filter.wanted(&alone)));
    assert!((alone.network.is_none(), alone.align_corners) == (true, true));
    let Err(Error::Network(text)) = alone.validate() else { panic!("without a network") };
    assert!(text.contains("--weights"), "{text}");
    let checked = of(&[("lr-check", "1"), ("fill", "rays")]).unwrap();
    assert_eq!((checked.lr_check, checked.right_view, checked.median), (Some(1), RightView::Match, Median::Off));
    let dense = of(&[("preset", "dense"), ("median", "off")]).unwrap();
    let preset = Params::preset(Preset::Dense, 192);
    assert_eq!(dense, Params { method: Method::Psmnet, median: Median::Off, ..preset });
    assert_eq!(of(&[("preset", "balanced")]).unwrap().right_view, RightView::Match);
    for (name, value, allowed) in [
        ("disp", "100", "a multiple of 16 up to 512"),
        ("disp", "528", "a multiple of 16 up to 512"),
        ("min-disp", "-16", "0 with method psmnet"),
    ] {
        let error = of(&[(name, value)]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{name} is {value}, but must be {allowed}")), "{error}");
    }
    let error = of(&[("lr-check", "1"), ("right-view", "diagonal")]).unwrap_err().to_string();
    assert!(error.starts_with("right-view is diagonal, but must be match"), "{error}");
    let confident = Params { confidence: true, ..alone.clone() };
    let error = confident.validate().unwrap_err().to_string();
    assert!(error.starts_with("confidence is on, but must be off with method psmnet"), "{error}");
    let idle = |name: &str| find(name).unwrap().idle(&alone).map(|other| other.name);
    for name in ["cost", "block", "prefilter", "prefilter-cap", "uniqueness", "subpixel", "paths", "p2"] {
        assert_eq!(idle(name), Some("method"), "{name}");
    }
    for name in ["align-corners", "median", "lr-check", "texture", "disp"] {
        assert_eq!(idle(name), None, "{name}");
    }
    assert_eq!(find("align-corners").unwrap().idle(&Params::sgm(64)).map(|other| other.name), Some("method"));
    assert_eq!(find("block").unwrap().idle(&Params { texture: 9, ..alone.clone() }).map(|other| other.name), None);
}

/// The smoothness counts for belief propagation, and for the energy of the labels of every method that has costs.
#[test]
fn the_smoothness_is_idle_where_no_energy_is_told() {
    let idle = |params: &Params| {
        let names = ["smoothness", "smoothness-weight", "smoothness-truncation", "smoothness-edge"];
        let idle = names.map(|name| find(name).unwrap().idle(params).map(|other| other.name));
        assert!(idle.iter().all(|other| *other == idle[0]), "{idle:?}");
        idle[0]
    };
    let labelled = |params: &Params| Params { labels: true, ..params.clone() };
    for params in [Params::sgm(16), Params::bm(16)] {
        assert_eq!((idle(&params), idle(&labelled(&params))), (Some("method"), None), "{params:?}");
        assert_eq!(find("bp-levels").unwrap().idle(&labelled(&params)).map(|other| other.name), Some("method"));
    }
    assert_eq!((idle(&Params::bp(16)), idle(&labelled(&Params::bp(16)))), (None, None));
    let network = Params { method: Method::Psmnet, ..Params::sgm(16) };
    assert_eq!(idle(&labelled(&network)), Some("method"));
}

#[test]
fn a_cost_brings_its_usual_prefilter_unless_another_is_given() {
    let of = |options: &[(&'static str, &'static str)]| Params::from_options(64, options.iter().copied()).unwrap();
    for &cost in Cost::VALUES {
        let method = if cost == Cost::Ncc { "bm" } else { "sgm" };
        for preset in ["classic", "balanced"] {
            let given = [("method", method), ("cost", cost.name()), ("preset", preset)];
            let usual = of(&given);
            assert_eq!((usual.cost, usual.method.name()), (cost, method));
            let sobel = of(&[&[("prefilter", "sobel"), ("block", "9")], &given[..]].concat());
            assert_eq!(sobel, Params { prefilter: Prefilter::Sobel, block: 9, ..usual });
        }
    }
    assert_eq!(of(&[("cost", "sad"), ("preset", "balanced")]).prefilter, Prefilter::XSobel);
    assert_eq!(of(&[("cost", "census"), ("preset", "classic")]).prefilter, Prefilter::None);
    // The preset's own cost stays as the preset has it.
    let balanced = Params::preset(Preset::Balanced, 64);
    assert_eq!(of(&[("cost", "census-sobel"), ("preset", "balanced")]), balanced);
}

#[test]
fn the_numbers_of_wls_switch_it_on_and_off_has_the_last_word() {
    let of = |options: &[(&'static str, &'static str)]| Params::from_options(64, options.iter().copied()).unwrap();
    let wls = Wls { lambda: 500.0, ..Wls::default() };
    assert_eq!(of(&[("wls-lambda", "500")]).wls, Some(wls));
    assert_eq!(of(&[("wls-lambda", "5e2"), ("wls", "on")]).wls, Some(wls));
    assert_eq!(of(&[("wls", "on")]).wls, Some(Wls::default()));
    assert_eq!(of(&[("wls", "off"), ("wls-lambda", "500")]).wls, None);
}

#[test]
fn a_choice_is_read_from_its_name_and_another_word_is_an_error() {
    fn check<T: std::str::FromStr<Err = Error> + std::fmt::Display>(option: &str, names: &[(&str, &str)]) {
        for (name, _) in names {
            assert_eq!(name.parse::<T>().unwrap().to_string(), *name);
        }
        let error = "Nothing".parse::<T>().err().unwrap().to_string();
        assert!(error.starts_with(&format!("{option} is Nothing, but must be one of {}", names[0].0)), "{error}");
    }
    check::<crate::Method>("method", crate::Method::NAMES);
    check::<crate::Cost>("cost", crate::Cost::NAMES);
    check::<crate::Preset>("preset", crate::Preset::NAMES);
}

#[test]
fn a_setting_of_an_unknown_name_is_an_error_that_tells_the_names() {
    let error = Params::default_for(64).get("path").unwrap_err().to_string();
    assert!(error.starts_with("option is \"path\"") && error.contains("paths"), "{error}");
}
