//! Another size, other settings: the list of steps is built anew from what there is.

use std::sync::Arc;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use crate::gpu::chain::Ends;
use crate::gpu::maps::MapBytes;
use crate::gpu::matcher::build::{COMPILING, build, ensure_memory};
use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::readback;
use crate::gpu::recording::{Level, Pool, Step, levels, rooms};
use crate::gpu::scopes::{self, Verdict};
use crate::gpu::spans::span;
use crate::{Error, Params, memory};

/// What follows from a size and settings.
struct Rebuilt {
    largest: [u32; 2],
    room: u64,
    levels: Vec<Level>,
    steps: Vec<Step>,
    ends: Ends,
    pool: Pool,
    /// Readback buffers.
    spare: Vec<wgpu::Buffer>,
    /// Whether no buffer of before is used, since recorded work may still need them.
    fresh: bool,
}

impl StereoMatcher {
    /// Rebuilds for another size or other settings from the pool: what the matcher continues with if the device reports no error.
    fn rebuilt(&self, size: [u32; 2], params: &Params) -> Result<(Rebuilt, Verdict), Error> {
        let (device, queue, format) = (&self.device, &self.queue, self.format);
        span!(DEBUG, "rebuild", width = size[0], height = size[1], disparities = params.disparities);
        self.pulse.check()?;
        params.accepts(size[0], size[1])?;
        let largest = [0, 1].map(|axis| self.largest[axis].max(size[axis]));
        let largest_levels = levels(device, largest, format, params, &[])?;
        let levels = levels(device, size, format, params, &largest_levels)?;
        #[cfg(not(target_arch = "wasm32"))]
        let _ = device.poll(wgpu::PollType::Poll); // work that is done drops its tokens
        let fresh = Arc::strong_count(&self.recorded) > 1;
        let mut before = Vec::new();
        if fresh || largest != self.largest || *params != self.params {
            // Room for larger pairs, so that nothing is made when they come.
            before = rooms(device, largest, format, params, &largest_levels)?;
            before.extend((size != largest).then(|| largest_levels.clone()));
        }
        let lists: Vec<&[Level]> = before.iter().chain([&levels]).map(|levels| &levels[..]).collect();
        let taken = if fresh { &Pool::default() } else { &self.pool };
        ensure_memory(device, format, &lists, taken)?;
        let Level { params, sizes, .. } = &levels[levels.len() - 1];
        let bytes = MapBytes::new(params, sizes).bytes();
        let room = MapBytes::new(params, &largest_levels[largest_levels.len() - 1].sizes).bytes();
        let missing = self.spares(|spare| spare.iter().filter(|buffer| buffer.size() < bytes).count());
        let missing = missing.max(usize::from(self.spares(|spare| spare.is_empty())));
        let ((ends, steps, pool, spare), verdict) = scopes::watched(device, || {
            let pool = if fresh { self.pool.lasting() } else { self.pool.clone() };
            let pool = before.iter().fold(pool, |pool, levels| build(device, queue, format, levels, pool).2);
            let (ends, steps, pool) = build(device, queue, format, &levels, pool);
            ends.blank(queue, sizes);
            let spare =
                (0..missing).map(|_| readback::buffer(device, "gpu-stereo.readback", bytes.max(room))).collect();
            (ends, steps, pool, spare)
        });
        Ok((Rebuilt { largest, room, levels, steps, ends, pool, spare, fresh }, verdict))
    }

    /// Goes on with what was rebuilt.
    fn install(&mut self, rebuilt: Rebuilt) {
        let Rebuilt { largest, room, levels, steps, ends, pool, spare, fresh } = rebuilt;
        let Level { params, sizes, .. } = levels[levels.len() - 1].clone();
        (self.largest, self.room) = (largest, room);
        (self.params, self.sizes, self.levels) = (params, sizes, levels);
        (self.ends, self.steps, self.pool, self.timer) = (ends, steps, pool, OnceLock::new());
        self.kernels.add(&self.pool);
        self.computed = AtomicBool::new(false);
        let bytes = MapBytes::new(&self.params, &self.sizes).bytes();
        self.spares(|spares| {
            spares.retain(|buffer| buffer.size() >= bytes); // those from before there was more to read are of no use
            spares.extend(spare);
        });
        if fresh {
            self.recorded = Arc::default();
            self.passes.forget(); // bind groups of the matcher's former buffers
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

    /// As [`StereoMatcher::resize`], and awaits the errors that the device reports, without blocking: in a browser they arrive
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
        let [width, height] = self.size();
        self.rebuild([width, height], params)
    }

    /// As [`StereoMatcher::set_params`], and awaits the errors that the device reports, without blocking: in a browser they arrive
    /// later.
    ///
    /// # Errors
    /// As [`StereoMatcher::set_params`].
    pub async fn set_params_async(&mut self, params: &Params) -> Result<(), Error> {
        let [width, height] = self.size();
        self.rebuild_async([width, height], params).await
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
}
