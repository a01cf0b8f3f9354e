"""Compares features.py with tests/algorithms.py, which was written from docs/ALGORITHMS.md alone, for random images and the network of
the library, or for those of files:

    python training/check.py [WEIGHTS.safetensors ...]
"""

import sys
from pathlib import Path

import numpy as np

import features

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))
import algorithms  # noqa: E402


def built_in():
    """The network of the library."""
    layers = []
    for kind, relu, outputs in algorithms.library_network():
        inputs = 64 if kind == "point" else 1
        side = 1 if kind == "point" else 3
        weight = np.array([o[0] for o in outputs], np.int8).reshape(len(outputs), inputs, side, side)
        integers = [np.array([o[i] for o in outputs], np.int32) for i in (1, 2, 3)]
        layers.append(features.Layer(kind, "relu" if relu else "linear", weight, *integers))
    return features.Network(layers)


def chain(network, width, height):
    """A chain of tests/algorithms.py that has the images' size and the network, and nothing else."""
    made = object.__new__(algorithms.Chain)
    made.width, made.height = width, height
    outputs = lambda l: [(w.ravel().tolist(), *map(int, n)) for w, *n in zip(l.weight, l.bias, l.multiplier, l.shift)]
    layers = [{"kind": l.kind, "relu": l.activation == "relu", "outputs": outputs(l)} for l in network.layers]
    made.case = {"features": layers}
    return made


def main():
    random = np.random.default_rng(1)
    networks = {path: features.read(Path(path)) for path in sys.argv[1:]} or {"the library's network": built_in()}
    for name, network in networks.items():
        for bits, width, height in ((8, 13, 9), (16, 7, 12), (8, 1, 5)):
            image = random.integers(0, 1 << bits, (height, width))
            if width == 7:
                image[:] = 7  # nothing to see
            unit, rows = 1 if bits == 8 else 257, image.tolist()
            theirs = chain(network, width, height)
            found = theirs.feature_statistics(rows, unit)
            assert tuple(found) == features.statistics(image, bits), f"{name}: statistics {found}, {features.statistics(image, bits)}"
            bytes_of = np.array(theirs.features(rows, unit, found)).transpose(2, 0, 1) - 128
            ours = features.features(network, image, bits)
            assert (bytes_of == ours).all(), f"{name}: {(bytes_of != ours).sum()} features of {width} x {height} differ"
        print(f"{name}: equal")


if __name__ == "__main__":
    main()
