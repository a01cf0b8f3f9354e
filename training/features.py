"""The learned cost in exact integers, as docs/ALGORITHMS.md defines it: statistics, input, layers, features, pixel costs; and the
files that networks are kept in.

Everything is computed by numpy. Matrices are multiplied as float32: all partial sums are integers below 2^24, which float32 holds
exactly in any order, and `check` refuses a network of which that is not true.
"""

import json
import struct
from dataclasses import dataclass, field
from math import isqrt

import numpy as np

KINDS = ("convolution", "depthwise", "point")
ACTIVATIONS = ("relu", "linear")
FORMAT = "gpu-stereo features 1"
UNIT = 170  # the length of a feature vector
LAST = 2047  # the values of the last layer: -LAST..LAST
COST = 225  # the largest pixel cost of `learned`


@dataclass
class Layer:
    """One layer: `weight` [out][in][3][3], [channel][1][3][3] or [out][in][1][1], `bias`, `multiplier` and `shift` [out]."""

    kind: str
    activation: str
    weight: np.ndarray
    bias: np.ndarray
    multiplier: np.ndarray
    shift: np.ndarray

    def inputs(self):
        """How many channels the layer reads."""
        return len(self.weight) if self.kind == "depthwise" else self.weight.shape[1]

    def work(self):
        """Multiplications a pixel."""
        return self.weight.size


@dataclass
class Network:
    """A list of layers, and what is known of them."""

    layers: list
    metadata: dict = field(default_factory=dict)

    def work(self):
        """Multiplications a pixel and side."""
        return sum(layer.work() for layer in self.layers)

    def named(self):
        """The layers as the file names them: "convolution relu,depthwise linear,..."."""
        return ",".join(f"{layer.kind} {layer.activation}" for layer in self.layers)


def check(network):
    """Raises ValueError, with what is allowed, where a layer has a wrong shape or its sums could overflow."""
    if not 1 <= len(network.layers) <= 16:
        raise ValueError(f"{len(network.layers)} layers: 1 to 16 are possible")
    channels = 1
    for i, layer in enumerate(network.layers):
        if layer.kind not in KINDS or layer.activation not in ACTIVATIONS:
            raise ValueError(f"layer {i}: {layer.kind} {layer.activation}: {KINDS} with one of {ACTIVATIONS} are possible")
        side = 1 if layer.kind == "point" else 3
        outputs = len(layer.weight)
        if layer.weight.shape != (outputs, 1 if layer.kind == "depthwise" else channels, side, side):
            raise ValueError(f"layer {i}: weights of {layer.weight.shape} after {channels} channels")
        if layer.kind == "depthwise" and outputs != channels or outputs % 4 or not 4 <= outputs <= 128:
            raise ValueError(f"layer {i}: {outputs} channels: multiples of 4 up to 128, those before for a depthwise one, are possible")
        w, b = np.abs(layer.weight.astype(np.int64)).reshape(outputs, -1), np.abs(layer.bias.astype(np.int64))
        m, s = layer.multiplier.astype(np.int64), layer.shift.astype(np.int64)
        largest = b + 127 * w.sum(1)
        if w.max() > 127 or largest.max() >= 1 << 24:
            raise ValueError(f"layer {i}: weights up to {w.max()} and sums up to {largest.max()}: 127 and {(1 << 24) - 1} are possible")
        if m.min() < 1 or m.max() > 32767 or s.min() < 1 or s.max() > 30:
            raise ValueError(f"layer {i}: multipliers {m.min()}..{m.max()} and shifts {s.min()}..{s.max()}: 1..32767 and 1..30 are possible")
        if (largest * m + (1 << (s - 1))).max() >= 1 << 31:
            raise ValueError(f"layer {i}: products up to {(largest * m).max()}: less than {1 << 31} are possible")
        channels = outputs
    if network.layers[0].kind != "convolution" or network.layers[-1].activation != "linear" or channels < 8:
        raise ValueError("the first layer must be a convolution, the last one linear with 8 to 128 channels")


def deep(luma, bits=8):
    """The samples of an image in 256ths of a level."""
    return luma.astype(np.int64) * (256 if bits == 8 else 1)


