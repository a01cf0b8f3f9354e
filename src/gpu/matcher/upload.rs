//! The pair of a frame, from the host to the matcher's textures.

use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::scopes;
use crate::gpu::spans::span;
use crate::{Error, ImageView};

impl StereoMatcher {
    /// Writes a pair where [`StereoMatcher::record`] takes it from with [`Inputs::Uploaded`](crate::Inputs::Uploaded); it is there for all that is
    /// recorded afterwards.
    ///
    /// # Errors
    /// [`Error::Image`] if a size or a format is not the matcher's; [`Error::OutOfMemory`] if there is no room for one more
    /// pair, in addition to those that recorded work still needs.
    pub fn upload<'a>(&self, left: impl Into<ImageView<'a>>, right: impl Into<ImageView<'a>>) -> Result<(), Error> {
        let (left, right) = (left.into(), right.into());
        span!(DEBUG, "upload");
        self.accepts(left, right)?;
        self.pulse.check()?;
        let side = self.sizes.source;
        let free = self.uploads.free(2 * side);
        let written = scopes::guarded_or_left(&self.device, || {
            let buffer = free.unwrap_or_else(|| {
                self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("gpu-stereo.upload"),
                    size: 2 * self.largest_source(),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                })
            });
            for (image, at) in [(left, 0), (right, side)] {
                let bytes = image.packed();
                let (whole, rest) = bytes.split_at(bytes.len() / 4 * 4);
                self.queue.write_buffer(&buffer, at, whole);
                if !rest.is_empty() {
                    let mut last = [0; 4];
                    last[..rest.len()].copy_from_slice(rest);
                    self.queue.write_buffer(&buffer, at + whole.len() as u64, &last);
                }
            }
            buffer
        });
        let buffer = written.map_err(|error| self.pulse.cause(error))?;
        self.uploads.set(buffer, self.size());
        Ok(())
    }

    /// Writes a pair into the matcher's textures, for what is submitted at once.
    pub(crate) fn write_sources(&self, left: ImageView<'_>, right: ImageView<'_>) {
        for (image, source) in [(left, &self.ends.sources[0]), (right, &self.ends.sources[1])] {
            let bytes = image.packed();
            // Whole rows of the texture, then the rest of them.
            let texels = self.sizes.source_texels;
            let row = 16 * texels as usize;
            let (whole, rest) = bytes.split_at(bytes.len() / row * row);
            let rows = (whole.len() / row) as u32;
            let mut rest = rest.to_vec();
            rest.resize(rest.len().next_multiple_of(16), 0);
            for (data, y, width, height) in [(whole, 0, texels, rows), (&rest, rows, rest.len() as u32 / 16, 1)] {
                if data.is_empty() {
                    continue;
                }
                let destination =
                    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y, z: 0 }, ..source.as_image_copy() };
                let bytes_per_row = Some(16 * texels);
                let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
                let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
                self.queue.write_texture(destination, data, layout, size);
            }
        }
    }

    /// Records the copy of a pair from a buffer into the matcher's textures.
    pub(crate) fn record_sources(&self, encoder: &mut wgpu::CommandEncoder, buffer: &wgpu::Buffer) {
        let side = self.sizes.source;
        for (source, offset) in self.ends.sources.iter().zip([0, side]) {
            let width = self.sizes.source_texels;
            let layout = wgpu::TexelCopyBufferLayout { offset, bytes_per_row: Some(16 * width), rows_per_image: None };
            let height = (side / (16 * u64::from(width))) as u32;
            let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
            encoder.copy_buffer_to_texture(wgpu::TexelCopyBufferInfo { buffer, layout }, source.as_image_copy(), size);
        }
    }
}
