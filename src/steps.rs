//! Builds the list of steps: buffers, textures, pipelines, bind groups and dispatches.

use std::collections::HashMap;

use crate::buffers::{Frame, Pass, Rows, Sizes, TEXELS, TEXTURE_ROW};
use crate::kernels::{self, Compiled, KERNELS};
use crate::reference::Direction;
use crate::schedule::Plan;
use crate::{Params, PixelFormat};

/// What a step leaves behind, and where: for the comparison with the reference.
#[derive(Clone, Debug)]
pub(crate) enum Output {
    /// Luma in 8 bits, or with `deep` the channel of an image in 16 bits.
    Gray {
        side: usize,
        channel: usize,
        deep: bool,
    },
    /// What a stage leaves for a later kernel of the same stage.
    Part,
    /// Sums over windows of an image, prefiltered or not.
    WindowSums {
        side: usize,
        channel: usize,
        filtered: bool,
        window: u32,
    },
    /// A prefiltered image, laid out like a gray one.
    Prefiltered {
        side: usize,
        channel: usize,
    },
    /// `count` planes of features, from `first` on.
    Features {
        side: usize,
        first: usize,
        count: usize,
    },
    /// The values that are halved, or what came of it, laid out like a gray image.
    Values {
        side: usize,
    },
    Histogram,
    Table,
    Columns {
        chunk: Rows,
    },
    /// Of a forward direction.
    Penalties {
        direction: Direction,
    },
    Cost {
        chunk: Rows,
        volume_row: u32,
    },
    /// Of the blocks of one side.
    BlockStatistics {
        side: usize,
        chunk: Rows,
    },
    /// The paths of all directions together, when the last of their steps is done.
    Paths {
        directions: Vec<Direction>,
        band: Rows,
        volume_row: u32,
        first: bool,
        last: bool,
    },
    /// Both views; the right one, and the margins, are in `right`.
    Views {
        right: wgpu::Buffer,
        last: bool,
    },
    /// The right view of a second match.
    Mirrored,
    Textured,
    Checked,
    Speckle,
    Median,
    Fill,
    WeightedMedian,
    Wls,
    Confidence,
}

/// A pass through the chain: its settings, and what follows from them.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    /// How often the images are halved.
    pub(crate) halvings: u32,
    pub(crate) params: Params,
    pub(crate) plan: Plan,
    pub(crate) sizes: Sizes,
}

/// One dispatch, and what is copied after it.
#[derive(Debug)]
pub(crate) struct Step {
    kernel: usize,
    /// The [`Level`] that it belongs to.
    pub(crate) level: usize,
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) bind_group: wgpu::BindGroup,
    /// The offset of its [`Pass`] in the uniform buffer.
    pub(crate) pass: u32,
    pub(crate) workgroups: [u32; 2],
    pub(crate) output: Output,
    pub(crate) buffer: wgpu::Buffer,
    /// Whether `buffer` is filled with zeros before.
    pub(crate) clears: bool,
    /// Whether this is of the mirrored pair.
    pub(crate) mirrored: bool,
    /// The texture that `buffer` is copied into when it is complete, row by row.
    pub(crate) copy_to: Option<wgpu::Texture>,
}

impl Step {
    pub(crate) fn stage(&self) -> &'static str {
        KERNELS[self.kernel].stage
    }
}

/// Distance of the blocks in the uniform buffer of [`Pass`]es: the largest alignment that WebGPU allows a device to ask.
const PASS_STRIDE: u32 = 256;

/// What a kernel is bound to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bound<'a> {
    Buffer(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView),
}

/// Bytes of a row of `width` texels.
pub(crate) fn row_bytes(format: wgpu::TextureFormat, width: u32) -> u32 {
    format.block_copy_size(None).unwrap_or(0) * width
}

/// A step whose bind group is not made yet.
struct Planned {
    kernel: usize,
    level: usize,
    compiled: Compiled,
    storage: Vec<Resource>,
    pass: Pass,
    workgroups: [u32; 2],
    output: Output,
    buffer: wgpu::Buffer,
    clears: bool,
    mirrored: bool,
    copy_to: Option<wgpu::Texture>,
}

enum Resource {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
}

