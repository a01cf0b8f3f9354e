//! The order of the stages.

use crate::image_view::check_pair;
use crate::params::Filter;
use crate::reference::stages::{Definition, Stages};
use crate::reference::trace::{Bytes, Receiver, Trace};
use crate::reference::{Content, Views, confidence, depth, mirror, mirrored, rectify, round_disparities};
use crate::{
    ConfidenceMap, DisparityMap, Error, Image, ImageView, Labels, Matched, Method, Params, StageTime, Unrounded,
};

/// The whole chain on the CPU: what [`crate::StereoMatcher`] computes, from the definition.
///
/// # Errors
/// As [`Params::validate`], and [`Error::Image`] if the two sizes differ.
pub fn compute<'a>(
    left: impl Into<ImageView<'a>>,
    right: impl Into<ImageView<'a>>,
    params: &Params,
) -> Result<DisparityMap, Error> {
    Ok(compute_all(left, right, params)?.map)
}

/// As [`compute`], with all else that the settings ask for.
///
/// # Errors
/// As [`compute`].
pub fn compute_all<'a>(
    left: impl Into<ImageView<'a>>,
    right: impl Into<ImageView<'a>>,
    params: &Params,
) -> Result<Matched, Error> {
    Ok(compute_timed(left, right, params)?.0)
}

/// As [`compute_all`], with the time of each stage.
///
/// # Errors
/// As [`compute`].
pub fn compute_timed<'a>(
    left: impl Into<ImageView<'a>>,
    right: impl Into<ImageView<'a>>,
    params: &Params,
) -> Result<(Matched, Vec<StageTime>), Error> {
    follow([left.into(), right.into()], params, None, &mut Definition)
}

/// As [`compute_all`], and calls `receive` with the name and the bytes of the result of each stage, in the order in which
/// they are computed: a second match and each round of [`rounds`](crate::reference::rounds) repeat the names of their stages. docs/VECTORS.md
/// describes the bytes of each stage.
///
/// ```
/// use gpu_stereo::{Image, Params, Pixels, reference};
///
/// let image = Image::new(32, 8, Pixels::Gray8((0..=255).collect()))?;
/// let mut stages = Vec::new();
/// let mut receive = |stage: &str, bytes: &[u8]| stages.push((stage.to_string(), bytes.len()));
/// reference::compute_traced(&image, &image, &Params::sgm(16), &mut receive)?;
/// assert!(stages.contains(&("matching_cost".into(), 32 * 8 * 16)));
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
///
/// # Errors
/// As [`compute`].
pub fn compute_traced<'a>(
    left: impl Into<ImageView<'a>>,
    right: impl Into<ImageView<'a>>,
    params: &Params,
    receive: &mut dyn FnMut(&str, &[u8]),
) -> Result<Matched, Error> {
    let mut receive = |stage: &str, result: &dyn Bytes| {
        let mut bytes = Vec::new();
        result.append_to(&mut bytes);
        receive(stage, &bytes);
    };
    Ok(follow([left.into(), right.into()], params, Some(&mut receive), &mut Definition)?.0)
}

/// The whole chain, its stages as `stages` computes them.
pub(crate) fn follow(
    [left, right]: [ImageView<'_>; 2],
    params: &Params,
    receiver: Option<Receiver<'_>>,
    stages: &mut dyn Stages,
) -> Result<(Matched, Vec<StageTime>), Error> {
    params.validate()?;
    check_pair([left, right])?;
    params.accepts(left.width(), left.height())?;
    let content = Content::new(params, left.width(), left.height());
    let content = content.as_ref();
    let mut trace = Trace::new(receiver);
    let rectified = match &params.rectify {
        Some(rectification) => {
            let pair = [rectify(left, rectification, 0)?, rectify(right, rectification, 1)?];
            Some(trace.stage("rectify", pair))
        }
        None => None,
    };
    if let Some(content) = content {
        trace.show("content", || content);
    }
    let [left, right] =
        rectified.as_ref().map_or([left, right], |pair: &[Image; 2]| pair.each_ref().map(ImageView::from));
    let matched = match params.second_match() {
        Some(second) => {
            let content = content.map(Content::mirrored);
            let pair = [mirrored(right)?, mirrored(left)?];
            let pair = pair.each_ref().map(ImageView::from);
            let luma = stages.luma(pair[0]);
            Some(match second.method {
                Method::Psmnet => trace.inferred(pair, &second, stages)?.0.left,
                _ => stages.views(pair, &luma, content.as_ref(), &second, &mut trace).0.left,
            })
        }
        None => None,
    };
    let luma = stages.luma(left);
    let (views, table, unrounded) = match params.method {
        Method::Psmnet => {
            let (views, unrounded) = trace.inferred([left, right], params, stages)?;
            (views, Vec::new(), Some(unrounded))
        }
        _ => {
            let (views, table) = stages.views([left, right], &luma, content, params, &mut trace);
            (views, table, None)
        }
    };
    let Views { left, mut right, margins, labels } = views;
    if let Some(matched) = matched {
        right = trace.stage("mirror", mirror(&matched));
    }
    if params.reads_right_view() {
        right = trace.valid(right, content, 1);
    }
    let mut map = trace.valid(left, content, 0);
    for &filter in Filter::ALL {
        let Some(filtered) = stages.filtered(filter, &map, &right, &luma, params) else { continue };
        map = trace.stage(filter.stage(), filtered);
        if filter.gives_disparities() {
            map = trace.valid(map, content, 0);
        }
    }
    let confidence = params.confidence.then(|| trace.stage("confidence", confidence(&map, &margins)));
    let depth = params.depth.as_ref().map(|camera| trace.stage("depth", depth(&map, camera)));
    let labels = (params.labels && params.method != Method::Psmnet).then_some(Labels {
        width: map.width,
        height: map.height,
        data: labels,
        table,
    });
    let right = params.right_map.then_some(right);
    let unrounded = unrounded.filter(|_| params.unrounded);
    Ok((Matched { map, right, confidence, labels, unrounded, depth }, trace.times))
}

impl Trace<'_> {
    /// From the images to the winners of a network, and its disparities before they are rounded. There is no right view.
    fn inferred(
        &mut self,
        pair: [ImageView<'_>; 2],
        params: &Params,
        stages: &mut dyn Stages,
    ) -> Result<(Views, Unrounded), Error> {
        let disparities = stages.infer(pair, params, &mut |stage, values| {
            self.stage(stage, values);
        })?;
        let left = self.stage("round_disparities", round_disparities(&disparities, params.disparities as usize));
        let right = DisparityMap { data: vec![DisparityMap::INVALID; left.data.len()], ..left };
        let unrounded = Unrounded { width: left.width, height: left.height, data: disparities.data };
        let margins = ConfidenceMap { width: left.width, height: left.height, data: Vec::new() };
        Ok((Views { left, right, margins, labels: Vec::new() }, unrounded))
    }
}
