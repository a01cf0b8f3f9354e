//! A stream of pairs, several of them in flight.

use std::collections::VecDeque;

use crate::buffers::{TEXELS, TEXTURE_ROW};
use crate::readback::{self, Mapping};
use crate::{Error, Image, Matched, Params, Reading, StereoMatcher};

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
    frames: VecDeque<Frame>,
    /// Of `frames`, those that were dropped.
    dropped: usize,
    /// Mapped buffers, each with room for the largest pair.
    uploads: Vec<wgpu::Buffer>,
}

/// A pair whose result was not taken yet.
#[derive(Debug)]
struct Frame {
    number: u64,
    reading: Reading,
    /// The buffer that the pair was uploaded from, until the host has it again.
    upload: Option<(wgpu::Buffer, Mapping)>,
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
        let capacity = in_flight.max(1);
        let uploads = readback::guarded(&matcher.device, || (0..capacity).map(|_| upload_buffer(&matcher)).collect())?;
        matcher.reserve_readbacks(capacity)?;
        Ok(Self { matcher, capacity, pushed: 0, frames: VecDeque::new(), dropped: 0, uploads })
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
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), Error> {
        self.matcher.resize(width, height)
    }

    /// Computes the pairs that are pushed from now on with other settings, as [`StereoMatcher::set_params`]. Those in flight
    /// are not touched.
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
        self.matcher.accepts(left, right)?;
        if self.in_flight() >= self.capacity {
            return Ok(None);
        }
        let (reading, upload) = self.send(left, right)?;
        Ok(Some(self.number(reading, Some(upload))))
    }

    fn number(&mut self, reading: Reading, upload: Option<(wgpu::Buffer, Mapping)>) -> u64 {
        let number = self.pushed;
        self.pushed += 1;
        self.frames.push_back(Frame { number, reading, upload });
        number
    }

    /// Writes a pair into a buffer, and submits its way from there through the device.
    fn send(&mut self, left: &Image, right: &Image) -> Result<(Reading, (wgpu::Buffer, Mapping)), Error> {
        let Self { matcher, uploads, .. } = self;
        let side = matcher.sizes.source;
        uploads.retain(|buffer| buffer.size() >= 2 * side);
        let upload = match uploads.pop() {
            Some(buffer) => buffer,
            None => readback::guarded(&matcher.device, || upload_buffer(matcher))?,
        };
        let reading = readback::guarded(&matcher.device, || {
            for (image, at) in [(left, 0), (right, side)] {
                let pixels = image.bytes();
                let mut view = readback::written(&upload, at..at + pixels.len().next_multiple_of(8) as u64)?;
                view.slice(..pixels.len()).copy_from_slice(pixels);
            }
            upload.unmap();
            matcher.start(|encoder| {
                for (source, offset) in matcher.sources().iter().zip([0, side]) {
                    let bytes_per_row = Some(TEXTURE_ROW as u32);
                    let layout = wgpu::TexelCopyBufferLayout { offset, bytes_per_row, rows_per_image: None };
                    let from = wgpu::TexelCopyBufferInfo { buffer: &upload, layout };
                    let height = (side / TEXTURE_ROW) as u32;
                    let size = wgpu::Extent3d { width: TEXELS, height, depth_or_array_layers: 1 };
                    encoder.copy_buffer_to_texture(from, source.as_image_copy(), size);
                }
                matcher.record_chain(encoder);
            })
        })??;
        let mapping = Mapping::new(&matcher.device, &upload, wgpu::MapMode::Write)?;
        Ok((reading, (upload, mapping)))
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
        self.dropped += 1;
        Ok(self.number(Reading::failed(Error::Dropped { in_flight: self.capacity }), None))
    }

    /// The next result in the order of the pairs; `None` if no pair is in flight. If the future is dropped before it is done,
    /// the result comes the next time.
    pub async fn next(&mut self) -> Option<StreamFrame> {
        let Frame { reading, upload, .. } = self.frames.front_mut()?;
        if let Some((_, mapping)) = upload {
            let _ = self.matcher.waiter.until(&self.matcher.device, mapping).await; // `taken` looks what came of it
        }
        let result = reading.await;
        self.taken(result)
    }

    /// As [`StereoStream::next`]; blocks until the result is there.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn next_blocking(&mut self) -> Option<StreamFrame> {
        let Frame { reading, upload, .. } = self.frames.front_mut()?;
        if let Some((_, mapping)) = upload {
            let _ = mapping.wait(&self.matcher.device); // as in `next`
        }
        let result = reading.take_blocking();
        self.taken(result)
    }

    /// The next result, if it is there already. Does not wait.
    pub fn try_next(&mut self) -> Option<StreamFrame> {
        let Frame { reading, upload, .. } = self.frames.front_mut()?;
        if let Some((_, mapping)) = upload {
            let _ = mapping.now(&self.matcher.device)?; // as in `next`
        }
        let result = reading.try_take()?;
        self.taken(result)
    }

    /// The first frame has this result.
    fn taken(&mut self, result: Result<Matched, Error>) -> Option<StreamFrame> {
        let Frame { number, upload, .. } = self.frames.pop_front()?;
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
