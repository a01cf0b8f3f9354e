//! What is read and written must not overlap.

use crate::Error;
use crate::gpu::interop::refusal::refused;
use crate::gpu::interop::resources::TextureLayer;

/// What a resource of the caller's covers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Region<'a> {
    Layer(&'a wgpu::Texture, u32),
    /// From the first byte to the one after the last.
    Bytes(&'a wgpu::Buffer, u64, u64),
}

impl Region<'_> {
    fn overlaps(&self, other: &Self) -> bool {
        match (self, other) {
            (Region::Layer(texture, layer), Region::Layer(other, other_layer)) => {
                texture == other && layer == other_layer
            }
            (Region::Bytes(buffer, from, to), Region::Bytes(other, other_from, other_to)) => {
                buffer == other && from < other_to && other_from < to
            }
            _ => false,
        }
    }
}

/// The regions that are read and written in a frame.
#[derive(Default)]
pub(crate) struct Regions<'a>(Vec<(&'static str, Region<'a>)>);

impl<'a> From<TextureLayer<'a>> for Region<'a> {
    fn from(TextureLayer { texture, layer, .. }: TextureLayer<'a>) -> Self {
        Self::Layer(texture, layer.unwrap_or(0))
    }
}

impl<'a> Regions<'a> {
    pub(super) fn read(&mut self, name: &'static str, region: Region<'a>) {
        self.0.push((name, region));
    }

    /// What is written overlaps nothing else.
    pub(super) fn write(&mut self, name: &'static str, region: Region<'a>) -> Result<(), Error> {
        match self.0.iter().find(|(_, other)| other.overlaps(&region)) {
            Some((other, _)) => {
                let allowed = format!("that is {other}");
                Err(refused(name, &"overlaps another place", &allowed, "give each output a place of its own"))
            }
            None => {
                self.read(name, region);
                Ok(())
            }
        }
    }
}