/// What is made once and asked for twice.
struct Shared<T> {
    made: HashMap<String, Vec<T>>,
    taken: HashMap<String, usize>,
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self { made: HashMap::new(), taken: HashMap::new() }
    }
}

impl<T: Clone> Shared<T> {
    fn next(&mut self, key: &str) -> Option<T> {
        let taken = self.taken.entry(key.into()).or_default();
        let next = self.made.get(key)?.get(*taken)?.clone();
        *taken += 1;
        Some(next)
    }

    fn keep(&mut self, key: String, made: &T) {
        *self.taken.entry(key.clone()).or_default() += 1;
        self.made.entry(key).or_default().push(made.clone());
    }
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
    compiled: HashMap<(usize, String), Compiled>,
    planned: Vec<Planned>,
    tables: Vec<(wgpu::Buffer, Vec<u32>)>,
    pub(crate) device_bytes: u64,
}

impl<'a> Builder<'a> {
    /// A builder for the last of the levels.
    pub(crate) fn new(device: &'a wgpu::Device, levels: &'a [Level], format: PixelFormat) -> Self {
        let (compiled, planned, tables) = (HashMap::new(), Vec::new(), Vec::new());
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
            compiled,
            planned,
            tables,
            device_bytes: 0,
        }
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

    /// Until sharing ends, what is asked for the n-th time since this was called is what was asked for the n-th time
    /// since it was called before: for work that is done again, when nothing reads any more what the first left.
    pub(crate) fn share(&mut self) {
        let (buffers, textures) = self.shared.get_or_insert_default();
        (buffers.taken, textures.taken) = (HashMap::new(), HashMap::new());
    }

    /// All is made anew from here on.
    pub(crate) fn share_no_more(&mut self) {
        self.shared = None;
    }

    pub(crate) fn buffer(&mut self, name: &str, size: u64) -> wgpu::Buffer {
        let key = format!("{name} {size}");
        if let Some(buffer) = self.shared.as_mut().and_then(|(buffers, _)| buffers.next(&key)) {
            return buffer;
        }
        self.device_bytes += size;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(&format!("gpu-stereo.{name}")),
            size,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if let Some((buffers, _)) = &mut self.shared {
            buffers.keep(key, &buffer);
        }
        buffer
    }

    /// A buffer of numbers that the kernels only read.
    pub(crate) fn table(&mut self, name: &str, contents: Vec<u32>) -> wgpu::Buffer {
        let buffer = self.buffer(name, 4 * contents.len() as u64);
        self.tables.push((buffer.clone(), contents));
        buffer
    }

    /// Volumes with a byte a disparity, a buffer a band, which holds `slots` of them one after the other.
    pub(crate) fn volumes(&mut self, name: &str, slots: u32) -> Vec<wgpu::Buffer> {
        let sizes = self.sizes;
        sizes.bands.iter().map(|band| self.buffer(name, sizes.volume(slots * band.count))).collect()
    }

