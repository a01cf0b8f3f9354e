//! A frame with the time of each stage.

use crate::gpu::matcher::record::Pieces;
use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::matcher::timer::Timer;
use crate::gpu::recording::record_steps;
use crate::gpu::{readback, scopes};
use crate::{Error, ImageView, Matched, StageTime};

impl StereoMatcher {
    /// As [`StereoMatcher::compute_blocking`], with the time of each stage in order of first use; none where the device
    /// was made without `TIMESTAMP_QUERY`, or there are more steps than a query set can time (2048).
    ///
    /// # Errors
    /// As [`StereoMatcher::compute_blocking`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn compute_timed_blocking<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<(Matched, Vec<StageTime>), Error> {
        let (left, right) = (left.into(), right.into());
        // Neighbouring steps of a stage are timed together.
        let runs = self.runs(true);
        let count = 2 * runs.len() as u32;
        let timed = self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if !timed || count > wgpu::QUERY_SET_MAX_QUERIES {
            return Ok((self.compute_blocking(left, right)?, Vec::new()));
        }
        let bytes = 8 * u64::from(count);
        self.pulse.check()?;
        let timer = match self.timer.get() {
            Some(timer) => timer,
            None => {
                let timer = scopes::guarded(&self.device, || Timer::new(&self.device, count))?;
                self.timer.get_or_init(|| timer)
            }
        };
        let matched = self
            .submit(left, right, |encoder| {
                let mut pieces = Pieces::new(self);
                for (i, run) in (0..).zip(&runs) {
                    let writes = wgpu::ComputePassTimestampWrites {
                        query_set: &timer.queries,
                        beginning_of_pass_write_index: Some(2 * i),
                        end_of_pass_write_index: Some(2 * i + 1),
                    };
                    record_steps(encoder, run[0].stage(), run, Some(writes));
                    pieces.recorded(encoder, run);
                }
                pieces.end(encoder);
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
