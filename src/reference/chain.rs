//! The order of the stages.

use crate::image::check_pair;
use crate::params::{Descriptor, Filter};
use crate::reference::energy::energy_of;
use crate::reference::stages::Stages;
use crate::reference::trace::{Bytes, Receiver, Trace};
use crate::reference::{
    Content, Descriptors, Plane, Views, Volume, beliefs, block_match, block_statistics, block_sums, coarse_cost,
    confidence, cost_columns, depth, halve, images, lr_check, matching_cost, messages, mi_histogram, mi_table, mirror,
    mirrored, penalties, rectify, round_disparities, rounds, sgm_aggregate, validity, winner,
};
use crate::{
    ConfidenceMap, DisparityMap, Energy, Error, Image, Labels, Matched, Method, Params, Prefilter, StageTime, Unrounded,
};

/// The whole chain on the CPU: what [`crate::StereoMatcher`] computes, from the definition.
///
/// # Errors
/// As [`Params::validate`], and [`Error::Image`] if the two sizes differ.
pub fn compute(left: &Image, right: &Image, params: &Params) -> Result<DisparityMap, Error> {
    Ok(compute_all(left, right, params)?.map)
}

/// As [`compute`], with all else that the settings ask for.
///
/// # Errors
/// As [`compute`].
pub fn compute_all(left: &Image, right: &Image, params: &Params) -> Result<Matched, Error> {
    Ok(compute_timed(left, right, params)?.0)
}

/// As [`compute_all`], with the time of each stage.
///
/// # Errors
/// As [`compute`].
pub fn compute_timed(left: &Image, right: &Image, params: &Params) -> Result<(Matched, Vec<StageTime>), Error> {
    follow(left, right, params, None, &mut Definition)
}

/// As [`compute_all`], and calls `receive` with the name and the bytes of the result of each stage, in the order in which
/// they are computed: a second match and each round of [`rounds`] repeat the names of their stages. docs/VECTORS.md
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
pub fn compute_traced(
    left: &Image,
    right: &Image,
    params: &Params,
    receive: &mut dyn FnMut(&str, &[u8]),
) -> Result<Matched, Error> {
    let mut receive = |stage: &str, result: &dyn Bytes| {
        let mut bytes = Vec::new();
        result.append_to(&mut bytes);
        receive(stage, &bytes);
    };
    Ok(follow(left, right, params, Some(&mut receive), &mut Definition)?.0)
}

/// All stages by the functions that define them.
pub(crate) struct Definition;

