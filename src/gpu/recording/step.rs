//! A step: one dispatch.

use std::sync::Arc;

use crate::gpu::kernels::KERNELS;
use crate::gpu::recording::pool::row_bytes;
use crate::gpu::recording::written::Written;

/// A step's place among those that leave an written together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) first: bool,
    pub(crate) last: bool,
}

/// One dispatch, and what is copied after it.
#[derive(Debug)]
pub(crate) struct Step {
    /// Its row of [`KERNELS`].
    pub(super) kernel: usize,
    /// The [`Level`] that it belongs to.
    pub(crate) level: usize,
    /// The text of that kernel.
    pub(super) text: Arc<str>,
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) bind_group: wgpu::BindGroup,
    /// The offset of its [`Dispatch`] in the uniform buffer.
    pub(crate) dispatch: u32,
    pub(crate) workgroups: [u32; 2],
    pub(crate) written: Written,
    pub(crate) buffer: wgpu::Buffer,
    /// Bytes of it that are in use.
    pub(crate) bytes: u64,
    /// Whether `buffer` is filled with zeros before.
    pub(crate) clears: bool,
    /// Whether this is of the mirrored pair.
    pub(crate) mirrored: bool,
    /// Whether it is the first, and the last, of the steps that leave the written together, some rows each.
    pub(crate) part: Part,
    /// What `buffer` is copied into when it is complete.
    pub(crate) copy_to: Option<CopyTo>,
}

/// What a buffer is copied into.
#[derive(Clone, Debug)]
pub(crate) enum CopyTo {
    /// A texture, so many texels and rows of them.
    Texture(wgpu::Texture, [u32; 2]),
    /// A buffer: from which byte on, and how many bytes.
    Buffer(wgpu::Buffer, u64, u64),
}

impl Step {
    pub(crate) fn stage(&self) -> &'static str {
        KERNELS[self.kernel].stage
    }

    /// The name of its kernel and its text.
    pub(crate) fn shader(&self) -> (&'static str, &str) {
        (KERNELS[self.kernel].name, &self.text)
    }

    /// Records the copy of what the step left, if there is one.
    pub(crate) fn record_copy(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(CopyTo::Buffer(buffer, offset, bytes)) = &self.copy_to {
            encoder.copy_buffer_to_buffer(&self.buffer, 0, buffer, *offset, *bytes);
        }
        if let Some(CopyTo::Texture(texture, [width, height])) = &self.copy_to {
            let bytes_per_row = Some(row_bytes(texture.format(), *width));
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
            let source = wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout };
            let size = wgpu::Extent3d { width: *width, height: *height, depth_or_array_layers: 1 };
            encoder.copy_buffer_to_texture(source, texture.as_image_copy(), size);
        }
    }
}

/// Records steps in one compute pass. Only the first one may clear, only the last one copy.
pub(crate) fn record_steps(
    encoder: &mut wgpu::CommandEncoder,
    label: &str,
    steps: &[Step],
    timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
) {
    if let Some(step) = steps.first().filter(|step| step.clears) {
        encoder.clear_buffer(&step.buffer, 0, Some(step.bytes));
    }
    let label = Some(label);
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
    for step in steps {
        pass.set_pipeline(&step.pipeline);
        pass.set_bind_group(0, &step.bind_group, &[step.dispatch]);
        pass.dispatch_workgroups(step.workgroups[0], step.workgroups[1], 1);
    }
    drop(pass);
    if let Some(step) = steps.last() {
        step.record_copy(encoder);
    }
}
