//! Large buffers that are used again for the next pair.

use std::sync::{Mutex, PoisonError};

use crate::cpu::aligned::Aligned;

/// Large buffers between one pair and the next, so that the system need not give their pages again.
#[derive(Default)]
pub(crate) struct Buffers(Mutex<Vec<Aligned<u8>>>);

impl Buffers {
    /// A buffer of `len` bytes of any values.
    pub(super) fn take(&self, len: usize) -> Aligned<u8> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match kept.iter().position(|buffer| buffer.len() == len) {
            Some(at) => kept.swap_remove(at),
            None => {
                kept.clear(); // those of another size
                Aligned::zeroed(len)
            }
        }
    }

    /// Takes it back.
    pub(super) fn give(&self, buffer: Aligned<u8>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
    }
}
