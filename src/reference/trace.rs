//! Follows the chain: times, and the results of stages as bytes.

use crate::reference::{
    BlockStatistics, Content, Descriptors, FeatureStatistics, Images, Messages, Plane, Values, Views, Volume,
};
use crate::{ConfidenceMap, DepthMap, DisparityMap, Image, Labels, Matched, Pixels, StageTime};
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
use std::time::Instant;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
use web_time::Instant;

/// Receives each result with the name of its stage.
pub(crate) type Receiver<'a> = &'a mut dyn FnMut(&str, &dyn Bytes);

/// Numbers of one kind that follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// How many.
    pub(crate) count: usize,
    /// Bytes of a number.
    pub(crate) bytes: usize,
    /// Whether a number may be negative.
    pub(crate) signed: bool,
    /// Pixels a row; 0 if the numbers are not those of pixels.
    pub(crate) width: usize,
    /// Numbers a pixel.
    pub(crate) depth: usize,
}

/// Appends the parts of `inner`, whose numbers are those of rows of `width` pixels.
fn append_rows(inner: &dyn Bytes, width: usize, depth: usize, parts: &mut Vec<Part>) {
    let first = parts.len();
    inner.append_parts(parts);
    parts[first..].iter_mut().for_each(|part| (part.width, part.depth) = (width, depth));
}

/// Follows the chain from stage to stage: measures the times, and passes the results on to a receiver, if there is one.
pub(crate) struct Trace<'a> {
    last: Instant,
    receiver: Option<Receiver<'a>>,
    pub(super) times: Vec<StageTime>,
}

impl<'a> Trace<'a> {
    pub(super) fn new(receiver: Option<Receiver<'a>>) -> Self {
        Self { last: Instant::now(), receiver, times: Vec::new() }
    }

    /// A stage has computed `result` since the stage before.
    pub(crate) fn stage<T: Bytes>(&mut self, name: &str, result: T) -> T {
        self.done(name, || &result);
        result
    }

    /// A stage is done since the stage before; `result` makes what it computed as the definition has it, where there is a
    /// receiver.
    pub(crate) fn done<T: Bytes>(&mut self, name: &str, result: impl FnOnce() -> T) {
        let ms = self.last.elapsed().as_secs_f64() * 1e3;
        match self.times.iter_mut().find(|time| time.name == name) {
            Some(time) => time.ms += ms,
            None => self.times.push(StageTime { name: name.into(), ms }),
        }
        self.show(name, result);
        self.last = Instant::now();
    }

    /// Whether there is a receiver.
    pub(crate) fn is_received(&self) -> bool {
        self.receiver.is_some()
    }

    /// Passes on a result that is part of another stage here and has no time of its own. It is computed only if there is a
    /// receiver.
    pub(crate) fn show<T: Bytes>(&mut self, name: &str, result: impl FnOnce() -> T) {
        if let Some(receiver) = &mut self.receiver {
            receiver(name, &result());
        }
    }
}

/// A result as bytes: its numbers in the order in which they are stored, each in little-endian order, without padding; a flag
/// is 1 or 0. Several parts follow one another, the left side first.
pub(crate) trait Bytes {
    /// Appends the bytes.
    fn append_to(&self, bytes: &mut Vec<u8>);

    /// Appends what the bytes are, part by part.
    fn append_parts(&self, parts: &mut Vec<Part>);

    /// As [`Bytes::append_parts`], of all in order.
    fn append_parts_of(all: &[Self], parts: &mut Vec<Part>)
    where
        Self: Sized,
    {
        all.iter().for_each(|each| each.append_parts(parts));
    }
}

/// Single numbers.
macro_rules! numbers {
    ($($number:ty: $signed:literal)+) => {$(
        impl Bytes for $number {
            fn append_to(&self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }

            fn append_parts(&self, parts: &mut Vec<Part>) {
                Self::append_parts_of(&[*self], parts);
            }

            fn append_parts_of(all: &[Self], parts: &mut Vec<Part>) {
                let (count, bytes) = (all.len(), size_of::<Self>());
                parts.push(Part { count, bytes, signed: $signed, width: 0, depth: 1 });
            }
        }
    )+};
}

