//! The matcher without a device.

use crate::check::StageCheck;
use crate::cpu::chain::Native;
use crate::cpu::instructions::Instructions;
use crate::cpu::paths::{Aggregation, Buffers};
use crate::cpu::{LANES, check};
use crate::image_view::check_made_for;
use crate::reference::{ensure_memory, follow};
use crate::{Error, Fill, ImageView, Matched, Method, Params, PixelFormat, StageTime, memory};
use std::fmt;

/// Matches pairs on the CPU, by the native schedule: the same results as [`crate::reference::compute_all`], to the bit, in a
/// small part of its time; those of a network within the tolerance of docs/NETWORKS.md. It works on the threads of rayon's
/// pool that it is called in.
///
/// ```
/// use gpu_stereo::cpu::CpuMatcher;
/// use gpu_stereo::{Image, Params, PixelFormat, Pixels};
///
/// let texture = |x: u32, y: u32| (x * x * 31 + x * y * 17 + y * 7) as u8;
/// let view = |shift| (0..32 * 8).map(|i| texture(i % 32 + shift, i / 32)).collect();
/// let left = Image::new(32, 8, Pixels::Gray8(view(0)))?;
/// let right = Image::new(32, 8, Pixels::Gray8(view(3)))?; // shows 3 pixels to the left what the left image shows
///
/// let matcher = CpuMatcher::new(32, 8, PixelFormat::Gray8, &Params::sgm(16))?; // once
/// let matched = matcher.compute(&left, &right)?; // for each pair
/// assert_eq!(matched.map.get(20, 4), Some(3.0));
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
pub struct CpuMatcher {
    size: [u32; 2],
    format: PixelFormat,
    params: Params,
    instructions: Instructions,
    /// What is used again for the next pair.
    buffers: Buffers,
}

/// About the bytes that semi-global matching or block matching takes at its peak.
fn bytes(size: [u32; 2], params: &Params, instructions: Instructions, buffers: &Buffers) -> u64 {
    let threads = rayon::current_num_threads();
    let [width, height] = size.map(|side| side as usize);
    let paths = match params.method {
        Method::Sgm => Aggregation::new([width, height], params, None, instructions, buffers).bytes(threads),
        _ => 0,
    };
    let [width, height, threads] = [width, height, threads].map(|count| count as u64);
    let (columns, padded) = (width + 2 * u64::from(params.radius()), u64::from(params.disparities) + LANES as u64);
    let features = u64::from(params.feature_planes());
    // Features lie in planes, and before that in rows of the image.
    let planes = height * ((PLANES + features) * (2 * columns + padded) + 2 * features * width);
    let pixel = PIXEL_BYTES + if params.fill == Fill::WeightedRays { GRAY_BYTES } else { 0 };
    paths + planes + ROW_BYTES * threads * columns * padded + pixel * width * height
}

/// About the bytes per column and disparity that a thread takes for the costs of a row, and for the sums that they are made of.
const ROW_BYTES: u64 = 16;

/// About the bytes of a pixel that a cost compares.
const PLANES: u64 = 9;

/// About the bytes per pixel that images, penalties and maps take.
const PIXEL_BYTES: u64 = 36;

/// About the bytes per pixel that the gray takes that comes along with values to fill holes.
const GRAY_BYTES: u64 = 16;

impl CpuMatcher {
    /// A matcher for pairs of `width` x `height` pixels in `format`.
    ///
    /// # Errors
    /// [`Error::Parameter`] as [`Params::validate`]; [`Error::Image`] if the size is not that of the masks or of the
    /// rectification; [`Error::Memory`] if the memory that is left does not hold the pair ([`Params::memory_check`]).
    pub fn new(width: u32, height: u32, format: PixelFormat, params: &Params) -> Result<Self, Error> {
        params.validate()?;
        params.accepts(width, height)?;
        let (instructions, buffers) = (Instructions::best()?, Buffers::default());
        let size = [width, height];
        match params.method {
            Method::Sgm | Method::Bm if !params.memory_check => {}
            Method::Sgm | Method::Bm => {
                let what =
                    format!("the native schedule of {width}x{height} pixels at {} disparities", params.disparities);
                memory::ensure(&what, bytes(size, params, instructions, &buffers))?;
            }
            Method::Bp => ensure_memory("belief propagation on the CPU", size, params, 0)?,
            Method::Psmnet => ensure_memory("the network on the CPU", size, params, 0)?,
        }
        Ok(Self { size, format, params: params.clone(), instructions, buffers })
    }

