//! The only code that waits for the device.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::Error;

/// A buffer that the host reads.
pub(crate) fn buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Runs `work` and returns what the device objects to, instead of leaving it to the caller's error handler.
pub(crate) fn guarded<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> Result<T, Error> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let result = work();
    let (validation, internal, memory) = (ready(validation.pop()), ready(internal.pop()), ready(memory.pop()));
    // What is made without memory is invalid afterwards: the cause comes before its consequences.
    match [memory, internal, validation].into_iter().flatten().flatten().next() {
        None => Ok(result),
        Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory),
        Some(error) => Err(Error::Lost(one_line(&error.to_string()))),
    }
}

/// The result of a future that is ready at once, as those of error scopes are outside browsers.
fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Waits for all submitted work, then hands the bytes of `buffer` to `take`.
pub(crate) fn read<T>(device: &wgpu::Device, buffer: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> T) -> Result<T, Error> {
    let lost = |error: &dyn std::fmt::Display| Error::Lost(one_line(&error.to_string()));
    let (sender, receiver) = std::sync::mpsc::channel();
    guarded(device, || {
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only if polling failed, and then that error is the one to tell.
            let _ = sender.send(result);
        });
    })?;
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| lost(&error))?;
    receiver.recv().map_err(|error| lost(&error))?.map_err(|error| lost(&error))?;
    let value = match buffer.get_mapped_range(..) {
        Ok(view) => Ok(take(&view)),
        Err(error) => Err(lost(&error)),
    };
    buffer.unmap();
    value
}

/// Copies `bytes` from the start of `buffer` to the host.
pub(crate) fn copy(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    from: &wgpu::Buffer,
    bytes: u64,
) -> Result<Vec<u8>, Error> {
    let staging = guarded(device, || {
        let staging = buffer(device, "gpu-stereo.readback", bytes);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(from, 0, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        staging
    })?;
    read(device, &staging, <[u8]>::to_vec)
}
