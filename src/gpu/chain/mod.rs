//! The order of the stages: which kernel runs on what.

mod beliefs;
mod content;
mod cost;
mod ends;
mod filters;
mod images;
mod mutual_information;
mod paths;
mod planes;
#[cfg(test)]
mod tests;
mod view_maps;
mod winner;

use crate::gpu::recording::Builder;
use content::ContentBits;
pub(crate) use ends::{Ends, LabelEnds};
use filters::filtered::{confidence, depth, filtered};
use planes::Planes;
use view_maps::ViewMaps;

/// All stages, from the uploaded images to the map.
pub(crate) fn chain(b: &mut Builder<'_>) -> Ends {
    let sources = images::sources(b);
    let views_of = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
    let images = images::rectified(b, sources.each_ref().map(views_of));
    let content = ContentBits::new(b);
    let content = content.as_ref();
    let views = ViewMaps::new(b);
    let mut right = None;
    if let Some(second) = b.params.second_match() {
        let params = std::mem::replace(&mut b.params, second);
        b.mirrored = true;
        b.share();
        winners(b, &images, &views, content);
        b.share();
        right = Some(winner::mirror(b, &views.left));
        (b.params, b.mirrored) = (params, false);
    }
    let planes = winners(b, &images, &views, content);
    b.share_no_more();
    let mut compared = ViewMaps { left: views.left.clone(), right: right.unwrap_or_else(|| views.right.clone()) };
    if let Some(content) = content {
        compared = content.views(b, compared);
    }
    let output = filtered(b, &compared, &planes.grays[0], content);
    let confidence = b.params.confidence.then(|| confidence(b, &views, &output));
    let depth = b.params.depth.is_some().then(|| depth(b, &output));
    let right = b.params.right_map.then_some(compared.right);
    let labels =
        b.params.labels.then(|| LabelEnds { right_map: views.right.clone(), table: planes.table_bytes.clone() });
    Ends { sources, output, right, confidence, labels, depth }
}

/// From the images to the winner of both views. Returns the planes.
fn winners(
    b: &mut Builder<'_>,
    sources: &[wgpu::TextureView; 2],
    views: &ViewMaps,
    content: Option<&ContentBits>,
) -> Planes {
    let mut planes = match b.params.has_table() {
        true => mutual_information::planes(b, sources, content),
        false => planes::planes(b, sources),
    };
    winner::winner(b, &mut planes, views);
    planes
}
