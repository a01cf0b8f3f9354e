//! The schedule: which kernel runs on what, in what order.

use std::sync::OnceLock;

use crate::buffers::{Frame, Pass, Rows, Sizes, TEXELS, TEXTURE_ROW, cut};
use crate::kernels::{self, Compiled, KERNELS};
use crate::reference::Direction;
use crate::schedule::{PATHS_BYTES, Plan, ROWS_BYTES};
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
    Gray {
        side: u32,
    },
    Prefiltered {
        side: u32,
    },
    Columns {
        chunk: Rows,
    },
    Cost {
        chunk: Rows,
        volume_row: u32,
    },
    /// The paths of all directions together, when the last of their steps is done.
    Paths {
        directions: Vec<Direction>,
        band: Rows,
        first: bool,
        last: bool,
    },
    Views {
        last: bool,
    },
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
    sources: [wgpu::Texture; 2],
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
    plan: Plan,
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

    /// A texture of `width` texels a row, to be filled by copies.
    fn texture(&mut self, name: &str, width: u32, height: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
        self.device_bytes += u64::from(row_bytes(format, width)) * u64::from(height);
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&format!("gpu-stereo.{name}")),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Copies what the last step left into a texture of `width` texels a row.
    fn copy_to_texture(&mut self, width: u32, height: u32, format: wgpu::TextureFormat) -> wgpu::TextureView {
        let texture = self.texture("copy", width, height, format);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        if let Some(step) = self.steps.last_mut() {
            step.copy_to = Some(texture);
        }
        view
    }

    /// Copies what the last step left into a texture of 16 bytes a texel, [`TEXELS`] a row: lavapipe reads 16 bytes of an
    /// image in a quarter of the time that a buffer takes, but writes buffers faster (docs/PERFORMANCE.md).
    fn copy_to_texels(&mut self) -> wgpu::TextureView {
        let bytes = self.steps.last().map_or(0, |step| step.buffer.size());
        self.copy_to_texture(TEXELS, (bytes / TEXTURE_ROW) as u32, wgpu::TextureFormat::Rgba32Uint)
    }

    /// One dispatch for `lines` x `rows` lines of the kernel. The first of `storage` that the kernel writes is what it leaves.
    fn step(&mut self, name: &str, storage: &[Bound<'_>], pass: Pass, lines: u32, rows: u32, output: Output) {
        let Some(kernel) = KERNELS.iter().position(|kernel| kernel.name == name) else {
            unreachable!("{name} is not in the table of kernels");
        };
        let compiled = self.pipelines[kernel].get_or_insert_with(|| {
            kernels::compile(self.device, &KERNELS[kernel], self.params, self.format, &self.plan)
        });
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
        let invocations = lines * KERNELS[kernel].members(&self.plan);
        let workgroups = [invocations.div_ceil(KERNELS[kernel].lanes(&self.plan)), rows];
        let (buffer, pass_index) = (buffer.clone(), self.passes.len() as u32);
        self.steps.push(Step { kernel, bind_group, pass: pass_index, workgroups, output, buffer, copy_to: None });
        self.passes.push(pass);
    }
}

