//! Matchers of one device that compile each kernel once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::gpu::kernels::{Compiled, CompiledKey};
use crate::gpu::recording::Pool;

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
