//! The matcher: images in, maps out, on the caller's device.

use std::sync::OnceLock;

use crate::buffers::{Frame, Sizes, TEXELS, TEXTURE_ROW};
use crate::chain::{Made, chain};
use crate::reference::{self, Round};
use crate::schedule::Plan;
use crate::steps::{Builder, Level, Step, row_bytes};
use crate::{
    ConfidenceMap, DisparityMap, Error, Image, Inputs, Matched, Outputs, Params, PixelFormat, kernels, readback,
};

/// The time of one stage in one frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StageTime {
    /// The stage's name, as in docs/ALGORITHMS.md.
    pub name: String,
    /// Milliseconds.
    pub ms: f64,
}

/// Matches pairs of one size with one set of parameters on the caller's device.
///
/// All buffers and pipelines are made in [`StereoMatcher::new`]. [`StereoMatcher::record`] records the work of a frame
/// into the caller's encoder: it neither submits nor waits. [`StereoMatcher::compute_blocking`] is the blocking convenience.
///
/// A matcher holds one frame at a time: two threads that use it at once overwrite each other's images. Make one each.
#[derive(Debug)]
pub struct StereoMatcher {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) params: Params,
    pub(crate) format: PixelFormat,
    pub(crate) sizes: Sizes,
    /// The passes through the chain; the last one has these settings and sizes.
    pub(crate) levels: Vec<Level>,
    pub(crate) steps: Vec<Step>,
    sources: [wgpu::Texture; 2],
    output: wgpu::Buffer,
    confidence: Option<wgpu::Buffer>,
    readback: wgpu::Buffer,
    device_bytes: u64,
    timer: OnceLock<Timer>,
}

#[derive(Debug)]
struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
}

/// Both images of a pair have one size.
pub(crate) fn check_pair(left: &Image, right: &Image) -> Result<(), Error> {
    let (l, r) = ((left.width(), left.height()), (right.width(), right.height()));
    if l == r {
        return Ok(());
    }
    Err(Error::Image(format!(
        "the left image is {}x{} and the right one {}x{}, but a rectified pair has one size; crop or rectify them again",
        l.0, l.1, r.0, r.1
    )))
}

