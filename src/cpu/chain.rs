//! The stages that this schedule computes in its own way.

use crate::cpu::cost::{CostRows, block_match};
use crate::cpu::features::FeatureRows;
use crate::cpu::filters::filtered;
use crate::cpu::images::{Channels, Planes, Samples, Side, luma};
use crate::cpu::instructions::Instructions;
use crate::cpu::network::disparities;
use crate::cpu::paths::{Aggregation, Buffers, CostSource, Record, aggregate, penalties, second_cost};
use crate::params::Filter;
use crate::reference::{
    Content, Descriptors, FeatureStatistics, Plane, Report, Stages, Trace, Views, Volume, stage, views_of,
};
use crate::{DisparityMap, Error, FeatureNetwork, ImageView, Method, Params};

/// The native schedule's stages.
pub(super) struct Native<'a> {
    /// What it is compiled for.
    instructions: Instructions,
    /// Of this pair and the next.
    buffers: &'a Buffers,
    /// The disparities of networks so far, which the check goes on from.
    pub(super) inferred: Vec<Plane<f32>>,
}

impl<'a> Native<'a> {
    pub(super) fn new(instructions: Instructions, buffers: &'a Buffers) -> Self {
        Self { instructions, buffers, inferred: Vec::new() }
    }
}

impl Stages for Native<'_> {
    fn infer(&mut self, pair: [ImageView<'_>; 2], params: &Params, report: Report<'_>) -> Result<Plane<f32>, Error> {
        let network = params.given_network()?;
        let mut receive = |at: usize| report(stage(network.operations()[at].kind), None);
        let inferred = disparities(pair, network, params, &mut receive)?;
        self.inferred.push(inferred.clone());
        Ok(inferred)
    }

    fn luma(&mut self, left: ImageView<'_>) -> Plane<u8> {
        luma(left, self.instructions)
    }

    fn features(
        &mut self,
        image: &Plane<u16>,
        unit: i32,
        _: FeatureStatistics,
        network: &FeatureNetwork,
    ) -> Descriptors {
        FeatureRows::new(&Samples::of(image, unit), network, self.instructions).descriptors()
    }

    fn views(
        &mut self,
        sides: [ImageView<'_>; 2],
        luma: &Plane<u8>,
        content: Option<&Content>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> (Views, Vec<u8>) {
        if !has_own_stages(params.method) {
            return views_of(sides, luma, content, params, self, trace);
        }
        let channels = sides.map(|image| Channels::new(image, params, self.instructions));
        trace.done("gray", || (channels.each_ref().map(Channels::images), luma));
        let channels = channels.map(|channels| channels.prefiltered(params));
        trace.done("prefilter", || channels.each_ref().map(Channels::images));
        let features = channels.each_ref().map(|side| side.features(params));
        let [left, right] = features.each_ref().map(Option::as_ref);
        if let (Some(left), Some(right)) = (left, right) {
            trace.show("feature_statistics", || [left.statistics, right.statistics]);
            trace.done("features", || [left.descriptors(), right.descriptors()]);
        }
        let planes = [channels[0].planes(Side::Left, left, params), channels[1].planes(Side::Right, right, params)];
        // In the definition's layout both sides are laid out like the left one.
        let of = |side: usize| channels[side].planes(Side::Left, [left, right][side], params).descriptors(params);
        let descriptors = || [of(0), of(1)];
        trace.done("descriptors", descriptors);
        let table = match params.has_table() {
            true => trace.table(&descriptors(), content, params, self),
            false => Vec::new(),
        };
        (self.winners(&planes, &table, Some(luma), params, trace), table)
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
        if !has_own_stages(params.method) {
            return trace.winner(sides, table, penalties, luma, params);
        }
        let [left, right] = sides;
        let planes = [Planes::of(left, Side::Left, params), Planes::of(right, Side::Right, params)];
        self.winners(&planes, table, luma, params, trace)
    }

    fn filtered(
        &mut self,
        filter: Filter,
        map: &DisparityMap,
        right: &DisparityMap,
        luma: &Plane<u8>,
        params: &Params,
    ) -> Option<DisparityMap> {
        filtered(filter, map, right, luma, params, self.instructions)
    }
}

/// Whether the native schedule has stages of its own for what leads to the winners of a method, compiled for several instruction
/// sets. Else it computes them as the reference does, or by a network.
pub fn has_own_stages(method: Method) -> bool {
    matches!(method, Method::Sgm | Method::Bm)
}

impl Native<'_> {
    /// From the planes of both sides to the winner of both views.
    fn winners(
        &self,
        planes: &[Planes; 2],
        table: &[u8],
        luma: Option<&Plane<u8>>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> Views {
        let [left, right] = planes;
        if params.method == Method::Bm {
            return trace.stage("block_match", block_match([left, right], table, params, self.instructions));
        }
        let size = [left.width, left.height];
        let adaptive = luma.filter(|_| params.adapts_penalties());
        let penalties = adaptive.map(|luma| trace.stage("penalties", penalties(luma, params)));
        let job = Aggregation::new(size, params, penalties.as_ref(), self.instructions, self.buffers);
        let mut record = trace.is_received().then(|| Record::new(left.width, left.height, params));
        let source = || -> Box<dyn CostSource + Send + '_> {
            Box::new(CostRows::new([left, right], table, params, self.instructions))
        };
        if !params.aggregates_twice() {
            let views = aggregate(&job, &source, record.as_mut());
            if let Some(Record { cost, sum }) = record {
                trace.show("matching_cost", || cost);
                trace.show("sgm_aggregate", || sum);
            }
            return trace.stage("winner", views);
        }
        let second = second_cost(&job, &source, record.as_mut());
        if let Some(Record { cost, sum }) = &record {
            trace.show("matching_cost", || cost);
            trace.show("sgm_aggregate", || sum);
        }
        trace.done("second_cost", || second.volume(params));
        let source = || -> Box<dyn CostSource + Send + '_> { Box::new(&second) };
        let views = aggregate(&job, &source, record.as_mut());
        if let Some(Record { sum, .. }) = record {
            trace.show("sgm_aggregate", || sum);
        }
        trace.stage("winner", views)
    }
}
