//! A stream of pairs, several of them in flight.

use std::collections::VecDeque;

use crate::gpu::matcher::Stamps;
use crate::gpu::readback::{self, Mapping};
use crate::gpu::scopes;
use crate::{Error, ImageView, Inputs, Matched, Outputs, Params, Reading, StereoMatcher};

/// Matches a stream of pairs: while the kernels of one pair run, the next one is uploaded and the one before is read
/// back. Results come in the order of the pairs, which are the host's ([`StereoStream::try_push`]) or in the caller's textures and
/// buffers ([`StereoStream::try_push_inputs`]).
///
/// At most [`StereoStream::capacity`] pairs are in flight, from the push until their result is taken.
/// [`StereoStream::try_push`] refuses a pair beyond that, so that a source can wait; [`StereoStream::push_or_drop`] drops it,
/// for a source that cannot; its result is then [`Error::Dropped`].
#[derive(Debug)]
pub struct StereoStream {
    matcher: StereoMatcher,
    capacity: usize,
    pushed: u64,
    frames: VecDeque<InFlight>,
    /// Of `frames`, those that were dropped.
    dropped: usize,
    /// Mapped buffers, each with room for the largest pair.
    uploads: Vec<wgpu::Buffer>,
}

/// A pair whose result was not taken yet.
#[derive(Debug)]
struct InFlight {
    number: u64,
    reading: Reading,
    /// The buffer that the pair was uploaded from, until the host has it again.
    upload: Option<(wgpu::Buffer, Mapping)>,
}

/// The result of a pair of a [`StereoStream`].
#[derive(Debug)]
#[non_exhaustive]
pub struct StreamFrame {
    /// The number of the pair: 0 for the first one that was pushed.
    pub number: u64,
    /// The maps; [`Error::Dropped`] if [`StereoStream::push_or_drop`] dropped the pair.
    pub result: Result<Matched, Error>,
}

