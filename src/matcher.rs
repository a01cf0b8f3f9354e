//! The schedule: which kernel runs on what, in what order.

use std::sync::OnceLock;

use crate::buffers::{COST_TEXELS, Frame, Pass, Rows, Sizes};
use crate::kernels::{self, Compiled, KERNELS};
use crate::reference::Direction;
use crate::{DisparityMap, Error, Image, Median, Method, Params, PixelFormat, readback};

/// The time of one stage in one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct StageTime {
    /// The stage's name, as in docs/ALGORITHMS.md.
    pub name: String,
    /// Milliseconds.
    pub ms: f64,
}

/// What a step leaves behind, and where: for the comparison with the reference.
#[derive(Clone, Debug)]
pub(crate) enum Output {
    Gray { side: u32 },
    Prefiltered { side: u32 },
    Columns { chunk: Rows },
    Cost { chunk: Rows, volume_row: u32 },
    Paths { directions: Vec<Direction>, band: Rows },
    Views { last: bool },
    Checked,
    Median,
}

/// One dispatch, and what is copied after it.
#[derive(Debug)]
pub(crate) struct Step {
    kernel: usize,
    bind_group: wgpu::BindGroup,
    pass: u32,
    workgroups: [u32; 2],
    pub(crate) output: Output,
    pub(crate) buffer: wgpu::Buffer,
    /// The texture that `buffer` is copied into when it is complete, row by row.
    copy_to: Option<wgpu::Texture>,
}

impl Step {
    pub(crate) fn stage(&self) -> &'static str {
        KERNELS[self.kernel].stage
    }
}

/// Matches pairs of one size with one set of parameters on the caller's device.
///
/// All buffers and pipelines are made in [`StereoMatcher::new`]. [`StereoMatcher::record`] records the work of a frame
/// into the caller's encoder: it neither submits nor waits. [`StereoMatcher::compute`] is the blocking convenience.
///
/// A matcher holds one frame at a time: two threads that use it at once overwrite each other's images. Make one each.
#[derive(Debug)]
pub struct StereoMatcher {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) params: Params,
    pub(crate) format: PixelFormat,
    pub(crate) sizes: Sizes,
    pipelines: Vec<Option<Compiled>>,
    pub(crate) steps: Vec<Step>,
    sources: [wgpu::Buffer; 2],
    pub(crate) right_map: wgpu::Buffer,
    output: wgpu::Buffer,
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

/// Distance of the blocks in the uniform buffer of [`Pass`]es: the largest alignment that WebGPU allows a device to ask.
const PASS_STRIDE: u32 = 256;

/// What a kernel is bound to.
#[derive(Clone, Copy)]
enum Bound<'a> {
    Buffer(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}
use Bound::{Buffer, Texture};

/// Bytes of a row of `width` texels.
fn row_bytes(format: wgpu::TextureFormat, width: u32) -> u32 {
    format.block_copy_size(None).unwrap_or(0) * width
}

/// Builds buffers and steps; becomes a [`StereoMatcher`].
struct Builder<'a> {
    device: &'a wgpu::Device,
    params: &'a Params,
    format: PixelFormat,
    pipelines: Vec<Option<Compiled>>,
    frame: wgpu::Buffer,
    passes_buffer: wgpu::Buffer,
    passes: Vec<Pass>,
    steps: Vec<Step>,
    device_bytes: u64,
}