    /// Makes the matcher fit for pairs of another size. If it fails, the matcher stays as it was. Of its own size it keeps what it
    /// has allocated.
    ///
    /// # Errors
    /// As [`CpuMatcher::new`].
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), Error> {
        if self.size != [width, height] {
            *self = Self::new(width, height, self.format, &self.params)?;
        }
        Ok(())
    }

    /// Goes on with other settings. If it fails, the matcher stays as it was.
    ///
    /// # Errors
    /// As [`CpuMatcher::new`].
    pub fn set_params(&mut self, params: &Params) -> Result<(), Error> {
        *self = Self::new(self.size[0], self.size[1], self.format, params)?;
        Ok(())
    }

    /// The settings.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Columns and rows of the pairs.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The samples of the pairs.
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// The instruction set that it computes with: `AVX-512`, `AVX2`, `NEON`, or `plain` for what the program is compiled for. It
    /// is the best one of the machine; the environment variable `GPU_STEREO_INSTRUCTIONS` may ask for a lesser one.
    pub fn instructions(&self) -> &'static str {
        self.instructions.name()
    }

    /// Computes the maps of a pair.
    ///
    /// # Errors
    /// [`Error::Image`] if a size or a format is not the matcher's; [`Error::Network`] if a network lacks weights.
    pub fn compute<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Matched, Error> {
        Ok(self.compute_timed(left, right)?.0)
    }

    /// As [`CpuMatcher::compute`], with the time of each stage. Stages that are computed together are one row, named by the last of
    /// them.
    ///
    /// # Errors
    /// As [`CpuMatcher::compute`].
    pub fn compute_timed<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<(Matched, Vec<StageTime>), Error> {
        let pair = self.accepted(left.into(), right.into())?;
        follow(pair, &self.params, None, &mut Native::new(self.instructions, &self.buffers))
    }

    /// Computes a pair and compares what each stage made with the reference, number by number. What stages of a network made is
    /// not compared; what follows them starts from the disparities that they gave.
    ///
    /// It takes the memory of the reference, a byte a pixel and disparity for the cost, two for the aggregate and four for the
    /// column sums, and once more that of the stages that are compared.
    ///
    /// # Errors
    /// As [`CpuMatcher::compute`].
    pub fn check<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Vec<StageCheck>, Error> {
        self.check_with(left, right, |_, _| {})
    }

    /// As [`CpuMatcher::check`], with a chance to spoil the bytes that a stage made: the test of the test.
    #[doc(hidden)]
    pub fn check_with<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
        mut spoil: impl FnMut(&str, &mut [u8]),
    ) -> Result<Vec<StageCheck>, Error> {
        let pair = self.accepted(left.into(), right.into())?;
        check::check(pair, &self.params, (self.instructions, &self.buffers), &mut spoil)
    }

    /// A pair, if it is what the matcher was made for.
    fn accepted<'a>(&self, left: ImageView<'a>, right: ImageView<'a>) -> Result<[ImageView<'a>; 2], Error> {
        check_made_for([left, right], self.size, self.format)?;
        Ok([left, right])
    }
}

impl fmt::Debug for CpuMatcher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size, format, params, instructions, .. } = self;
        let mut shown = f.debug_struct("CpuMatcher");
        shown.field("size", size).field("format", format).field("params", params).field("instructions", instructions);
        shown.finish_non_exhaustive()
    }
}