impl StereoMatcher {
    /// The optional features that a matcher makes use of where the adapter has them; none is required.
    /// `TIMESTAMP_QUERY` lets [`StereoMatcher::compute_timed`] time each stage; `SUBGROUP` lets invocations share a path
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
        let plan = Plan::new(device, params);
        let sizes = Sizes::new(width, height, format, params, &limits, &plan)?;
        readback::guarded(device, || Self::build(device, queue, format, params, plan, sizes))
    }

    fn build(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: PixelFormat,
        params: &Params,
        plan: Plan,
        sizes: Sizes,
    ) -> Self {
        let uniform = |name: &str, size: u64| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&format!("gpu-stereo.{name}")),
                size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        // gray, prefilter of two sides; the cost of a band or its chunks twice; six directions a band and strip; the
        // horizontal ones; check and median
        let chunks: usize = sizes.chunks.iter().map(Vec::len).sum();
        let most_band = sizes.bands.iter().map(|band| band.count).max().unwrap_or(1);
        let path_bytes = u64::from(16 * params.quads()) * u64::from(sizes.frame.height);
        let strip_lines = plan.strip(sizes.frame.width, path_bytes, PATHS_BYTES);
        let strip_rows = plan.strip(most_band, sizes.volume_row, ROWS_BYTES);
        let strips = sizes.frame.width.div_ceil(strip_lines) as usize;
        let row_strips = sizes.frame.height.div_ceil(strip_rows) as usize + sizes.bands.len();
        let most_steps = 4 + 2 * chunks + (1 + 6 * strips) * sizes.bands.len() + 2 * row_strips + 2;
        let passes_bytes = most_steps as u64 * u64::from(PASS_STRIDE);
        let mut b = Builder {
            device,
            params,
            plan,
            format,
            pipelines: KERNELS.iter().map(|_| None).collect(),
            frame: uniform("frame", size_of::<Frame>() as u64),
            passes_buffer: uniform("passes", passes_bytes),
            passes: Vec::new(),
            steps: Vec::new(),
            device_bytes: size_of::<Frame>() as u64 + passes_bytes,
        };
        let Frame { width, height, gray_stride, left_stride, right_stride, map_stride, .. } = sizes.frame;

        let source_rows = (sizes.source / TEXTURE_ROW) as u32;
        let sources = ["source.left", "source.right"]
            .map(|name| b.texture(name, TEXELS, source_rows, wgpu::TextureFormat::Rgba32Uint));
        let source_views = [0, 1].map(|i: usize| sources[i].create_view(&wgpu::TextureViewDescriptor::default()));
        let grays = [b.buffer("gray.left", sizes.gray), b.buffer("gray.right", sizes.gray)];
        let planes = [b.buffer("prefilter.left", sizes.left), b.buffer("prefilter.right", sizes.right)];
        let most_chunk = sizes.chunks.iter().flatten().map(|chunk| chunk.count).max().unwrap_or(0);
        let columns = b.buffer("sad_columns", u64::from(most_chunk) * sizes.columns_row);
        let [left_map, right_map] = [b.buffer("winner.left", sizes.map), b.buffer("winner.right", sizes.map)];

        let mut plane_views = Vec::new();
        for side in 0..2 {
            let (i, pass) = (side as usize, Pass { side, ..Pass::default() });
            b.step(
                "gray",
                &[Texture(&source_views[i]), Buffer(&grays[i])],
                pass,
                gray_stride,
                height,
                Output::Gray { side },
            );
            let gray = b.copy_to_texels();
            let stride = [left_stride, right_stride][i];
            b.step(
                "prefilter",
                &[Texture(&gray), Buffer(&planes[i])],
                pass,
                stride / 4,
                height,
                Output::Prefiltered { side },
            );
            if sizes.small_block && !b.plan.lanes {
                plane_views.push(b.copy_to_texture(stride, height, wgpu::TextureFormat::R32Uint));
            }
        }

        let column_step = |b: &mut Builder<'_>, chunk: Rows| {
            let pass = Pass { first_row: chunk.first, rows: chunk.count, ..Pass::default() };
            let vectors = kernels::vectors(params.quads(), &b.plan);
            let lanes = (width + 2 * params.radius()) * (params.quads() / vectors);
            let segments = chunk.count.div_ceil(kernels::segment(&b.plan));
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
                    let (parts, strip) = kernels::parts_and_strip(params.disparities);
                    let lanes = parts * height.div_ceil(strip);
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
                let directions = Direction::all(params.paths);
                let (across, along) = directions.split_at(directions.len() - 2);
                let pairs: Vec<&[Direction]> = across.chunks(2).collect();
                let paired: Vec<Vec<wgpu::Buffer>> = pairs.iter().map(|_| b.volume("sgm_aggregate", &sizes)).collect();
                let carries: Vec<[wgpu::Buffer; 2]> =
                    pairs.iter().map(|_| [(); 2].map(|()| b.buffer("sgm_aggregate.carry", sizes.volume_row))).collect();
                // On `lines` the cost is computed into what is then the first pair's volume, and copied into a texture.
                let computed = if b.plan.lanes { b.volume("sad_cost", &sizes) } else { paired[0].clone() };
                let mut textures = Vec::new();
                for (band, (&rows, chunks)) in sizes.bands.iter().zip(&sizes.chunks).enumerate() {
                    if sizes.small_block {
                        let pass = Pass { first_row: rows.first, rows: rows.count, ..Pass::default() };
                        let output = Output::Cost { chunk: rows, volume_row: 0 };
                        if b.plan.lanes {
                            let storage = [Buffer(&planes[0]), Buffer(&planes[1]), Buffer(&computed[band])];
                            let segments = rows.count.div_ceil(kernels::segment(&b.plan));
                            b.step("sad_cost_lanes", &storage, pass, width * params.quads(), segments, output);
                        } else {
                            let storage = [Texture(&plane_views[0]), Texture(&plane_views[1]), Buffer(&computed[band])];
                            let lanes = rows.count.div_ceil(2) * params.quads();
                            b.step("sad_cost_small", &storage, pass, lanes, 1, output);
                        }
                    }
                    for &chunk in chunks {
                        let volume_row = chunk.first - rows.first;
                        let pass = Pass { volume_row, ..column_step(&mut b, chunk) };
                        let output = Output::Cost { chunk, volume_row };
                        let storage = [Buffer(&columns), Buffer(&computed[band])];
                        let spans = width.div_ceil(kernels::span(&b.plan));
                        b.step("sad_cost", &storage, pass, chunk.count * params.quads(), spans, output);
                    }
                    if !b.plan.lanes {
                        textures.push(b.copy_to_texels());
                    }
                }
                let costs: Vec<Bound<'_>> = match b.plan.lanes {
                    true => computed.iter().map(Buffer).collect(),
                    false => textures.iter().map(Texture).collect(),
                };
                // The paths of a pair that cross rows, there and back, a strip of them at a time.
                let strips = cut(Rows { first: 0, count: width }, strip_lines);
                for ((pair, paths), carry) in pairs.iter().zip(&paired).zip(&carries) {
                    for strip in &strips {
                        for (second, direction) in pair.iter().enumerate() {
                            for nth in 0..sizes.bands.len() {
                                let band = if direction.dy > 0 { nth } else { sizes.bands.len() - 1 - nth };
                                let rows = sizes.bands[band];
                                let enters = if direction.dy > 0 { rows.first } else { rows.first + rows.count - 1 };
                                let slope = i64::from(direction.dx * direction.dy);
                                let pass = Pass {
                                    rows: rows.count,
                                    first_line: strip.first,
                                    lines: strip.count,
                                    shift: (slope * i64::from(enters)).rem_euclid(width.into()) as u32,
                                    dx: direction.dx,
                                    dy: direction.dy,
                                    carried: (nth > 0).into(),
                                    accumulate: second as u32,
                                    ..Pass::default()
                                };
                                let (from, to) = (Buffer(&carry[nth % 2]), Buffer(&carry[1 - nth % 2]));
                                let output = Output::Paths {
                                    directions: pair.to_vec(),
                                    band: rows,
                                    first: second == 0 && strip.first == 0,
                                    last: second + 1 == pair.len() && strip.first + strip.count == width,
                                };
                                let storage = [costs[band], Buffer(&paths[band]), from, to];
                                b.step("sgm_aggregate", &storage, pass, strip.count, 1, output);
                            }
                        }
                    }
                }
                // The horizontal pair, which ends in the winner, a strip of rows at a time.
                let forward = b.buffer("sgm_aggregate.forward", sizes.volume(strip_rows));
                for (band, &rows) in sizes.bands.iter().enumerate() {
                    for strip in cut(rows, strip_rows) {
                        let volume_row = strip.first - rows.first;
                        let pass = Pass { first_row: strip.first, rows: strip.count, volume_row, ..Pass::default() };
                        let along_row = Pass { lines: strip.count, dx: along[0].dx, dy: along[0].dy, ..pass };
                        let directions = along[..1].to_vec();
                        let output = Output::Paths { directions, band: strip, first: true, last: true };
                        let storage = [costs[band], Buffer(&forward), Buffer(&carries[0][0]), Buffer(&carries[0][1])];
                        b.step("sgm_aggregate", &storage, along_row, strip.count, 1, output);
                        let pair = |i: usize| Buffer(&paired[i.min(paired.len() - 1)][band]);
                        let storage = [
                            costs[band],
                            Buffer(&forward),
                            pair(0),
                            pair(1),
                            pair(2),
                            Buffer(&left_map),
                            Buffer(&right_map),
                        ];
                        let output = Output::Views { last: strip.first + strip.count == height };
                        b.step("winner", &storage, pass, strip.count, 1, output);
                    }
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
                map_stride / 4,
                height,
                Output::Checked,
            );
            output = checked;
        }
        if params.median == Median::Three {
            let map = b.copy_to_texels();
            let filtered = b.buffer("median", sizes.map);
            b.step(
                "median",
                &[Texture(&map), Buffer(&filtered)],
                Pass::default(),
                map_stride / 4,
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
    /// the low half, each row padded to a multiple of 16 bytes; [`DisparityMap::INVALID`] where there is none. The buffer may be
    /// longer.
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
        let mut data = Vec::with_capacity(width as usize * height as usize);
        for row in bytes.chunks_exact(4 * map_stride as usize).take(height as usize) {
            data.extend(row[..2 * width as usize].chunks_exact(2).map(|v| i16::from_le_bytes([v[0], v[1]])));
        }
        DisparityMap { width, height, data }
    }

    /// As [`StereoMatcher::compute`], with the time of each stage in order of first use; none where the device was
    /// made without `TIMESTAMP_QUERY`, or there are more steps than a query set can time (2048).
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    pub fn compute_timed(&self, left: &Image, right: &Image) -> Result<(DisparityMap, Vec<StageTime>), Error> {
        // Neighbouring steps of a stage are timed together.
        let runs: Vec<&[Step]> = self.steps.chunk_by(|a, b| a.stage() == b.stage() && a.copy_to.is_none()).collect();
        let count = 2 * runs.len() as u32;
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
        Ok((map, times))
    }
}
