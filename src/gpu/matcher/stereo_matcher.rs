//! The matcher: what it holds, how it is made, and its getters.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::gpu::chain::Ends;
use crate::gpu::device::Pulse;
use crate::gpu::interop::PassCache;
use crate::gpu::layout::{Sizes, source_layout};
use crate::gpu::map_layout::{MapFormat, MapLayout};
use crate::gpu::maps::MapBytes;
use crate::gpu::matcher::build::{build, ensure_memory};
use crate::gpu::matcher::shared_kernels::SharedKernels;
use crate::gpu::matcher::timer::Timer;
use crate::gpu::readback::{self, Waiter};
use crate::gpu::recording::{Level, Pool, Step, levels, rooms};
use crate::gpu::scopes::{self, Verdict};
use crate::gpu::spans::span;
use crate::gpu::uploads::Uploads;
use crate::image_view::check_made_for;
use crate::{Error, ImageView, Params, PixelFormat};

/// Matches pairs on the caller's device.
///
/// All buffers and kernels are made in [`StereoMatcher::new`]. [`StereoMatcher::record`] records the work of a frame into
/// the caller's encoder: it neither submits nor waits. [`StereoMatcher::read`] brings what was computed to the host, and
/// [`StereoMatcher::compute`] does all of it. Functions that block have `blocking` in their names.
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
    pub(super) largest: [u32; 2],
    /// Bytes that are read back of such a pair.
    pub(super) room: u64,
    pub(crate) sizes: Sizes,
    /// The rounds through the chain; the last one has these settings and sizes.
    pub(crate) levels: Vec<Level>,
    pub(crate) steps: Vec<Step>,
    pub(super) ends: Ends,
    pub(super) pool: Pool,
    pub(super) kernels: SharedKernels,
    /// Readback buffers that are not in use.
    pub(super) spare: Arc<Mutex<Vec<wgpu::Buffer>>>,
    pub(crate) waiter: Arc<Waiter>,
    pub(super) timer: OnceLock<Timer>,
    pub(super) passes: PassCache,
    pub(super) uploads: Uploads,
    /// A token that work recorded into the caller's encoders holds until it is done or dropped.
    pub(super) recorded: Arc<()>,
    /// Whether there may be a map of this size and these settings.
    pub(super) computed: AtomicBool,
}

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
    /// In a browser only [`StereoMatcher::new_async`] can return the errors that the device reports.
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
        let (matcher, verdict) = Self::begin(device, queue, [width, height], format, params, SharedKernels::default())?;
        matcher.begun(verdict.now())
    }

    /// As [`StereoMatcher::new`], and awaits the errors that the device reports, without blocking: in a browser they arrive later.
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
        let (matcher, verdict) = Self::begin(device, queue, [width, height], format, params, SharedKernels::default())?;
        matcher.begun(verdict.await)
    }

    /// A matcher, and the errors that the device reports.
    pub(super) fn begin(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        [width, height]: [u32; 2],
        format: PixelFormat,
        params: &Params,
        kernels: SharedKernels,
    ) -> Result<(Self, Verdict), Error> {
        span!(DEBUG, "new", width = width, height = height, disparities = params.disparities);
        let pulse = Pulse::new(device, queue)?;
        params.accepts(width, height)?;
        let levels = levels(device, [width, height], format, params, &[])?;
        let before = rooms(device, [width, height], format, params, &levels)?;
        let lists: Vec<&[Level]> = before.iter().chain([&levels]).map(|levels| &levels[..]).collect();
        ensure_memory(device, format, &lists, &Pool::default())?;
        Ok(scopes::watched(device, || {
            let known = kernels.pool();
            let pool = before.iter().fold(known, |pool, levels| build(device, queue, format, levels, pool).2);
            let (ends, steps, pool) = build(device, queue, format, &levels, pool);
            let Level { params, sizes, .. } = levels[levels.len() - 1].clone();
            ends.blank(queue, &sizes);
            let room = MapBytes::new(&params, &sizes).bytes();
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
                ends,
                pool,
                kernels,
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

    /// The matcher, unless the device reported an error.
    pub(super) fn begun(self, verdict: Result<(), Error>) -> Result<Self, Error> {
        self.settled(verdict)?;
        self.kernels.add(&self.pool);
        Ok(self)
    }

    /// The error that the device reported, or that it is lost.
    pub(crate) fn settled(&self, verdict: Result<(), Error>) -> Result<(), Error> {
        verdict.map_err(|error| self.pulse.cause(error))?;
        self.pulse.check()
    }

    /// The settings.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Columns and rows of the pairs.
    pub fn size(&self) -> [u32; 2] {
        [self.sizes.frame.width, self.sizes.frame.height]
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
    /// the low half, each row padded to a multiple of 16 bytes; [`DisparityMap::INVALID`](crate::DisparityMap::INVALID) where there is none.
    /// [`StereoMatcher::layout`] says the same in numbers. The buffer may be longer. After [`StereoMatcher::resize`] or [`StereoMatcher::set_params`] it may be another one.
    pub fn output(&self) -> &wgpu::Buffer {
        &self.ends.output
    }

    /// Where [`StereoMatcher::record`] leaves the right view's map, laid out like [`StereoMatcher::output`], if
    /// [`Params::right_map`] asks for it.
    pub fn right(&self) -> Option<&wgpu::Buffer> {
        self.ends.right.as_ref()
    }

    /// Where [`StereoMatcher::record`] leaves the confidence, if [`Params::confidence`] asks for it: a byte a pixel, each
    /// row padded to a multiple of 8 bytes. The buffer may be longer.
    pub fn confidence(&self) -> Option<&wgpu::Buffer> {
        self.ends.confidence.as_ref()
    }

    /// Where [`StereoMatcher::record`] leaves the depth, if [`Params::depth`] asks for it: a `u32` a pixel, as in
    /// [`DepthMap`](crate::DepthMap), each row padded to a multiple of 32 bytes. The buffer may be longer.
    pub fn depth(&self) -> Option<&wgpu::Buffer> {
        self.ends.depth.as_ref()
    }

    /// How maps of a format lie in the matcher's buffers, and in the copies that [`Outputs`](crate::Outputs) makes of them.
    pub fn layout(&self, format: MapFormat) -> MapLayout {
        MapLayout::new(format, &self.sizes.frame)
    }

    /// Whether a pair is what the matcher was made for.
    pub(crate) fn accepts(&self, left: ImageView<'_>, right: ImageView<'_>) -> Result<(), Error> {
        check_made_for([left, right], self.size(), self.format)
    }

    /// Bytes of an image of the largest pair, in whole rows of its texture.
    pub(crate) fn largest_source(&self) -> u64 {
        source_layout(self.largest, self.format, &self.device.limits()).1
    }

    /// There is a map of the present size and settings.
    pub(crate) fn has_computed(&self) {
        self.computed.store(true, Ordering::Relaxed);
    }

    pub(super) fn spares<T>(&self, work: impl FnOnce(&mut Vec<wgpu::Buffer>) -> T) -> T {
        work(&mut self.spare.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(super) fn spare_again(&self, buffer: wgpu::Buffer) {
        self.spares(|spare| spare.push(buffer));
    }

    /// A buffer for what is read back, with room for the largest pair if it must be made.
    pub(super) fn readback_buffer(&self) -> wgpu::Buffer {
        let bytes = MapBytes::new(&self.params, &self.sizes).bytes();
        let found = self.spares(|spare| {
            spare.retain(|buffer| buffer.size() >= bytes); // those from before there was more to read are of no use
            spare.pop()
        });
        found.unwrap_or_else(|| readback::buffer(&self.device, "gpu-stereo.readback", bytes.max(self.room)))
    }

    /// Makes readback buffers for so many frames at a time.
    pub(crate) fn reserve_readbacks(&self, frames: usize) {
        let buffers: Vec<_> = (0..frames).map(|_| self.readback_buffer()).collect();
        buffers.into_iter().for_each(|buffer| self.spare_again(buffer));
    }
}
