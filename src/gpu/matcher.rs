//! The matcher: images in, maps out, on the caller's device.

use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::task::{Context, Poll, Waker};

use crate::gpu::chain::{Ends, chain};
use crate::gpu::device::Pulse;
use crate::gpu::interop::{Context as InteropContext, PassCache, Regions};
use crate::gpu::layout::{Frame, Sizes, source_layout};
use crate::gpu::readback;
use crate::gpu::readback::{Mapping, Waiter};
use crate::gpu::recording::{Builder, Level, Pool, Step, levels, record_steps, rooms};
use crate::gpu::scopes::{self, Verdict};
use crate::gpu::uploads::Uploads;
use crate::image::check_pair;
use crate::{
    ConfidenceMap, DepthMap, DisparityMap, Error, Image, Inputs, Matched, Outputs, Params, PixelFormat, StageTime,
    memory,
};

/// Matches pairs on the caller's device.
///
/// All buffers and kernels are made in [`StereoMatcher::new`]. [`StereoMatcher::record`] records the work of a frame into
/// the caller's encoder: it neither submits nor waits. [`StereoMatcher::read`] brings what was computed to the host, and
/// [`StereoMatcher::compute`] does all of it. What blocks says so in its name.
///
/// A matcher holds one frame at a time: two threads that use it at once overwrite each other's images. Make one each.
#[derive(Debug)]
pub struct StereoMatcher {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) pulse: Pulse,
    pub(crate) params: Params,
    pub(crate) format: PixelFormat,
    /// Columns and rows of the largest pair that all is made for.
    largest: [u32; 2],
    /// Bytes that are read back of such a pair.
    room: u64,
    pub(crate) sizes: Sizes,
    /// The passes through the chain; the last one has these settings and sizes.
    pub(crate) levels: Vec<Level>,
    pub(crate) steps: Vec<Step>,
    made: Ends,
    pool: Pool,
    /// Readback buffers that are not in use.
    spare: Arc<Mutex<Vec<wgpu::Buffer>>>,
    pub(crate) waiter: Arc<Waiter>,
    timer: OnceLock<Timer>,
    passes: PassCache,
    uploads: Uploads,
    /// Held by what was recorded into encoders of the caller's, until it is done or dropped.
    recorded: Arc<()>,
    /// Whether there may be a map of this size and these settings.
    computed: AtomicBool,
}

/// What follows from a size and settings.
struct Rebuilt {
    largest: [u32; 2],
    room: u64,
    levels: Vec<Level>,
    steps: Vec<Step>,
    made: Ends,
    pool: Pool,
    /// Readback buffers.
    spare: Vec<wgpu::Buffer>,
    /// Whether nothing of before is used, since it belongs to what was recorded.
    fresh: bool,
}

#[derive(Debug)]
struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
}

/// What is read back, in this order, and how it is laid out.
#[derive(Clone, Debug)]
struct Layout {
    frame: Frame,
    /// Bytes of a map.
    map: u64,
    /// Whether there is a right view.
    right: bool,
    /// Bytes of the confidence, if there is one.
    confidence: Option<u64>,
    /// Bytes of the depth, if there is one.
    depth: Option<u64>,
}

impl Layout {
    fn new(params: &Params, sizes: &Sizes) -> Self {
        let confidence = params.confidence.then_some(sizes.confidence);
        let depth = params.depth.is_some().then_some(sizes.regions);
        Self { frame: sizes.frame, map: sizes.map, right: params.right_map, confidence, depth }
    }

    fn bytes(&self) -> u64 {
        self.map + if self.right { self.map } else { 0 } + self.confidence.unwrap_or(0) + self.depth.unwrap_or(0)
    }

    fn matched(&self, bytes: &[u8]) -> Matched {
        let map = self.map as usize;
        let (left, rest) = bytes.split_at(map);
        let (right, rest) = rest.split_at(if self.right { map } else { 0 });
        let (confidence, depth) = rest.split_at(self.confidence.unwrap_or(0) as usize);
        Matched {
            map: map_of(&self.frame, left),
            right: self.right.then(|| map_of(&self.frame, right)),
            confidence: self.confidence.map(|_| confidence_of(&self.frame, confidence)),
            depth: self.depth.map(|_| depth_of(&self.frame, depth)),
        }
    }
}

/// A disparity map from the bytes of its buffer.
pub(crate) fn map_of(frame: &Frame, bytes: &[u8]) -> DisparityMap {
    let Frame { width, height, map_stride, .. } = *frame;
    let mut data = Vec::with_capacity(width as usize * height as usize);
    for row in bytes.chunks_exact(4 * map_stride as usize).take(height as usize) {
        data.extend(row[..2 * width as usize].chunks_exact(2).map(|v| i16::from_le_bytes([v[0], v[1]])));
    }
    DisparityMap { width, height, data }
}

