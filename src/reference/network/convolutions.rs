use crate::network::Convolution;
use crate::reference::Values;
use rayon::prelude::*;
use std::ops::Range;

/// Stages `conv2d` and `conv3d`: to each output channel's bias is added, for each input channel and each tap of the weights
/// `[output][input]..[row][column]`, the weight times the input value that lies at output x `stride` + (tap - middle tap) x
/// `dilation` along each axis, or 0 where that is outside. An image is a volume of one plane, and its weights have no axis
/// of planes.
pub fn convolution(input: &Values, weights: &Convolution, stride: usize, dilation: usize) -> Values {
    let [inputs, planes, rows, columns] = input.shape;
    let shape = weights.weights.shape();
    let (outputs, side) = (shape[0], shape[3]);
    let deep = if shape.len() == 5 { side } else { 1 };
    let [out_planes, out_rows, out_columns] = [planes, rows, columns].map(|side| side.div_ceil(stride));
    let mut output = Values::new([outputs, out_planes, out_rows, out_columns]);
    let [across, along] = [side, deep].map(|taps| Axis { taps, stride, dilation });
    output.data.par_chunks_mut(out_rows * out_columns).enumerate().for_each(|(plane, values)| {
        let (channel, plane) = (plane / out_planes, plane % out_planes);
        values.fill(weights.bias[channel].into());
        for (y, to) in values.chunks_exact_mut(out_columns).enumerate() {
            for (from, i, j) in taps(inputs, deep, side) {
                let taps = &weights.weights.data()[((channel * inputs + from) * deep + i) * side * side + j * side..];
                let plane = along.read(plane, i).filter(|&plane| plane < planes);
                let row = across.read(y, j).filter(|&row| row < rows);
                let (Some(plane), Some(row)) = (plane, row) else { continue };
                let row = input.row(from, plane, row);
                for (tap, &weight) in taps[..side].iter().enumerate() {
                    across.add_products(to, row, weight.into(), tap);
                }
            }
        }
    });
    output
}

/// All input channels, and of each the planes and rows of the taps.
fn taps(inputs: usize, deep: usize, side: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..inputs).flat_map(move |from| (0..deep).flat_map(move |i| (0..side).map(move |j| (from, i, j))))
}

/// The taps along an axis.
#[derive(Clone, Copy)]
struct Axis {
    taps: usize,
    stride: usize,
    dilation: usize,
}

impl Axis {
    /// Where a tap reads for an output, if not before the first value.
    fn read(self, output: usize, tap: usize) -> Option<usize> {
        (output * self.stride + tap * self.dilation).checked_sub(self.taps / 2 * self.dilation)
    }

    /// The first of `outputs` whose tap reads one of `inputs` values, and the one after the last.
    fn inside(self, outputs: usize, inputs: usize, tap: usize) -> Range<usize> {
        let (before, ahead) = (self.taps / 2 * self.dilation, tap * self.dilation);
        let end = (inputs + before).saturating_sub(ahead).div_ceil(self.stride).min(outputs);
        before.saturating_sub(ahead).div_ceil(self.stride).min(end)..end
    }

    /// A weight times what its tap reads, added to a row of outputs.
    fn add_products(self, to: &mut [f64], from: &[f64], weight: f64, tap: usize) {
        let outputs = self.inside(to.len(), from.len(), tap);
        let Some(first) = self.read(outputs.start, tap).filter(|_| !outputs.is_empty()) else { return };
        let (to, from) = (&mut to[outputs], &from[first..]);
        if self.stride == 1 {
            to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
        } else {
            to.iter_mut().zip(from.iter().step_by(self.stride)).for_each(|(to, from)| *to += weight * from);
        }
    }
}

/// The volume of the features of both sides that `dres0.0` reads: plane i has the channels of `left`, then those of `right`
/// from i columns to the left; where that is outside, all channels are 0.
pub fn feature_volume(left: &Values, right: &Values, planes: usize) -> Values {
    let [channels, _, rows, columns] = left.shape;
    let mut volume = Values::new([2 * channels, planes, rows, columns]);
    let row_of = |i: usize| (i / rows / planes, i / rows % planes, i % rows);
    volume.data.par_chunks_mut(columns).enumerate().for_each(|(i, to)| {
        let (channel, plane, row) = row_of(i);
        let shift = plane.min(columns);
        match channel.checked_sub(channels) {
            None => to[shift..].copy_from_slice(&left.row(channel, 0, row)[shift..]),
            Some(channel) => to[shift..].copy_from_slice(&right.row(channel, 0, row)[..columns - shift]),
        }
    });
    volume
}

/// Stage `conv3d_transposed`: each value of the input, times tap k of 0, 1, 2 along each axis, is added to the output at
/// 2 x its place + k - 1 along each axis, if that is inside. The output has twice the sides.
pub fn conv3d_transposed(input: &Values, weights: &Convolution) -> Values {
    let [inputs, planes, rows, columns] = input.shape;
    let outputs = weights.bias.len();
    let mut output = Values::new([outputs, 2 * planes, 2 * rows, 2 * columns]);
    output.data.par_chunks_mut(4 * rows * columns).enumerate().for_each(|(plane, values)| {
        let (channel, plane) = (plane / (2 * planes), plane % (2 * planes));
        values.fill(weights.bias[channel].into());
        for (y, to) in values.chunks_exact_mut(2 * columns).enumerate() {
            for (from, i, j) in taps(inputs, 3, 3) {
                let taps = &weights.weights.data()[((channel * inputs + from) * 9 + i * 3 + j) * 3..][..3];
                let (Some(plane), Some(row)) = (source(plane, i, planes), source(y, j, rows)) else { continue };
                for (x, value) in input.row(from, plane, row).iter().enumerate() {
                    for (tap, &weight) in taps.iter().enumerate() {
                        if let Some(to) = (2 * x + tap).checked_sub(1).and_then(|at| to.get_mut(at)) {
                            *to += f64::from(weight) * value;
                        }
                    }
                }
            }
        }
    });
    output
}

/// Which of `inputs` values a tap of the transposed convolution adds to this output, if any.
fn source(output: usize, tap: usize, inputs: usize) -> Option<usize> {
    let twice = (output + 1).checked_sub(tap)?;
    (twice % 2 == 0 && twice / 2 < inputs).then_some(twice / 2)
}
