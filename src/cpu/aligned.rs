//! Buffers that begin at a cache line, so that no vector crosses one.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

/// Disparities that the loops of the native schedule take at once: volumes hold a multiple of them for each pixel.
pub const LANES: usize = 32;

/// A cache line.
const LINE: usize = 64;

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; LINE]);

/// A slice of numbers on the heap that begins at a multiple of 64 bytes. Take the slice once before a loop, since each
/// dereference checks its bounds.
#[derive(Clone)]
pub struct Aligned<T> {
    lines: Vec<Line>,
    len: usize,
    of: PhantomData<T>,
}

impl<T: Pod> Aligned<T> {
    /// `len` times `value`.
    pub fn new(len: usize, value: T) -> Self {
        let mut aligned = Self::zeroed(len);
        aligned.fill(value);
        aligned
    }

    /// `len` zeros, whose memory the system gives page by page when it is first written.
    pub fn zeroed(len: usize) -> Self {
        let lines = bytemuck::zeroed_vec((len * size_of::<T>()).div_ceil(LINE));
        Self { lines, len, of: PhantomData }
    }
}

impl<T: Pod> Deref for Aligned<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }
}

impl<T: Pod> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_begin_at_cache_lines() {
        for len in [0, 1, 31, 32, 33, 1000] {
            let (mut bytes, words) = (Aligned::new(len, 7u8), Aligned::new(len, -3i16));
            assert_eq!((&bytes[..], &words[..]), (&vec![7; len][..], &vec![-3; len][..]));
            assert!(len == 0 || (bytes.as_ptr().addr() % LINE, words.as_ptr().addr() % LINE) == (0, 0));
            bytes.fill(1);
            assert_eq!(bytes.iter().map(|&v| usize::from(v)).sum::<usize>(), len);
            assert!(Aligned::<u32>::zeroed(len).iter().all(|&v| v == 0));
        }
    }
}