numbers! { u8: false u16: false u32: false u64: false i16: true f64: true }

impl Bytes for bool {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        u8::from(*self).append_to(bytes);
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        u8::from(*self).append_parts(parts);
    }

    fn append_parts_of(all: &[Self], parts: &mut Vec<Part>) {
        parts.push(Part { count: all.len(), bytes: 1, signed: false, width: 0, depth: 1 });
    }
}

impl<T: Bytes> Bytes for Option<T> {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|part| part.append_to(bytes));
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        self.iter().for_each(|part| part.append_parts(parts));
    }
}

impl<T: Bytes> Bytes for Vec<T> {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|part| part.append_to(bytes));
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        T::append_parts_of(self, parts);
    }
}

impl<T: Bytes, const N: usize> Bytes for [T; N] {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|part| part.append_to(bytes));
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        T::append_parts_of(self, parts);
    }
}

impl<T: Bytes> Bytes for &T {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        T::append_to(self, bytes);
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        T::append_parts(self, parts);
    }
}

impl<A: Bytes, B: Bytes> Bytes for (A, B) {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        self.0.append_to(bytes);
        self.1.append_to(bytes);
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        self.0.append_parts(parts);
        self.1.append_parts(parts);
    }
}

/// Types by the fields that hold their numbers.
macro_rules! fields {
    ($([$($number:ident)?] $kind:ty: $($field:ident)+;)+) => {$(
        impl$(<$number: Bytes>)? Bytes for $kind {
            fn append_to(&self, bytes: &mut Vec<u8>) {
                $(self.$field.append_to(bytes);)+
            }

            fn append_parts(&self, parts: &mut Vec<Part>) {
                $(self.$field.append_parts(parts);)+
            }
        }
    )+};
}

fields! {
    [] Images: channels;
    [] BlockStatistics: data;
    [] Content: sides;
    [] FeatureStatistics: mean deviation;
    [] Messages: received;
    [] Values: data;
    [] Views: left right margins;
    [] Labels: data table;
    [] Matched: map right confidence labels depth;
}

/// Types with a number for each pixel, or several.
macro_rules! rows {
    ($([$($number:ident)?] $kind:ty: $depth:expr;)+) => {$(
        impl$(<$number: Bytes>)? Bytes for $kind {
            fn append_to(&self, bytes: &mut Vec<u8>) {
                self.data.append_to(bytes);
            }

            fn append_parts(&self, parts: &mut Vec<Part>) {
                let depth: fn(&Self) -> usize = $depth;
                append_rows(&self.data, self.width as usize, depth(self), parts);
            }
        }
    )+};
}

rows! {
    [T] Plane<T>: |_| 1;
    [T] Volume<T>: |it| it.disparities;
    [] Descriptors: |it| it.planes;
    [] DisparityMap: |_| 1;
    [] ConfidenceMap: |_| 1;
    [] DepthMap: |_| 1;
}

impl Bytes for Image {
    fn append_to(&self, bytes: &mut Vec<u8>) {
        match self.pixels() {
            Pixels::Gray8(samples) | Pixels::Rgba8(samples) => samples.append_to(bytes),
            Pixels::Gray16(samples) | Pixels::Rgba16(samples) => samples.append_to(bytes),
        }
    }

    fn append_parts(&self, parts: &mut Vec<Part>) {
        let samples = self.format().samples();
        match self.pixels() {
            Pixels::Gray8(data) | Pixels::Rgba8(data) => append_rows(data, self.width() as usize, samples, parts),
            Pixels::Gray16(data) | Pixels::Rgba16(data) => append_rows(data, self.width() as usize, samples, parts),
        }
    }
}
