//! The rounds through the chain: one, or with mutual information several, from small images to large ones.

use crate::gpu::kernels;
use crate::gpu::layout::Sizes;
use crate::gpu::plan::Plan;
use crate::reference::{self, Round};
use crate::{Error, Params, PixelFormat};

/// A round through the chain: its settings, and what follows from them.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    /// How often the images are halved.
    pub(crate) halvings: u32,
    pub(crate) params: Params,
    pub(crate) plan: Plan,
    pub(crate) sizes: Sizes,
}

/// The rounds through the chain for pairs of `width` x `height` pixels, in buffers that were made for `largest`.
pub(crate) fn levels(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: PixelFormat,
    params: &Params,
    largest: &[Level],
) -> Result<Vec<Level>, Error> {
    params.validate()?;
    let limits = device.limits();
    kernels::check_limits(&limits)?;
    if width == 0 || height == 0 {
        return Err(Error::Image(format!("the images are {width}x{height}, but each side must be at least 1")));
    }
    let level = |Round { halvings, params }: Round| {
        let plan = Plan::new(device, &params);
        let [width, height] = [width, height].map(|side| side.div_ceil(1 << halvings));
        let same = |level: &&Level| level.halvings == halvings && level.params == params;
        let largest = largest.iter().find(same).map(|level| &level.sizes);
        let sizes = Sizes::new(width, height, format, &params, &limits, &plan, largest)?;
        let plan = Plan { part_bits: sizes.part_bits, ..plan };
        Ok(Level { halvings, params, plan, sizes })
    };
    reference::rounds(width, height, params).into_iter().map(level).collect()
}

/// The rounds of smaller pairs that need buffers which the largest one does not.
pub(crate) fn rooms(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: PixelFormat,
    params: &Params,
    largest: &[Level],
) -> Result<Vec<Vec<Level>>, Error> {
    let sizes = reference::largest_with_fewer_rounds(width, height, params);
    sizes.into_iter().map(|size| levels(device, size, format, params, largest)).collect()
}
