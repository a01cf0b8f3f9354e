//! What a schedule may compute in its own way while it follows the chain.

use crate::params::{Descriptor, Filter};
use crate::reference::energy::energy_of;
use crate::reference::trace::Trace;
use crate::reference::{
    Channel, Content, Descriptors, FeatureStatistics, Images, Plane, Report, Values, Views, Volume, beliefs,
    block_match, block_statistics, block_sums, coarse_cost, cost_columns, feature_statistics, feature_values, features,
    filtered, gray, halve, images, lr_check, matching_cost, messages, mi_histogram, mi_table, network, penalties,
    rounds, second_cost, sgm_aggregate, stage, validity, winner,
};
use crate::{DisparityMap, Energy, Error, FeatureNetwork, ImageView, Method, Params, Prefilter};

/// How stages are computed. Without a function of its own a schedule computes them as the definition does.
pub(crate) trait Stages {
    /// The network of the settings: the disparities of the left image.
    fn infer(
        &mut self,
        [left, right]: [ImageView<'_>; 2],
        params: &Params,
        report: Report<'_>,
    ) -> Result<Plane<f32>, Error> {
        let with = params.given_network()?;
        let mut receive = |at: usize, _, values: &Values| report(stage(with.operations()[at].kind), Some(values));
        let Plane { width, height, data } = network(left, right, with, params, &mut receive)?;
        Ok(Plane { width, height, data: data.into_iter().map(|value| value as f32).collect() })
    }

    /// The luma of the left image, which filters read.
    fn luma(&mut self, left: ImageView<'_>) -> Plane<u8> {
        gray(left, Channel::Luma)
    }

    /// The features of a prefiltered image, whose unit is `unit`.
    fn features(
        &mut self,
        image: &Plane<u16>,
        unit: i32,
        statistics: FeatureStatistics,
        network: &FeatureNetwork,
    ) -> Descriptors {
        features(&feature_values(image, unit, statistics, network))
    }

    /// From the images, of which `luma` is that of the left one, to the winner of both views; and the table of what matches
    /// cost, if the cost has one.
    fn views(
        &mut self,
        sides: [ImageView<'_>; 2],
        luma: &Plane<u8>,
        content: Option<&Content>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> (Views, Vec<u8>) {
        views_of(sides, luma, content, params, self, trace)
    }

    /// From what the cost compares to the winner of both views.
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

    /// The map that a filter makes of `map`. `None` if the settings do not ask for the filter.
    fn filtered(
        &mut self,
        filter: Filter,
        map: &DisparityMap,
        right: &DisparityMap,
        luma: &Plane<u8>,
        params: &Params,
    ) -> Option<DisparityMap> {
        filtered(filter, map, right, luma, params)
    }
}

/// All stages by the functions that define them.
pub(crate) struct Definition;

impl Stages for Definition {}

/// From the images, of which `luma` is that of the left one, to the winner of both views, and [`cost_table`]: stage by stage.
pub(crate) fn views_of(
    [left, right]: [ImageView<'_>; 2],
    luma: &Plane<u8>,
    content: Option<&Content>,
    params: &Params,
    stages: &mut (impl Stages + ?Sized),
    trace: &mut Trace<'_>,
) -> (Views, Vec<u8>) {
    let ([left, right], _) = trace.stage("gray", ([left, right].map(|image| images(image, params)), luma));
    let penalties = params.adapts_penalties().then(|| trace.stage("penalties", penalties(luma, params)));
    if params.prefilter == Prefilter::Normalized {
        trace.show("window_sums", || [&left, &right].map(|images| images.window_sums(params.prefilter_window)));
    }
    let [left, right] = trace.stage("prefilter", [left.prefiltered(params), right.prefiltered(params)]);
    if params.compares(Descriptor::Excess) {
        trace.show("window_sums", || [&left, &right].map(|images| images.window_sums(params.block)));
    }
    let features = trace.features([&left, &right], params, stages);
    let described =
        |images: &Images, side: usize| images.described(features.as_ref().map(|sides| &sides[side]), params);
    let sides = trace.stage("descriptors", [described(&left, 0), described(&right, 1)]);
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
    /// The features of both sides, where the cost compares such, from the prefiltered images.
    fn features(
        &mut self,
        sides: [&Images; 2],
        params: &Params,
        stages: &mut (impl Stages + ?Sized),
    ) -> Option<[Descriptors; 2]> {
        let network = params.feature_network()?;
        let of = |images: &Images| feature_statistics(&images.channels[0], images.unit);
        let statistics = self.stage("feature_statistics", sides.map(of));
        let made = [0, 1].map(|side: usize| {
            let Images { channels, unit, .. } = sides[side];
            stages.features(&channels[0], *unit, statistics[side], &network)
        });
        Some(self.stage("features", made))
    }

    /// [`cost_table`].
    pub(crate) fn table(
        &mut self,
        sides: &[Descriptors; 2],
        content: Option<&Content>,
        params: &Params,
        stages: &mut (impl Stages + ?Sized),
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
                let mut cost = self.stage("matching_cost", matching_cost(&columns, params));
                drop(columns);
                let mut sum = self.stage("sgm_aggregate", sgm_aggregate(&cost, penalties, params));
                if params.aggregates_twice() {
                    cost = self.stage("second_cost", second_cost(&cost, &sum, params));
                    drop(sum);
                    sum = self.stage("sgm_aggregate", sgm_aggregate(&cost, penalties, params));
                }
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

    /// Stage `validity`, where not all pixels have content.
    pub(super) fn valid(&mut self, map: DisparityMap, content: Option<&Content>, side: usize) -> DisparityMap {
        match content {
            Some(content) => self.stage("validity", validity(&map, content, side)),
            None => map,
        }
    }
}
