//! Uploaded pairs that recorded work may still need.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A pair in a buffer.
#[derive(Clone, Debug)]
pub(crate) struct Uploaded {
    pub(crate) buffer: wgpu::Buffer,
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// A token that recorded work holds until it is done: then another pair may be written into the buffer.
    pub(crate) held: Arc<()>,
}

/// The buffers of pairs that recorded work may still need, and the pair that was uploaded last.
#[derive(Debug, Default)]
pub(crate) struct Uploads(Mutex<Places>);

#[derive(Debug, Default)]
struct Places {
    last: Option<Uploaded>,
    others: Vec<(wgpu::Buffer, Arc<()>)>,
}

impl Uploads {
    fn places(&self) -> MutexGuard<'_, Places> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The pair that was uploaded last.
    pub(crate) fn last(&self) -> Option<Uploaded> {
        self.places().last.clone()
    }

    /// Bytes of all buffers.
    pub(crate) fn bytes(&self) -> u64 {
        let places = self.places();
        let last = places.last.as_ref().map_or(0, |pair| pair.buffer.size());
        last + places.others.iter().map(|(buffer, _)| buffer.size()).sum::<u64>()
    }

    /// Takes a buffer of at least `bytes` that no work needs, and drops unused smaller ones. There is no last pair any more.
    pub(crate) fn free(&self, bytes: u64) -> Option<wgpu::Buffer> {
        let mut places = self.places();
        if let Some(Uploaded { buffer, held, .. }) = places.last.take() {
            places.others.push((buffer, held));
        }
        places.others.retain(|(buffer, held)| buffer.size() >= bytes || Arc::strong_count(held) > 1);
        let free = places.others.iter().position(|(_, held)| Arc::strong_count(held) == 1)?;
        Some(places.others.swap_remove(free).0)
    }

    /// Another pair was uploaded.
    pub(crate) fn set(&self, buffer: wgpu::Buffer, size: [u32; 2]) {
        let mut places = self.places();
        let before = places.last.replace(Uploaded { buffer, size, held: Arc::default() });
        places.others.extend(before.map(|Uploaded { buffer, held, .. }| (buffer, held)));
    }
}
