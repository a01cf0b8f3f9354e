use crate::network::{Kind, Operation, Padded};
use crate::reference::{Plane, Values, network_input, operation};
use crate::{Error, ImageView, Network, Params};

/// Receives the stage of each operation when that is done, with what it made if that is of f64.
pub(crate) type Report<'a> = &'a mut dyn FnMut(&str, Option<&Values>);

/// The stage that an operation is part of.
pub(crate) fn stage(kind: Kind) -> &'static str {
    match kind {
        Kind::Input => "network_input",
        Kind::Conv2d { .. } => "conv2d",
        Kind::AveragePool { .. } => "average_pool",
        Kind::Upsample => "upsample",
        Kind::Concat => "concat",
        Kind::VolumeConv3d | Kind::Conv3d { .. } => "conv3d",
        Kind::TransposedConv3d => "conv3d_transposed",
        Kind::Regression => "disparity_regression",
    }
}

/// Runs a network on a pair: the disparities of the left image in pixels. `receive` is called with the number of each
/// operation, the side (0 is left, and what both sides have in common) and what it made.
///
/// # Errors
/// [`Error::Network`] if the network lacks weights.
pub fn network<'a>(
    left: impl Into<ImageView<'a>>,
    right: impl Into<ImageView<'a>>,
    network: &Network,
    params: &Params,
    receive: &mut dyn FnMut(usize, usize, &Values),
) -> Result<Plane<f64>, Error> {
    let (left, right) = (left.into(), right.into());
    let padded = Padded::new(left.width(), left.height(), params.disparities);
    let operations = network.operations();
    let last = Operation::last_reads(operations);
    let mut made: Vec<[Option<Values>; 2]> = Vec::new();
    for (at, row) in operations.iter().enumerate() {
        let mut sides = [None, None];
        for (side, to) in sides.iter_mut().enumerate().take(if row.both_sides { 2 } else { 1 }) {
            let read = |input: usize, side: usize| made[input][side].as_ref();
            let inputs: Vec<&Values> =
                row.reads(side).into_iter().filter_map(|(input, side)| read(input, side)).collect();
            let values = match row.kind {
                Kind::Input => network_input([left, right][side], &padded),
                _ => {
                    let add = row.add.and_then(|add| read(add, side));
                    operation(network, at, &inputs, add, &padded, params.align_corners)?
                }
            };
            receive(at, side, &values);
            *to = Some(values);
        }
        network.add_done(row.multiplications(operations, &padded));
        made.push(sides);
        (0..at).filter(|&earlier| last[earlier] <= at).for_each(|earlier| made[earlier] = [None, None]);
    }
    let disparities = made.pop().and_then(|[left, _]| left).unwrap_or_else(|| Values::new([1, 1, 0, 0]));
    Ok(cropped(&disparities, left))
}

/// What lies on the image: the last rows, the first columns.
pub fn cropped<'a>(disparities: &Values, image: impl Into<ImageView<'a>>) -> Plane<f64> {
    let image = image.into();
    let [width, height] = [image.width() as usize, image.height() as usize];
    let above = disparities.shape[2] - height;
    let data = (0..height).flat_map(|y| &disparities.row(0, 0, above + y)[..width]).copied().collect();
    Plane { width, height, data }
}
