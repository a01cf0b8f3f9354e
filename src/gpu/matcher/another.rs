//! A matcher made from another one.

use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::{Error, Params, PixelFormat};

impl StereoMatcher {
    /// Another matcher on the same device, as [`StereoMatcher::new`] makes it. Kernels that this one has compiled, or one
    /// made from it or that it was made from, are not compiled again; buffers are its own. For several cameras, or sizes that are
    /// matched in turn.
    ///
    /// # Errors
    /// As [`StereoMatcher::new`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn another(&self, width: u32, height: u32, format: PixelFormat, params: &Params) -> Result<Self, Error> {
        let kernels = self.kernels.clone();
        let (matcher, verdict) = Self::begin(&self.device, &self.queue, [width, height], format, params, kernels)?;
        matcher.begun(verdict.now())
    }

    /// As [`StereoMatcher::another`], and awaits the errors that the device reports, without blocking: in a browser they arrive
    /// later.
    ///
    /// # Errors
    /// As [`StereoMatcher::new`].
    pub async fn another_async(
        &self,
        width: u32,
        height: u32,
        format: PixelFormat,
        params: &Params,
    ) -> Result<Self, Error> {
        let kernels = self.kernels.clone();
        let (matcher, verdict) = Self::begin(&self.device, &self.queue, [width, height], format, params, kernels)?;
        matcher.begun(verdict.await)
    }
}
