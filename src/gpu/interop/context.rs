//! The matcher's side of a frame.

use crate::gpu::device::Pulse;
use crate::gpu::layout::Frame;
use crate::{Params, PixelFormat};

/// The matcher's side: its device and settings, and where its chain begins and ends.
pub(crate) struct Context<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) pulse: &'a Pulse,
    pub(crate) frame: &'a Frame,
    pub(crate) format: PixelFormat,
    pub(crate) params: &'a Params,
    pub(crate) sources: &'a [wgpu::Texture; 2],
    pub(crate) output: &'a wgpu::Buffer,
    pub(crate) right: Option<&'a wgpu::Buffer>,
    pub(crate) confidence: Option<&'a wgpu::Buffer>,
    pub(crate) depth: Option<&'a wgpu::Buffer>,
}
