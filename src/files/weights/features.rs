//! Networks of features in files: .safetensors with whole numbers, and what kind each layer is in its metadata.

use super::file::hashed;
use super::safetensors;
use super::values::shown;
use crate::features::{FeatureNetwork, Layer, LayerKind};
use crate::files::contents;
use crate::files::error::{Context as _, Result, bail, ensure, error};
use ::safetensors::tensor::{Dtype, SafeTensors, TensorView};
use std::path::Path;

/// What the metadata `format` says.
const FORMAT: &str = "gpu-stereo features 1";

/// The four tensors of a layer: its name, and the type of its numbers.
const TENSORS: [(&str, Dtype); 4] =
    [("weight", Dtype::I8), ("bias", Dtype::I32), ("multiplier", Dtype::I32), ("shift", Dtype::I32)];

/// The tensor `part` of a layer.
fn name_of(layer: usize, part: &str) -> String {
    format!("layers.{layer}.{part}")
}

impl FeatureNetwork {
    /// From a file: .safetensors with the tensors `layers.0.weight`, `layers.0.bias`, `layers.0.multiplier`, `layers.0.shift`, and so on, and
    /// the metadata `format` and `layers`. docs/LEARNED.md describes it.
    ///
    /// # Errors
    /// If the file cannot be read, is none of a network of features, or one that might overflow.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = contents::read_file(path, "weights of a network of features")?;
        Self::parse(&bytes).with_context(|| format!("{path:?} cannot be read as a network of features"))
    }

    /// As [`FeatureNetwork::load`], from a file's bytes.
    ///
    /// # Errors
    /// As [`FeatureNetwork::load`].
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        ensure!(
            safetensors::is_one(bytes),
            "it is not .safetensors; give a file as training/quantise.py writes it, or none for the network of the library"
        );
        let file = safetensors::opened(bytes)?;
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|problem| error!("it is damaged ({problem})"))?;
        let metadata = metadata.metadata().clone().unwrap_or_default();
        let format = metadata.get("format").map_or("missing", String::as_str);
        ensure!(
            format == FORMAT,
            "its metadata format is {}, but must be {FORMAT:?}; give a file of a network of features",
            shown(format)
        );
        let kinds = kinds(metadata.get("layers").map_or("", String::as_str))?;
        let layers: Vec<Layer> =
            kinds.iter().enumerate().map(|(at, kind)| layer(&file, at, *kind)).collect::<Result<_>>()?;
        let wanted: Vec<String> = (0..layers.len()).flat_map(|at| TENSORS.map(|(part, _)| name_of(at, part))).collect();
        if let Some(name) = file.names().into_iter().find(|name| !wanted.iter().any(|wanted| wanted == name)) {
            bail!("it has the tensor {}, which no layer has; leave it out", shown(name));
        }
        Ok(Self::new(layers)?)
    }

    /// The contents of a file with this network.
    ///
    /// # Errors
    /// If the library of the format refuses them; none is known.
    pub fn encode(&self) -> Result<Vec<u8>> {
        let words = |words: &[i32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
        let mut tensors = Vec::new();
        for (at, layer) in self.layers().iter().enumerate() {
            let weights = layer.weights.iter().map(|&weight| weight as u8).collect();
            tensors.push((name_of(at, "weight"), Dtype::I8, shape(layer.kind, layer.inputs, layer.outputs), weights));
            for (part, numbers) in [("bias", &layer.bias), ("multiplier", &layer.multiplier), ("shift", &layer.shift)] {
                tensors.push((name_of(at, part), Dtype::I32, vec![layer.outputs], words(numbers)));
            }
        }
        let views = tensors
            .iter()
            .map(|(name, kind, shape, bytes)| Ok((name.as_str(), TensorView::new(*kind, shape.clone(), bytes)?)));
        let views = views.collect::<std::result::Result<Vec<_>, ::safetensors::SafeTensorError>>();
        let kind = |layer: &Layer| format!("{} {}", layer.kind, if layer.relu { "relu" } else { "linear" });
        let kinds: Vec<String> = self.layers().iter().map(kind).collect();
        let metadata = [("format", FORMAT.to_owned()), ("layers", kinds.join(","))];
        let metadata = metadata.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        let encoded = views.and_then(|views| ::safetensors::serialize(views, Some(metadata)));
        encoded.map_err(|problem| error!("the network cannot be written as .safetensors ({problem}); give another"))
    }

    /// A hash of all that it computes with: equal for equal networks, whatever file they were read from.
    pub fn fingerprint(&self) -> String {
        let numbers = self.layers().iter().flat_map(|layer| {
            let head = [layer.kind as i32, i32::from(layer.relu), layer.inputs as i32, layer.outputs as i32];
            let weights = layer.weights.iter().map(|&weight| i32::from(weight));
            let words = [&layer.bias, &layer.multiplier, &layer.shift].into_iter().flatten().copied();
            head.into_iter().chain(weights).chain(words).collect::<Vec<i32>>()
        });
        hashed("features", numbers.map(i32::to_le_bytes))
    }
}

/// The layers that the metadata lists.
fn kinds(text: &str) -> Result<Vec<(LayerKind, bool)>> {
    let kind = |word: &str| {
        let (name, activation) = word.trim().split_once(' ').unwrap_or((word.trim(), ""));
        let kind = LayerKind::ALL.into_iter().find(|kind| kind.name() == name);
        let relu = match activation {
            "relu" => Some(true),
            "linear" => Some(false),
            _ => None,
        };
        kind.zip(relu).with_context(|| {
            let names = LayerKind::ALL.map(LayerKind::name).join(", ");
            format!(
                "its metadata layers has {}, but must list one of {names} with relu or linear for each layer, separated by commas; write it so",
                shown(word)
            )
        })
    };
    let count = text.split(',').count();
    ensure!(
        count <= FeatureNetwork::MAX_LAYERS,
        "its metadata layers lists {count}, but must list at most {}; give a smaller network",
        FeatureNetwork::MAX_LAYERS
    );
    text.split(',').map(kind).collect()
}

