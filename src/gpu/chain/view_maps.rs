//! The buffers of the maps of both views.

use crate::gpu::layout::{ROW_UNIT, Rows};
use crate::gpu::recording::{Bound, Builder};

/// The maps of both views. The right one is followed, if a confidence is wanted, by the margins of the left one's winners, and, if
/// they are wanted, by their labels: `winner` has no binding left for one more buffer.
pub(super) struct ViewMaps {
    pub(super) left: wgpu::Buffer,
    pub(super) right: wgpu::Buffer,
}

impl ViewMaps {
    /// What is bound of both for some rows, and where the first of them lies in it.
    pub(super) fn bound(&self, b: &Builder<'_>, rows: Rows) -> ([Bound<'_>; 2], u32) {
        let row = 4 * u64::from(b.sizes.frame.map_stride);
        if b.sizes.right_map <= b.sizes.binding {
            return ([&self.left, &self.right].map(Bound::Buffer), rows.first);
        }
        // A binding begins at few rows.
        let skipped = rows.first % ROW_UNIT as u32;
        let from = u64::from(rows.first - skipped) * row;
        let bytes = u64::from(skipped + rows.count) * row;
        ([&self.left, &self.right].map(|map| Bound::Part(map, from, bytes)), skipped)
    }

    pub(super) fn new(b: &mut Builder<'_>) -> Self {
        Self { left: b.buffer("winner.left", b.sizes.map), right: b.buffer("winner.right", b.sizes.right_map) }
    }
}
