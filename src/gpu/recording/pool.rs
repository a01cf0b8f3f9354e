//! The buffers, textures and kernels that lists of steps are made of.

use std::collections::HashMap;

use crate::gpu::kernels::{Compiled, CompiledKey};
use crate::gpu::recording::weights::Weights;

/// Bytes of a row of `width` texels.
pub(crate) fn row_bytes(format: wgpu::TextureFormat, width: u32) -> u32 {
    format.block_copy_size(None).unwrap_or(0) * width
}

/// A buffer or a texture, and the size that was asked for: what is only planned is smaller.
#[derive(Clone, Debug)]
pub(super) struct Sized<T, S> {
    pub(super) item: T,
    pub(super) size: S,
}

pub(super) type SizedTexture = Sized<wgpu::Texture, [u32; 2]>;

/// The buffers and textures that one list of steps leaves to the next, and the kernels compiled so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pool {
    pub(super) buffers: HashMap<(String, wgpu::BufferUsages), Vec<Sized<wgpu::Buffer, u64>>>,
    pub(super) textures: HashMap<(String, wgpu::TextureFormat), Vec<SizedTexture>>,
    pub(crate) compiled: HashMap<CompiledKey, Compiled>,
    /// Those of the network that was used last.
    pub(super) weights: Option<Weights>,
}

impl Pool {
    pub(crate) fn of_kernels(compiled: HashMap<CompiledKey, Compiled>) -> Self {
        Self { compiled, ..Self::default() }
    }

    /// Bytes of all buffers and textures.
    pub(crate) fn bytes(&self) -> u64 {
        let buffers = self.buffers.values().flatten().map(|buffer| buffer.size);
        let textures = self.textures.iter().flat_map(|((_, format), textures)| {
            textures
                .iter()
                .map(|Sized { size: [width, height], .. }| u64::from(row_bytes(*format, *width)) * u64::from(*height))
        });
        buffers.chain(textures).sum::<u64>() + self.weights.as_ref().map_or(0, |weights| weights.bytes)
    }

    /// What is never written again: the kernels and the weights.
    pub(crate) fn lasting(&self) -> Self {
        Self { compiled: self.compiled.clone(), weights: self.weights.clone(), ..Self::default() }
    }

    /// Takes over all that another pool holds.
    pub(super) fn join(&mut self, left: Self) {
        for (key, buffers) in left.buffers {
            self.buffers.entry(key).or_default().extend(buffers);
        }
        for (key, textures) in left.textures {
            self.textures.entry(key).or_default().extend(textures);
        }
        self.weights = self.weights.take().or(left.weights);
    }
}

/// Takes the smallest of those that are large enough.
pub(super) fn take<T>(free: &mut Vec<T>, enough: impl Fn(&T) -> bool, size: impl Fn(&T) -> u64) -> Option<T> {
    let smallest = (0..free.len()).filter(|&i| enough(&free[i])).min_by_key(|&i| size(&free[i]))?;
    Some(free.swap_remove(smallest))
}

/// Allocations that a second run shares with the first: its n-th request returns what the first run's n-th request returned.
pub(super) struct Shared<T> {
    made: HashMap<String, Vec<T>>,
    pub(super) taken: HashMap<String, usize>,
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self { made: HashMap::new(), taken: HashMap::new() }
    }
}

impl<T: Clone> Shared<T> {
    pub(super) fn next(&mut self, key: &str) -> Option<T> {
        let taken = self.taken.entry(key.into()).or_default();
        let next = self.made.get(key)?.get(*taken)?.clone();
        *taken += 1;
        Some(next)
    }

    pub(super) fn keep(&mut self, key: String, made: &T) {
        *self.taken.entry(key.clone()).or_default() += 1;
        self.made.entry(key).or_default().push(made.clone());
    }
}
