use crate::reference::{BlockStatistics, Content, Descriptors, Images, Messages, Plane, Values, Views, Volume};
use crate::{ConfidenceMap, DepthMap, DisparityMap, Image, Pixels, StageTime};
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
use std::time::Instant;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
use web_time::Instant;

/// Receives each result: the name of its stage and its bytes.
pub(super) type Receiver<'a> = &'a mut dyn FnMut(&str, &[u8]);

/// Follows the chain from stage to stage: measures the times, and passes the results on to a receiver, if there is one.
pub(super) struct Trace<'a> {
    last: Instant,
    receiver: Option<Receiver<'a>>,
    pub(super) times: Vec<StageTime>,
}

impl<'a> Trace<'a> {
    pub(super) fn new(receiver: Option<Receiver<'a>>) -> Self {
        Self { last: Instant::now(), receiver, times: Vec::new() }
    }

    /// A stage has computed `result` since the stage before.
    pub(super) fn stage<T: Bytes>(&mut self, name: &str, result: T) -> T {
        let ms = self.last.elapsed().as_secs_f64() * 1e3;
        match self.times.iter_mut().find(|time| time.name == name) {
            Some(time) => time.ms += ms,
            None => self.times.push(StageTime { name: name.into(), ms }),
        }
        self.show(name, || &result);
        self.last = Instant::now();
        result
    }

    /// Passes on a result that is part of another stage here and has no time of its own. It is computed only if there is a
    /// receiver.
    pub(super) fn show<T: Bytes>(&mut self, name: &str, result: impl FnOnce() -> T) {
        if let Some(receiver) = &mut self.receiver {
            let mut bytes = Vec::new();
            result().append_to(&mut bytes);
            receiver(name, &bytes);
        }
    }
}

/// A result as bytes: its numbers in the order in which they are stored, each in little-endian order, without padding; a flag
/// is 1 or 0. Several parts follow one another, the left side first.
pub(super) trait Bytes {
    /// Appends the bytes.
    fn append_to(&self, bytes: &mut Vec<u8>);
}

/// Single numbers.
macro_rules! numbers {
    ($($number:ty)+) => {$(
        impl Bytes for $number {
            fn append_to(&self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }
        }
    )+};
}

numbers! { u8 u16 u32 u64 i16 f64 }

impl Bytes for bool {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        u8::from(*self).append_to(bytes);
    }
}

impl<T: Bytes> Bytes for Option<T> {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|part| part.append_to(bytes));
    }
}

impl<T: Bytes> Bytes for Vec<T> {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|part| part.append_to(bytes));
    }
}

impl<T: Bytes, const N: usize> Bytes for [T; N] {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|part| part.append_to(bytes));
    }
}

impl<T: Bytes> Bytes for &T {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        T::append_to(self, bytes);
    }
}

impl<A: Bytes, B: Bytes> Bytes for (A, B) {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.0.append_to(bytes);
        self.1.append_to(bytes);
    }
}

/// Types by the fields that hold their numbers.
macro_rules! fields {
    ($([$($number:ident)?] $kind:ty: $($field:ident)+;)+) => {$(
        impl$(<$number: Bytes>)? Bytes for $kind {
            fn append_to(&self, bytes: &mut Vec<u8>) {
                $(self.$field.append_to(bytes);)+
            }
        }
    )+};
}

fields! {
    [T] Plane<T>: data;
    [T] Volume<T>: data;
    [] Images: channels;
    [] Descriptors: data;
    [] BlockStatistics: data;
    [] Content: sides;
    [] DisparityMap: data;
    [] ConfidenceMap: data;
    [] DepthMap: data;
    [] Messages: received;
    [] Values: data;
    [] Views: left right margins;
}

impl Bytes for Image {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        match self.pixels() {
            Pixels::Gray8(samples) | Pixels::Rgba8(samples) => samples.append_to(bytes),
            Pixels::Gray16(samples) | Pixels::Rgba16(samples) => samples.append_to(bytes),
        }
    }
}
