//! The kinds of errors that a program can tell apart: one of each, made as a program meets it.

use std::collections::BTreeMap;

use crate::support;
use gpu_stereo::cpu::CpuMatcher;
use gpu_stereo::{Error, Image, Method, Params, PixelFormat, Pixels, StereoMatcher, StereoStream};

/// Those that need a driver with a fault, or a full device: the tests of src/gpu/scopes.rs make them from what a device reports.
const OF_A_DRIVER: [&str; 2] = ["OutOfMemory", "Refused"];

/// The variants as the source names them.
fn variants() -> Vec<String> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/error.rs")).unwrap();
    let file = syn::parse_file(&text).unwrap();
    let is_error = |item: &syn::Item| match item {
        syn::Item::Enum(item) if item.ident == "Error" => Some(item.variants.clone()),
        _ => None,
    };
    file.items.iter().find_map(is_error).unwrap().iter().map(|variant| variant.ident.to_string()).collect()
}

/// The name of a variant, as a program asks for it.
fn kind(error: &Error) -> &'static str {
    match error {
        Error::Parameter { .. } => "Parameter",
        Error::Image(_) => "Image",
        Error::Network(_) => "Network",
        Error::TooLarge { .. } => "TooLarge",
        Error::Memory { .. } => "Memory",
        Error::OutOfMemory => "OutOfMemory",
        Error::Device(_) => "Device",
        Error::Lost(_) => "Lost",
        Error::Refused(_) => "Refused",
        Error::Misuse(_) => "Misuse",
        Error::Dropped { .. } => "Dropped",
        Error::Adapter(_) => "Adapter",
        other => panic!("a kind that this test does not know: {other:?}"),
    }
}

/// Those that need no device.
fn without_a_device() -> Vec<(&'static str, Error)> {
    let mut psmnet = Params::sgm(64);
    (psmnet.method, psmnet.right_view) = (Method::Psmnet, gpu_stereo::RightView::Match);
    let huge = CpuMatcher::new(1 << 20, 1 << 20, PixelFormat::Gray8, &Params::sgm(256));
    vec![
        ("Parameter", Params::sgm(0).validate().unwrap_err()),
        ("Parameter", "sgmm".parse::<Method>().unwrap_err()),
        ("Parameter", Params::sgm(64).get("frobnicate").unwrap_err()),
        ("Image", Image::new(2, 2, Pixels::Gray8(vec![0; 3])).unwrap_err()),
        ("Network", psmnet.validate().unwrap_err()),
        ("Memory", huge.unwrap_err()),
    ]
}

/// Those of a device.
fn of_a_device(made: &mut Vec<(&'static str, Error)>) {
    let (left, right) = support::pair(20, 10, 0);
    let params = Params::sgm(16);
    let Some((_, device, queue)) = support::device() else { return };
    let matcher = StereoMatcher::new(&device, &queue, 20, 10, left.format(), &params).unwrap();
    made.push(("Misuse", matcher.read_blocking().unwrap_err()));
    made.push(("Image", matcher.compute_blocking(&left, &support::pair(21, 10, 0).1).unwrap_err()));

    let mut stream = StereoStream::new(matcher, 1).unwrap();
    for _ in 0..2 {
        stream.push_or_drop(&left, &right).unwrap();
    }
    let results: Vec<_> = std::iter::from_fn(|| stream.next_blocking()).map(|frame| frame.result).collect();
    assert_eq!((results.len(), results[0].is_ok()), (2, true), "{results:?}");
    made.extend(results.into_iter().filter_map(Result::err).map(|error| ("Dropped", error)));
    // The stream goes on.
    stream.push_or_drop(&left, &right).unwrap();
    assert!(stream.next_blocking().unwrap().result.is_ok());
    device.destroy();
    made.push(("Lost", stream.push_or_drop(&left, &right).unwrap_err()));

    let less = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 24 << 10);
    let Some((_, device, queue)) = less else { return };
    let large = StereoMatcher::new(&device, &queue, 200, 200, PixelFormat::Gray8, &Params::sgm(1));
    made.push(("TooLarge", large.unwrap_err()));
    let less = support::device_with(|_, limits| limits.max_compute_invocations_per_workgroup = 8);
    let Some((_, device, queue)) = less else { return };
    made.push(("Device", StereoMatcher::new(&device, &queue, 20, 10, left.format(), &params).unwrap_err()));
}

/// One of each variant, with its name, in one line, with a remedy; what failed left no trace.
#[test]
fn each_kind_of_error_can_be_told_apart() {
    let mut made = without_a_device();
    let before = made.len();
    of_a_device(&mut made);
    let mut times: BTreeMap<&str, usize> = BTreeMap::new();
    for (expected, error) in &made {
        let text = error.to_string();
        assert_eq!(kind(error), *expected, "{error:?}");
        assert!(!text.contains('\n') && text.contains("; "), "no remedy, or no line: {text:?}");
        *times.entry(expected).or_default() += 1;
    }
    if made.len() == before {
        return; // no adapter, which was said
    }
    let of_the_machine = "Adapter"; // made in a process of its own: tests/command, and src/backend/environment.rs
    for variant in variants() {
        let elsewhere = OF_A_DRIVER.contains(&variant.as_str()) || variant == of_the_machine;
        assert!(times.contains_key(variant.as_str()) != elsewhere, "{variant}: {times:?}");
    }
}
