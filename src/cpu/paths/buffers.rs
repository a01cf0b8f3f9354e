//! Large buffers that are used again for the next pair.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, PoisonError};

use crate::cpu::aligned::Aligned;

/// Large buffers between one pair and the next of a matcher, so that the system need not give their pages again.
#[derive(Clone, Default)]
pub(crate) struct Buffers(Arc<Mutex<Vec<Aligned<u8>>>>);

/// A buffer that goes back when it is dropped.
pub(super) struct Lent {
    buffer: Aligned<u8>,
    home: Buffers,
}

impl Buffers {
    /// A buffer of `len` bytes of any values.
    pub(super) fn take(&self, len: usize) -> Lent {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = kept.iter().position(|buffer| buffer.len() == len);
        let buffer = at.map_or_else(|| Aligned::zeroed(len), |at| kept.swap_remove(at));
        Lent { buffer, home: self.clone() }
    }
}

impl Clone for Lent {
    fn clone(&self) -> Self {
        let mut clone = self.home.take(self.len());
        clone.copy_from_slice(self);
        clone
    }
}

impl Deref for Lent {
    type Target = [u8];

    #[inline(always)]
    fn deref(&self) -> &[u8] {
        &self.buffer
    }
}

impl DerefMut for Lent {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [u8] {
        &mut self.buffer
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        let buffer = std::mem::replace(&mut self.buffer, Aligned::zeroed(0));
        self.home.0.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
    }
}
