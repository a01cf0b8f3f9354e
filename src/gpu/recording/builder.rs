//! Builds the list of steps: buffers, textures, pipelines, bind groups and dispatches.

use std::collections::HashMap;
use std::sync::Arc;

use crate::gpu::kernels::{self, Compiled, KERNELS};
use crate::gpu::layout::{Dispatch, ROW_UNIT, Rows, Sizes, TEXELS, TEXTURE_ROW};
use crate::gpu::plan::Plan;
use crate::gpu::recording::level::Level;
use crate::gpu::recording::planned::{DISPATCH_STRIDE, Planned, Resource};
use crate::gpu::recording::pool::{Pool, Shared, Sized, SizedTexture, take};
use crate::gpu::recording::step::{CopyTo, Part, Step};
use crate::gpu::recording::weights::Weights;
use crate::gpu::recording::written::Written;
use crate::network::Network;
use crate::{Params, PixelFormat};

/// Compiled kernels that are kept though no step needs them: settings that change to and fro find theirs again.
const MOST_SPARE_KERNELS: usize = 256;

/// What a kernel is bound to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bound<'a> {
    Buffer(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
    /// A buffer with so many bytes a row of the image. [`Builder::step_rows`] binds the rows that it works on.
    Rows(&'a wgpu::Buffer, u64),
    /// Bytes of a buffer: where they begin, and how many.
    Part(&'a wgpu::Buffer, u64, u64),
}

/// Makes buffers and steps.
pub(crate) struct Builder<'a> {
    device: &'a wgpu::Device,
    pub(crate) levels: &'a [Level],
    pub(crate) level: usize,
    /// The settings of the kernels that are made next.
    pub(crate) params: Params,
    pub(crate) plan: Plan,
    pub(crate) format: PixelFormat,
    pub(crate) sizes: &'a Sizes,
    /// Whether the steps that are made next are of the mirrored pair.
    pub(crate) mirrored: bool,
    shared: Option<(Shared<wgpu::Buffer>, Shared<wgpu::Texture>)>,
    /// What is there and not in use.
    free: Pool,
    /// What is in use.
    used: Pool,
    /// Bytes that were asked for of each buffer in use.
    bytes: HashMap<wgpu::Buffer, u64>,
    planned: Vec<Planned>,
    /// Buffers and textures are made as small as can be, and nothing is compiled: only the sizes are wanted.
    only_planned: bool,
    tables: Vec<(wgpu::Buffer, Vec<u32>)>,
    unwritten: Vec<Weights>,
    /// The kernels so far, and what they were compiled for.
    kernels: Vec<(usize, PixelFormat, Plan, Params, Compiled)>,
}

impl<'a> Builder<'a> {
    /// A builder for the last of the levels, which takes buffers, textures and kernels from `free` where they fit.
    pub(crate) fn new(device: &'a wgpu::Device, levels: &'a [Level], format: PixelFormat, free: Pool) -> Self {
        let level = levels.len() - 1;
        let Level { params, plan, sizes, .. } = &levels[level];
        Self {
            device,
            levels,
            level,
            params: params.clone(),
            plan: *plan,
            format,
            sizes,
            mirrored: false,
            shared: None,
            free,
            used: Pool::default(),
            bytes: HashMap::new(),
            planned: Vec::new(),
            only_planned: false,
            tables: Vec::new(),
            unwritten: Vec::new(),
            kernels: Vec::new(),
        }
    }

    /// The same, but only to measure what the list of steps needs: nothing of any size is made.
    pub(crate) fn only_planned(self) -> Self {
        Self { only_planned: true, ..self }
    }

    /// All that was planned, and what was free and did not fit.
    pub(crate) fn plan(mut self) -> Pool {
        self.used.join(self.free);
        self.used
    }

    /// Goes on with another level.
    pub(crate) fn enter(&mut self, level: usize) {
        let Level { params, plan, sizes, .. } = &self.levels[level];
        let params = if self.mirrored { params.second() } else { params.clone() };
        (self.level, self.params, self.plan, self.sizes) = (level, params, *plan, sizes);
    }

    /// Has the buffer that the last step writes filled with zeros before it.
    pub(crate) fn clear(&mut self) {
        if let Some(step) = self.planned.last_mut() {
            step.clears = true;
        }
    }

    /// Starts a run over shared allocations: until sharing ends, the n-th request returns what the n-th request of the run before
    /// returned. Safe once nothing reads the data of the run before.
    pub(crate) fn share(&mut self) {
        let (buffers, textures) = self.shared.get_or_insert_default();
        (buffers.taken, textures.taken) = (HashMap::new(), HashMap::new());
    }

    /// Ends sharing: further requests return allocations of their own.
    pub(crate) fn share_no_more(&mut self) {
        self.shared = None;
    }

    pub(crate) fn buffer(&mut self, name: &str, size: u64) -> wgpu::Buffer {
        self.buffer_of(name, size, size)
    }

    /// A buffer of which `size` bytes are asked for; where it must be made, it gets `room` for more, which a smaller image
    /// may take.
    pub(crate) fn buffer_of(&mut self, name: &str, size: u64, room: u64) -> wgpu::Buffer {
        let key = format!("{name} {size}");
        if let Some(buffer) = self.shared.as_mut().and_then(|(buffers, _)| buffers.next(&key)) {
            return buffer;
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = self.made(name, size, room, usage);
        if let Some((buffers, _)) = &mut self.shared {
            buffers.keep(key, &buffer);
        }
        buffer
    }

    /// A buffer that is free, or a new one.
    fn made(&mut self, name: &str, size: u64, room: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let key = (name.to_string(), usage);
        let free = self.free.buffers.entry(key.clone()).or_default();
        let made = take(free, |buffer| buffer.size >= size, |buffer| buffer.size).unwrap_or_else(|| {
            let item = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&format!("gpu-stereo.{name}")),
                size: if self.only_planned { 16 } else { size.max(room) },
                usage,
                mapped_at_creation: false,
            });
            Sized { item, size: size.max(room) }
        });
        let buffer = made.item.clone();
        self.bytes.insert(buffer.clone(), size);
        self.used.buffers.entry(key).or_default().push(made);
        buffer
    }

    /// A buffer of numbers that the kernels only read.
    pub(crate) fn table(&mut self, name: &str, contents: Vec<u32>) -> wgpu::Buffer {
        let buffer = self.buffer(name, 4 * contents.len() as u64);
        if !self.only_planned {
            self.tables.push((buffer.clone(), contents));
        }
        buffer
    }

    /// The weights of a network, as the plan wants them.
    pub(crate) fn weights(&mut self, network: &Network) -> Weights {
        let per_subgroup = self.plan.per_subgroup;
        let known = self.used.weights.clone().or(self.free.weights.clone());
        if let Some(weights) = known.filter(|weights| weights.are_of(network, per_subgroup)) {
            self.used.weights = Some(weights.clone());
            return weights;
        }
        let weights = Weights::new(self.device, network, per_subgroup, self.only_planned);
        self.used.weights = Some(weights.clone());
        if !self.only_planned {
            self.unwritten.push(weights.clone());
        }
        weights
    }

    /// Volumes with a byte a disparity, a buffer a band, which holds `slots` of them one after the other.
    pub(crate) fn volumes(&mut self, name: &str, slots: u32) -> Vec<wgpu::Buffer> {
        let sizes = self.sizes;
        let room = sizes.bands.first().map_or(0, |band| sizes.volume(slots * band.count));
        sizes.bands.iter().map(|band| self.buffer_of(name, sizes.volume(slots * band.count), room)).collect()
    }

    /// A texture of at least `width` texels a row, to be filled by copies; where it must be made, with `room` for so many
    /// rows.
    pub(crate) fn texture(
        &mut self,
        name: &str,
        [width, height]: [u32; 2],
        room: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        let shared = format!("{name} {width} {height} {format:?}");
        if let Some(texture) = self.shared.as_mut().and_then(|(_, textures)| textures.next(&shared)) {
            return texture;
        }
        let key = (name.to_string(), format);
        let free = self.free.textures.entry(key.clone()).or_default();
        let enough = |texture: &SizedTexture| texture.size[0] >= width && texture.size[1] >= height;
        let area = |texture: &SizedTexture| u64::from(texture.size[0]) * u64::from(texture.size[1]);
        let made = take(free, enough, area).unwrap_or_else(|| {
            let size = [width, height.max(room)];
            let [width, height] = if self.only_planned { [1, 1] } else { size };
            let item = self.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(&format!("gpu-stereo.{name}")),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            Sized { item, size }
        });
        let texture = made.item.clone();
        self.used.textures.entry(key).or_default().push(made);
        if let Some((_, textures)) = &mut self.shared {
            textures.keep(shared, &texture);
        }
        texture
    }

    /// Copies what the last step left into a texture of `size` texels and rows; `room` as of [`Builder::texture`].
    pub(crate) fn copy_to_texture(
        &mut self,
        size: [u32; 2],
        room: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::TextureView {
        let texture = self.texture("copy", size, room, format);
        self.copy_into(&texture, size)
    }

    /// Copies what the last step left into `size` texels and rows of a texture.
    pub(crate) fn copy_into(&mut self, texture: &wgpu::Texture, size: [u32; 2]) -> wgpu::TextureView {
        if let Some(step) = self.planned.last_mut() {
            step.copy_to = Some(CopyTo::Texture(texture.clone(), size));
        }
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Copies the first bytes of what the last step left into a buffer, from `offset` on.
    pub(crate) fn copy_to_buffer(&mut self, buffer: &wgpu::Buffer, offset: u64, bytes: u64) {
        if let Some(step) = self.planned.last_mut() {
            step.copy_to = Some(CopyTo::Buffer(buffer.clone(), offset, bytes));
        }
    }

    /// Copies what the last step left into a texture of 16 bytes a texel, [`TEXELS`] a row: lavapipe reads 16 bytes of an
    /// image in a quarter of the time that a buffer takes, but writes buffers faster (docs/PERFORMANCE.md).
    pub(crate) fn copy_to_texels(&mut self) -> wgpu::TextureView {
        let bytes = self.planned.last().map_or(0, |step| step.bytes);
        self.copy_first_to_texels(bytes, bytes)
    }

    /// The same of the first bytes of what it left; `room` for so many.
    pub(crate) fn copy_first_to_texels(&mut self, bytes: u64, room: u64) -> wgpu::TextureView {
        let [rows, room] = [bytes, room].map(|bytes| (bytes / TEXTURE_ROW) as u32);
        self.copy_to_texture([TEXELS, rows], room, wgpu::TextureFormat::Rgba32Uint)
    }

    /// One dispatch for `lines` x `rows` lines of the kernel. The first of `storage` that the kernel writes is what it leaves.
    pub(crate) fn step(
        &mut self,
        name: &str,
        storage: &[Bound<'_>],
        dispatch: Dispatch,
        lines: u32,
        rows: u32,
        written: Written,
    ) {
        let Some(kernel) = KERNELS.iter().position(|kernel| kernel.name == name) else {
            unreachable!("{name} is not in the table of kernels");
        };
        let row = &KERNELS[kernel];
        let compiled = if self.only_planned { None } else { Some(self.compiled(kernel)) };
        let accesses = row.storage(&self.params, &self.plan);
        let first = |wanted| accesses.iter().position(|access| *access == wanted);
        let target = first(kernels::Access::Write).or_else(|| first(kernels::Access::Trees));
        let Some(Bound::Buffer(buffer) | Bound::Rows(buffer, _) | Bound::Part(buffer, ..)) = target.map(|i| storage[i])
        else {
            unreachable!("{name} writes no buffer");
        };
        let resource = |bound: &Bound<'_>| match *bound {
            Bound::Buffer(buffer) => Resource::Buffer(buffer.clone(), 0, self.bytes_of(buffer)),
            Bound::Rows(buffer, row) => {
                // All rows may fit a binding, where with what pads them they do not.
                let (all, rows) = (self.bytes_of(buffer), row * u64::from(self.sizes.frame.height));
                Resource::Buffer(buffer.clone(), 0, if all <= self.sizes.binding { all } else { rows })
            }
            Bound::Part(buffer, from, bytes) => Resource::Buffer(buffer.clone(), from, bytes),
            Bound::Texture(view) => Resource::Texture(view.clone()),
        };
        let invocations = lines * row.members(&self.plan);
        self.planned.push(Planned {
            kernel,
            level: self.level,
            compiled,
            storage: storage.iter().map(resource).collect(),
            dispatch,
            workgroups: [invocations.div_ceil(row.lanes(&self.plan)), rows],
            written,
            buffer: buffer.clone(),
            bytes: self.bytes_of(buffer),
            clears: false,
            mirrored: self.mirrored,
            part: Part { first: true, last: true },
            copy_to: None,
        });
    }

    /// The rows of the image, of which each lot fits a binding of every [`Bound::Rows`].
    pub(crate) fn lots(&self, storage: &[Bound<'_>]) -> Vec<Rows> {
        let rows = |bound: &Bound<'_>| if let Bound::Rows(_, row) = bound { Some(*row) } else { None };
        let (height, widest) = (self.sizes.frame.height, storage.iter().filter_map(rows).max().unwrap_or(1));
        if widest * u64::from(height) <= self.sizes.binding {
            return vec![Rows { first: 0, count: height }];
        }
        let count = (self.sizes.binding / widest / ROW_UNIT * ROW_UNIT) as u32;
        let lot = |first| Rows { first, count: count.min(height - first) };
        (0..height).step_by(count as usize).map(lot).collect()
    }

    /// What is bound of a resource for some rows of the image.
    pub(crate) fn lot<'b>(&self, bound: Bound<'b>, rows: Rows) -> Bound<'b> {
        match bound {
            Bound::Rows(buffer, row) if rows.count < self.sizes.frame.height => {
                Bound::Part(buffer, u64::from(rows.first) * row, u64::from(rows.count) * row)
            }
            bound => bound,
        }
    }

    /// [`Builder::step`] for `lines` lines of each row of the image, or as many of `rows_each` rows together, in as many steps
    /// as bindings ask for.
    pub(crate) fn step_rows(
        &mut self,
        name: &str,
        storage: &[Bound<'_>],
        dispatch: Dispatch,
        lines: u32,
        rows_each: u32,
        written: Written,
    ) {
        let lots = self.lots(storage);
        for (i, &rows) in lots.iter().enumerate() {
            let bound: Vec<_> = storage.iter().map(|&bound| self.lot(bound, rows)).collect();
            let dispatch = Dispatch { first_row: rows.first, rows: rows.count, ..dispatch };
            self.step(name, &bound, dispatch, lines, rows.count.div_ceil(rows_each), written.clone());
            self.part_of(i, lots.len());
        }
    }

    /// The last step is one of several that leave an written together.
    pub(crate) fn part_of(&mut self, i: usize, count: usize) {
        if let Some(step) = self.planned.last_mut() {
            step.part = Part { first: i == 0, last: i + 1 == count };
        }
    }

    /// A kernel for the present settings: one of this list of steps, one of before, or a new one.
    fn compiled(&mut self, kernel: usize) -> Compiled {
        let known = self.kernels.iter().find(|(other, format, plan, params, _)| {
            (*other, *format, *plan) == (kernel, self.format, self.plan) && *params == self.params
        });
        if let Some((.., compiled)) = known {
            return compiled.clone();
        }
        let row = &KERNELS[kernel];
        let text: Arc<str> = kernels::source(row, &self.params, self.format, &self.plan).into();
        let key = (kernel, self.params.shader_checks, text.clone());
        let compiled = self.used.compiled.get(&key).cloned().unwrap_or_else(|| {
            let known = self.free.compiled.remove(&key);
            let compiled = known.unwrap_or_else(|| kernels::compile(self.device, row, text, &self.params, &self.plan));
            self.used.compiled.insert(key, compiled.clone());
            compiled
        });
        self.kernels.push((kernel, self.format, self.plan, self.params.clone(), compiled.clone()));
        compiled
    }

    /// The bytes that were asked for of a buffer.
    fn bytes_of(&self, buffer: &wgpu::Buffer) -> u64 {
        self.bytes.get(buffer).copied().unwrap_or_else(|| buffer.size())
    }

    /// The steps, with the uniform blocks that they read, and the pool: all that was made, or was free and did not fit.
    pub(crate) fn finish(mut self, queue: &wgpu::Queue) -> (Vec<Step>, Pool) {
        for (buffer, contents) in &self.tables {
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(contents));
        }
        for weights in &self.unwritten {
            weights.write(queue);
        }
        let mut blocks = vec![0u8; self.planned.len() * DISPATCH_STRIDE as usize];
        for (block, step) in blocks.chunks_exact_mut(DISPATCH_STRIDE as usize).zip(&self.planned) {
            block[..size_of::<Dispatch>()].copy_from_slice(bytemuck::bytes_of(&step.dispatch));
        }
        // There may be more steps for a smaller image.
        let (levels, room) = (self.levels, 2 * blocks.len() as u64);
        let frames: Vec<_> = levels
            .iter()
            .map(|level| self.uniform(queue, "frame", bytemuck::bytes_of(&level.sizes.frame), 0))
            .collect();
        let dispatches = self.uniform(queue, "dispatches", &blocks, room);
        let finished = |(i, step): (u32, Planned)| {
            let frame = &frames[step.level];
            step.finished(self.device, frame, &dispatches, i * DISPATCH_STRIDE)
        };
        let steps = (0..).zip(self.planned).filter_map(finished).collect();
        if self.free.compiled.len() < MOST_SPARE_KERNELS {
            self.used.compiled.extend(std::mem::take(&mut self.free.compiled));
        }
        self.used.join(self.free);
        (steps, self.used)
    }

    fn uniform(&mut self, queue: &wgpu::Queue, name: &str, contents: &[u8], room: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = self.made(name, contents.len() as u64, room, usage);
        queue.write_buffer(&buffer, 0, contents);
        buffer
    }
}
