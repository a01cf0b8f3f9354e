//! A request for sizes, and the checks against the limits of the device.

use crate::gpu::layout::uniforms::TEXELS;
use crate::gpu::plan::Plan;
use crate::gpu::rounds::{self, MOST_SIDE};
use crate::{Error, Method, Params, PixelFormat};

/// Rows of a map or an image, a multiple of which begin where a binding may: at a multiple of 256 bytes, of rows that are
/// a multiple of 4.
pub(crate) const ROW_UNIT: u64 = 64;

/// The remedy where pixels alone are too many.
pub(super) const SMALLER: &str = "make the images smaller";

/// The remedy where a row of a volume is too long.
pub(super) const FEWER: &str = "use fewer disparities or narrower images";

/// What the sizes depend on.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) format: PixelFormat,
    pub(super) params: &'a Params,
    pub(super) limits: &'a wgpu::Limits,
    pub(super) plan: &'a Plan,
}

/// Words a row of each kind of buffer.
#[derive(Clone, Copy)]
pub(super) struct Strides {
    /// In vectors of 16 bytes.
    pub(super) gray: u32,
    pub(super) left: u32,
    pub(super) right: u32,
    pub(super) map: u32,
    /// In pixels.
    pub(super) volume: u32,
}

impl Strides {
    pub(super) fn new(width: u32, params: &Params) -> Self {
        let reach = 2 * params.radius();
        Self {
            // Sixteen columns before the image; three vectors are read from the one before the last column on.
            gray: (width + 14) / 16 + 3,
            // Rows of the planes are copied into textures: 256 bytes are the unit of that.
            left: (width + reach).div_ceil(4).next_multiple_of(64),
            right: ((width - 1 + reach) / 4 + 4 * params.quads() + 1).next_multiple_of(64),
            map: 4 * width.div_ceil(8),
            // Rows an even number of pixels apart may share a few places of a cache.
            volume: width | 1,
        }
    }
}

impl Request<'_> {
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The most bytes of a buffer that one binding may hold.
    pub(super) fn binding(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// The most workgroups, and pixels, a side.
    pub(super) fn most_side(&self) -> u32 {
        self.limits.max_compute_workgroups_per_dimension.min(MOST_SIDE)
    }

    /// A buffer that kernels are bound to as a whole.
    pub(super) fn fits(&self, what: &str, needed: u64, remedy: &'static str) -> Result<(), Error> {
        let allowed = self.binding();
        if needed <= allowed { Ok(()) } else { Err(Error::TooLarge { what: what.into(), needed, allowed, remedy }) }
    }

    /// A buffer with `row` bytes a row of the image: kernels are bound to some rows of it, or to all.
    pub(super) fn rows_fit(&self, what: &str, row: u64, remedy: &'static str) -> Result<(), Error> {
        let all = row * u64::from(self.height);
        let (needed, allowed) = match all <= self.limits.max_buffer_size {
            true => (all.min(ROW_UNIT * row), self.binding()),
            false => (all, self.limits.max_buffer_size),
        };
        if needed <= allowed { Ok(()) } else { Err(Error::TooLarge { what: what.into(), needed, allowed, remedy }) }
    }

    /// Whether a kernel takes images of this size, but at most `side` pixels a side, in the rounds that drivers allow.
    pub(super) fn takes(&self, kernel: &str, side: u32) -> bool {
        let size = [self.width.min(side), self.height.min(side)];
        rounds::rounds(kernel, self.params, size, self.plan).is_none_or(|rounds| rounds <= rounds::MOST)
    }

    /// Whether the images are not too long for workgroups and for loops.
    pub(super) fn check_sides(&self) -> Result<(), Error> {
        let (width, height, side) = (self.width, self.height, self.most_side());
        if width > side || height > side {
            return Err(Error::Image(format!(
                "the images are {width}x{height}, but at most {side} pixels a side are possible here; make them smaller"
            )));
        }
        let walks: &[&str] = match self.params.method {
            Method::Sgm => &["sgm_aggregate", "winner"],
            Method::Bm => &["block_match"],
            Method::Psmnet => &[],
            Method::Bp => &["winner_beliefs"],
        };
        let all_taken = |side: &u32| walks.iter().all(|kernel| self.takes(kernel, *side));
        if !all_taken(&MOST_SIDE) {
            let most = (1..width.max(height)).rev().find(all_taken).unwrap_or(0);
            return Err(Error::Image(format!(
                "the images are {width}x{height}, but with shader checks at most {most} pixels a side are possible with these \
                 settings; switch the checks off or make the images smaller"
            )));
        }
        Ok(())
    }

    /// Bytes of one uploaded image, and 256 more, which may be read.
    pub(super) fn source_bytes(&self) -> u64 {
        source_bytes([self.width, self.height], self.format)
    }
}

fn source_bytes([width, height]: [u32; 2], format: PixelFormat) -> u64 {
    u64::from(width) * u64::from(height) * u64::from(format.bytes_per_pixel()) + 256
}

/// Texels a row of the texture of one uploaded image, [`TEXELS`] if so many rows do as a texture may have, and its bytes.
pub(crate) fn source_layout(size: [u32; 2], format: PixelFormat, limits: &wgpu::Limits) -> (u32, u64) {
    let bytes = source_bytes(size, format);
    let most = limits.max_texture_dimension_2d;
    let mut texels = TEXELS;
    while bytes > 16 * u64::from(texels) * u64::from(most) && 2 * texels <= most {
        texels *= 2;
    }
    (texels, bytes.next_multiple_of(16 * u64::from(texels)))
}
