"""Makes the weights that the crate ships first from those of CNES's MC-CNN (fast, depthwise), Apache-2.0.

    pip download mccnn==1.4.1 --no-deps && unzip -d mccnn mccnn-1.4.1-*.whl
    python training/quantise.py mccnn/mc_cnn/weights/mc_cnn_fast_dw.onnx SCENES OUT

SCENES is a directory of generated pairs, whose left images tell how large the activations become. Writes OUT.safetensors and OUT.bin.
"""

import argparse
from pathlib import Path

import numpy as np

import pairs
from features import LAST, Layer, Network, normalised, write, write_compact

LICENSE = "Apache-2.0, Copyright (c) 2026 Centre National d'Etudes Spatiales (CNES)"


def folded(path):
    """The layers of the ONNX file as (kind, activation, weight, bias) in floats, its first two made one."""
    import onnx
    from onnx import numpy_helper

    tensors = {t.name: numpy_helper.to_array(t).astype(np.float64) for t in onnx.load(path).graph.initializer}
    get = lambda i: (tensors[f"conv_blocks.{i}.weight"], tensors[f"conv_blocks.{i}.bias"])
    (spread, offset), (mix, bias) = get(0), get(1)
    layers = [("convolution", "relu", mix * spread, bias + mix[:, 0, 0, 0] * offset)]
    for i in (3, 6, 9, 12):
        layers.append(("depthwise", "linear", *get(i)))
        layers.append(("point", "linear" if i == 12 else "relu", *get(i + 1)))
    return layers


def float_layer(kind, activation, weight, bias, values):
    """A layer in floats on [channel][y][x]."""
    from features import sums

    out = sums(Layer(kind, activation, weight, bias, None, None), values)
    return np.maximum(out, 0) if activation == "relu" else out


def float_features(layers, luma):
    """Unit vectors [channel][y][x] of the network in floats, for comparison."""
    values = luma.astype(np.float64)
    values = (values - values.mean())[None] / (values.std() or 1)
    for layer in layers:
        values = float_layer(*layer, values)
    return values / np.maximum(1e-9, np.sqrt((values**2).sum(0)))


def multiplier_and_shift(ratio, largest):
    """(m, s) with m / 2^s nearest to `ratio`, m <= 32767, s <= 30 and largest m + 2^(s-1) < 2^31."""
    for s in range(30, 0, -1):
        m = round(ratio * 2**s)
        if m <= 32767 and largest * m + 2 ** (s - 1) < 2**31:
            return max(1, m), s
    raise ValueError(f"no multiplier and shift for {ratio} of sums up to {largest}")


def quantised_layer(kind, activation, weight, bias, scale_in, scale_out):
    """A layer of integers: inputs are `scale_in` [in] times as large as in floats, outputs are to be `scale_out` [out] times."""
    inputs = scale_in[:, None, None, None] if kind == "depthwise" else scale_in[None, :, None, None]
    weight = weight / inputs
    unit = 127 / np.maximum(1e-12, np.abs(weight).reshape(len(weight), -1).max(1))
    unit = np.minimum(unit, 2**22 / np.maximum(1e-12, np.abs(bias)))  # biases beside which weights are nothing
    whole = np.rint(weight * unit[:, None, None, None]).astype(np.int64)
    offset = np.rint(bias * unit).astype(np.int64)
    largest = np.abs(offset) + 127 * np.abs(whole).reshape(len(whole), -1).sum(1)
    pairs_of = [multiplier_and_shift(r, int(t)) for r, t in zip(scale_out / unit, largest)]
    m, s = (np.array(v, np.int32) for v in zip(*pairs_of))
    return Layer(kind, activation, whole.astype(np.int8), offset.astype(np.int32), m, s)


def balanced(layers, images, share=0.999, span=4.0):
    """Layers that give the same features, and the span of each channel's values in `images` for `share` of the pixels.

    Each channel is divided so that its span is `span`, unless it is hardly used, and the next layer multiplied.
    """
    values = [normalised(image)[None].astype(np.float32) / 32 for image in images]
    result, factor = [], np.ones(1)
    for i, (kind, activation, weight, bias) in enumerate(layers):
        weight = weight * (factor[:, None, None, None] if kind == "depthwise" else factor[None, :, None, None])
        values = [float_layer(kind, activation, weight, bias, v) for v in values]
        sizes = np.concatenate([np.abs(v.reshape(len(v), -1)) for v in values], 1)
        largest = np.quantile(sizes, share, axis=1)
        if i + 1 == len(layers):
            largest[:] = np.quantile(sizes, 0.9999)
        factor = np.maximum(largest, largest.max() / 64) / span
        values = [v / factor[:, None, None].astype(np.float32) for v in values]
        result.append((kind, activation, weight / factor[:, None, None, None], bias / factor))
    return result


def quantised(layers, images, span=4.0):
    """The network in integers, from layers in floats; `images` tell what their values are."""
    scale, result = np.full(1, 32.0), []
    for layer in balanced(layers, images, span=span):
        outputs = len(layer[2])
        scale_out = np.full(outputs, (LAST if len(result) + 1 == len(layers) else 127) / span)
        result.append(quantised_layer(*layer, scale, scale_out))
        scale = scale_out
    return Network(result)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("onnx", type=Path)
    options.add_argument("scenes", type=Path)
    options.add_argument("out", type=Path)
    options = options.parse_args()
    images = [pair.left for pair in pairs.generated(options.scenes, 16)]
    network = quantised(folded(options.onnx), images)
    network.metadata = {
        "source": "CNES MC-CNN 1.4.1, mc_cnn_fast_dw.onnx, quantised by training/quantise.py of gpu-stereo",
        "license": LICENSE,
    }
    write(network, options.out.with_suffix(".safetensors"))
    write_compact(network, options.out.with_suffix(".bin"))


if __name__ == "__main__":
    main()
