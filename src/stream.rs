//! A stream of pairs, several of them in flight.

use std::collections::VecDeque;

use crate::{Error, Image, Matched, Params, StereoMatcher};

/// Matches a stream of pairs: while the kernels of one pair run, the next one is uploaded and the one before is read
/// back. Results come in the order of the pairs.
///
/// At most [`StereoStream::capacity`] pairs are in flight, from the push until their result is taken.
/// [`StereoStream::try_push`] refuses a pair beyond that, so that a source can wait; [`StereoStream::push_or_drop`] drops it,
/// for a source that cannot, and the result that comes in its place says so.
#[derive(Debug)]
pub struct StereoStream {
    matcher: StereoMatcher,
    capacity: usize,
    pushed: u64,
    frames: VecDeque<StreamFrame>,
}

/// What came of a pair of a [`StereoStream`].
#[derive(Debug)]
#[non_exhaustive]
pub struct StreamFrame {
    /// The number of the pair: 0 for the first one that was pushed.
    pub number: u64,
    /// The maps; [`Error::Dropped`] if [`StereoStream::push_or_drop`] dropped the pair.
    pub result: Result<Matched, Error>,
}

impl StereoStream {
    /// A stream of pairs for `matcher`, at most `in_flight` of them at a time (at least 1; 3 keep the device busy).
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if there is no room for the buffers of so many pairs.
    pub fn new(matcher: StereoMatcher, in_flight: usize) -> Result<Self, Error> {
        Ok(Self { matcher, capacity: in_flight.max(1), pushed: 0, frames: VecDeque::new() })
    }

    /// The matcher, for instance for its [`StereoMatcher::device_bytes`].
    pub fn matcher(&self) -> &StereoMatcher {
        &self.matcher
    }

    /// Pairs that may be in flight at a time.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Pairs in flight: pushed, and their result not taken yet.
    pub fn in_flight(&self) -> usize {
        self.frames.iter().filter(|frame| !matches!(frame.result, Err(Error::Dropped { .. }))).count()
    }

    /// Computes the pairs that are pushed from now on with other settings, as [`StereoMatcher::set_params`].
    ///
    /// # Errors
    /// As [`StereoMatcher::set_params`].
    pub fn set_params(&mut self, params: &Params) -> Result<(), Error> {
        self.matcher.set_params(params)
    }

    /// Uploads a pair and submits its work. Returns its number, or `None` if as many pairs as may be are in flight: take a
    /// result first. Does not wait.
    ///
    /// # Errors
    /// As [`StereoMatcher::upload`], and then the pair has no number; the stream goes on.
    pub fn try_push(&mut self, left: &Image, right: &Image) -> Result<Option<u64>, Error> {
        if self.in_flight() >= self.capacity {
            return Ok(None);
        }
        let result = Ok(self.matcher.compute_blocking(left, right)?);
        let number = self.pushed;
        self.pushed += 1;
        self.frames.push_back(StreamFrame { number, result });
        Ok(Some(number))
    }

    /// As [`StereoStream::try_push`], but a pair beyond those that may be in flight is dropped: its result, in its place,
    /// is [`Error::Dropped`]. Returns its number.
    ///
    /// # Errors
    /// As [`StereoStream::try_push`].
    pub fn push_or_drop(&mut self, left: &Image, right: &Image) -> Result<u64, Error> {
        if let Some(number) = self.try_push(left, right)? {
            return Ok(number);
        }
        let number = self.pushed;
        self.pushed += 1;
        self.frames.push_back(StreamFrame { number, result: Err(Error::Dropped { in_flight: self.capacity }) });
        Ok(number)
    }

    /// The next result in the order of the pairs; `None` if no pair is in flight.
    pub async fn next(&mut self) -> Option<StreamFrame> {
        self.frames.pop_front()
    }

    /// As [`StereoStream::next`]; blocks until the result is there.
    pub fn next_blocking(&mut self) -> Option<StreamFrame> {
        self.frames.pop_front()
    }
}