def statistics(luma, bits=8):
    """Stage `feature_statistics`: the mean of an image in 256ths of a level and its deviation in units of four of them."""
    values = deep(luma, bits).ravel()
    count = np.bincount(values >> 6, minlength=1024)
    shift = 0
    while values.size >> shift > 8192:
        shift += 1
    some, k = (count + (1 << shift) // 2) >> shift, np.arange(1024)
    number, total = int(some.sum()), int((some * k).sum())
    centre, level = total // number, 64 * total // number
    spread, rest = int((some * (k - centre) ** 2).sum()), level - 64 * centre
    return level + (0 if bits == 8 else 32), max(1, isqrt(256 * spread // number - (rest * rest >> 4)))


def normalised(luma, bits=8):
    """The input of the first layer: 32 units are a standard deviation, at most 127 in size."""
    mean, deviation = statistics(luma, bits)
    excess = deep(luma, bits) - mean
    size = np.minimum(127, (16 * np.abs(excess) + deviation) // (2 * deviation))
    return (np.sign(excess) * size).astype(np.int16)


def sums(layer, values):
    """The sums of a layer before they are scaled: float32 [out][y][x] of whole numbers, from int16 [channel][y][x]."""
    channels, height, width = values.shape
    weight = layer.weight.astype(np.float32)
    out = np.empty((len(weight), height, width), np.float32)
    out[:] = layer.bias.astype(np.float32)[:, None, None]
    if layer.kind == "point":
        out += (weight[:, :, 0, 0] @ values.reshape(channels, -1).astype(np.float32)).reshape(out.shape)
        return out
    padded = np.pad(values, ((0, 0), (1, 1), (1, 1)), mode="edge").astype(np.float32)
    for dy in range(3):
        for dx in range(3):
            near = padded[:, dy : dy + height, dx : dx + width]
            if layer.kind == "depthwise":
                for o in range(len(out)):
                    out[o] += weight[o, 0, dy, dx] * near[o]
            else:
                out += np.tensordot(weight[:, :, dy, dx], near, 1)
    return out


def apply(layer, values, last):
    """A layer on int16 [channel][y][x]."""
    out = np.empty((len(layer.weight), *values.shape[1:]), np.int16)
    acc = sums(layer, values)
    low, high = (0 if layer.activation == "relu" else -127, 127) if not last else (-LAST, LAST)
    for o, (m, s) in enumerate(zip(layer.multiplier, layer.shift)):
        scaled = acc[o].astype(np.int32)  # `check` has seen that the products fit 32 bits
        scaled *= m
        scaled += np.int32(1 << (int(s) - 1))
        scaled >>= s
        out[o] = np.clip(scaled, low, high)
    return out


def raw(network, luma, bits=8):
    """The values of the last layer, int16 [channel][y][x]."""
    values = normalised(luma, bits)[None]
    for layer in network.layers:
        values = apply(layer, values, layer is network.layers[-1])
    return values


def unit_vectors(values):
    """The features of the values of the last layer: int8 [channel][y][x] of length 170."""
    squares = (values.astype(np.int64) ** 2).sum(0)
    root = np.sqrt(squares.astype(np.float64)).astype(np.int64)
    root += root * root < squares
    root -= (root - 1) * (root - 1) >= squares
    r = np.maximum(root, 1)  # the smallest number whose square is at least the sum
    size = np.minimum(127, (2 * UNIT * np.abs(values.astype(np.int64)) + r) // (2 * r))
    return (np.sign(values) * size).astype(np.int8)


def features(network, luma, bits=8):
    """int8 [channel][y][x] of an image."""
    return unit_vectors(raw(network, luma, bits))


def pixel_costs(dots):
    """The cost of products of features, 0 to 225."""
    return np.minimum(COST, np.clip(UNIT * UNIT - dots, 0, UNIT * UNIT) >> 7)


def write(network, path):
    """A network as a safetensors file."""
    check(network)
    tensors = {}
    for i, layer in enumerate(network.layers):
        tensors[f"layers.{i}.weight"] = ("I8", layer.weight.astype("<i1"))
        for name in ("bias", "multiplier", "shift"):
            tensors[f"layers.{i}.{name}"] = ("I32", getattr(layer, name).astype("<i4"))
    header, data = {"__metadata__": network.metadata | {"format": FORMAT, "layers": network.named()}}, b""
    for name, (kind, values) in sorted(tensors.items(), key=lambda t: t[1][0] != "I32"):
        header[name] = {"dtype": kind, "shape": list(values.shape), "data_offsets": [len(data), len(data) + values.nbytes]}
        data += values.tobytes()
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    path.write_bytes(struct.pack("<Q", len(text)) + text + data)


def read(path):
    """The network of a safetensors file."""
    content = path.read_bytes()
    size = struct.unpack("<Q", content[:8])[0]
    header, data = json.loads(content[8 : 8 + size]), content[8 + size :]
    metadata = header.pop("__metadata__")

    def tensor(name):
        entry = header[name]
        start, end = entry["data_offsets"]
        return np.frombuffer(data[start:end], "<i1" if entry["dtype"] == "I8" else "<i4").reshape(entry["shape"])

    layers = []
    for i, name in enumerate(metadata["layers"].split(",")):
        kind, activation = name.split()
        layers.append(Layer(kind, activation, *(tensor(f"layers.{i}.{t}") for t in ("weight", "bias", "multiplier", "shift"))))
    network = Network(layers, {k: v for k, v in metadata.items() if k not in ("format", "layers")})
    check(network)
    return network


def write_compact(network, path):
    """The file that is part of the crate: of each layer its weights, biases, multipliers and shifts."""
    check(network)
    parts = []
    for layer in network.layers:
        parts += [layer.weight.astype("<i1")] + [a.astype("<i4") for a in (layer.bias, layer.multiplier, layer.shift)]
    path.write_bytes(b"".join(p.tobytes() for p in parts))