impl Builder<'_> {
    fn buffer(&mut self, name: &str, size: u64) -> wgpu::Buffer {
        self.device_bytes += size;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(&format!("gpu-stereo.{name}")),
            size,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A volume with a byte a disparity, a buffer a band.
    fn volume(&mut self, name: &str, sizes: &Sizes) -> Vec<wgpu::Buffer> {
        sizes.bands.iter().map(|band| self.buffer(name, sizes.volume(band.count))).collect()
    }

    /// Copies what the last step left into a texture of `width` texels a row.
    fn copy_to_texture(&mut self, width: u32, height: u32, format: wgpu::TextureFormat) -> wgpu::TextureView {
        self.device_bytes += u64::from(row_bytes(format, width)) * u64::from(height);
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("gpu-stereo.copy"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        if let Some(step) = self.steps.last_mut() {
            step.copy_to = Some(texture);
        }
        view
    }

    /// One dispatch of `lanes` x `rows` invocations. The first of `storage` that the kernel writes is what it leaves.
    fn step(&mut self, name: &str, storage: &[Bound<'_>], pass: Pass, lanes: u32, rows: u32, output: Output) {
        let Some(kernel) = KERNELS.iter().position(|kernel| kernel.name == name) else {
            unreachable!("{name} is not in the table of kernels");
        };
        let compiled = self.pipelines[kernel]
            .get_or_insert_with(|| kernels::compile(self.device, &KERNELS[kernel], self.params, self.format));
        let bytes = (size_of::<Pass>() as u64).try_into().ok();
        let uniform = wgpu::BufferBinding { buffer: &self.passes_buffer, offset: 0, size: bytes };
        let mut entries = vec![
            wgpu::BindGroupEntry { binding: 0, resource: self.frame.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Buffer(uniform) },
        ];
        for (binding, bound) in (2..).zip(storage) {
            let resource = match bound {
                Bound::Buffer(buffer) => buffer.as_entire_binding(),
                Bound::Texture(view) => wgpu::BindingResource::TextureView(view),
            };
            entries.push(wgpu::BindGroupEntry { binding, resource });
        }
        let bind_group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&format!("gpu-stereo.{name}")),
            layout: &compiled.layout,
            entries: &entries,
        });
        let written = KERNELS[kernel].storage.iter().position(|access| *access == kernels::Access::Write);
        let Some(Bound::Buffer(buffer)) = written.map(|i| storage[i]) else {
            unreachable!("{name} writes no buffer");
        };
        let (buffer, workgroups, pass_index) =
            (buffer.clone(), [lanes.div_ceil(KERNELS[kernel].lanes), rows], self.passes.len() as u32);
        self.steps.push(Step { kernel, bind_group, pass: pass_index, workgroups, output, buffer, copy_to: None });
        self.passes.push(pass);
    }
}

impl StereoMatcher {
    /// The optional features that a matcher makes use of where the adapter has them; none is required.
    /// `TIMESTAMP_QUERY` lets [`StereoMatcher::compute_timed`] time each stage; with `SUBGROUP` block matching is faster.
    pub fn required_features(adapter: &wgpu::Adapter) -> wgpu::Features {
        adapter.features() & (wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::SUBGROUP)
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
        let sizes = Sizes::new(width, height, format, params, &limits, kernels::has_subgroups(device))?;
        readback::guarded(device, || Self::build(device, queue, format, params, sizes))
    }

    fn build(device: &wgpu::Device, queue: &wgpu::Queue, format: PixelFormat, params: &Params, sizes: Sizes) -> Self {
        let uniform = |name: &str, size: u64| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&format!("gpu-stereo.{name}")),
                size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        // gray, prefilter of two sides; chunks twice; eight directions and the winner a band; check and median
        let chunks: usize = sizes.chunks.iter().map(Vec::len).sum();
        let most_steps = 4 + 2 * chunks + 9 * sizes.bands.len() + 2;
        let passes_bytes = most_steps as u64 * u64::from(PASS_STRIDE);
        let mut b = Builder {
            device,
            params,
            format,
            pipelines: KERNELS.iter().map(|_| None).collect(),
            frame: uniform("frame", size_of::<Frame>() as u64),
            passes_buffer: uniform("passes", passes_bytes),
            passes: Vec::new(),
            steps: Vec::new(),
            device_bytes: size_of::<Frame>() as u64 + passes_bytes,
        };
        let Frame { width, height, gray_stride, left_stride, right_stride, map_stride, .. } = sizes.frame;

        let sources = [b.buffer("source.left", sizes.source), b.buffer("source.right", sizes.source)];
        let grays = [b.buffer("gray.left", sizes.gray), b.buffer("gray.right", sizes.gray)];
        let planes = [b.buffer("prefilter.left", sizes.left), b.buffer("prefilter.right", sizes.right)];
        let most_chunk = sizes.chunks.iter().flatten().map(|chunk| chunk.count).max().unwrap_or(0);
        let columns = b.buffer("sad_columns", u64::from(most_chunk) * sizes.columns_row);
        let [left_map, right_map] = [b.buffer("winner.left", sizes.map), b.buffer("winner.right", sizes.map)];

