//! The checks of single resources: whose they are, their size, format and usage.

use crate::gpu::interop::context::Context;
use crate::gpu::interop::refusal::{lacks, listed, refused};
use crate::gpu::interop::resources::{INPUTS, PixelBuffer, TextureLayer};
use crate::gpu::layout::Frame;
use crate::{Error, PixelFormat};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

impl Context<'_> {
    pub(super) fn check_input(&self, name: &str, input: &TextureLayer<'_>) -> Result<(), Error> {
        let formats: Vec<TextureFormat> =
            INPUTS.iter().filter(|(_, samples)| *samples == self.format).map(|&(format, _)| format).collect();
        let remedy = match PixelFormat::of(input.texture.format()) {
            Some(format) => format!("make the matcher for PixelFormat::{format:?}"),
            None => "copy or draw it into a texture of such a format".into(),
        };
        self.check_sampled(name, input, self.pixels(), &formats, &remedy)
    }

    /// A texture that is read: `size` texels of the whole, or of a part if one is named.
    pub(super) fn check_sampled(
        &self,
        name: &str,
        layer: &TextureLayer<'_>,
        size: [u32; 2],
        formats: &[TextureFormat],
        remedy: &str,
    ) -> Result<(), Error> {
        self.check_texture(name, layer, size, layer.origin.is_some(), formats, remedy)?;
        let usage = layer.texture.usage();
        match usage.contains(TextureUsages::TEXTURE_BINDING) {
            true => Ok(()),
            false => Err(lacks(name, &usage, "TEXTURE_BINDING")),
        }
    }

    /// The matcher's size.
    pub(super) fn pixels(&self) -> [u32; 2] {
        [self.frame.width, self.frame.height]
    }

    /// `size` texels are needed, of the whole texture or of a part of it.
    pub(super) fn check_texture(
        &self,
        name: &str,
        &TextureLayer { texture, layer, origin }: &TextureLayer<'_>,
        [width, height]: [u32; 2],
        part: bool,
        formats: &[TextureFormat],
        remedy: &str,
    ) -> Result<(), Error> {
        self.check_owner(name, texture)?;
        let (columns, rows) = (texture.width(), texture.height());
        let flat = texture.dimension() == wgpu::TextureDimension::D2;
        let [x, y] = origin.unwrap_or_default();
        let fits = |at: u32, side: u32, whole: u32| whole.checked_sub(at).is_some_and(|rest| rest >= side);
        if part && flat && !(fits(x, width, columns) && fits(y, height, rows)) {
            let given = format!("begins at column {x}, row {y} of a texture of {columns}x{rows}");
            let allowed = format!("the matcher takes {width}x{height} texels from there on");
            return Err(refused(name, &given, &allowed, "begin further left or above, or resize the matcher"));
        }
        if (!part && (columns, rows) != (width, height)) || !flat {
            let given = format!("is a texture of {columns}x{rows} in {:?}", texture.dimension());
            let allowed = format!("must be one of {width}x{height} in D2");
            let remedy =
                "make the texture of that size, resize the matcher, or name a part of an input (TextureLayer::at)";
            return Err(refused(name, &given, &allowed, remedy));
        }
        if origin.is_some() && !part {
            let given = format!("begins at column {x}, row {y} of its texture");
            return Err(refused(name, &given, &"must be a whole layer", "give it without TextureLayer::at"));
        }
        if (texture.sample_count(), texture.mip_level_count()) != (1, 1) {
            let (samples, levels) = (texture.sample_count(), texture.mip_level_count());
            let given = format!("is a texture with {samples} samples a pixel and {levels} mip levels");
            return Err(refused(name, &given, &"must have one of each", "resolve or copy it into such a texture"));
        }
        let layers = texture.depth_or_array_layers();
        match layer {
            None if layers > 1 => {
                let given = format!("is a texture of {layers} layers");
                let allowed = "one of them must be named";
                return Err(refused(name, &given, &allowed, "give a TextureLayer::new(texture, layer)"));
            }
            Some(layer) if layer >= layers => {
                let given = format!("is layer {layer} of a texture");
                let allowed = format!("that has {layers}, counted from 0");
                return Err(refused(name, &given, &allowed, "name one of those"));
            }
            _ => {}
        }
        let format = texture.format();
        if !formats.contains(&format) {
            let allowed = format!("must be {}", listed(formats));
            return Err(refused(name, &format!("is a texture in the format {format:?}"), &allowed, remedy));
        }
        Ok(())
    }

    /// The first check: a resource of another device may pass for one of this device.
    fn check_owner(&self, name: &str, thing: &dyn std::fmt::Debug) -> Result<(), Error> {
        if self.pulse.owns(thing) {
            return Ok(());
        }
        let remedy = "create it with the device that the matcher was made with, or copy it over by way of the host";
        Err(refused(name, &"is of another wgpu device", &"must be of the matcher's", remedy))
    }

    /// No place of the caller's is one of the matcher's.
    pub(super) fn check_buffer(
        &self,
        name: &str,
        buffer: &wgpu::Buffer,
        needed: (BufferUsages, &str),
    ) -> Result<(), Error> {
        self.check_owner(name, buffer)?;
        if [Some(self.output), self.right, self.confidence, self.depth].contains(&Some(buffer)) {
            let allowed = "must be a buffer of the caller's";
            return Err(refused(
                name,
                &"is the matcher's own buffer",
                &allowed,
                "use it as it is, or make another one",
            ));
        }
        match buffer.usage().contains(needed.0) {
            true => Ok(()),
            false => Err(lacks(name, &buffer.usage(), needed.1)),
        }
    }

    /// Bytes of the image, from its offset on.
    pub(super) fn check_pixels(&self, name: &str, pixels: &PixelBuffer<'_>) -> Result<u64, Error> {
        let Frame { width, height, .. } = *self.frame;
        let [x, y] = pixels.origin.map(u64::from);
        let row = (x + u64::from(width)) * u64::from(self.format.bytes_per_pixel());
        self.check_rows(name, pixels, row, y + u64::from(height))
    }

    /// Bytes from the offset on to the last one of `rows` rows of at least `row` bytes.
    pub(super) fn check_rows(&self, name: &str, pixels: &PixelBuffer<'_>, row: u64, rows: u64) -> Result<u64, Error> {
        let &PixelBuffer { buffer, offset, bytes_per_row, origin: [x, _] } = pixels;
        let limits = self.device.limits();
        self.check_buffer(name, buffer, (BufferUsages::STORAGE, "STORAGE"))?;
        let alignment = limits.min_storage_buffer_offset_alignment;
        if !offset.is_multiple_of(alignment.into()) {
            let allowed = format!("must begin at a multiple of {alignment}");
            return Err(refused(name, &format!("begins at byte {offset}"), &allowed, "copy it to such a place"));
        }
        if !bytes_per_row.is_multiple_of(4) || u64::from(bytes_per_row) < row {
            let allowed = format!(
                "must have a multiple of 4, at least {row} for {} columns from column {x} on in {:?}",
                self.frame.width, self.format
            );
            return Err(refused(name, &format!("has {bytes_per_row} bytes a row"), &allowed, "pad the rows"));
        }
        let bytes = (rows - 1) * u64::from(bytes_per_row) + row.next_multiple_of(4);
        long_enough(name, buffer, offset, bytes)?;
        let most = limits.max_storage_buffer_binding_size;
        if bytes > most {
            let (given, allowed) = (format!("has {bytes} bytes"), format!("the device allows {most} a binding"));
            return Err(refused(name, &given, &allowed, "request larger limits, or use textures"));
        }
        Ok(bytes)
    }
}

/// Both parts of a pair begin in the same row, unless they are parts of one picture.
pub(super) fn same_rows(one_picture: bool, rows: [u32; 2]) -> Result<(), Error> {
    if one_picture || rows[0] == rows[1] {
        return Ok(());
    }
    let given = format!("begins in row {}", rows[1]);
    let allowed = format!("the left one begins in row {} of another picture", rows[0]);
    Err(refused(
        "the right input",
        &given,
        &allowed,
        "take both from the same row: a rectified pair has its rows in common",
    ))
}

/// Whether `bytes` bytes lie in a buffer from `offset` on.
pub(super) fn long_enough(name: &str, buffer: &wgpu::Buffer, offset: u64, bytes: u64) -> Result<(), Error> {
    let size = buffer.size();
    if size.checked_sub(offset).is_some_and(|rest| rest >= bytes) {
        return Ok(());
    }
    let given = format!("is a buffer of {size} bytes");
    Err(refused(name, &given, &format!("{bytes} are needed from byte {offset} on"), "make the buffer larger"))
}
