//! The operations in order.

use super::activation::{Activation, Source};
use super::convolutions::{Finish, convolution};
use super::images::{average_pool, concat, input, upsample};
use super::regression::disparity_regression;
use super::transposed::transposed;
use crate::network::{Convolution, Kind, Operation, Padded};
use crate::reference::Plane;
use crate::{Error, ImageView, Network, Params};

/// Runs a network on a pair: the disparities of the left image in pixels. `receive` is called with the number of each
/// operation when it is done.
///
/// # Errors
/// [`Error::Network`] if the network lacks weights.
pub fn disparities(
    [left, right]: [ImageView<'_>; 2],
    network: &Network,
    params: &Params,
    receive: &mut dyn FnMut(usize),
) -> Result<Plane<f32>, Error> {
    let padded = Padded::new(left.width(), left.height(), params.disparities);
    let operations = network.operations();
    let last = Operation::last_reads(operations);
    let mut made: Vec<[Option<Activation>; 2]> = Vec::new();
    for (at, operation) in operations.iter().enumerate() {
        let mut sides = [None, None];
        for (side, to) in sides.iter_mut().enumerate().take(if operation.both_sides { 2 } else { 1 }) {
            let image = [left, right][side];
            *to = Some(Step { network, operation, made: &made, side, padded: &padded }.compute(image, params)?);
        }
        made.push(sides);
        (0..at).filter(|&earlier| last[earlier] <= at).for_each(|earlier| made[earlier] = [None, None]);
        network.add_done(operation.multiplications(operations, &padded));
        receive(at);
    }
    let [width, height] = [left.width() as usize, left.height() as usize];
    let above = padded.height - height;
    let data = match made.last() {
        Some([Some(last), _]) => (above..padded.height).flat_map(|y| &last.row(0, 0, y)[..width]).copied().collect(),
        _ => Vec::new(),
    };
    Ok(Plane { width, height, data })
}

/// An operation for a side.
pub(super) struct Step<'a> {
    pub(super) network: &'a Network,
    pub(super) operation: &'a Operation,
    /// What earlier operations made, of both sides, as far as it is still read.
    pub(super) made: &'a [[Option<Activation>; 2]],
    pub(super) side: usize,
    pub(super) padded: &'a Padded,
}

impl<'a> Step<'a> {
    fn read(&self, input: usize, side: usize) -> Result<&'a Activation, Error> {
        let made = self.made.get(input).and_then(|sides| sides[side].as_ref());
        made.ok_or_else(|| Error::Network(format!("{} reads what is not there", self.operation.name)))
    }

    pub(super) fn compute(&self, image: ImageView<'_>, params: &Params) -> Result<Activation, Error> {
        let input_of = |i: usize| self.read(self.operation.inputs[i], self.side);
        let [_, planes, rows, columns] = self.operation.shape(self.padded);
        let Some(weights) = self.network.convolution(&self.operation.name) else {
            return Ok(match self.operation.kind {
                Kind::AveragePool { side } => average_pool(input_of(0)?, side),
                Kind::Upsample => upsample(input_of(0)?, rows, columns, params.align_corners),
                Kind::Concat => {
                    let inputs = self.operation.inputs.iter().map(|&input| self.read(input, self.side));
                    concat(&inputs.collect::<Result<Vec<_>, _>>()?)
                }
                Kind::Regression => disparity_regression(input_of(0)?, self.padded.disparities, params.align_corners),
                _ => input(image, self.padded),
            });
        };
        let add = self.operation.add.map(|add| self.read(add, self.side)).transpose()?;
        let finish = Finish { bias: &weights.bias, add, relu: self.operation.relu };
        self.convolved(weights, finish, planes, input_of(0)?)
    }

    fn convolved(
        &self,
        weights: &Convolution,
        finish: Finish<'_>,
        planes: usize,
        input: &Activation,
    ) -> Result<Activation, Error> {
        Ok(match self.operation.kind {
            Kind::TransposedConv3d => transposed(input, weights, finish),
            Kind::VolumeConv3d => {
                let right = self.read(self.operation.inputs[0], 1)?;
                convolution(Source::Pair(input, right, planes), weights, [1, 1], finish)
            }
            Kind::Conv2d { stride, dilation, .. } => {
                convolution(Source::One(input), weights, [stride, dilation], finish)
            }
            Kind::Conv3d { stride } => convolution(Source::One(input), weights, [stride, 1], finish),
            _ => return Err(Error::Network(format!("{} takes no weights", self.operation.name))),
        })
    }
}
