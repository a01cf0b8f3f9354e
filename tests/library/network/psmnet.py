"""PSMNet in PyTorch, both architectures, as docs/NETWORKS.md describes them: for the goldens of this folder and for
benches/psmnet. Weights are a dictionary of tensors by their published names, without `module.`."""

import torch
import torch.nn.functional as F

MEAN = torch.tensor([0.485, 0.456, 0.406]).view(3, 1, 1)
DEVIATION = torch.tensor([0.229, 0.224, 0.225]).view(3, 1, 1)


class PSMNet:
    """`align_corners` as in F.interpolate. `receive` is called with the name of an operation, the side and what it made.
    With `calibrate`, each batch normalisation first takes the mean and the variance of what it reads as its own."""

    def __init__(self, weights, align_corners=True, receive=None, calibrate=False):
        self.weights, self.align_corners, self.calibrate = weights, align_corners, calibrate
        self.receive = receive or (lambda name, side, made: None)
        self.side = 0

    def made(self, name, value):
        self.receive(name, self.side, value)
        return value

    def norm(self, name, value):
        axes = [0, *range(2, value.dim())]
        mean, var = f"{name}.running_mean", f"{name}.running_var"
        if self.calibrate and self.side == 0:
            self.weights[mean], self.weights[var] = value.mean(axes), value.var(axes, unbiased=False)
        return F.batch_norm(value, *(self.weights[f"{name}.{part}"] for part in
                                     ("running_mean", "running_var", "weight", "bias")), eps=1e-5)

    def conv(self, name, value, relu=True, add=None, stride=1, dilation=1, of="", norm=True, transposed=False):
        """`of` is the place of the convolution's module in that of its name."""
        if not norm:
            of, module = "", name
        else:
            module = f"{name}{of}.0"
        weight = self.weights[f"{module}.weight"]
        volume = weight.dim() == 5
        if transposed:
            value = F.conv_transpose3d(value, weight, stride=2, padding=1, output_padding=1)
        else:
            convolution = F.conv3d if volume else F.conv2d
            padding = weight.shape[-1] // 2 * dilation
            value = convolution(value, weight, stride=stride, padding=padding, dilation=dilation)
        if norm:
            value = self.norm(f"{name}{of}.1", value)
        if add is not None:
            value = value + add
        return self.made(name, F.relu(value) if relu else value)

    def features(self, image, side):
        self.side = side
        at = self.made("feature_extraction.input", image)
        name = "feature_extraction.{}".format
        for i, stride in ((0, 2), (2, 1), (4, 1)):
            at = self.conv(name(f"firstconv.{i}"), at, stride=stride)
        for layer, blocks, channels, stride, dilation in (
            (1, 3, 32, 1, 1), (2, 16, 64, 2, 1), (3, 3, 128, 1, 1), (4, 3, 128, 1, 2),
        ):
            for block in range(blocks):
                block_stride = stride if block == 0 else 1
                part = name(f"layer{layer}.{block}") + ".{}"
                inner = self.conv(part.format("conv1"), at, stride=block_stride, dilation=dilation, of=".0")
                if block_stride > 1 or at.shape[1] != channels:
                    at = self.conv(part.format("downsample"), at, relu=False, stride=block_stride)
                at = self.conv(part.format("conv2"), inner, relu=False, add=at, dilation=dilation)
            if layer == 2:
                second = at
        parts = [second, at]
        for branch, side in ((4, 8), (3, 16), (2, 32), (1, 64)):
            pooled = self.made(name(f"branch{branch}.0"), F.avg_pool2d(at, side, side))
            narrow = self.conv(name(f"branch{branch}.1"), pooled)
            wide = F.interpolate(narrow, at.shape[2:], mode="bilinear", align_corners=self.align_corners)
            parts.append(self.made(name(f"branch{branch}"), wide))
        joined = self.made(name("concat"), torch.cat(parts, 1))
        return self.conv(name("lastconv.2"), self.conv(name("lastconv.0"), joined), relu=False, norm=False)

    def residual(self, name, volume):
        return self.conv(f"{name}.2", self.conv(f"{name}.0", volume), relu=False, add=volume)

    def hourglass(self, name, volume, cost, down=None, up=None):
        first = self.conv(f"{name}.conv1", volume, stride=2, of=".0")
        second = self.conv(f"{name}.conv2", first, add=up)
        third = self.conv(f"{name}.conv3", second, stride=2, of=".0")
        fourth = self.conv(f"{name}.conv4", third, of=".0")
        fifth = self.conv(f"{name}.conv5", fourth, add=second if down is None else down, transposed=True)
        return self.conv(f"{name}.conv6", fifth, relu=False, add=cost, transposed=True), second, fifth

    def classify(self, name, volume, add=None):
        return self.conv(f"{name}.2", self.conv(f"{name}.0", volume), relu=False, add=add, norm=False)

    @torch.no_grad()
    def __call__(self, left, right, disparities):
        """Of padded, normalised images [1, 3, H, W] the disparities [H, W] in pixels."""
        left, right = self.features(left, 0), self.features(right, 1)
        self.side = 0
        planes = []
        for shift in range(disparities // 4):
            plane = torch.cat([left, torch.roll(right, shift, 3)], 1)
            plane[..., :shift] = 0
            planes.append(plane)
        cost = self.conv("dres0.2", self.conv("dres0.0", torch.stack(planes, 2)))
        cost = self.residual("dres1", cost)
        if "classify.0.0.weight" in self.weights:
            for name in ("dres2", "dres3", "dres4"):
                cost = self.residual(name, cost)
            scores = self.classify("classify", cost)
        else:
            out1, down, up = self.hourglass("dres2", cost, cost)
            out2, _, up = self.hourglass("dres3", out1, cost, down, up)
            out3, _, _ = self.hourglass("dres4", out2, cost, down, up)
            scores = self.classify("classif1", out1)
            scores = self.classify("classif2", out2, scores)
            scores = self.classify("classif3", out3, scores)
        size = [4 * side for side in scores.shape[2:]]
        scores = F.interpolate(scores, size, mode="trilinear", align_corners=self.align_corners)
        share = F.softmax(scores[0, 0], 0)
        numbers = torch.arange(len(share), dtype=share.dtype).view(-1, 1, 1)
        return self.made("disparity_regression", (share * numbers).sum(0))


def network_input(image, dtype=torch.float32):
    """[1, 3, H, W], normalised and padded, of an array [H, W, 3] of bytes; and the rows that were added above."""
    values = torch.tensor(image).permute(2, 0, 1).to(dtype) / 255
    values = (values - MEAN.to(dtype)) / DEVIATION.to(dtype)
    height, width = values.shape[1:]
    padded_height, padded_width = (max(256, -(-side // 16) * 16) for side in (height, width))
    return F.pad(values, (0, padded_width - width, padded_height - height, 0))[None], padded_height - height


def disparities(network, left, right, count, dtype=torch.float32):
    """The disparities [H, W] of the left of two images [H, W, 3] of bytes."""
    width = left.shape[1]
    (left, above), (right, _) = (network_input(image, dtype) for image in (left, right))
    return network(left, right, count)[above:, :width]


def shapes(basic):
    """The names and shapes of all tensors, without the counters of batches."""
    found = {}

    def conv(module, outputs, inputs, *taps, norm=True, transposed=False):
        at = module if not norm else f"{module}.0"
        found[f"{at}.weight"] = [inputs, outputs, *taps] if transposed else [outputs, inputs, *taps]
        if norm:
            for part in ("weight", "bias", "running_mean", "running_var"):
                found[f"{module}.1.{part}"] = [outputs]

    name = "feature_extraction.{}".format
    for i, inputs in ((0, 3), (2, 32), (4, 32)):
        conv(name(f"firstconv.{i}"), 32, inputs, 3, 3)
    at = 32
    for layer, blocks, channels in ((1, 3, 32), (2, 16, 64), (3, 3, 128), (4, 3, 128)):
        for block in range(blocks):
            conv(name(f"layer{layer}.{block}.conv1.0"), channels, at, 3, 3)
            conv(name(f"layer{layer}.{block}.conv2"), channels, channels, 3, 3)
            if at != channels:
                conv(name(f"layer{layer}.{block}.downsample"), channels, at, 1, 1)
            at = channels
    for branch in range(1, 5):
        conv(name(f"branch{branch}.1"), 32, 128, 1, 1)
    conv(name("lastconv.0"), 128, 320, 3, 3)
    conv(name("lastconv.2"), 32, 128, 1, 1, norm=False)
    cube = (3, 3, 3)
    conv("dres0.0", 32, 64, *cube)
    for module in ["dres0.2", "dres1.0", "dres1.2"] + [f"dres{i}.{j}" for i in (2, 3, 4) for j in (0, 2) if basic]:
        conv(module, 32, 32, *cube)
    for hourglass in () if basic else ("dres2", "dres3", "dres4"):
        conv(f"{hourglass}.conv1.0", 64, 32, *cube)
        conv(f"{hourglass}.conv2", 64, 64, *cube)
        conv(f"{hourglass}.conv3.0", 64, 64, *cube)
        conv(f"{hourglass}.conv4.0", 64, 64, *cube)
        conv(f"{hourglass}.conv5", 64, 64, *cube, transposed=True)
        conv(f"{hourglass}.conv6", 32, 64, *cube, transposed=True)
    for classify in ["classify"] if basic else ["classif1", "classif2", "classif3"]:
        conv(f"{classify}.0", 32, 32, *cube)
        conv(f"{classify}.2", 1, 32, *cube, norm=False)
    return found