impl Stages for Definition {
    fn views(
        &mut self,
        sides: [&Image; 2],
        luma: &Plane<u8>,
        content: Option<&Content>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> (Views, Vec<u8>) {
        views_of(sides, luma, content, params, self, trace)
    }

    fn winner(
        &mut self,
        sides: &[Descriptors; 2],
        table: &[u8],
        penalties: Option<&Volume<u8>>,
        luma: Option<&Plane<u8>>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> Views {
        trace.winner(sides, table, penalties, luma, params)
    }
}

/// The whole chain, its stages as `stages` computes them.
pub(crate) fn follow(
    left: &Image,
    right: &Image,
    params: &Params,
    receiver: Option<Receiver<'_>>,
    stages: &mut dyn Stages,
) -> Result<(Matched, Vec<StageTime>), Error> {
    params.validate()?;
    check_pair(left, right)?;
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
    let [left, right] = rectified.as_ref().map_or([left, right], |[left, right]| [left, right]);
    let matched = match params.second_match() {
        Some(second) => {
            let content = content.map(Content::mirrored);
            let [left, right] = [mirrored(right)?, mirrored(left)?];
            let luma = stages.luma(&left);
            Some(match second.method {
                Method::Psmnet => trace.inferred([&left, &right], &second, stages)?.0.left,
                _ => stages.views([&left, &right], &luma, content.as_ref(), &second, &mut trace).0.left,
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

/// From the images, of which `luma` is that of the left one, to the winner of both views, and [`cost_table`]: stage by stage.
pub(crate) fn views_of(
    [left, right]: [&Image; 2],
    luma: &Plane<u8>,
    content: Option<&Content>,
    params: &Params,
    stages: &mut dyn Stages,
    trace: &mut Trace<'_>,
) -> (Views, Vec<u8>) {
    let adaptive = params.adaptive_p2 && params.method == Method::Sgm;
    let ([left, right], _) = trace.stage("gray", ([left, right].map(|image| images(image, params)), luma));
    let penalties = adaptive.then(|| trace.stage("penalties", penalties(luma, params)));
    if params.prefilter == Prefilter::Normalized {
        trace.show("window_sums", || [&left, &right].map(|images| images.window_sums(params.prefilter_window)));
    }
    let [left, right] = trace.stage("prefilter", [left.prefiltered(params), right.prefiltered(params)]);
    if params.compares(Descriptor::Excess) {
        trace.show("window_sums", || [&left, &right].map(|images| images.window_sums(params.block)));
    }
    let sides = trace.stage("descriptors", [left.descriptors(params), right.descriptors(params)]);
    let table = trace.table(&sides, content, params, stages);
    let views = stages.winner(&sides, &table, penalties.as_ref(), Some(luma), params, trace);
    if params.labels {
        trace.show("labels", || &views.labels);
        trace.show("energy", || {
            let Energy { data, smoothness } = energy_of(&sides, luma, &views.labels, &table, params);
            [data, smoothness]
        });
    }
    (views, table)
}

/// What matches cost in the last round of [`rounds`], for a cost that has a table; else nothing. `content`: where the pair
/// has it, `None` for everywhere.
pub fn cost_table(sides: &[Descriptors; 2], content: Option<&Content>, params: &Params) -> Vec<u8> {
    Trace::new(None).table(sides, content, params, &mut Definition)
}

impl Trace<'_> {
    /// [`cost_table`].
    pub(crate) fn table(
        &mut self,
        sides: &[Descriptors; 2],
        content: Option<&Content>,
        params: &Params,
        stages: &mut dyn Stages,
    ) -> Vec<u8> {
        if !params.has_table() {
            return Vec::new();
        }
        let rounds = rounds(sides[0].width as u32, sides[0].height as u32, params);
        let mut pyramid = vec![sides.clone()];
        for _ in 0..rounds[0].halvings {
            let halved = pyramid[pyramid.len() - 1].each_ref().map(halve);
            pyramid.push(self.stage("halve", halved));
        }
        let mut table = self.round(&pyramid[rounds[0].halvings as usize], None, 0);
        for (before, here) in rounds.iter().zip(&rounds[1..]) {
            let sides = &pyramid[before.halvings as usize];
            let views = stages.winner(sides, &table, None, None, &before.params, self);
            let content = content.map(|content| content.halved(before.halvings));
            let right = self.valid(views.right, content.as_ref(), 1);
            let mut map = self.valid(views.left, content.as_ref(), 0);
            if let Some(max_difference) = before.params.lr_check {
                map = self.stage("lr_check", lr_check(&map, &right, max_difference));
            }
            table = self.round(&pyramid[here.halvings as usize], Some(&map), before.halvings - here.halvings);
        }
        table
    }

    /// The table of a round, by the map of the round before.
    fn round(&mut self, [left, right]: &[Descriptors; 2], map: Option<&DisparityMap>, halvings: u32) -> Vec<u8> {
        let counts = self.stage("mi_histogram", mi_histogram(left, right, map, halvings));
        self.stage("mi_table", mi_table(&counts, (left.width * left.height) as u64))
    }

    /// From what the cost compares to the winner of both views, stage by stage.
    pub(crate) fn winner(
        &mut self,
        [left, right]: &[Descriptors; 2],
        table: &[u8],
        penalties: Option<&Volume<u8>>,
        luma: Option<&Plane<u8>>,
        params: &Params,
    ) -> Views {
        let columns = self.stage("cost_columns", cost_columns(left, right, table, params));
        self.show("block_sums", || (0..columns.height).map(|y| block_sums(&columns, y, params)).collect::<Vec<_>>());
        match params.method {
            // A network finds its winners by itself.
            Method::Bm | Method::Psmnet => {
                let statistics =
                    params.correlates().then(|| self.stage("block_statistics", block_statistics(left, right, params)));
                self.stage("block_match", block_match(&columns, statistics.as_ref(), params))
            }
            Method::Sgm => {
                let cost = self.stage("matching_cost", matching_cost(&columns, params));
                drop(columns);
                let sum = self.stage("sgm_aggregate", sgm_aggregate(&cost, penalties, params));
                self.stage("winner", winner(&sum, params))
            }
            Method::Bp => {
                let cost = self.stage("matching_cost", matching_cost(&columns, params));
                drop(columns);
                let mut coarse = coarse_cost(&cost, params);
                if !coarse.is_empty() {
                    coarse = self.stage("coarse_cost", coarse);
                }
                let messages = self.stage("messages", messages(&cost, &coarse, luma, params));
                let beliefs = beliefs(&cost, &messages[messages.len() - 1]);
                self.show("beliefs", || &beliefs);
                self.stage("winner", winner(&beliefs, params))
            }
        }
    }

    /// From the images to the winners of a network, and its disparities before they are rounded. There is no right view.
    fn inferred(
        &mut self,
        [left, right]: [&Image; 2],
        params: &Params,
        stages: &mut dyn Stages,
    ) -> Result<(Views, Unrounded), Error> {
        let disparities = stages.infer(left, right, params, &mut |stage, values| {
            self.stage(stage, values);
        })?;
        let left = self.stage("round_disparities", round_disparities(&disparities, params.disparities as usize));
        let right = DisparityMap { data: vec![DisparityMap::INVALID; left.data.len()], ..left };
        let unrounded = Unrounded { width: left.width, height: left.height, data: disparities.data };
        let margins = ConfidenceMap { width: left.width, height: left.height, data: Vec::new() };
        Ok((Views { left, right, margins, labels: Vec::new() }, unrounded))
    }

    /// Stage `validity`, where not all pixels have content.
    fn valid(&mut self, map: DisparityMap, content: Option<&Content>, side: usize) -> DisparityMap {
        match content {
            Some(content) => self.stage("validity", validity(&map, content, side)),
            None => map,
        }
    }
}