/// A disparity map from the bytes of its buffer.
pub(crate) fn map_of(sizes: &Sizes, bytes: &[u8]) -> DisparityMap {
    let Frame { width, height, map_stride, .. } = sizes.frame;
    let mut data = Vec::with_capacity(width as usize * height as usize);
    for row in bytes.chunks_exact(4 * map_stride as usize).take(height as usize) {
        data.extend(row[..2 * width as usize].chunks_exact(2).map(|v| i16::from_le_bytes([v[0], v[1]])));
    }
    DisparityMap { width, height, data }
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

    /// A matcher for pairs of `width` x `height` pixels in `format`.
    ///
    /// # Errors
    /// [`Error::Parameter`] as [`Params::validate`]; [`Error::Device`] if the device lacks a limit that the kernels
    /// need; [`Error::TooLarge`] and [`Error::OutOfMemory`] if the pair does not fit it.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        width: u32,
        height: u32,
        format: PixelFormat,
        params: &Params,
    ) -> Result<Self, Error> {
        params.validate()?;
        let limits = device.limits();
        kernels::check_limits(&limits)?;
        if width == 0 || height == 0 {
            return Err(Error::Image(format!("the images are {width}x{height}, but each side must be at least 1")));
        }
        let level = |Round { halvings, params }: Round| {
            let plan = Plan::new(device, &params);
            let [width, height] = [width, height].map(|side| side.div_ceil(1 << halvings));
            let sizes = Sizes::new(width, height, format, &params, &limits, &plan)?;
            Ok(Level { halvings, params, plan, sizes })
        };
        let levels: Vec<Level> =
            reference::rounds(width, height, params).into_iter().map(level).collect::<Result<_, Error>>()?;
        readback::guarded(device, || Self::build(device, queue, format, levels))
    }

    fn build(device: &wgpu::Device, queue: &wgpu::Queue, format: PixelFormat, levels: Vec<Level>) -> Self {
        let mut builder = Builder::new(device, &levels, format);
        let Made { sources, output, confidence } = chain(&mut builder);
        let (steps, device_bytes) = builder.finish(queue);
        let Level { params, sizes, .. } = levels[levels.len() - 1].clone();
        let read_bytes = sizes.map + confidence.as_ref().map_or(0, |_| sizes.confidence);
        Self {
            device: device.clone(),
            queue: queue.clone(),
            params,
            format,
            levels,
            steps,
            sources,
            output,
            confidence,
            readback: readback::buffer(device, "gpu-stereo.readback", read_bytes),
            device_bytes: device_bytes + read_bytes,
            sizes,
            timer: OnceLock::new(),
        }
    }

    /// Takes pairs of another size from now on. No buffer and no texture is made where neither side is larger than the
    /// matcher was made for; else the matcher grows. What was recorded before must be submitted before.
    ///
    /// # Errors
    /// As [`StereoMatcher::new`]; the matcher is then as it was.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), Error> {
        let params = self.params.clone();
        *self = Self::new(&self.device, &self.queue, width, height, self.format, &params)?;
        Ok(())
    }

    /// Computes with other settings from now on. Only kernels that the matcher has not had yet are compiled, and buffers
    /// are made only where those that there are do not do. What was recorded before must be submitted before.
    ///
    /// # Errors
    /// As [`StereoMatcher::new`]; the matcher is then as it was.
    pub fn set_params(&mut self, params: &Params) -> Result<(), Error> {
        let Frame { width, height, .. } = self.sizes.frame;
        *self = Self::new(&self.device, &self.queue, width, height, self.format, params)?;
        Ok(())
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

    /// Bytes of all buffers that the matcher holds on the device.
    pub fn device_bytes(&self) -> u64 {
        self.device_bytes
    }

    /// Where [`StereoMatcher::record`] leaves the disparity map: `i16` in 1/16 px, two pixels a word, the left one in
    /// the low half, each row padded to a multiple of 16 bytes; [`DisparityMap::INVALID`] where there is none. The buffer may be
    /// longer.
    pub fn output(&self) -> &wgpu::Buffer {
        &self.output
    }

    /// Where [`StereoMatcher::record`] leaves the confidence, if [`Params::confidence`] asks for it: a byte a pixel, each
    /// row padded to a multiple of 8 bytes. The buffer may be longer.
    pub fn confidence(&self) -> Option<&wgpu::Buffer> {
        self.confidence.as_ref()
    }

    /// Writes a pair into the matcher's buffers; it is there for all that is submitted afterwards.
    ///
    /// # Errors
    /// [`Error::Image`] if a size or a format is not the matcher's.
    pub fn upload(&self, left: &Image, right: &Image) -> Result<(), Error> {
        check_pair(left, right)?;
        let Frame { width, height, .. } = self.sizes.frame;
        for (image, source) in [(left, &self.sources[0]), (right, &self.sources[1])] {
            if (image.width(), image.height(), image.format()) != (width, height, self.format) {
                return Err(Error::Image(format!(
                    "an image is {}x{} in {:?}, but the matcher was made for {width}x{height} in {:?}; make another one",
                    image.width(),
                    image.height(),
                    image.format(),
                    self.format
                )));
            }
            let bytes = image.bytes();
            // Whole rows of the texture, then the rest of them.
            let (whole, rest) = bytes.split_at(bytes.len() / TEXTURE_ROW as usize * TEXTURE_ROW as usize);
            let rows = (whole.len() / TEXTURE_ROW as usize) as u32;
            let mut rest = rest.to_vec();
            rest.resize(rest.len().next_multiple_of(16), 0);
            for (data, y, width, height) in [(whole, 0, TEXELS, rows), (&rest, rows, rest.len() as u32 / 16, 1)] {
                if data.is_empty() {
                    continue;
                }
                let destination =
                    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y, z: 0 }, ..source.as_image_copy() };
                let bytes_per_row = Some(TEXTURE_ROW as u32);
                let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
                let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
                self.queue.write_texture(destination, data, layout, size);
            }
        }
        Ok(())
    }

    /// Records the work of one frame into the caller's encoder: takes the pair from `inputs`, leaves the map in
    /// [`StereoMatcher::output`] and in what `outputs` names. It neither submits nor waits.
    ///
    /// # Errors
    /// [`Error::Image`] if an input or an output does not fit the matcher; then nothing is recorded.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        outputs: &Outputs<'_>,
    ) -> Result<(), Error> {
        let _ = (inputs, outputs.disparity);
        self.record_chain(encoder);
        Ok(())
    }

    /// Records the work of one frame, from the uploaded pair to [`StereoMatcher::output`].
    fn record_chain(&self, encoder: &mut wgpu::CommandEncoder) {
        // A compute pass ends where something is copied or cleared.
        for steps in self.steps.chunk_by(|a, b| a.copy_to.is_none() && !b.clears) {
            self.record_steps(encoder, "gpu-stereo", steps, None);
        }
    }

    /// Records steps in one compute pass. Only the first one may clear, only the last one copy.
    pub(crate) fn record_steps(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        steps: &[Step],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        if let Some(step) = steps.first().filter(|step| step.clears) {
            encoder.clear_buffer(&step.buffer, 0, None);
        }
        let label = Some(label);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        for step in steps {
            pass.set_pipeline(&step.pipeline);
            pass.set_bind_group(0, &step.bind_group, &[step.pass]);
            pass.dispatch_workgroups(step.workgroups[0], step.workgroups[1], 1);
        }
        drop(pass);
        if let Some(step) = steps.last() {
            self.copy_of(encoder, step);
        }
    }

    /// Records the copy of what a step left, if there is one.
    pub(crate) fn copy_of(&self, encoder: &mut wgpu::CommandEncoder, step: &Step) {
        if let Some(texture) = &step.copy_to {
            let bytes_per_row = Some(row_bytes(texture.format(), texture.width()));
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            let source = wgpu::TexelCopyBufferInfo { buffer: &step.buffer, layout };
            encoder.copy_buffer_to_texture(source, texture.as_image_copy(), texture.size());
        }
    }

    /// Uploads a pair, computes its maps and reads them back. Blocks until they are there.
    ///
    /// # Errors
    /// As [`StereoMatcher::upload`]; [`Error::Lost`] if the device fails on the way.
    pub fn compute_blocking(&self, left: &Image, right: &Image) -> Result<Matched, Error> {
        self.run(left, right, |encoder| self.record_chain(encoder))
    }

    fn run(
        &self,
        left: &Image,
        right: &Image,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<Matched, Error> {
        readback::guarded(&self.device, || {
            self.upload(left, right)?;
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            encoder.copy_buffer_to_buffer(&self.output, 0, &self.readback, 0, self.sizes.map);
            if let Some(confidence) = &self.confidence {
                let (at, bytes) = (self.sizes.map, self.sizes.confidence);
                encoder.copy_buffer_to_buffer(confidence, 0, &self.readback, at, bytes);
            }
            self.queue.submit([encoder.finish()]);
            Ok(())
        })??;
        readback::read(&self.device, &self.readback, |bytes| {
            let (map, confidence) = bytes.split_at(self.sizes.map as usize);
            let confidence = self.confidence.as_ref().map(|_| self.confidence_map(confidence));
            Matched { map: self.map(map), confidence }
        })
    }

    /// A disparity map from the bytes of one of the matcher's map buffers.
    pub(crate) fn map(&self, bytes: &[u8]) -> DisparityMap {
        map_of(&self.sizes, bytes)
    }

    /// A confidence from the bytes of its buffer.
    pub(crate) fn confidence_map(&self, bytes: &[u8]) -> ConfidenceMap {
        let Frame { width, height, map_stride, .. } = self.sizes.frame;
        let rows = bytes.chunks_exact(2 * map_stride as usize).take(height as usize);
        ConfidenceMap { width, height, data: rows.flat_map(|row| &row[..width as usize]).copied().collect() }
    }

    /// As [`StereoMatcher::compute_blocking`], with the time of each stage in order of first use; none where the device
    /// was made without `TIMESTAMP_QUERY`, or there are more steps than a query set can time (2048).
    ///
    /// # Errors
    /// As [`StereoMatcher::compute_blocking`].
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
        let timer = readback::guarded(&self.device, || self.timer.get_or_init(make))?;
        let matched = self.run(left, right, |encoder| {
            for (i, run) in (0..).zip(&runs) {
                let writes = wgpu::ComputePassTimestampWrites {
                    query_set: &timer.queries,
                    beginning_of_pass_write_index: Some(2 * i),
                    end_of_pass_write_index: Some(2 * i + 1),
                };
                self.record_steps(encoder, run[0].stage(), run, Some(writes));
            }
            encoder.resolve_query_set(&timer.queries, 0..count, &timer.resolved, 0);
            encoder.copy_buffer_to_buffer(&timer.resolved, 0, &timer.readback, 0, bytes);
        })?;
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
