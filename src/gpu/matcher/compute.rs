//! Frames whose maps come to the host.

use std::sync::atomic::Ordering;

use crate::gpu::chain::Ends;
use crate::gpu::maps::MapBytes;
use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::readback::Mapping;
use crate::gpu::reading::{Awaited, Reading};
use crate::gpu::scopes;
use crate::gpu::spans::span;
use crate::{Error, ImageView, Matched};

impl StereoMatcher {
    /// Brings what the work submitted last leaves to the host: work of the matcher's present size and settings. Submits the
    /// copy, and does not wait: the result is a future. Where work was recorded but never submitted, no pixel has a disparity.
    ///
    /// [`Error::Misuse`] comes of it if nothing was recorded or computed with the present size and settings.
    pub fn read(&self) -> Reading {
        let computed = self.computed.load(Ordering::Relaxed);
        let absent = || {
            let [width, height] = self.size();
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
    pub async fn compute<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Matched, Error> {
        self.submit(left.into(), right.into(), |encoder| self.record_at_once(encoder))?.await
    }

    /// As [`StereoMatcher::compute`]; blocks until the maps are there.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn compute_blocking<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Matched, Error> {
        self.submit(left.into(), right.into(), |encoder| self.record_at_once(encoder))?.wait_blocking()
    }

    pub(super) fn submit(
        &self,
        left: ImageView<'_>,
        right: ImageView<'_>,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<Reading, Error> {
        span!(DEBUG, "compute");
        self.accepts(left, right)?;
        let started = self.start(|encoder| {
            self.write_sources(left, right);
            record(encoder);
        })?;
        self.has_computed();
        Ok(started)
    }

    /// Submits what `record` records, and the copy of the maps to the host.
    pub(crate) fn start(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<Reading, Error> {
        span!(DEBUG, "submit");
        self.pulse.check()?;
        let maps = MapBytes::new(&self.params, &self.sizes);
        let ((buffer, mapping), verdict) = scopes::watched(&self.device, || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            let buffer = self.readback_buffer();
            let Ends { output, right, confidence, labels, unrounded, depth, .. } = &self.ends;
            let [label_bytes, table_bytes] = maps.labels.unwrap_or_default();
            let before_labels = self.sizes.right_map - self.sizes.map;
            let mut at = 0;
            for (from, first, bytes) in [
                (Some(output), 0, maps.map),
                (right.as_ref(), 0, maps.map),
                (confidence.as_ref(), 0, maps.confidence.unwrap_or(0)),
                (labels.as_ref().map(|labels| &labels.right_map), before_labels, label_bytes),
                (labels.as_ref().and_then(|labels| labels.table.as_ref()), 0, table_bytes),
                (unrounded.as_ref(), 0, maps.unrounded.map_or(0, |[bytes, _]| bytes)),
                (depth.as_ref(), 0, maps.depth.unwrap_or(0)),
            ] {
                if let Some(from) = from {
                    encoder.copy_buffer_to_buffer(from, first, &buffer, at, bytes);
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
        Ok(Reading::awaited(Awaited { device, pulse, verdict, waiter, mapping, buffer, maps, spare }))
    }
}
