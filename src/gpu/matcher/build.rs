//! From levels to a list of steps, and the memory that it needs.

use crate::gpu::chain::{Ends, chain};
use crate::gpu::layout::Frame;
use crate::gpu::maps::MapBytes;
use crate::gpu::recording::{Builder, Level, Pool, Step};
use crate::gpu::scopes;
use crate::gpu::spans::span;
use crate::{Error, PixelFormat, memory};

/// Bytes that a driver on the CPU takes to compile and to run the kernels, measured with lavapipe.
pub(super) const COMPILING: u64 = 64 << 20;

/// Builds a list of steps from what `pool` has.
pub(super) fn build(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    format: PixelFormat,
    levels: &[Level],
    pool: Pool,
) -> (Ends, Vec<Step>, Pool) {
    span!(DEBUG, "build", levels = levels.len());
    let mut builder = Builder::new(device, levels, format, pool);
    let ends = chain(&mut builder);
    let (steps, pool) = builder.finish(queue);
    (ends, steps, pool)
}

/// Compares what lists of steps need beyond `pool`, and their frames, with the memory that is left, where the device
/// works in the host's.
pub(super) fn ensure_memory(
    device: &wgpu::Device,
    format: PixelFormat,
    lists: &[&[Level]],
    pool: &Pool,
) -> Result<(), Error> {
    let Some(Level { params, sizes, .. }) = lists.last().and_then(|levels| levels.last()) else { return Ok(()) };
    if !params.memory_check || device.adapter_info().device_type != wgpu::DeviceType::Cpu {
        return Ok(());
    }
    let plan = |pool, levels: &&[Level]| {
        let mut builder = Builder::new(device, levels, format, pool).only_planned();
        chain(&mut builder);
        builder.plan()
    };
    let planned = scopes::guarded_or_left(device, || lists.iter().fold(pool.clone(), plan).bytes())?;
    let more = planned - pool.bytes();
    if more == 0 {
        return Ok(());
    }
    // Of a frame: the staged upload, the maps in the readback buffer, and the maps that are returned.
    let frame = 2 * sizes.source + 2 * MapBytes::new(params, sizes).bytes();
    let Frame { width, height, .. } = sizes.frame;
    let what = format!("a pair of {width}x{height} pixels at {} disparities", params.disparities);
    let needed = more + frame + COMPILING;
    memory::ensure(&what, needed).or_else(|_| {
        // What was dropped goes when the device is asked.
        let _ = device.poll(wgpu::PollType::wait_indefinitely());
        memory::ensure(&what, needed)
    })
}