impl StereoStream {
    /// A stream of pairs for `matcher`, at most `in_flight` of them at a time (at least 1; 3 keep the device busy). In a
    /// browser only [`StereoStream::new_async`] can return the errors that the device reports.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if there is no room for the buffers of so many pairs; [`Error::Lost`] if the device is lost;
    /// [`Error::Memory`] as [`StereoMatcher::new`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(matcher: StereoMatcher, in_flight: usize) -> Result<Self, Error> {
        let (stream, verdict) = Self::begin(matcher, in_flight)?;
        stream.matcher.settled(verdict.now())?;
        Ok(stream)
    }

    /// As [`StereoStream::new`], and awaits the errors that the device reports, without blocking: in a browser they arrive later.
    ///
    /// # Errors
    /// As [`StereoStream::new`].
    pub async fn new_async(matcher: StereoMatcher, in_flight: usize) -> Result<Self, Error> {
        let (stream, verdict) = Self::begin(matcher, in_flight)?;
        stream.matcher.settled(verdict.await)?;
        Ok(stream)
    }

    fn begin(matcher: StereoMatcher, in_flight: usize) -> Result<(Self, scopes::Verdict), Error> {
        matcher.pulse.check()?;
        let capacity = in_flight.max(1);
        matcher.ensure_frames(capacity as u64)?;
        let (uploads, verdict) = scopes::watched(&matcher.device, || {
            matcher.reserve_readbacks(capacity);
            (0..capacity).map(|_| upload_buffer(&matcher)).collect()
        });
        Ok((Self { matcher, capacity, pushed: 0, frames: VecDeque::new(), dropped: 0, uploads }, verdict))
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
        self.frames.len() - self.dropped
    }

    /// Takes pairs of another size from now on, as [`StereoMatcher::resize`]. Those in flight are not touched.
    ///
    /// # Errors
    /// As [`StereoMatcher::resize`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), Error> {
        self.matcher.resize(width, height)
    }

    /// As [`StereoStream::resize`]: [`StereoMatcher::resize_async`].
    ///
    /// # Errors
    /// As [`StereoMatcher::resize`].
    pub async fn resize_async(&mut self, width: u32, height: u32) -> Result<(), Error> {
        self.matcher.resize_async(width, height).await
    }

    /// Computes the pairs that are pushed from now on with other settings, as [`StereoMatcher::set_params`]. Those in flight
    /// are not touched.
    ///
    /// # Errors
    /// As [`StereoMatcher::set_params`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn set_params(&mut self, params: &Params) -> Result<(), Error> {
        self.matcher.set_params(params)
    }

    /// As [`StereoStream::set_params`]: [`StereoMatcher::set_params_async`].
    ///
    /// # Errors
    /// As [`StereoMatcher::set_params`].
    pub async fn set_params_async(&mut self, params: &Params) -> Result<(), Error> {
        self.matcher.set_params_async(params).await
    }

    /// Uploads a pair and submits its work. Returns its number, or `None` if as many pairs as may be are in flight: take a
    /// result first. Does not wait.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`], and then the pair has no number; the stream goes on.
    pub fn try_push<'a>(
        &mut self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Option<u64>, Error> {
        let (left, right) = (left.into(), right.into());
        self.matcher.accepts(left, right)?;
        if self.in_flight() >= self.capacity {
            return Ok(None);
        }
        let (reading, upload) = self.send(left, right)?;
        Ok(Some(self.number(reading, Some(upload))))
    }

    /// As [`StereoStream::try_push`], of a pair in the caller's textures or buffers, or one that was uploaded with
    /// [`StereoMatcher::upload`]; the result comes to the host all the same, and `outputs` names where it is left besides. Nothing is
    /// copied: the work is submitted, so what is submitted later may overwrite the pair and the outputs.
    ///
    /// ```no_run
    /// # use gpu_stereo::{Error, Inputs, Outputs, StereoStream, wgpu};
    /// /// Each pair from the textures of a decoder that has written them.
    /// fn frame(stream: &mut StereoStream, [left, right]: [&wgpu::Texture; 2]) -> Result<(), Error> {
    ///     while stream.try_push_inputs(&Inputs::textures(left, right), &Outputs::default())?.is_none() {
    ///         if let Some(frame) = stream.next_blocking() {
    ///             println!("pair {}: {:?}", frame.number, frame.result?.map.get(0, 0));
    ///         }
    ///     }
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// As [`StereoMatcher::record`], and then the pair has no number; the stream goes on.
    pub fn try_push_inputs(&mut self, inputs: &Inputs<'_>, outputs: &Outputs<'_>) -> Result<Option<u64>, Error> {
        self.matcher.pulse.check()?;
        let frame = self.matcher.prepared(inputs, outputs, false)?;
        if self.in_flight() >= self.capacity {
            return Ok(None);
        }
        let reading = self.matcher.start(|encoder| {
            self.matcher.record_prepared(encoder, &frame, &mut Stamps::default());
            self.matcher.has_recorded(encoder, &frame);
        })?;
        Ok(Some(self.number(reading, None)))
    }

    /// As [`StereoStream::try_push_inputs`], but a pair beyond those that may be in flight is dropped, as by
    /// [`StereoStream::push_or_drop`]; its outputs keep what they hold.
    ///
    /// # Errors
    /// As [`StereoStream::try_push_inputs`].
    pub fn push_inputs_or_drop(&mut self, inputs: &Inputs<'_>, outputs: &Outputs<'_>) -> Result<u64, Error> {
        match self.try_push_inputs(inputs, outputs)? {
            Some(number) => Ok(number),
            None => Ok(self.drop_one()),
        }
    }

    /// The pair is dropped: its result says so.
    fn drop_one(&mut self) -> u64 {
        self.dropped += 1;
        self.number(Reading::failed(Error::Dropped { in_flight: self.capacity }), None)
    }

    fn number(&mut self, reading: Reading, upload: Option<(wgpu::Buffer, Mapping)>) -> u64 {
        let number = self.pushed;
        self.pushed += 1;
        self.frames.push_back(InFlight { number, reading, upload });
        number
    }

    /// Writes a pair into a buffer, and submits the work of its frame.
    fn send(&mut self, left: ImageView<'_>, right: ImageView<'_>) -> Result<(Reading, (wgpu::Buffer, Mapping)), Error> {
        let Self { matcher, uploads, .. } = self;
        let side = matcher.sizes.source;
        matcher.pulse.check()?;
        uploads.retain(|buffer| buffer.size() >= 2 * side);
        let upload = match uploads.pop() {
            Some(buffer) => buffer,
            None => scopes::guarded_or_left(&matcher.device, || upload_buffer(matcher))?,
        };
        for (image, at) in [(left, 0), (right, side)] {
            let pixels = u64::from(image.width()) * u64::from(image.height());
            let bytes = pixels * u64::from(image.format().bytes_per_pixel());
            let part = at..at + bytes.next_multiple_of(8);
            let mut view = readback::written(&upload, part).map_err(|error| matcher.pulse.cause(error))?;
            image.each_packed_row(|at, row| view.slice(at..at + row.len()).copy_from_slice(row));
        }
        let reading = matcher.start(|encoder| {
            upload.unmap();
            matcher.record_sources(encoder, &upload);
            matcher.record_chain(encoder);
        })?;
        let mapping = scopes::guarded_or_left(&matcher.device, || Mapping::new(&upload, wgpu::MapMode::Write))?;
        matcher.has_computed();
        Ok((reading, (upload, mapping)))
    }

    /// As [`StereoStream::try_push`], but a pair beyond those that may be in flight is dropped: its result, in its place,
    /// is [`Error::Dropped`]. Returns its number.
    ///
    /// # Errors
    /// As [`StereoStream::try_push`].
    pub fn push_or_drop<'a>(
        &mut self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<u64, Error> {
        match self.try_push(left, right)? {
            Some(number) => Ok(number),
            None => Ok(self.drop_one()),
        }
    }

    /// The next result in the order of the pairs; `None` if no pair is in flight. If the future is dropped before it is done,
    /// the result comes the next time.
    pub async fn next(&mut self) -> Option<StreamFrame> {
        let InFlight { reading, upload, .. } = self.frames.front_mut()?;
        if let Some((_, mapping)) = upload {
            let _ = self.matcher.waiter.until(&self.matcher.device, mapping).await; // `taken` looks what came of it
        }
        let result = reading.await;
        self.taken(result)
    }

    /// As [`StereoStream::next`]; blocks until the result is there.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn next_blocking(&mut self) -> Option<StreamFrame> {
        let InFlight { reading, upload, .. } = self.frames.front_mut()?;
        if let Some((_, mapping)) = upload {
            let _ = mapping.wait(&self.matcher.device); // as in `next`
        }
        let result = reading.take_blocking();
        self.taken(result)
    }

    /// The next result, if it is there already. Does not wait.
    pub fn try_next(&mut self) -> Option<StreamFrame> {
        let InFlight { reading, upload, .. } = self.frames.front_mut()?;
        if let Some((_, mapping)) = upload {
            let _ = mapping.now(&self.matcher.device)?; // as in `next`
        }
        let result = reading.try_take()?;
        self.taken(result)
    }

    /// The first frame has this result.
    fn taken(&mut self, result: Result<Matched, Error>) -> Option<StreamFrame> {
        let InFlight { number, upload, .. } = self.frames.pop_front()?;
        if matches!(result, Err(Error::Dropped { .. })) {
            self.dropped -= 1;
        }
        if let Some((buffer, mapping)) = upload
            && matches!(mapping.now(&self.matcher.device), Some(Ok(())))
        {
            self.uploads.push(buffer);
        }
        Some(StreamFrame { number, result })
    }
}

/// A buffer that the host writes the largest pair into, mapped.
fn upload_buffer(matcher: &StereoMatcher) -> wgpu::Buffer {
    matcher.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("gpu-stereo.upload"),
        size: 2 * matcher.largest_source(),
        usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    })
}
