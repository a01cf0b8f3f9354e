//! The schedule: which kernel runs on what, in what order.

mod aggregation;
mod cost;
mod filters;
mod planes;

use crate::Method;
use crate::steps::Builder;

/// What the matcher needs of what the chain made.
pub(crate) struct Made {
    /// The textures into which images are uploaded.
    pub(crate) sources: [wgpu::Texture; 2],
    /// The map of the right view.
    pub(crate) right_map: wgpu::Buffer,
    /// The map that is read back.
    pub(crate) output: wgpu::Buffer,
}

/// The maps of both views.
pub(crate) struct Views {
    left: wgpu::Buffer,
    right: wgpu::Buffer,
}

/// All stages, from the uploaded images to the map.
pub(crate) fn chain(b: &mut Builder<'_>) -> Made {
    let sources = planes::sources(b);
    let mut views = Views { left: b.buffer("winner.left", b.sizes.map), right: b.buffer("winner.right", b.sizes.map) };
    let right_map = views.right.clone();
    if let Some(second) = b.params.second_match() {
        let params = std::mem::replace(&mut b.params, second);
        b.mirrored = true;
        b.share();
        winners(b, &sources, &views);
        b.share();
        views.right = filters::mirror(b, &views.left);
        (b.params, b.mirrored) = (params, false);
    }
    winners(b, &sources, &Views { left: views.left.clone(), right: right_map.clone() });
    b.share_no_more();
    let output = filters::filtered(b, &views);
    Made { sources, right_map, output }
}

/// From the images to the winner of both views.
fn winners(b: &mut Builder<'_>, sources: &[wgpu::Texture; 2], views: &Views) {
    let planes = planes::planes(b, sources);
    match b.params.method {
        Method::Bm => cost::block_match(b, &planes, views),
        Method::Sgm => aggregation::winner(b, &planes, views),
    }
}
