"""Writes the goldens of tests/library/network.rs with PyTorch: operations.json, and NETWORK.f32 of each architecture.

    python3 tests/library/network/golden.py     # needs torch and numpy

Weights and images come from the integers of docs/VECTORS.md, so that the test makes the same ones.
"""

import json
import pathlib

import numpy as np
import torch
import torch.nn.functional as F

from psmnet import PSMNet, disparities, shapes

HERE = pathlib.Path(__file__).parent
U32 = np.uint32


def mixed(x, y, c):
    """docs/VECTORS.md, of arrays of integers."""
    x, y, c = (np.asarray(v).astype(U32) for v in (x, y, c))
    h = x * U32(374761393) + y * U32(668265263) + c * U32(2246822519)
    h = (h ^ (h >> U32(15))) * U32(2654435761)
    h = (h ^ (h >> U32(13))) * U32(3266489917)
    return ((h ^ (h >> U32(16))) & U32(0xFFFF)).astype(np.int64)


def values(seed, shape):
    """Numbers from -1 to 1: value i of tensor `seed`."""
    numbers = (mixed(np.arange(np.prod(shape)), seed, 0) - 32768) / 32768
    return torch.from_numpy(numbers.astype(np.float32)).reshape(shape)


def operations():
    """Single operations: the inputs have the seeds 1, 2 .., the weights 8, the bias 9."""
    cases = []

    def case(kind, inputs, made, weights=None, **taken):
        numbers = [float(f"{value:.7g}") for value in made.double().flatten().tolist()]
        cases.append({"kind": kind, "inputs": inputs, "weights": weights, **taken,
                      "shape": list(made.shape[1:]), "made": numbers})

    for kernel, stride, dilation, sides in (
        (1, 1, 1, (5, 6)), (1, 2, 1, (5, 6)), (3, 1, 1, (5, 7)), (3, 2, 1, (6, 7)), (3, 2, 1, (5, 8)), (3, 1, 2, (6, 5)),
    ):
        shape, weights = [3, 1, *sides], [4, 3, kernel, kernel]
        made = F.conv2d(values(1, shape).transpose(0, 1), values(8, weights), values(9, [4]), stride=stride,
                        padding=kernel // 2 * dilation, dilation=dilation)
        case("conv2d", [shape], made[:, :, None], weights, stride=stride, dilation=dilation)
    for stride in (1, 2):
        shape, weights = [2, 4, 5, 6], [3, 2, 3, 3, 3]
        made = F.conv3d(values(1, shape)[None], values(8, weights), values(9, [3]), stride=stride, padding=1)
        case("conv3d", [shape], made, weights, stride=stride, dilation=1)
    shape, weights = [2, 2, 3, 4], [3, 2, 3, 3, 3]
    # PyTorch has the inputs of transposed convolutions first.
    made = F.conv_transpose3d(values(1, shape)[None], values(8, weights).transpose(0, 1), values(9, [3]), stride=2,
                              padding=1, output_padding=1)
    case("conv3d_transposed", [shape], made, weights)
    shape = [2, 1, 2, 5]
    left, right = values(1, shape)[:, 0], values(2, shape)[:, 0]
    planes = []
    for shift in range(4):
        plane = torch.zeros(4, 2, 5)
        plane[:2, :, shift:], plane[2:, :, shift:] = left[:, :, shift:], right[:, :, :5 - shift]
        planes.append(plane)
    case("feature_volume", [shape, shape], torch.stack(planes, 1)[None], planes=4)
    shape = [2, 1, 7, 9]
    case("average_pool", [shape], F.avg_pool2d(values(1, shape).transpose(0, 1), 3, 3)[:, :, None], side=3)
    for align in (True, False):
        for sides, to in (((3, 4), (8, 7)), ((1, 2), (4, 6))):
            shape = [2, 1, *sides]
            made = F.interpolate(values(1, shape).transpose(0, 1), to, mode="bilinear", align_corners=align)
            case("upsample", [shape], made[:, :, None], align_corners=align)
        shape = [1, 4, 2, 3]
        scores = F.interpolate(8 * values(1, shape)[None], [16, 8, 12], mode="trilinear", align_corners=align)[0, 0]
        made = (F.softmax(scores, 0) * torch.arange(16.).view(-1, 1, 1)).sum(0)
        case("disparity_regression", [shape], made[None, None, None], align_corners=align)
    return cases


def network(basic):
    """The weights of an architecture but for the statistics of the batch normalisations, which are calibrated later."""
    weights = {}
    for seed, (name, shape) in enumerate(sorted(shapes(basic).items())):
        numbers = (mixed(np.arange(np.prod(shape)), seed, 20 + basic) - 32768) / 32768
        if name.endswith(".weight") and len(shape) > 1:
            inputs = shape[0] if ".conv5." in name or ".conv6." in name else shape[1]
            numbers *= np.sqrt(6 / (inputs * np.prod(shape[2:])))
        elif name.endswith(".weight"):
            numbers = 1 + numbers / 4
        elif name.endswith(".bias"):
            numbers /= 4
        elif name.endswith(".running_var"):
            numbers = np.ones_like(numbers)
        weights[name] = torch.from_numpy(numbers.astype(np.float32)).reshape(shape)
    return weights


def pair():
    """256 x 256, blocks of noise; the right image shows the left one 3 px, and in the lower half 9 px, to the left."""
    y, x, c = np.ogrid[:256, :270, :3]
    left = (mixed(x // 3, y // 3, c) + mixed(x, y, c + 4)) >> 9
    right = np.where(np.arange(256)[:, None, None] < 128, left[:, 3:259], left[:, 9:265])
    return left[:, :256].astype(np.uint8), right.astype(np.uint8)


def whole(basic):
    """Factor of the last weights, means and variances of all batch normalisations in the order of their names, and every
    fourth disparity of every fourth row, computed in doubles."""
    weights = network(basic)
    left, right = pair()
    align = not basic
    disparities(PSMNet(weights, align, calibrate=True), left, right, 16)
    # Scores that differ little: the softmax then weighs many planes, and what f32 rounds stays small.
    scores = {}
    last = "classify.2" if basic else "classif3.2"
    run = PSMNet(weights, align, lambda name, side, made: scores.update({name: made}))
    disparities(run, left, right, 16)
    factor = np.float32(0.5 / scores[last].std().item())
    for name in weights:
        if name.startswith("classif") and name.endswith(".2.weight"):
            weights[name] = weights[name] * torch.tensor(factor)
    single = disparities(PSMNet(weights, align), left, right, 16)
    doubles = {name: value.double() for name, value in weights.items()}
    made = disparities(PSMNet(doubles, align), left, right, 16, torch.float64)
    off = (single - made).abs()
    print(f"{'basic' if basic else 'stackhourglass'}: {made.min():.3f} to {made.max():.3f}, deviation {made.std():.3f}; "
          f"in f32 at most {off.max():.1e} px away, {off.mean():.1e} on average")
    parts = [torch.tensor([factor])]
    for part in (".running_mean", ".running_var"):
        parts += [weights[name] for name in sorted(weights) if name.endswith(part)]
    parts.append(made[::4, ::4].flatten())
    return torch.cat([part.flatten().float() for part in parts]).numpy().astype("<f4")


if __name__ == "__main__":
    torch.manual_seed(0)
    lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in operations())
    (HERE / "operations.json").write_text(f"[\n{lines}\n]\n")
    for basic in (False, True):
        whole(basic).tofile(HERE / f"{'basic' if basic else 'stackhourglass'}.f32")
