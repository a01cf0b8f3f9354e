use crate::network::{Convolution, Kind, Padded};
use crate::reference::{
    Values, average_pool, conv3d_transposed, convolution, disparity_regression, feature_volume, upsample,
};
use crate::{Error, Network};

/// What operation `at` of [`Network::operations`] makes for a side of what its `inputs` made: of [`Kind::VolumeConv3d`] the
/// features of the left and of the right side, of [`Kind::Upsample`] what is interpolated, else one after the other. `add` is
/// what the operation adds to each value.
///
/// # Errors
/// [`Error::Misuse`] for [`Kind::Input`], which reads an image ([`super::network_input`]).
pub fn operation(
    network: &Network,
    at: usize,
    inputs: &[&Values],
    add: Option<&Values>,
    padded: &Padded,
    align_corners: bool,
) -> Result<Values, Error> {
    let operation = &network.operations()[at];
    let weights = || weights(network, &operation.name);
    let [channels, planes, rows, columns] = operation.shape(padded);
    let mut values = match operation.kind {
        Kind::Input => return Err(Error::Misuse("the input of a network reads an image; call network_input".into())),
        Kind::Conv2d { stride, dilation, .. } => convolution(inputs[0], weights()?, stride, dilation),
        Kind::AveragePool { side } => average_pool(inputs[0], side),
        Kind::Upsample => upsample(inputs[0], rows, columns, align_corners),
        Kind::Concat => {
            let shape = [channels, planes, rows, columns];
            Values { shape, data: inputs.iter().flat_map(|input| &input.data).copied().collect() }
        }
        Kind::VolumeConv3d => convolution(&feature_volume(inputs[0], inputs[1], planes), weights()?, 1, 1),
        Kind::Conv3d { stride } => convolution(inputs[0], weights()?, stride, 1),
        Kind::TransposedConv3d => conv3d_transposed(inputs[0], weights()?),
        Kind::Regression => disparity_regression(inputs[0], [padded.disparities, rows, columns], align_corners),
    };
    if let Some(add) = add {
        values.data.iter_mut().zip(&add.data).for_each(|(value, add)| *value += add);
    }
    if operation.relu {
        values.data.iter_mut().for_each(|value| *value = value.max(0.0));
    }
    Ok(values)
}

/// The weights of a convolution, which a network has for each.
fn weights<'a>(network: &'a Network, name: &str) -> Result<&'a Convolution, Error> {
    network.convolution(name).ok_or_else(|| Error::Network(format!("{name} has no weights; give a whole network")))
}