/// A confidence from the bytes of its buffer.
pub(crate) fn confidence_of(frame: &Frame, bytes: &[u8]) -> ConfidenceMap {
    let Frame { width, height, map_stride, .. } = *frame;
    let rows = bytes.chunks_exact(2 * map_stride as usize).take(height as usize);
    ConfidenceMap { width, height, data: rows.flat_map(|row| &row[..width as usize]).copied().collect() }
}

/// A depth from the bytes of its buffer.
pub(crate) fn depth_of(frame: &Frame, bytes: &[u8]) -> DepthMap {
    let Frame { width, height, map_stride, .. } = *frame;
    let rows = bytes.chunks_exact(8 * map_stride as usize).take(height as usize);
    let words = rows.flat_map(|row| row[..4 * width as usize].chunks_exact(4));
    DepthMap { width, height, data: words.map(|v| u32::from_le_bytes([v[0], v[1], v[2], v[3]])).collect() }
}

/// Maps on their way to the host. A future that any executor drives; it owns all that it needs, so that the matcher may go
/// on meanwhile. Where nobody waits for it, [`Reading::try_take`] looks whether they are there.
#[derive(Debug)]
#[must_use = "the maps are lost if nobody takes them"]
pub struct Reading {
    state: Option<Result<Awaited, Error>>,
}

#[derive(Debug)]
struct Awaited {
    device: wgpu::Device,
    pulse: Pulse,
    /// What the device objects to, where that was not known yet.
    verdict: Option<Verdict>,
    waiter: Arc<Waiter>,
    mapping: Mapping,
    buffer: wgpu::Buffer,
    layout: Layout,
    spare: Arc<Mutex<Vec<wgpu::Buffer>>>,
}

impl Awaited {
    /// The maps, and the buffer goes back to the others.
    fn taken(self, mapped: Result<(), Error>) -> Result<Matched, Error> {
        let matched = mapped.and_then(|()| {
            readback::taken(&self.device, &self.buffer, |bytes| {
                self.layout.matched(&bytes[..self.layout.bytes() as usize])
            })
        });
        self.pulse.check()?; // nobody goes on with a lost device by mistake
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(self.buffer);
        matched
    }

    /// What the device objects to, if that is known; then `mapped` says whether the buffer is mapped.
    fn poll_with(
        &mut self,
        context: &mut Context<'_>,
        mapped: impl FnOnce(&Self, &mut Context<'_>) -> Poll<Result<(), Error>>,
    ) -> Poll<Result<(), Error>> {
        if let Some(verdict) = &mut self.verdict {
            match Pin::new(verdict).poll(context) {
                Poll::Ready(Ok(())) => self.verdict = None,
                other => return other,
            }
        }
        mapped(self, context)
    }
}

impl Reading {
    pub(crate) fn failed(error: Error) -> Self {
        Self { state: Some(Err(error)) }
    }

    /// The maps, if they are there. Does not wait. `None` ever after they were taken.
    pub fn try_take(&mut self) -> Option<Result<Matched, Error>> {
        let mapped = match self.state.as_mut()? {
            Ok(awaited) => {
                let now = |awaited: &Awaited| awaited.mapping.now(&awaited.device).map_or(Poll::Pending, Poll::Ready);
                match awaited.poll_with(&mut Context::from_waker(Waker::noop()), |awaited, _| now(awaited)) {
                    Poll::Ready(mapped) => mapped,
                    Poll::Pending => return None,
                }
            }
            Err(_) => Ok(()),
        };
        self.finish(mapped)
    }

    /// The maps. Blocks until they are there.
    ///
    /// # Errors
    /// [`Error::Lost`] if the device fails; [`Error::Misuse`] if the maps were taken before.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait_blocking(mut self) -> Result<Matched, Error> {
        self.take_blocking()
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn take_blocking(&mut self) -> Result<Matched, Error> {
        let mapped = match &mut self.state {
            Some(Ok(awaited)) => {
                let verdict = awaited.verdict.take().map_or(Ok(()), Verdict::now);
                verdict.and_then(|()| awaited.mapping.wait(&awaited.device))
            }
            _ => Ok(()),
        };
        self.finish(mapped).unwrap_or_else(Self::gone)
    }

    fn finish(&mut self, mapped: Result<(), Error>) -> Option<Result<Matched, Error>> {
        Some(self.state.take()?.and_then(|awaited| awaited.taken(mapped)))
    }

    fn gone() -> Result<Matched, Error> {
        Err(Error::Misuse("the maps of this Reading were taken before; read once more to have them again".into()))
    }
}

impl Future for Reading {
    type Output = Result<Matched, Error>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mapped = match &mut self.state {
            Some(Ok(awaited)) => {
                let mapped = |awaited: &Awaited, context: &mut Context<'_>| {
                    awaited.waiter.poll(&awaited.device, &awaited.mapping, context)
                };
                match awaited.poll_with(context, mapped) {
                    Poll::Ready(mapped) => mapped,
                    Poll::Pending => return Poll::Pending,
                }
            }
            _ => Ok(()),
        };
        Poll::Ready(self.finish(mapped).unwrap_or_else(Self::gone))
    }
}

