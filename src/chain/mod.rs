//! The schedule: which kernel runs on what, in what order.

mod aggregation;
mod cost;
mod filters;
mod mi;
mod planes;
#[cfg(test)]
mod tests;

use crate::steps::Builder;
use crate::{Cost, Method};

/// What the matcher needs of what the chain made.
pub(crate) struct Made {
    /// The textures into which images are uploaded.
    pub(crate) sources: [wgpu::Texture; 2],
    /// The map that is read back.
    pub(crate) output: wgpu::Buffer,
    /// The confidence of that map, if it is wanted.
    pub(crate) confidence: Option<wgpu::Buffer>,
}

/// The maps of both views, and behind the right one, if a confidence is wanted, the margins of the left one's winners:
/// `winner` has no room for one more buffer.
pub(crate) struct Views {
    left: wgpu::Buffer,
    right: wgpu::Buffer,
}

/// All stages, from the uploaded images to the map.
pub(crate) fn chain(b: &mut Builder<'_>) -> Made {
    let sources = planes::sources(b);
    let planes = match b.params.cost {
        Cost::MutualInformation => mi::planes(b, &sources),
        _ => planes::planes(b, &sources),
    };
    let views = views(b, &planes);
    let output = filters::filtered(b, &views, &planes.grays[0]);
    let confidence = b.params.confidence.then(|| filters::confidence(b, &views, &output));
    Made { sources, output, confidence }
}

/// The stages from the planes to the maps of both views.
fn views(b: &mut Builder<'_>, planes: &planes::Planes) -> Views {
    let views =
        Views { left: b.buffer("winner.left", b.sizes.map), right: b.buffer("winner.right", b.sizes.right_map) };
    match b.params.method {
        Method::Bm => cost::block_match(b, planes, &views),
        Method::Sgm => aggregation::winner(b, planes, &views),
    }
    views
}
