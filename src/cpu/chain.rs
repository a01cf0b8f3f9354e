//! The stages that this schedule computes in its own way.

use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::cpu::cost::CostRows;
use crate::cpu::filters::filtered;
use crate::cpu::images::{Channels, Planes, Side, luma};
use crate::cpu::instructions::Instructions;
use crate::cpu::network::disparities;
use crate::params::Filter;
use crate::reference::{
    Content, Descriptors, Plane, Report, Stages, Trace, Views, Volume, penalties, sgm_aggregate, stage, views_of,
    winner,
};
use crate::{DisparityMap, Error, Image, Method, Params};
use rayon::prelude::*;

/// The native schedule's stages.
#[derive(Debug)]
pub(super) struct Native {
    /// What it is compiled for.
    instructions: Instructions,
    /// The disparities of networks so far, which the check goes on from.
    pub(super) inferred: Vec<Plane<f32>>,
}

impl Native {
    pub(super) fn new(instructions: Instructions) -> Self {
        Self { instructions, inferred: Vec::new() }
    }
}

impl Stages for Native {
    fn infer(&mut self, left: &Image, right: &Image, params: &Params, report: Report<'_>) -> Result<Plane<f32>, Error> {
        let Some(network) = &params.network else { return Err(Error::Misuse("method psmnet needs a network".into())) };
        let mut receive = |at: usize| report(stage(network.operations()[at].kind), None);
        let inferred = disparities(left, right, network, params, &mut receive)?;
        self.inferred.push(inferred.clone());
        Ok(inferred)
    }

    fn luma(&mut self, left: &Image) -> Plane<u8> {
        luma(left, self.instructions)
    }

    fn views(
        &mut self,
        sides: [&Image; 2],
        luma: &Plane<u8>,
        content: Option<&Content>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> (Views, Vec<u8>) {
        if !has_own_stages(params) {
            return views_of(sides, luma, content, params, self, trace);
        }
        let channels = sides.map(|image| Channels::new(image, params, self.instructions));
        trace.done("gray", || (channels.each_ref().map(Channels::images), luma));
        let channels = channels.map(|channels| channels.prefiltered(params));
        trace.done("prefilter", || channels.each_ref().map(Channels::images));
        let planes = [channels[0].planes(Side::Left, params), channels[1].planes(Side::Right, params)];
        // In the definition's layout both sides are laid out like the left one.
        let descriptors = || channels.each_ref().map(|side| side.planes(Side::Left, params).descriptors(params));
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
        if !has_own_stages(params) {
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

/// Whether there is a schedule of its own for what leads to the winners; else the reference computes it.
fn has_own_stages(params: &Params) -> bool {
    params.method == Method::Sgm
}

impl Native {
    /// From the planes of both sides to the winner of both views.
    fn winners(
        &self,
        planes: &[Planes; 2],
        table: &[u8],
        luma: Option<&Plane<u8>>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> Views {
        let adaptive = luma.filter(|_| params.adaptive_p2);
        let penalties = adaptive.map(|luma| trace.stage("penalties", penalties(luma, params)));
        let cost = trace.stage("matching_cost", self.matching_cost(planes, table, params));
        let sum = trace.stage("sgm_aggregate", sgm_aggregate(&cost, penalties.as_ref(), params));
        trace.stage("winner", winner(&sum, params))
    }

    /// Stage `matching_cost` as the definition has it.
    fn matching_cost(&self, planes: &[Planes; 2], table: &[u8], params: &Params) -> Volume<u8> {
        let [left, right] = planes;
        let (width, disparities) = (left.width, params.disparities as usize);
        let padded = disparities.next_multiple_of(LANES);
        let mut cost = Volume::new(width, left.height, disparities);
        let rows = left.height.div_ceil(4 * rayon::current_num_threads()).max(8);
        let length = cost.row_len();
        cost.data.par_chunks_mut(rows * length).enumerate().for_each(|(band, to)| {
            let mut costs = CostRows::new([left, right], table, params, self.instructions);
            let mut row = Aligned::zeroed(width * padded);
            for (y, to) in (rows * band..).zip(to.chunks_exact_mut(length)) {
                costs.row(y, 0..width, &mut row);
                for (to, row) in to.chunks_exact_mut(disparities).zip(row.chunks_exact(padded)) {
                    to.copy_from_slice(&row[..disparities]);
                }
            }
        });
        cost
    }
}
