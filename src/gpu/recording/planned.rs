//! Steps whose bind groups are not made yet.

use std::num::NonZeroU64;

use crate::gpu::kernels::{Compiled, KERNELS};
use crate::gpu::layout::Dispatch;
use crate::gpu::recording::step::{CopyTo, Part, Step};
use crate::gpu::recording::written::Written;

/// Distance of the blocks in the uniform buffer of [`Dispatch`]es: the largest alignment that WebGPU allows a device to ask.
pub(super) const DISPATCH_STRIDE: u32 = 256;

/// A step whose bind group is not made yet.
pub(super) struct Planned {
    pub(super) kernel: usize,
    pub(super) level: usize,
    /// None if it is only planned.
    pub(super) compiled: Option<Compiled>,
    pub(super) storage: Vec<Resource>,
    pub(super) dispatch: Dispatch,
    pub(super) workgroups: [u32; 2],
    pub(super) written: Written,
    pub(super) buffer: wgpu::Buffer,
    pub(super) bytes: u64,
    pub(super) clears: bool,
    pub(super) mirrored: bool,
    pub(super) part: Part,
    pub(super) copy_to: Option<CopyTo>,
}

/// What a kernel is bound to.
pub(super) enum Resource {
    /// Where it begins, and how many bytes.
    Buffer(wgpu::Buffer, u64, u64),
    Texture(wgpu::TextureView),
}

impl Planned {
    /// The step, bound to the uniform blocks of its frame and to those of all dispatches, of which its own begins at `dispatch`.
    /// `None` if it is only planned.
    pub(super) fn finished(
        self,
        device: &wgpu::Device,
        frame: &wgpu::Buffer,
        dispatches: &wgpu::Buffer,
        dispatch: u32,
    ) -> Option<Step> {
        let Compiled { layout, pipeline, text } = self.compiled?;
        let part_of = |buffer, offset, bytes| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size: NonZeroU64::new(bytes) })
        };
        let uniforms = [frame.as_entire_binding(), part_of(dispatches, 0, size_of::<Dispatch>() as u64)];
        let storage = self.storage.iter().map(|resource| match resource {
            Resource::Buffer(buffer, offset, bytes) => part_of(buffer, *offset, *bytes),
            Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
        });
        let entries: Vec<_> = (0..)
            .zip(uniforms.into_iter().chain(storage))
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&format!("gpu-stereo.{}", KERNELS[self.kernel].name)),
            layout: &layout,
            entries: &entries,
        });
        Some(Step {
            kernel: self.kernel,
            level: self.level,
            text,
            pipeline,
            bind_group,
            dispatch,
            workgroups: self.workgroups,
            written: self.written,
            buffer: self.buffer,
            bytes: self.bytes,
            clears: self.clears,
            mirrored: self.mirrored,
            part: self.part,
            copy_to: self.copy_to,
        })
    }
}