/// Bytes that a driver on the CPU takes to compile and to run the kernels, measured with lavapipe.
const COMPILING: u64 = 64 << 20;

impl StereoMatcher {
    /// The optional features that a matcher makes use of where the adapter has them; none is required.
    /// `TIMESTAMP_QUERY` lets [`StereoMatcher::compute_timed_blocking`] time each stage; `SUBGROUP` lets invocations share a path
    /// without workgroup memory; `SHADER_INT64` makes wider loads and stores.
    pub fn required_features(adapter: &wgpu::Adapter) -> wgpu::Features {
        adapter.features() & (wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::SUBGROUP | wgpu::Features::SHADER_INT64)
    }

    /// The limits to ask a device for. WebGPU's default limits do; this raises the sizes of buffers and textures to what
    /// the adapter has, so that large pairs need fewer bands.
    pub fn required_limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
        let has = adapter.limits();
        wgpu::Limits {
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            max_buffer_size: has.max_buffer_size,
            max_texture_dimension_2d: has.max_texture_dimension_2d,
            ..wgpu::Limits::default().or_worse_values_from(&has)
        }
    }

    /// A matcher for pairs of `width` x `height` pixels in `format`, and of smaller ones after [`StereoMatcher::resize`].
    /// In a browser only [`StereoMatcher::new_async`] can say what the device objects to.
    ///
    /// # Errors
    /// [`Error::Parameter`] as [`Params::validate`]; [`Error::Device`] if the device lacks a limit that the kernels
    /// need; [`Error::TooLarge`] and [`Error::OutOfMemory`] if the pair does not fit it; [`Error::Misuse`] if the queue is
    /// another device's; [`Error::Lost`] if the device is lost; on a CPU
    /// adapter [`Error::Memory`] if the memory that is left does not hold the pair ([`Params::memory_check`]).
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        width: u32,
        height: u32,
        format: PixelFormat,
        params: &Params,
    ) -> Result<Self, Error> {
        let (matcher, verdict) = Self::begin(device, queue, [width, height], format, params)?;
        matcher.settled(verdict.now())?;
        Ok(matcher)
    }

    /// As [`StereoMatcher::new`], and waits for what the device objects to, without blocking: in a browser that comes later.
    ///
    /// # Errors
    /// As [`StereoMatcher::new`].
    pub async fn new_async(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        width: u32,
        height: u32,
        format: PixelFormat,
        params: &Params,
    ) -> Result<Self, Error> {
        let (matcher, verdict) = Self::begin(device, queue, [width, height], format, params)?;
        matcher.settled(verdict.await)?;
        Ok(matcher)
    }

    /// A matcher, and what the device objects to.
    fn begin(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        [width, height]: [u32; 2],
        format: PixelFormat,
        params: &Params,
    ) -> Result<(Self, Verdict), Error> {
        let pulse = Pulse::new(device, queue)?;
        params.accepts(width, height)?;
        let levels = levels(device, [width, height], format, params, &[])?;
        let before = rooms(device, [width, height], format, params, &levels)?;
        let lists: Vec<&[Level]> = before.iter().chain([&levels]).map(|levels| &levels[..]).collect();
        Self::ensure_memory(device, format, &lists, &Pool::default())?;
        Ok(scopes::watched(device, || {
            let pool =
                before.iter().fold(Pool::default(), |pool, levels| Self::build(device, queue, format, levels, pool).2);
            let (made, steps, pool) = Self::build(device, queue, format, &levels, pool);
            let Level { params, sizes, .. } = levels[levels.len() - 1].clone();
            made.blank(queue, &sizes);
            let room = Layout::new(&params, &sizes).bytes();
            let matcher = Self {
                device: device.clone(),
                queue: queue.clone(),
                pulse,
                params,
                format,
                largest: [width, height],
                room,
                levels,
                steps,
                made,
                pool,
                spare: Arc::default(),
                waiter: Arc::default(),
                sizes,
                timer: OnceLock::new(),
                passes: PassCache::default(),
                uploads: Uploads::default(),
                recorded: Arc::default(),
                computed: AtomicBool::new(false),
            };
            matcher.spare_again(matcher.readback_buffer());
            matcher
        }))
    }

    /// What the device objects to, or that it is lost.
    pub(crate) fn settled(&self, verdict: Result<(), Error>) -> Result<(), Error> {
        verdict.map_err(|error| self.pulse.cause(error))?;
        self.pulse.check()
    }

    fn build(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: PixelFormat,
        levels: &[Level],
        pool: Pool,
    ) -> (Ends, Vec<Step>, Pool) {
        let mut builder = Builder::new(device, levels, format, pool);
        let made = chain(&mut builder);
        let (steps, pool) = builder.finish(queue);
        (made, steps, pool)
    }

    /// Compares what lists of steps need beyond `pool`, and their frames, with the memory that is left, where the device
    /// works in the host's.
    fn ensure_memory(device: &wgpu::Device, format: PixelFormat, lists: &[&[Level]], pool: &Pool) -> Result<(), Error> {
        let Some(Level { params, sizes, .. }) = lists.last().and_then(|levels| levels.last()) else { return Ok(()) };
        if !params.memory_check || device.adapter_info().device_type != wgpu::DeviceType::Cpu {
            return Ok(());
        }
        let plan = |pool, levels: &&[Level]| {
            let mut builder = Builder::new(device, levels, format, pool).only_planned();
            chain(&mut builder);
            builder.plan()
        };
        let planned = scopes::guarded_or_left(device, || lists.iter().fold(pool.clone(), plan).bytes())?;
        let more = planned - pool.bytes();
        if more == 0 {
            return Ok(());
        }
        // Of a frame: what is uploaded on its way, and the maps in the buffer that is read back and as they are given.
        let frame = 2 * sizes.source + 2 * Layout::new(params, sizes).bytes();
        let Frame { width, height, .. } = sizes.frame;
        let what = format!("a pair of {width}x{height} pixels at {} disparities", params.disparities);
        let needed = more + frame + COMPILING;
        memory::ensure(&what, needed).or_else(|_| {
            // What was dropped goes when the device is asked.
            let _ = device.poll(wgpu::PollType::wait_indefinitely());
            memory::ensure(&what, needed)
        })
    }

    /// All anew for another size or other settings, from what there is: what the matcher goes on with if the device does not
    /// object.
    fn rebuilt(&self, size: [u32; 2], params: &Params) -> Result<(Rebuilt, Verdict), Error> {
        let (device, queue, format) = (&self.device, &self.queue, self.format);
        self.pulse.check()?;
        params.accepts(size[0], size[1])?;
        let largest = [0, 1].map(|axis| self.largest[axis].max(size[axis]));
        let largest_levels = levels(device, largest, format, params, &[])?;
        let levels = levels(device, size, format, params, &largest_levels)?;
        #[cfg(not(target_arch = "wasm32"))]
        let _ = device.poll(wgpu::PollType::Poll); // what is done lets go of what it needed
        let fresh = Arc::strong_count(&self.recorded) > 1;
        let mut before = Vec::new();
        if fresh || largest != self.largest || *params != self.params {
            // Room for larger pairs, so that nothing is made when they come.
            before = rooms(device, largest, format, params, &largest_levels)?;
            before.extend((size != largest).then(|| largest_levels.clone()));
        }
        let lists: Vec<&[Level]> = before.iter().chain([&levels]).map(|levels| &levels[..]).collect();
        let taken = if fresh { &Pool::default() } else { &self.pool };
        Self::ensure_memory(device, format, &lists, taken)?;
        let Level { params, sizes, .. } = &levels[levels.len() - 1];
        let bytes = Layout::new(params, sizes).bytes();
        let room = Layout::new(params, &largest_levels[largest_levels.len() - 1].sizes).bytes();
        let missing = self.spares(|spare| spare.iter().filter(|buffer| buffer.size() < bytes).count());
        let missing = missing.max(usize::from(self.spares(|spare| spare.is_empty())));
        let ((made, steps, pool, spare), verdict) = scopes::watched(device, || {
            let pool = if fresh { self.pool.kernels() } else { self.pool.clone() };
            let pool = before.iter().fold(pool, |pool, levels| Self::build(device, queue, format, levels, pool).2);
            let (made, steps, pool) = Self::build(device, queue, format, &levels, pool);
            made.blank(queue, sizes);
            let spare =
                (0..missing).map(|_| readback::buffer(device, "gpu-stereo.readback", bytes.max(room))).collect();
            (made, steps, pool, spare)
        });
        Ok((Rebuilt { largest, room, levels, steps, made, pool, spare, fresh }, verdict))
    }

    /// Goes on with what was rebuilt.
    fn install(&mut self, rebuilt: Rebuilt) {
        let Rebuilt { largest, room, levels, steps, made, pool, spare, fresh } = rebuilt;
        let Level { params, sizes, .. } = levels[levels.len() - 1].clone();
        (self.largest, self.room) = (largest, room);
        (self.params, self.sizes, self.levels) = (params, sizes, levels);
        (self.made, self.steps, self.pool, self.timer) = (made, steps, pool, OnceLock::new());
        self.computed = AtomicBool::new(false);
        let bytes = Layout::new(&self.params, &self.sizes).bytes();
        self.spares(|spares| {
            spares.retain(|buffer| buffer.size() >= bytes); // those from before there was more to read are of no use
            spares.extend(spare);
        });
        if fresh {
            self.recorded = Arc::default();
            self.passes.forget(); // what binds the matcher's former buffers
        }
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn rebuild(&mut self, size: [u32; 2], params: &Params) -> Result<(), Error> {
        let (rebuilt, verdict) = self.rebuilt(size, params)?;
        self.settled(verdict.now())?;
        self.install(rebuilt);
        Ok(())
    }

    async fn rebuild_async(&mut self, size: [u32; 2], params: &Params) -> Result<(), Error> {
        let (rebuilt, verdict) = self.rebuilt(size, params)?;
        self.settled(verdict.await)?;
        self.install(rebuilt);
        Ok(())
    }

    /// Takes pairs of another size from now on. No buffer and no texture is made where neither side is larger than the
    /// matcher was made for; else the matcher grows. What was recorded before and is not done yet keeps its buffers and
    /// gives what it would have given; then the matcher makes others for what comes.
    ///
    /// # Errors
    /// As [`StereoMatcher::new`]; the matcher is then as it was.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), Error> {
        let params = self.params.clone();
        self.rebuild([width, height], &params)
    }

    /// As [`StereoMatcher::resize`], and waits for what the device objects to, without blocking: in a browser that comes
    /// later.
    ///
    /// # Errors
    /// As [`StereoMatcher::resize`].
    pub async fn resize_async(&mut self, width: u32, height: u32) -> Result<(), Error> {
        let params = self.params.clone();
        self.rebuild_async([width, height], &params).await
    }

    /// Computes with other settings from now on. Only kernels that the matcher has not had yet are compiled, and buffers
    /// are made only where those that there are do not do. What was recorded before keeps its own, as with
    /// [`StereoMatcher::resize`].
    ///
    /// # Errors
    /// As [`StereoMatcher::new`]; the matcher is then as it was.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn set_params(&mut self, params: &Params) -> Result<(), Error> {
        let (width, height) = self.size();
        self.rebuild([width, height], params)
    }

    /// As [`StereoMatcher::set_params`], and waits for what the device objects to, without blocking: in a browser that comes
    /// later.
    ///
    /// # Errors
    /// As [`StereoMatcher::set_params`].
    pub async fn set_params_async(&mut self, params: &Params) -> Result<(), Error> {
        let (width, height) = self.size();
        self.rebuild_async([width, height], params).await
    }

    /// The settings.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Columns and rows of the pairs.
    pub fn size(&self) -> (u32, u32) {
        (self.sizes.frame.width, self.sizes.frame.height)
    }

    /// The samples of the pairs.
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// Bytes of all buffers and textures that the matcher holds on the device.
    pub fn device_bytes(&self) -> u64 {
        let spare = self.spares(|spare| spare.iter().map(wgpu::Buffer::size).sum::<u64>());
        self.pool.bytes() + spare + self.uploads.bytes()
    }

    /// Where [`StereoMatcher::record`] leaves the disparity map: `i16` in 1/16 px, two pixels a word, the left one in
    /// the low half, each row padded to a multiple of 16 bytes; [`DisparityMap::INVALID`] where there is none. The buffer
    /// may be longer. After [`StereoMatcher::resize`] or [`StereoMatcher::set_params`] it may be another one.
    pub fn output(&self) -> &wgpu::Buffer {
        &self.made.output
    }

    /// Where [`StereoMatcher::record`] leaves the right view's map, laid out like [`StereoMatcher::output`], if
    /// [`Params::right_map`] asks for it.
    pub fn right(&self) -> Option<&wgpu::Buffer> {
        self.made.right.as_ref()
    }

    /// Where [`StereoMatcher::record`] leaves the confidence, if [`Params::confidence`] asks for it: a byte a pixel, each
    /// row padded to a multiple of 8 bytes. The buffer may be longer.
    pub fn confidence(&self) -> Option<&wgpu::Buffer> {
        self.made.confidence.as_ref()
    }

    /// Where [`StereoMatcher::record`] leaves the depth, if [`Params::depth`] asks for it: a `u32` a pixel, as in
    /// [`DepthMap`], each row padded to a multiple of 32 bytes. The buffer may be longer.
    pub fn depth(&self) -> Option<&wgpu::Buffer> {
        self.made.depth.as_ref()
    }

    /// Whether a pair is what the matcher was made for.
    pub(crate) fn accepts(&self, left: &Image, right: &Image) -> Result<(), Error> {
        check_pair(left, right)?;
        let ((width, height), format) = (self.size(), self.format);
        match [left, right].into_iter().find(|i| (i.width(), i.height(), i.format()) != (width, height, format)) {
            None => Ok(()),
            Some(image) => Err(Error::Image(format!(
                "an image is {}x{} in {:?}, but the matcher was made for {width}x{height} in {format:?}; resize \
                 it, or make another one",
                image.width(),
                image.height(),
                image.format(),
            ))),
        }
    }

    /// Bytes of an image of the largest pair, in whole rows of its texture.
    pub(crate) fn largest_source(&self) -> u64 {
        source_layout(self.largest, self.format, &self.device.limits()).1
    }

    /// Compares what so many frames in flight need, besides what there is, with the memory that is left.
    pub(crate) fn ensure_frames(&self, frames: u64) -> Result<(), Error> {
        if !self.params.memory_check || self.device.adapter_info().device_type != wgpu::DeviceType::Cpu {
            return Ok(());
        }
        // The pair and where it is uploaded from, the buffer that is read back and the maps. What the matcher made is not
        // filled yet.
        let frame = 4 * self.largest_source() + 2 * self.room;
        let what = format!("{frames} frames in flight with what computes them");
        memory::ensure(&what, self.pool.bytes() + frames * frame + COMPILING)
    }

    /// Makes readback buffers for so many frames at a time.
    pub(crate) fn reserve_readbacks(&self, frames: usize) {
        let buffers: Vec<_> = (0..frames).map(|_| self.readback_buffer()).collect();
        buffers.into_iter().for_each(|buffer| self.spare_again(buffer));
    }

    /// Writes a pair where [`StereoMatcher::record`] takes it from with [`Inputs::Uploaded`]; it is there for all that is
    /// recorded afterwards.
    ///
    /// # Errors
    /// [`Error::Image`] if a size or a format is not the matcher's; [`Error::OutOfMemory`] if there is no room for one more
    /// pair, beside those that what was recorded still needs.
    pub fn upload(&self, left: &Image, right: &Image) -> Result<(), Error> {
        self.accepts(left, right)?;
        self.pulse.check()?;
        let side = self.sizes.source;
        let free = self.uploads.free(2 * side);
        let written = scopes::guarded_or_left(&self.device, || {
            let buffer = free.unwrap_or_else(|| {
                self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("gpu-stereo.upload"),
                    size: 2 * self.largest_source(),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                })
            });
            for (image, at) in [(left, 0), (right, side)] {
                let bytes = image.bytes();
                let (whole, rest) = bytes.split_at(bytes.len() / 4 * 4);
                self.queue.write_buffer(&buffer, at, whole);
                if !rest.is_empty() {
                    let mut last = [0; 4];
                    last[..rest.len()].copy_from_slice(rest);
                    self.queue.write_buffer(&buffer, at + whole.len() as u64, &last);
                }
            }
            buffer
        });
        let buffer = written.map_err(|error| self.pulse.cause(error))?;
        self.uploads.set(buffer, self.size());
        Ok(())
    }

    /// Writes a pair into the matcher's textures, for what is submitted at once.
    pub(crate) fn write_sources(&self, left: &Image, right: &Image) {
        for (image, source) in [(left, &self.made.sources[0]), (right, &self.made.sources[1])] {
            let bytes = image.bytes();
            // Whole rows of the texture, then the rest of them.
            let texels = self.sizes.source_texels;
            let row = 16 * texels as usize;
            let (whole, rest) = bytes.split_at(bytes.len() / row * row);
            let rows = (whole.len() / row) as u32;
            let mut rest = rest.to_vec();
            rest.resize(rest.len().next_multiple_of(16), 0);
            for (data, y, width, height) in [(whole, 0, texels, rows), (&rest, rows, rest.len() as u32 / 16, 1)] {
                if data.is_empty() {
                    continue;
                }
                let destination =
                    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y, z: 0 }, ..source.as_image_copy() };
                let bytes_per_row = Some(16 * texels);
                let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
                let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
                self.queue.write_texture(destination, data, layout, size);
            }
        }
    }

    /// Records the way of a pair from a buffer into the matcher's textures.
    pub(crate) fn record_sources(&self, encoder: &mut wgpu::CommandEncoder, buffer: &wgpu::Buffer) {
        let side = self.sizes.source;
        for (source, offset) in self.made.sources.iter().zip([0, side]) {
            let width = self.sizes.source_texels;
            let layout = wgpu::TexelCopyBufferLayout { offset, bytes_per_row: Some(16 * width), rows_per_image: None };
            let height = (side / (16 * u64::from(width))) as u32;
            let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
            encoder.copy_buffer_to_texture(wgpu::TexelCopyBufferInfo { buffer, layout }, source.as_image_copy(), size);
        }
    }

    /// Records the work of one frame into the caller's encoder: takes the pair from `inputs`, leaves the map in
    /// [`StereoMatcher::output`] and in what `outputs` names. It neither submits nor waits.
    ///
    /// What is recorded is whole: whatever is uploaded, computed, resized or set before it is submitted, it gives the maps of
    /// the pair, the size and the settings that it was recorded with.
    ///
    /// # Errors
    /// [`Error::Image`] if an input or an output does not fit the matcher; [`Error::Misuse`] if no pair of this size was
    /// uploaded, or the encoder is another device's: then nothing is recorded. [`Error::Misuse`], too, if a pass of the encoder
    /// is open, which spoils it. [`Error::Lost`] if the device is lost. In a browser, what the device itself objects to comes
    /// to the caller's error scopes and error handler.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        outputs: &Outputs<'_>,
    ) -> Result<(), Error> {
        self.pulse.check()?;
        if !self.pulse.owns(encoder) {
            return Err(Error::Misuse(
                "the encoder is of another wgpu device than the matcher; create it with the device that the matcher was \
                 made with"
                    .into(),
            ));
        }
        let context = self.interop();
        let mut regions = Regions::default();
        let before = context.before(&self.passes, inputs, &mut regions)?;
        let after = context.after(&self.passes, outputs, &mut regions)?;
        let uploaded = match inputs {
            Inputs::Uploaded => Some(self.uploads.last().filter(|pair| pair.size == self.size()).ok_or_else(|| {
                let (width, height) = self.size();
                Error::Misuse(format!(
                    "no pair of {width}x{height} was uploaded since the matcher takes that size; upload one before it is \
                     recorded"
                ))
            })?),
            _ => None,
        };
        let recorded = scopes::guarded_or_left(&self.device, || {
            if let Some(pair) = &uploaded {
                self.record_sources(encoder, &pair.buffer);
            }
            before.iter().for_each(|work| work.record(encoder));
            self.record_chain(encoder);
            after.iter().for_each(|work| work.record(encoder));
        });
        recorded.map_err(|error| match self.pulse.cause(error) {
            Error::Lost(text) if scopes::refusal(&text).is_some() => Error::Misuse(format!(
                "the encoder refused the work: {}; end its open passes before, and begin with a new encoder",
                scopes::refusal(&text).unwrap_or_default()
            )),
            other => other,
        })?;
        let held = (self.recorded.clone(), uploaded.map(|pair| pair.held));
        encoder.on_submitted_work_done(move || drop(held));
        self.has_computed();
        Ok(())
    }

    /// There is a map of the present size and settings.
    pub(crate) fn has_computed(&self) {
        self.computed.store(true, Ordering::Relaxed);
    }

    fn interop(&self) -> InteropContext<'_> {
        InteropContext {
            device: &self.device,
            queue: &self.queue,
            pulse: &self.pulse,
            frame: &self.sizes.frame,
            format: self.format,
            params: &self.params,
            sources: &self.made.sources,
            output: &self.made.output,
            right: self.made.right.as_ref(),
            confidence: self.made.confidence.as_ref(),
            depth: self.made.depth.as_ref(),
        }
    }

    /// Lets go of the textures and buffers of [`Inputs`] and [`Outputs`]. What binds the last of them (those of about eight
    /// pairs) is kept for the next frames, and keeps them alive.
    pub fn forget_surfaces(&self) {
        self.passes.forget();
    }

    /// Records the work of one frame, from the uploaded pair to [`StereoMatcher::output`].
    pub(crate) fn record_chain(&self, encoder: &mut wgpu::CommandEncoder) {
        // A compute pass ends where something is copied or cleared.
        for steps in self.steps.chunk_by(|a, b| a.copy_to.is_none() && !b.clears) {
            record_steps(encoder, "gpu-stereo", steps, None);
        }
    }

    /// Brings what the work submitted last leaves to the host: work of the matcher's present size and settings. Submits the
    /// copy, and does not wait: the result is a future. Where work was recorded but never submitted, no pixel has a disparity.
    ///
    /// [`Error::Misuse`] comes of it if nothing was recorded or computed with the present size and settings.
    pub fn read(&self) -> Reading {
        let computed = self.computed.load(Ordering::Relaxed);
        let absent = || {
            let (width, height) = self.size();
            Error::Misuse(format!(
                "there is no map of {width}x{height} with the present settings to read; record and submit a pair, or compute \
                 one, before"
            ))
        };
        let started = self.pulse.check().and_then(|()| computed.then_some(()).ok_or_else(absent));
        started.and_then(|()| self.start(|_| ())).unwrap_or_else(Reading::failed)
    }

    /// As [`StereoMatcher::read`]; blocks until the maps are there.
    ///
    /// # Errors
    /// [`Error::Lost`] if the device fails on the way.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_blocking(&self) -> Result<Matched, Error> {
        self.read().wait_blocking()
    }

    /// Computes the maps of a pair of the host's, and reads them back.
    ///
    /// # Errors
    /// [`Error::Image`] if a size or a format is not the matcher's; [`Error::Lost`] if the device fails on the way.
    pub async fn compute(&self, left: &Image, right: &Image) -> Result<Matched, Error> {
        self.submit(left, right, |encoder| self.record_chain(encoder))?.await
    }

    /// As [`StereoMatcher::compute`]; blocks until the maps are there.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn compute_blocking(&self, left: &Image, right: &Image) -> Result<Matched, Error> {
        self.submit(left, right, |encoder| self.record_chain(encoder))?.wait_blocking()
    }

    fn submit(
        &self,
        left: &Image,
        right: &Image,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<Reading, Error> {
        self.accepts(left, right)?;
        let started = self.start(|encoder| {
            self.write_sources(left, right);
            record(encoder);
        })?;
        self.has_computed();
        Ok(started)
    }

    /// Submits what `record` records, and the way of the maps to the host.
    pub(crate) fn start(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<Reading, Error> {
        self.pulse.check()?;
        let layout = Layout::new(&self.params, &self.sizes);
        let ((buffer, mapping), verdict) = scopes::watched(&self.device, || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            let buffer = self.readback_buffer();
            let mut at = 0;
            for (from, bytes) in [
                (Some(&self.made.output), layout.map),
                (self.made.right.as_ref(), layout.map),
                (self.made.confidence.as_ref(), layout.confidence.unwrap_or(0)),
                (self.made.depth.as_ref(), layout.depth.unwrap_or(0)),
            ] {
                if let Some(from) = from {
                    encoder.copy_buffer_to_buffer(from, 0, &buffer, at, bytes);
                    at += bytes;
                }
            }
            self.queue.submit([encoder.finish()]);
            let mapping = Mapping::new(&buffer, wgpu::MapMode::Read);
            (buffer, mapping)
        });
        let verdict = verdict.or_later().map_err(|error| self.pulse.cause(error))?;
        let (device, pulse) = (self.device.clone(), self.pulse.clone());
        let (waiter, spare) = (self.waiter.clone(), self.spare.clone());
        Ok(Reading { state: Some(Ok(Awaited { device, pulse, verdict, waiter, mapping, buffer, layout, spare })) })
    }

    fn spares<T>(&self, work: impl FnOnce(&mut Vec<wgpu::Buffer>) -> T) -> T {
        work(&mut self.spare.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn spare_again(&self, buffer: wgpu::Buffer) {
        self.spares(|spare| spare.push(buffer));
    }

    /// A buffer for what is read back, with room for the largest pair if it must be made.
    fn readback_buffer(&self) -> wgpu::Buffer {
        let bytes = Layout::new(&self.params, &self.sizes).bytes();
        let found = self.spares(|spare| {
            spare.retain(|buffer| buffer.size() >= bytes); // those from before there was more to read are of no use
            spare.pop()
        });
        found.unwrap_or_else(|| readback::buffer(&self.device, "gpu-stereo.readback", bytes.max(self.room)))
    }

    /// As [`StereoMatcher::compute_blocking`], with the time of each stage in order of first use; none where the device
    /// was made without `TIMESTAMP_QUERY`, or there are more steps than a query set can time (2048).
    ///
    /// # Errors
    /// As [`StereoMatcher::compute_blocking`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn compute_timed_blocking(&self, left: &Image, right: &Image) -> Result<(Matched, Vec<StageTime>), Error> {
        // Neighbouring steps of a stage are timed together.
        let runs: Vec<&[Step]> =
            self.steps.chunk_by(|a, b| a.stage() == b.stage() && a.copy_to.is_none() && !b.clears).collect();
        let count = 2 * runs.len() as u32;
        let timed = self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if !timed || count > wgpu::QUERY_SET_MAX_QUERIES {
            return Ok((self.compute_blocking(left, right)?, Vec::new()));
        }
        let bytes = 8 * u64::from(count);
        let make = || Timer {
            queries: self.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("gpu-stereo.timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("gpu-stereo.timestamps"),
                size: bytes,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            readback: readback::buffer(&self.device, "gpu-stereo.timestamps", bytes),
        };
        self.pulse.check()?;
        let timer = match self.timer.get() {
            Some(timer) => timer,
            None => {
                let timer = scopes::guarded(&self.device, make)?;
                self.timer.get_or_init(|| timer)
            }
        };
        let matched = self
            .submit(left, right, |encoder| {
                for (i, run) in (0..).zip(&runs) {
                    let writes = wgpu::ComputePassTimestampWrites {
                        query_set: &timer.queries,
                        beginning_of_pass_write_index: Some(2 * i),
                        end_of_pass_write_index: Some(2 * i + 1),
                    };
                    record_steps(encoder, run[0].stage(), run, Some(writes));
                }
                encoder.resolve_query_set(&timer.queries, 0..count, &timer.resolved, 0);
                encoder.copy_buffer_to_buffer(&timer.resolved, 0, &timer.readback, 0, bytes);
            })?
            .wait_blocking()?;
        let period = f64::from(self.queue.get_timestamp_period());
        let stamps: Vec<u64> = readback::read(&self.device, &timer.readback, bytemuck::pod_collect_to_vec)?;
        let mut times: Vec<StageTime> = Vec::new();
        for (run, stamps) in runs.iter().zip(stamps.chunks_exact(2)) {
            let ms = stamps[1].saturating_sub(stamps[0]) as f64 * period * 1e-6;
            match times.iter_mut().find(|time| time.name == run[0].stage()) {
                Some(time) => time.ms += ms,
                None => times.push(StageTime { name: run[0].stage().into(), ms }),
            }
        }
        Ok((matched, times))
    }
}
