//! A network with its weights, ready for inference.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::architecture::{Architecture, short};
use super::graph::{Kind, Operation, Parameters};
use super::tensor::{Tensor, Tensors};
use crate::Error;

/// What batch normalisation adds to the variance.
const EPSILON: f64 = 1e-5;

/// PSMNet with its weights: for [`crate::Params::network`]. A clone shares them.
#[derive(Clone)]
pub struct Network(Arc<Inner>, Arc<AtomicU64>);

#[derive(PartialEq)]
struct Inner {
    architecture: Architecture,
    operations: Vec<Operation>,
    convolutions: BTreeMap<String, Convolution>,
}

/// The weights of one operation, with batch normalisation folded into them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Convolution {
    /// `[output][input][row][column]` of an image, `[output][input][plane][row][column]` of a volume; also of a transposed
    /// convolution.
    pub weights: Tensor,
    /// What is added to each output channel.
    pub bias: Vec<f32>,
}

impl Convolution {
    /// Weights and as many biases as they have outputs.
    pub fn new(weights: Tensor, bias: Vec<f32>) -> Self {
        Self { weights, bias }
    }
}

impl PartialEq for Network {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parameters = self.parameters();
        let architecture = self.architecture();
        f.debug_struct("Network").field("architecture", &architecture).field("parameters", &parameters).finish()
    }
}

impl Network {
    /// From the tensors of a published file, by name. The architecture is recognised by the names. They may begin with
    /// `module.`, and counters (`num_batches_tracked`) are ignored.
    ///
    /// Batch normalisation is folded: with its scale g, shift b, mean m and variance v of an output channel, in doubles,
    /// s = g / sqrt(v + 1e-5); each weight becomes s w and the bias b - s m, both rounded to f32 once.
    ///
    /// # Errors
    /// [`Error::Network`] if the tensors are of no architecture, or one of them is missing, unknown or misshapen: it names
    /// the tensors, the shapes found and the shapes wanted.
    pub fn new(tensors: Tensors) -> Result<Self, Error> {
        let Some(architecture) = Architecture::of(tensors.keys().map(String::as_str)) else {
            let some: Vec<&str> = tensors.keys().take(3).map(String::as_str).collect();
            let some = if some.is_empty() { "none".to_owned() } else { some.join(", ") };
            return Err(Error::Network(format!(
                "the names of the {} tensors ({some} ..) are of no network that is known; give weights of PSMNet, \
                 stackhourglass (with dres2.conv1.0.0.weight) or basic (with classify.0.0.weight)",
                tensors.len()
            )));
        };
        architecture.check(&tensors)?;
        let tensors: BTreeMap<&str, &Tensor> = tensors.iter().map(|(name, tensor)| (short(name), tensor)).collect();
        let operations = architecture.operations();
        let mut convolutions = BTreeMap::new();
        for operation in &operations {
            if let Some(parameters) = &operation.parameters {
                convolutions.insert(operation.name.clone(), folded(operation.kind, parameters, &tensors)?);
            }
        }
        Ok(Self(Arc::new(Inner { architecture, operations, convolutions }), Arc::default()))
    }

    /// One of any operations.
    #[cfg(test)]
    pub(super) fn of(
        architecture: Architecture,
        operations: Vec<Operation>,
        convolutions: BTreeMap<String, Convolution>,
    ) -> Self {
        Self(Arc::new(Inner { architecture, operations, convolutions }), Arc::default())
    }

    /// Which of the two networks it is.
    pub fn architecture(&self) -> Architecture {
        self.0.architecture
    }

    /// The list of operations, in the order of computation; the last one makes the disparities.
    pub fn operations(&self) -> &[Operation] {
        &self.0.operations
    }

    /// The weights of the operation of this name, if it is a convolution.
    pub fn convolution(&self, name: &str) -> Option<&Convolution> {
        self.0.convolutions.get(name)
    }

    /// Multiplications with weights that were done so far with this network and its clones, for showing the progress of a
    /// pair, which takes [`crate::Params::multiplications`]. What computes adds those of an operation once it is done; they
    /// do not influence equality.
    pub fn done(&self) -> u64 {
        self.1.load(Ordering::Relaxed)
    }

    /// Adds the multiplications of an operation that was done: for whoever computes it.
    pub fn add_done(&self, multiplications: u64) {
        self.1.fetch_add(multiplications, Ordering::Relaxed);
    }

    /// The number of weights and biases that inference reads.
    pub fn parameters(&self) -> usize {
        self.0.convolutions.values().map(|convolution| convolution.weights.data().len() + convolution.bias.len()).sum()
    }
}

/// The tensor of a name that was checked before.
fn named<'a>(tensors: &BTreeMap<&str, &'a Tensor>, name: &str) -> Result<&'a Tensor, Error> {
    tensors.get(name).copied().ok_or_else(|| Error::Network(format!("{name} is missing; give a whole file")))
}

/// A convolution with the batch normalisation that follows it.
fn folded(kind: Kind, parameters: &Parameters, tensors: &BTreeMap<&str, &Tensor>) -> Result<Convolution, Error> {
    let weights = named(tensors, &format!("{}.weight", parameters.convolution))?;
    let mut shape = weights.shape().to_vec();
    let mut data = weights.data().to_vec();
    if kind == Kind::TransposedConv3d {
        (shape, data) = outputs_first(&shape, &data);
    }
    let outputs = shape[0];
    let mut bias = vec![0.0; outputs];
    if let Some(norm) = &parameters.norm {
        let part = |part: &str| named(tensors, &format!("{norm}.{part}")).map(Tensor::data);
        let (scale, shift, mean, variance) =
            (part("weight")?, part("bias")?, part("running_mean")?, part("running_var")?);
        let each = data.len() / outputs;
        for output in 0..outputs {
            let factor = f64::from(scale[output]) / (f64::from(variance[output]) + EPSILON).sqrt();
            for value in &mut data[output * each..(output + 1) * each] {
                *value = (f64::from(*value) * factor) as f32;
            }
            bias[output] = (f64::from(shift[output]) - factor * f64::from(mean[output])) as f32;
        }
    }
    Ok(Convolution::new(Tensor::new(shape, data)?, bias))
}

/// From `[input][output][tap]` to `[output][input][tap]`.
fn outputs_first(shape: &[usize], data: &[f32]) -> (Vec<usize>, Vec<f32>) {
    let [inputs, outputs] = [shape[0], shape[1]];
    let taps = shape[2..].iter().product::<usize>();
    let mut turned = Vec::with_capacity(data.len());
    for output in 0..outputs {
        for input in 0..inputs {
            turned.extend_from_slice(&data[(input * outputs + output) * taps..][..taps]);
        }
    }
    let shape = [&[outputs, inputs], &shape[2..]].concat();
    (shape, turned)
}
