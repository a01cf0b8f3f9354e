//! What a schedule may compute in its own way while it follows the chain.

use crate::params::Filter;
use crate::reference::trace::Trace;
use crate::reference::{
    Channel, Content, Descriptors, Plane, Report, Values, Views, Volume, filtered, gray, network, stage,
};
use crate::{DisparityMap, Error, Image, Params};

/// How stages are computed. Without a function of its own a schedule computes them as the definition does.
pub(crate) trait Stages {
    /// The network of the settings: the disparities of the left image.
    fn infer(&mut self, left: &Image, right: &Image, params: &Params, report: Report<'_>) -> Result<Plane<f32>, Error> {
        let Some(with) = &params.network else { return Err(Error::Misuse("method psmnet needs a network".into())) };
        let mut receive = |at: usize, _, values: &Values| report(stage(with.operations()[at].kind), Some(values));
        let Plane { width, height, data } = network(left, right, with, params, &mut receive)?;
        Ok(Plane { width, height, data: data.into_iter().map(|value| value as f32).collect() })
    }

    /// The luma of the left image, which filters read.
    fn luma(&mut self, left: &Image) -> Plane<u8> {
        gray(left, Channel::Luma)
    }

    /// From the images, of which `luma` is that of the left one, to the winner of both views; and the table of what matches
    /// cost, if the cost has one.
    fn views(
        &mut self,
        sides: [&Image; 2],
        luma: &Plane<u8>,
        content: Option<&Content>,
        params: &Params,
        trace: &mut Trace<'_>,
    ) -> (Views, Vec<u8>);

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
