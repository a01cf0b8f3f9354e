//! Matchers of one device that compile each kernel once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::gpu::kernels::{Compiled, CompiledKey};
use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::recording::Pool;
use crate::{Error, Params, PixelFormat};

/// More are not kept: a driver holds up to a megabyte for each.
const MOST: usize = 512;

/// The kernels that the matchers made from each other have compiled without an error.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedKernels(Arc<Mutex<HashMap<CompiledKey, Compiled>>>);

impl SharedKernels {
    /// A pool with these kernels, and nothing else.
    pub(super) fn pool(&self) -> Pool {
        let compiled = self.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Pool::of_kernels(compiled)
    }

    /// Takes over the kernels of a pool.
    pub(super) fn add(&self, pool: &Pool) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.len() > MOST {
            all.clear();
        }
        all.extend(pool.compiled.iter().map(|(key, compiled)| (key.clone(), compiled.clone())));
    }
}

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
