//! The order of the stages: which kernel runs on what.

mod beliefs;
mod content;
mod cost;
mod ends;
mod features;
mod filters;
mod images;
mod mutual_information;
mod network;
mod paths;
mod planes;
#[cfg(test)]
mod tests;
mod view_maps;
mod winner;

use crate::Method;
use crate::gpu::recording::Builder;
use content::ContentBits;
pub(crate) use ends::{Ends, LabelEnds};
use filters::filtered::{confidence, depth, filtered};
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
    let winners = winners(b, &images, &views, content);
    b.share_no_more();
    let mut compared = ViewMaps { left: views.left.clone(), right: right.unwrap_or_else(|| views.right.clone()) };
    if let Some(content) = content {
        compared = content.views(b, compared);
    }
    let output = filtered(b, &compared, &winners.gray, content);
    let confidence = b.params.confidence.then(|| confidence(b, &views, &output));
    let depth = b.params.depth.is_some().then(|| depth(b, &output));
    let right = b.params.right_map.then_some(compared.right);
    let labels =
        b.params.has_labels().then(|| LabelEnds { right_map: views.right.clone(), table: winners.table.clone() });
    let unrounded = winners.disparities.filter(|_| b.params.unrounded);
    Ends { sources, output, right, confidence, labels, unrounded, depth }
}

/// What is left beside the winners of both views.
struct Winners {
    /// The left gray image.
    gray: wgpu::TextureView,
    /// What pairs of values cost, if the cost is looked up.
    table: Option<wgpu::Buffer>,
    /// The disparities of the network, if there is one.
    disparities: Option<wgpu::Buffer>,
}

/// From the images to the winner of both views.
fn winners(
    b: &mut Builder<'_>,
    sources: &[wgpu::TextureView; 2],
    views: &ViewMaps,
    content: Option<&ContentBits>,
) -> Winners {
    if b.params.method == Method::Psmnet {
        let source = images::source_of(b, sources, 0);
        let gray = images::gray(b, &source, 0);
        let disparities = Some(network::network(b, sources, &views.left));
        return Winners { gray, table: None, disparities };
    }
    let mut planes = match b.params.has_table() {
        true => mutual_information::planes(b, sources, content),
        false => planes::planes(b, sources),
    };
    winner::winner(b, &mut planes, views);
    Winners { gray: planes.grays[0].clone(), table: planes.table_bytes, disparities: None }
}
