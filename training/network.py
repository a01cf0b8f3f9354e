"""The network in PyTorch, computed as the integers will be: every rounding is done in the forward pass and ignored in the backward
pass (straight-through estimates), so that training sees what ships."""

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from features import LAST, UNIT, Layer, Network
from quantise import multiplier_and_shift

ARCHITECTURES = {
    # (kind, activation, outputs); the layers of CNES's network, 19,264 multiplications a pixel
    "depthwise": [("convolution", "relu", 64)] + [("depthwise", "linear", 64), ("point", "relu", 64)] * 3
    + [("depthwise", "linear", 64), ("point", "linear", 64)],
    # fewer channels, more layers
    "deep": [("convolution", "relu", 48)] + [("depthwise", "linear", 48), ("point", "relu", 48)] * 5
    + [("depthwise", "linear", 48), ("point", "linear", 64)],
}


class Round(torch.autograd.Function):
    """Whole numbers, floor(v + 1/2), with the gradient of what was rounded."""

    @staticmethod
    def forward(ctx, values):
        return (values + 0.5).floor_()

    @staticmethod
    def backward(ctx, gradient):
        return gradient


class QuantisedLayer(nn.Module):
    """A layer with weights in floats, and the scale of each output."""

    def __init__(self, kind, activation, inputs, outputs, last):
        super().__init__()
        self.kind, self.activation, self.last = kind, activation, last
        side = 1 if kind == "point" else 3
        self.weight = nn.Parameter(torch.empty(outputs, 1 if kind == "depthwise" else inputs, side, side))
        self.bias = nn.Parameter(torch.zeros(outputs))
        nn.init.kaiming_normal_(self.weight, nonlinearity="relu" if activation == "relu" else "linear")
        # Whole numbers of outputs are this many times the value in floats; set from the first images, then kept.
        self.register_buffer("scale", torch.full((outputs,), 1.0))

    def forward(self, values, scale_in, quantise=True):
        """From whole numbers (as floats) that are `scale_in` times their value, the same of the outputs."""
        if self.kind != "point":
            values = F.pad(values, (1, 1, 1, 1), mode="replicate")
        groups = len(self.weight) if self.kind == "depthwise" else 1
        scale_in = scale_in[:, None, None, None] if self.kind == "depthwise" else scale_in[None, :, None, None]
        weight = self.weight / scale_in
        # Per output: the largest weight becomes 127. With it and the scale of the outputs, one factor remains.
        size = weight.detach().abs().flatten(1).amax(1).clamp(min=1e-9)
        unit = torch.minimum(127 / size, 2**22 / self.bias.detach().abs().clamp(min=1e-9))
        factor = self.scale / unit
        if quantise:
            weight = Round.apply(weight * unit[:, None, None, None]) * factor[:, None, None, None]
            out = Round.apply(F.conv2d(values, weight, Round.apply(self.bias * unit) * factor, groups=groups))
        else:
            out = F.conv2d(values, weight * self.scale[:, None, None, None], self.bias * self.scale, groups=groups)
        limit = LAST if self.last else 127
        return F.hardtanh(out, 0.0 if self.activation == "relu" else float(-limit), float(limit))  # clamps, faster backwards

    @torch.no_grad()
    def calibrate(self, values, scale_in):
        """Sets the scale so that nearly all values of the outputs fit their range."""
        self.scale.fill_(1e-6)  # nothing is clamped
        sizes = self.forward(values, scale_in, quantise=False).abs().transpose(0, 1).flatten(1) / self.scale[:, None]
        k = max(1, int(sizes.shape[1] * (0.9999 if self.last else 0.999)))
        largest = sizes.kthvalue(k, 1).values
        if self.last:
            self.scale.fill_(LAST / largest.max())
        else:
            self.scale.copy_(127 / torch.maximum(largest, largest.max() / 64))

    @torch.no_grad()
    def whole(self, scale_in):
        """The layer in integers."""
        f64 = lambda t: t.detach().double().numpy()
        inputs = f64(scale_in)[:, None, None, None] if self.kind == "depthwise" else f64(scale_in)[None, :, None, None]
        weight, bias = f64(self.weight) / inputs, f64(self.bias)
        size = np.abs(weight).reshape(len(weight), -1).max(1)
        unit = np.minimum(127 / np.maximum(size, 1e-9), 2**22 / np.maximum(np.abs(bias), 1e-9))
        whole = np.rint(weight * unit[:, None, None, None]).astype(np.int64)
        offset = np.rint(bias * unit).astype(np.int64)
        largest = np.abs(offset) + 127 * np.abs(whole).reshape(len(whole), -1).sum(1)
        m, s = zip(*(multiplier_and_shift(r, int(t)) for r, t in zip(f64(self.scale) / unit, largest)))
        integers = [np.array(a, np.int32) for a in (offset, m, s)]
        return Layer(self.kind, self.activation, whole.astype(np.int8), *integers)


class FeatureNet(nn.Module):
    """The network: whole numbers of the input (32 a standard deviation) to unit vectors."""

    def __init__(self, architecture):
        super().__init__()
        layers, inputs = [], 1
        for i, (kind, activation, outputs) in enumerate(architecture):
            layers.append(QuantisedLayer(kind, activation, inputs, outputs, i + 1 == len(architecture)))
            inputs = outputs
        self.layers = nn.ModuleList(layers)

    def forward(self, values, quantise=True):
        """[batch][1][y][x] to [batch][F][y][x], vectors of length 1."""
        scale = torch.full((1,), 32.0)
        for layer in self.layers:
            values = layer(values, scale, quantise)
            scale = layer.scale
        vectors = F.normalize(values, dim=1, eps=1.0)
        if quantise:
            vectors = Round.apply(UNIT * vectors).clamp(-127, 127) / UNIT
        return vectors

    @torch.no_grad()
    def calibrate(self, values):
        """Sets the scales of all layers from a batch."""
        scale = torch.full((1,), 32.0)
        for layer in self.layers:
            layer.calibrate(values, scale)
            values, scale = layer(values, scale), layer.scale

    @torch.no_grad()
    def start_from(self, folded):
        """Takes the weights of layers (kind, activation, weight, bias) in floats."""
        for layer, (kind, _, weight, bias) in zip(self.layers, folded, strict=True):
            assert kind == layer.kind and weight.shape == tuple(layer.weight.shape), f"{kind} {weight.shape} does not fit"
            layer.weight.copy_(torch.from_numpy(weight))
            layer.bias.copy_(torch.from_numpy(bias))

    def whole(self):
        """The network in integers."""
        scale, layers = torch.full((1,), 32.0), []
        for layer in self.layers:
            layers.append(layer.whole(scale))
            scale = layer.scale
        return Network(layers)
