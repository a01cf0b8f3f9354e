//! Timestamps of a frame.

use crate::gpu::readback;

/// What timestamps are written to and read from.
#[derive(Debug)]
pub(super) struct Timer {
    pub(super) queries: wgpu::QuerySet,
    pub(super) resolved: wgpu::Buffer,
    pub(super) readback: wgpu::Buffer,
}

impl Timer {
    /// For `count` timestamps.
    pub(super) fn new(device: &wgpu::Device, count: u32) -> Self {
        let bytes = 8 * u64::from(count);
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("gpu-stereo.timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("gpu-stereo.timestamps"),
                size: bytes,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            readback: readback::buffer(device, "gpu-stereo.timestamps", bytes),
        }
    }
}