/// The shape of a layer's weights.
fn shape(kind: LayerKind, inputs: usize, outputs: usize) -> Vec<usize> {
    match kind {
        LayerKind::Convolution => vec![outputs, inputs, 3, 3],
        LayerKind::Depthwise => vec![outputs, 1, 3, 3],
        LayerKind::Point => vec![outputs, inputs, 1, 1],
    }
}

/// A tensor of a type.
fn tensor<'a>(file: &SafeTensors<'a>, name: &str, kind: Dtype) -> Result<TensorView<'a>> {
    let tensor = file.tensor(name).ok().with_context(|| format!("the tensor {name} is missing; give a whole file"))?;
    ensure!(
        tensor.dtype() == kind,
        "the tensor {name} is of type {}, but must be {kind}; quantise it, as training/quantise.py does",
        tensor.dtype()
    );
    Ok(tensor)
}

fn layer(file: &SafeTensors<'_>, at: usize, (kind, relu): (LayerKind, bool)) -> Result<Layer> {
    let name = name_of(at, "weight");
    let weights = tensor(file, &name, Dtype::I8)?;
    let given = weights.shape();
    let outputs = given.first().copied().unwrap_or(0);
    let inputs = if kind == LayerKind::Depthwise { outputs } else { given.get(1).copied().unwrap_or(0) };
    let wanted = shape(kind, inputs, outputs);
    ensure!(
        given == wanted,
        "the tensor {name} has the shape {given:?}, but must be [outputs, inputs or 1, 3, 3], of a layer {kind} {wanted:?}; give weights of \
         the layers that the metadata lists"
    );
    let words = |part: &str| -> Result<Vec<i32>> {
        let name = name_of(at, part);
        let tensor = tensor(file, &name, Dtype::I32)?;
        ensure!(
            tensor.shape() == [outputs],
            "the tensor {name} has the shape {:?}, but must be [{outputs}], a number an output; give weights that fit each other",
            tensor.shape()
        );
        Ok(tensor.data().as_chunks().0.iter().map(|word| i32::from_le_bytes(*word)).collect())
    };
    let (bias, multiplier, shift) = (words("bias")?, words("multiplier")?, words("shift")?);
    let weights = weights.data().iter().map(|&byte| byte as i8).collect();
    Ok(Layer { kind, relu, inputs, outputs, weights, bias, multiplier, shift })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::damage::damaged;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_network_is_read_as_it_was_written() {
        let network = FeatureNetwork::built_in();
        let bytes = network.encode().unwrap();
        let read = FeatureNetwork::parse(&bytes).unwrap();
        assert_eq!((read == network, read.fingerprint()), (true, network.fingerprint()));
        let mut layers = network.layers().to_vec();
        layers[3].weights[7] ^= 1;
        assert_ne!(FeatureNetwork::new(layers).unwrap().fingerprint(), network.fingerprint());
    }

    /// A file with its header changed in one place, of the same length.
    fn changed(from: &str, to: &str) -> String {
        assert_eq!(from.len(), to.len());
        let mut bytes = FeatureNetwork::built_in().encode().unwrap();
        let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        FeatureNetwork::parse(&bytes).unwrap_err().to_string()
    }

    #[test]
    fn what_is_no_network_of_features_is_refused() {
        for (from, to, text) in [
            ("features 1", "features 2", "its metadata format is \"gpu-stereo features 2\", but must be"),
            (
                "convolution relu",
                "konvolution relu",
                "its metadata layers has \"konvolution relu\", but must list one of",
            ),
            ("convolution relu", "convolution zero", "has \"convolution zero\""),
            (
                "convolution relu",
                "depthwise   relu",
                "must list one of convolution, depthwise, point with relu or linear",
            ),
            ("convolution relu", "convolution,relu", "has \"convolution\""),
            ("layers.3.bias", "layers.3.bios", "the tensor layers.3.bias is missing"),
            ("[64,1,3,3]", "[64,3,1,3]", "the tensor layers."),
            ("point linear", "point relu  ", "layer 8 of the network of features is relu, but must be linear"),
        ] {
            let error = changed(from, to);
            assert!(error.contains(text) && error.contains("; ") && !error.contains('\n'), "{error}\nwanted: {text}");
        }
        let error = FeatureNetwork::parse(b"PK\x03\x04").unwrap_err().to_string();
        assert!(error.starts_with("it is not .safetensors; "), "{error}");
        let floats = super::super::encode(&Default::default()).unwrap();
        let error = FeatureNetwork::parse(&floats).unwrap_err().to_string();
        assert!(error.starts_with("its metadata format is \"missing\", but must be"), "{error}");
    }

    /// Files with bytes changed, left out and put in are read or refused.
    #[test]
    fn damaged_files_are_read_or_refused() {
        let mut random = ChaCha8Rng::seed_from_u64(21);
        let bytes = FeatureNetwork::built_in().encode().unwrap();
        for _ in 0..2000 {
            let damaged = damaged(&bytes, &mut random, b"{}[]:,\"0");
            if let Err(error) = FeatureNetwork::parse(&damaged) {
                let error = error.to_string();
                assert!(error.len() < 1000 && !error.contains('\n'), "{error}");
            }
        }
    }
}