    /// A texture of `width` texels a row, to be filled by copies.
    pub(crate) fn texture(
        &mut self,
        name: &str,
        width: u32,
        height: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        let key = format!("{name} {width} {height} {format:?}");
        if let Some(texture) = self.shared.as_mut().and_then(|(_, textures)| textures.next(&key)) {
            return texture;
        }
        self.device_bytes += u64::from(row_bytes(format, width)) * u64::from(height);
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&format!("gpu-stereo.{name}")),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        if let Some((_, textures)) = &mut self.shared {
            textures.keep(key, &texture);
        }
        texture
    }

    /// Copies what the last step left into a texture of `width` texels a row.
    pub(crate) fn copy_to_texture(
        &mut self,
        width: u32,
        height: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::TextureView {
        let texture = self.texture("copy", width, height, format);
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        if let Some(step) = self.planned.last_mut() {
            step.copy_to = Some(texture);
        }
        view
    }

    /// Copies what the last step left into a texture of 16 bytes a texel, [`TEXELS`] a row: lavapipe reads 16 bytes of an
    /// image in a quarter of the time that a buffer takes, but writes buffers faster (docs/PERFORMANCE.md).
    pub(crate) fn copy_to_texels(&mut self) -> wgpu::TextureView {
        let bytes = self.planned.last().map_or(0, |step| step.buffer.size());
        self.copy_first_to_texels(bytes)
    }

    /// The same of the first bytes of what it left.
    pub(crate) fn copy_first_to_texels(&mut self, bytes: u64) -> wgpu::TextureView {
        self.copy_to_texture(TEXELS, (bytes / TEXTURE_ROW) as u32, wgpu::TextureFormat::Rgba32Uint)
    }

    /// One dispatch for `lines` x `rows` lines of the kernel. The first of `storage` that the kernel writes is what it leaves.
    pub(crate) fn step(
        &mut self,
        name: &str,
        storage: &[Bound<'_>],
        pass: Pass,
        lines: u32,
        rows: u32,
        output: Output,
    ) {
        let Some(kernel) = KERNELS.iter().position(|kernel| kernel.name == name) else {
            unreachable!("{name} is not in the table of kernels");
        };
        let row = &KERNELS[kernel];
        let text = kernels::source(row, &self.params, self.format, &self.plan);
        let compiled = self
            .compiled
            .entry((kernel, text))
            .or_insert_with_key(|(_, text)| kernels::compile(self.device, row, text, &self.params, &self.plan));
        let written = row.storage.iter().position(|access| *access == kernels::Access::Write);
        let Some(Bound::Buffer(buffer)) = written.map(|i| storage[i]) else {
            unreachable!("{name} writes no buffer");
        };
        let resource = |bound: &Bound<'_>| match *bound {
            Bound::Buffer(buffer) => Resource::Buffer(buffer.clone()),
            Bound::Texture(view) => Resource::Texture(view.clone()),
        };
        let invocations = lines * row.members(&self.plan);
        self.planned.push(Planned {
            kernel,
            level: self.level,
            compiled: compiled.clone(),
            storage: storage.iter().map(resource).collect(),
            pass,
            workgroups: [invocations.div_ceil(row.lanes(&self.plan)), rows],
            output,
            buffer: buffer.clone(),
            clears: false,
            mirrored: self.mirrored,
            copy_to: None,
        });
    }

    /// The steps, with the uniform blocks that they read, and the bytes of all that was made.
    pub(crate) fn finish(mut self, queue: &wgpu::Queue) -> (Vec<Step>, u64) {
        let uniform = |name: &str, contents: &[u8]| {
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&format!("gpu-stereo.{name}")),
                size: contents.len() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        for (buffer, contents) in &self.tables {
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(contents));
        }
        let mut blocks = vec![0u8; self.planned.len() * PASS_STRIDE as usize];
        for (block, step) in blocks.chunks_exact_mut(PASS_STRIDE as usize).zip(&self.planned) {
            block[..size_of::<Pass>()].copy_from_slice(bytemuck::bytes_of(&step.pass));
        }
        let frames = self.levels.iter().map(|level| uniform("frame", bytemuck::bytes_of(&level.sizes.frame)));
        let (frames, passes): (Vec<_>, _) = (frames.collect(), uniform("passes", &blocks));
        self.device_bytes += (frames.len() * size_of::<Frame>() + blocks.len()) as u64;
        let block = (size_of::<Pass>() as u64).try_into().ok();
        let finished = |(pass, step): (u32, Planned)| {
            let passes = wgpu::BufferBinding { buffer: &passes, offset: 0, size: block };
            let uniforms = [frames[step.level].as_entire_binding(), wgpu::BindingResource::Buffer(passes)];
            let storage = step.storage.iter().map(|resource| match resource {
                Resource::Buffer(buffer) => buffer.as_entire_binding(),
                Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
            });
            let entries: Vec<_> = (0..)
                .zip(uniforms.into_iter().chain(storage))
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect();
            let bind_group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&format!("gpu-stereo.{}", KERNELS[step.kernel].name)),
                layout: &step.compiled.layout,
                entries: &entries,
            });
            Step {
                kernel: step.kernel,
                level: step.level,
                pipeline: step.compiled.pipeline,
                bind_group,
                pass: pass * PASS_STRIDE,
                workgroups: step.workgroups,
                output: step.output,
                buffer: step.buffer,
                clears: step.clears,
                mirrored: step.mirrored,
                copy_to: step.copy_to,
            }
        };
        ((0..).zip(self.planned).map(finished).collect(), self.device_bytes)
    }
}
