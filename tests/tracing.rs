//! The spans of the feature `tracing`: `cargo test --features gpu-stereo/tracing --test tracing`. A test program of its own, since a
//! program has one subscriber.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use gpu_stereo::{Inputs, Outputs, Params, PixelFormat, StereoMatcher, StereoStream, wgpu};
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

/// What was entered and left since this was last emptied: `name{fields}`, and `-` when it is left.
static SEEN: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// The texts of spans, from the first one on.
static SPANS: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Watch(AtomicU64);

struct Fields(String);

impl Visit for Fields {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        self.0 += &format!(" {}={value:?}", field.name());
    }
}

impl Subscriber for Watch {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target() == "gpu_stereo"
    }

    fn new_span(&self, span: &Attributes<'_>) -> Id {
        let mut fields = Fields(span.metadata().name().into());
        span.record(&mut fields);
        SPANS.lock().unwrap().push(fields.0);
        Id::from_u64(self.0.fetch_add(1, Ordering::Relaxed) + 1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, _: &Event<'_>) {}

    fn enter(&self, id: &Id) {
        let text = SPANS.lock().unwrap()[id.into_u64() as usize - 1].clone();
        SEEN.lock().unwrap().push(text);
    }

    fn exit(&self, _: &Id) {
        SEEN.lock().unwrap().push("-".into());
    }
}

/// What was seen since the last call.
fn seen() -> Vec<String> {
    let seen = std::mem::take(&mut *SEEN.lock().unwrap());
    let left = seen.iter().filter(|text| *text == "-").count();
    assert_eq!(2 * left, seen.len(), "not all spans were left: {seen:?}");
    seen.into_iter().filter(|text| text != "-").collect()
}

#[test]
fn spans_are_around_what_a_matcher_does() {
    tracing::subscriber::set_global_default(Watch(AtomicU64::new(0))).unwrap();
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(40, 20, 1);
    let mut matcher = StereoMatcher::new(&device, &queue, 40, 20, PixelFormat::Gray8, &Params::sgm(16)).unwrap();
    assert_eq!(seen(), ["new width=40 height=20 disparities=16", "build levels=1"]);
    matcher.resize(30, 20).unwrap();
    assert_eq!(seen(), ["rebuild width=30 height=20 disparities=16", "build levels=1"]);
    matcher.set_params(&Params::bm(8)).unwrap();
    assert_eq!(seen()[0], "rebuild width=30 height=20 disparities=8");
    matcher.resize(40, 20).unwrap();
    seen();

    matcher.upload(&left, &right).unwrap();
    assert_eq!(seen(), ["upload"]);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
    queue.submit([encoder.finish()]);
    let recorded = seen();
    assert_eq!(recorded[0], "record");
    assert!(recorded.len() > 1 && recorded[1].starts_with("pass stage=\"gray\" dispatches="), "{recorded:?}");
    matcher.read_blocking().unwrap();
    assert_eq!(seen(), ["submit", "wait"]);
    matcher.compute_blocking(&left, &right).unwrap();
    let computed = seen();
    assert_eq!(computed[..2], ["compute", "submit"]);
    assert!(computed[2].starts_with("pass ") && computed[computed.len() - 1] == "wait", "{computed:?}");
    let mut stream = StereoStream::new(matcher, 2).unwrap();
    stream.try_push(&left, &right).unwrap().unwrap();
    stream.next_blocking().unwrap().result.unwrap();
    assert!(seen().iter().any(|text| text == "submit"));
}
