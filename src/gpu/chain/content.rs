//! Stage `validity`: maps without what has no content.

use crate::gpu::chain::view_maps::ViewMaps;
use crate::gpu::layout::{Dispatch, Frame, ValidityOwn};
use crate::gpu::recording::Bound::{Buffer, Rows};
use crate::gpu::recording::{Builder, Written};
use crate::reference;

/// Which pixels have content, a bit a pixel: of the pair and of the mirrored one, each halved ever more often.
pub(super) struct ContentBits([Vec<wgpu::Buffer>; 2]);

impl ContentBits {
    /// `None` where all pixels have content, and where only room is made for pairs of another size than that of the masks:
    /// those never come.
    pub(super) fn new(b: &mut Builder<'_>) -> Option<Self> {
        let Frame { width, height, .. } = b.sizes.frame;
        b.params.accepts(width, height).ok()?;
        let content = reference::Content::new(&b.params, width, height)?;
        let mirrored = content.mirrored();
        let most = b.levels[0].halvings;
        Some(Self([content, mirrored].map(|content| {
            (0..=most).map(|halvings| b.table("validity.content", bits(&content.halved(halvings)))).collect()
        })))
    }

    /// Of both views, if anything reads the right one. The left one comes last: what follows takes it from the last step.
    pub(super) fn views(&self, b: &mut Builder<'_>, views: ViewMaps) -> ViewMaps {
        let right = if b.params.reads_right_view() { self.valid(b, &views.right, 1) } else { views.right };
        ViewMaps { left: self.valid(b, &views.left, 0), right }
    }

    /// Of a map of the left view (0) or of the right one (1).
    pub(super) fn valid(&self, b: &mut Builder<'_>, map: &wgpu::Buffer, side: usize) -> wgpu::Buffer {
        let Frame { map_stride, .. } = b.sizes.frame;
        let content = &self.0[usize::from(b.mirrored)][b.levels[b.level].halvings as usize];
        let valid = b.buffer("validity", b.sizes.map);
        let (row, own) = (4 * u64::from(map_stride), ValidityOwn { side: side as u32 });
        let dispatch = Dispatch { own: own.into(), ..Dispatch::default() };
        let storage = [Rows(map, row), Buffer(content), Rows(&valid, row)];
        b.step_rows("validity", &storage, dispatch, map_stride / 4, 1, Written::Validity { side });
        valid
    }
}

/// The left view's rows, then the right one's, each of whole words.
fn bits(content: &reference::Content) -> Vec<u32> {
    let word = |pixels: &[bool]| (0..).zip(pixels).fold(0, |word, (i, &has)| word | u32::from(has) << i);
    let rows = content.sides.iter().flat_map(|side| side.data.chunks_exact(side.width));
    rows.flat_map(|row| row.chunks(32).map(word)).collect()
}
