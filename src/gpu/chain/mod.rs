//! The schedule: which kernel runs on what, in what order.

mod aggregation;
mod cost;
mod filters;
mod mi;
mod planes;
#[cfg(test)]
mod tests;
mod validity;

use crate::gpu::layout::{ROW_UNIT, Rows, Sizes};
use crate::gpu::recording::{Bound, Builder};
use crate::{Cost, DisparityMap, Method};
use planes::Planes;
use validity::Content;

/// What the matcher needs of what the chain made.
#[derive(Debug)]
pub(crate) struct Made {
    /// The textures into which images are uploaded.
    pub(crate) sources: [wgpu::Texture; 2],
    /// The map that is read back.
    pub(crate) output: wgpu::Buffer,
    /// The right view, if it is wanted.
    pub(crate) right: Option<wgpu::Buffer>,
    /// The confidence of the map, if it is wanted.
    pub(crate) confidence: Option<wgpu::Buffer>,
    /// The depth of the map, if it is wanted.
    pub(crate) depth: Option<wgpu::Buffer>,
}

impl Made {
    /// No map is there yet: no pixel has a disparity.
    pub(crate) fn blank(&self, queue: &wgpu::Queue, sizes: &Sizes) {
        let none = |bytes: u64| DisparityMap::INVALID.to_le_bytes().repeat(bytes as usize / 2);
        for map in [Some(&self.output), self.right.as_ref()].into_iter().flatten() {
            queue.write_buffer(map, 0, &none(sizes.map));
        }
        for (other, bytes) in [(&self.confidence, sizes.confidence), (&self.depth, sizes.regions)] {
            if let Some(other) = other {
                queue.write_buffer(other, 0, &vec![0; bytes as usize]);
            }
        }
    }
}

/// The maps of both views, and behind the right one, if a confidence is wanted, the margins of the left one's winners:
/// `winner` has no room for one more buffer.
pub(crate) struct Views {
    left: wgpu::Buffer,
    right: wgpu::Buffer,
}

impl Views {
    /// What is bound of both for some rows, and where the first of them lies in it.
    fn bound(&self, b: &Builder<'_>, rows: Rows) -> ([Bound<'_>; 2], u32) {
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

    fn new(b: &mut Builder<'_>) -> Self {
        Self { left: b.buffer("winner.left", b.sizes.map), right: b.buffer("winner.right", b.sizes.right_map) }
    }
}

/// All stages, from the uploaded images to the map.
pub(crate) fn chain(b: &mut Builder<'_>) -> Made {
    let sources = planes::sources(b);
    let views_of = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
    let images = planes::rectified(b, sources.each_ref().map(views_of));
    let content = Content::new(b);
    let content = content.as_ref();
    let views = Views::new(b);
    let mut right = None;
    if let Some(second) = b.params.second_match() {
        let params = std::mem::replace(&mut b.params, second);
        b.mirrored = true;
        b.share();
        winners(b, &images, &views, content);
        b.share();
        right = Some(filters::mirror(b, &views.left));
        (b.params, b.mirrored) = (params, false);
    }
    let planes = winners(b, &images, &views, content);
    b.share_no_more();
    let mut compared = Views { left: views.left.clone(), right: right.unwrap_or_else(|| views.right.clone()) };
    if let Some(content) = content {
        compared = content.views(b, compared);
    }
    let output = filters::filtered(b, &compared, &planes.grays[0], content);
    let confidence = b.params.confidence.then(|| filters::confidence(b, &views, &output));
    let depth = b.params.depth.is_some().then(|| filters::depth(b, &output));
    let right = b.params.right_map.then_some(compared.right);
    Made { sources, output, right, confidence, depth }
}

/// From the images to the winner of both views. Returns the planes.
fn winners(b: &mut Builder<'_>, sources: &[wgpu::TextureView; 2], views: &Views, content: Option<&Content>) -> Planes {
    let mut planes = match b.params.cost {
        Cost::MutualInformation => mi::planes(b, sources, content),
        _ => planes::planes(b, sources),
    };
    winner(b, &mut planes, views);
    planes
}

/// From what the cost compares to the winner of both views.
fn winner(b: &mut Builder<'_>, planes: &mut Planes, views: &Views) {
    match b.params.method {
        Method::Bm => cost::block_match(b, planes, views),
        Method::Sgm => aggregation::winner(b, planes, views),
    }
}