        let mut plane_views = Vec::new();
        for side in 0..2 {
            let (i, pass) = (side as usize, Pass { side, ..Pass::default() });
            b.step("gray", &[Buffer(&sources[i]), Buffer(&grays[i])], pass, gray_stride, height, Output::Gray { side });
            let stride = [left_stride, right_stride][i];
            b.step(
                "prefilter",
                &[Buffer(&grays[i]), Buffer(&planes[i])],
                pass,
                stride,
                height,
                Output::Prefiltered { side },
            );
            if sizes.small_block {
                plane_views.push(b.copy_to_texture(stride, height, wgpu::TextureFormat::R32Uint));
            }
        }

        let column_step = |b: &mut Builder<'_>, chunk: Rows| {
            let pass = Pass { first_row: chunk.first, rows: chunk.count, ..Pass::default() };
            let lanes = width + 2 * params.radius();
            let segments = chunk.count.div_ceil(kernels::SEGMENT);
            b.step(
                "sad_columns",
                &[Buffer(&planes[0]), Buffer(&planes[1]), Buffer(&columns)],
                pass,
                lanes,
                segments,
                Output::Columns { chunk },
            );
            pass
        };

        match params.method {
            Method::Bm => {
                if sizes.small_block {
                    let pass = Pass { rows: height, ..Pass::default() };
                    let planes = [Texture(&plane_views[0]), Texture(&plane_views[1])];
                    let storage = [planes[0], planes[1], Buffer(&left_map), Buffer(&right_map)];
                    let (slices, strip) = kernels::slices_and_strip(params.disparities);
                    let lanes = slices * height.div_ceil(strip);
                    b.step("block_match_small", &storage, pass, lanes, 1, Output::Views { last: true });
                }
                for &chunk in sizes.chunks.iter().flatten() {
                    let pass = column_step(&mut b, chunk);
                    let output = Output::Views { last: chunk.first + chunk.count == height };
                    b.step(
                        "block_match",
                        &[Buffer(&columns), Buffer(&left_map), Buffer(&right_map)],
                        pass,
                        chunk.count,
                        1,
                        output,
                    );
                }
            }
            Method::Sgm => {
                // The cost is computed into what is later the first pair's volume, and copied into a texture band by band:
                // lavapipe reads 16 bytes of an image in a quarter of the time that a buffer takes, but writes buffers
                // faster (docs/PERFORMANCE.md).
                let first_paired = b.volume("sgm_aggregate", &sizes);
                let mut cost = Vec::new();
                for (band, (rows, chunks)) in sizes.bands.iter().zip(&sizes.chunks).enumerate() {
                    if sizes.small_block {
                        let pass = Pass { first_row: rows.first, rows: rows.count, ..Pass::default() };
                        let planes = [Texture(&plane_views[0]), Texture(&plane_views[1])];
                        let storage = [planes[0], planes[1], Buffer(&first_paired[band])];
                        let output = Output::Cost { chunk: *rows, volume_row: 0 };
                        b.step("sad_cost_small", &storage, pass, rows.count.div_ceil(2), 1, output);
                    }
                    for &chunk in chunks {
                        let volume_row = chunk.first - rows.first;
                        let pass = Pass { volume_row, ..column_step(&mut b, chunk) };
                        let output = Output::Cost { chunk, volume_row };
                        let storage = [Buffer(&columns), Buffer(&first_paired[band])];
                        b.step("sad_cost", &storage, pass, chunk.count, 1, output);
                    }
                    let height = sizes.cost_texture_rows(rows.count);
                    cost.push(b.copy_to_texture(COST_TEXELS, height, wgpu::TextureFormat::Rgba32Uint));
                }
                // The pairs of opposite directions that cross rows, then the horizontal one, which ends in the winner.
                let directions = Direction::all(params.paths);
                let (across, along) = directions.split_at(directions.len() - 2);
                let carry_bytes = sizes.volume_row;
                let carry =
                    [b.buffer("sgm_aggregate.carry", carry_bytes), b.buffer("sgm_aggregate.carry", carry_bytes)];
                let mut paired = vec![first_paired];
                for (i, pair) in across.chunks_exact(2).enumerate() {
                    if i > 0 {
                        paired.push(b.volume("sgm_aggregate", &sizes));
                    }
                    let paths = &paired[i];
                    for (second, direction) in pair.iter().enumerate() {
                        let count = sizes.bands.len();
                        for i in 0..count {
                            let band = if direction.dy > 0 { i } else { count - 1 - i };
                            let rows = sizes.bands[band];
                            let pass = Pass {
                                rows: rows.count,
                                dx: direction.dx,
                                dy: direction.dy,
                                carried: (i > 0).into(),
                                accumulate: second as u32,
                                ..Pass::default()
                            };
                            let storage = [
                                Texture(&cost[band]),
                                Buffer(&paths[band]),
                                Buffer(&carry[i % 2]),
                                Buffer(&carry[1 - i % 2]),
                            ];
                            let output = Output::Paths { directions: pair[..=second].to_vec(), band: rows };
                            b.step("sgm_aggregate", &storage, pass, width, 1, output);
                        }
                    }
                }
                let most_band = sizes.bands.iter().map(|band| band.count).max().unwrap_or(1);
                let forward = b.buffer("sgm_aggregate.forward", sizes.volume(most_band));
                for (band, &rows) in sizes.bands.iter().enumerate() {
                    let pass = Pass {
                        first_row: rows.first,
                        rows: rows.count,
                        dx: along[0].dx,
                        dy: along[0].dy,
                        ..Pass::default()
                    };
                    let storage = [Texture(&cost[band]), Buffer(&forward), Buffer(&carry[0]), Buffer(&carry[1])];
                    let output = Output::Paths { directions: vec![along[0]], band: rows };
                    b.step("sgm_aggregate", &storage, pass, rows.count, 1, output);
                    let pair = |i: usize| Buffer(&paired[i.min(paired.len() - 1)][band]);
                    let storage = [
                        Texture(&cost[band]),
                        Buffer(&forward),
                        pair(0),
                        pair(1),
                        pair(2),
                        Buffer(&left_map),
                        Buffer(&right_map),
                    ];
                    let output = Output::Views { last: rows.first + rows.count == height };
                    b.step("winner", &storage, pass, rows.count, 1, output);
                }
            }
        }

        let mut output = left_map;
        if params.lr_check.is_some() {
            let checked = b.buffer("lr_check", sizes.map);
            b.step(
                "lr_check",
                &[Buffer(&output), Buffer(&right_map), Buffer(&checked)],
                Pass::default(),
                map_stride,
                height,
                Output::Checked,
            );
            output = checked;
        }
        if params.median == Median::Three {
            let filtered = b.buffer("median", sizes.map);
            b.step(
                "median",
                &[Buffer(&output), Buffer(&filtered)],
                Pass::default(),
                map_stride,
                height,
                Output::Median,
            );
            output = filtered;
        }

        queue.write_buffer(&b.frame, 0, bytemuck::bytes_of(&sizes.frame));
        let mut blocks = vec![0u8; b.passes.len() * PASS_STRIDE as usize];
        for (block, pass) in blocks.chunks_exact_mut(PASS_STRIDE as usize).zip(&b.passes) {
            block[..size_of::<Pass>()].copy_from_slice(bytemuck::bytes_of(pass));
        }
        queue.write_buffer(&b.passes_buffer, 0, &blocks);
        let readback = readback::buffer(device, "gpu-stereo.readback", sizes.map);
        Self {
            device: device.clone(),
            queue: queue.clone(),
            params: params.clone(),
            format,
            pipelines: b.pipelines,
            steps: b.steps,
            sources,
            right_map,
            output,
            readback,
            device_bytes: b.device_bytes + sizes.map,
            sizes,
            timer: OnceLock::new(),
        }
    }

    /// Bytes of all buffers that the matcher holds on the device.
    pub fn device_bytes(&self) -> u64 {
        self.device_bytes
    }

    /// Where [`StereoMatcher::record`] leaves the disparity map: `i16` in 1/16 px, two pixels a word, the left one in
    /// the low half, each row padded to a whole word; [`DisparityMap::INVALID`] where there is none.
    pub fn output(&self) -> &wgpu::Buffer {
        &self.output
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
            let whole = bytes.len() / 4 * 4;
            self.queue.write_buffer(source, 0, &bytes[..whole]);
            if whole < bytes.len() {
                let mut rest = [0; 4];
                rest[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
                self.queue.write_buffer(source, whole as u64, &rest);
            }
        }
        Ok(())
    }

    /// Records the work of one frame, from the uploaded pair to [`StereoMatcher::output`].
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        // A compute pass ends where something is copied.
        for steps in self.steps.split_inclusive(|step| step.copy_to.is_some()) {
            self.record_steps(encoder, "gpu-stereo", steps, None);
        }
    }

    /// Records steps in one compute pass. Only the last one may copy.
    pub(crate) fn record_steps(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        steps: &[Step],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let label = Some(label);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        for step in steps {
            if let Some(compiled) = &self.pipelines[step.kernel] {
                pass.set_pipeline(&compiled.pipeline);
                pass.set_bind_group(0, &step.bind_group, &[step.pass * PASS_STRIDE]);
                pass.dispatch_workgroups(step.workgroups[0], step.workgroups[1], 1);
            }
        }
        drop(pass);
        if let Some((step, texture)) = steps.last().and_then(|step| Some((step, step.copy_to.as_ref()?))) {
            let bytes_per_row = Some(row_bytes(texture.format(), texture.width()));
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            let source = wgpu::TexelCopyBufferInfo { buffer: &step.buffer, layout };
            encoder.copy_buffer_to_texture(source, texture.as_image_copy(), texture.size());
        }
    }

    /// Uploads a pair, computes its map and reads it back. Blocks until it is there.
    ///
    /// # Errors
    /// As [`StereoMatcher::upload`]; [`Error::Lost`] if the device fails on the way.
    pub fn compute(&self, left: &Image, right: &Image) -> Result<DisparityMap, Error> {
        self.run(left, right, |encoder| self.record(encoder))
    }

    fn run(
        &self,
        left: &Image,
        right: &Image,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<DisparityMap, Error> {
        readback::guarded(&self.device, || {
            self.upload(left, right)?;
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            record(&mut encoder);
            encoder.copy_buffer_to_buffer(&self.output, 0, &self.readback, 0, self.sizes.map);
            self.queue.submit([encoder.finish()]);
            Ok(())
        })??;
        readback::read(&self.device, &self.readback, |bytes| self.map(bytes))
    }

    /// A disparity map from the bytes of one of the matcher's map buffers.
    pub(crate) fn map(&self, bytes: &[u8]) -> DisparityMap {
        let Frame { width, height, map_stride, .. } = self.sizes.frame;
        let rows = bytes.chunks_exact(4 * map_stride as usize);
        let data =
            rows.flat_map(|row| row.chunks_exact(2).take(width as usize)).map(|v| i16::from_le_bytes([v[0], v[1]]));
        DisparityMap { width, height, data: data.collect() }
    }

    /// As [`StereoMatcher::compute`], with the time of each stage in order of first use; none where the device was
    /// made without `TIMESTAMP_QUERY`, or there are more steps than a query set can time (2048).
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    pub fn compute_timed(&self, left: &Image, right: &Image) -> Result<(DisparityMap, Vec<StageTime>), Error> {
        let count = 2 * self.steps.len() as u32;
        let timed = self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if !timed || count > wgpu::QUERY_SET_MAX_QUERIES {
            return Ok((self.compute(left, right)?, Vec::new()));
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
        let map = self.run(left, right, |encoder| {
            for (i, step) in (0..).zip(self.steps.chunks(1)) {
                let writes = wgpu::ComputePassTimestampWrites {
                    query_set: &timer.queries,
                    beginning_of_pass_write_index: Some(2 * i),
                    end_of_pass_write_index: Some(2 * i + 1),
                };
                self.record_steps(encoder, step[0].stage(), step, Some(writes));
            }
            encoder.resolve_query_set(&timer.queries, 0..count, &timer.resolved, 0);
            encoder.copy_buffer_to_buffer(&timer.resolved, 0, &timer.readback, 0, bytes);
        })?;
        let period = f64::from(self.queue.get_timestamp_period());
        let stamps: Vec<u64> = readback::read(&self.device, &timer.readback, bytemuck::pod_collect_to_vec)?;
        let mut times: Vec<StageTime> = Vec::new();
        for (step, stamps) in self.steps.iter().zip(stamps.chunks_exact(2)) {
            let ms = stamps[1].saturating_sub(stamps[0]) as f64 * period * 1e-6;
            match times.iter_mut().find(|time| time.name == step.stage()) {
                Some(time) => time.ms += ms,
                None => times.push(StageTime { name: step.stage().into(), ms }),
            }
        }
        Ok((map, times))
    }
}
