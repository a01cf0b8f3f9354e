"""Trains the network of the learned cost on generated scenes, with its quantisation in the loop.

    python training/train.py SCENES OUT                                     # from scratch
    python training/train.py SCENES OUT --start mccnn/.../mc_cnn_fast_dw.onnx   # from CNES's weights

SCENES is what the example render_scenes wrote. A step takes a band of rows of a few pairs: for some left pixels of each row, all
right pixels of the searched range compete (softmax over the products of features), and the loss is the cross-entropy with the two
that lie beside the truth. OUT/checkpoint.pt is written now and then and continued from; a step draws from random numbers of its own
number, so a run that was interrupted gives the weights of one that was not. At the end, OUT.safetensors and OUT.bin.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional as F

import pairs
import quantise
from features import write, write_compact
from network import ARCHITECTURES, FeatureNet

MARGIN = 5  # rows at the edges of a band whose features see its border


def arguments():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("scenes", type=Path, help="directory of generated pairs")
    options.add_argument("out", type=Path, help="where the weights and checkpoint.pt are written, without an ending")
    options.add_argument("--architecture", choices=ARCHITECTURES, default="depthwise")
    options.add_argument("--start", type=Path, help="weights to start from: CNES's ONNX file")
    options.add_argument("--steps", type=int, default=1200)
    options.add_argument("--rate", type=float, default=2e-3, help="the largest learning rate")
    options.add_argument("--rows", type=int, default=48, help="rows of a band")
    options.add_argument("--batch", type=int, default=2, help="bands a step")
    options.add_argument("--count", type=int, help="how many pairs of SCENES are read; all without it")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--threads", type=int, default=1)
    options.add_argument("--held-out", type=int, default=6, help="pairs at the end of SCENES that are not trained on")
    return options.parse_args()


def exposed(image, random):
    """The input of the network, as floats, of an image under another curve, with more noise."""
    values = image.astype(np.float32)
    if random is not None:
        if random.random() < 0.5:
            values = 255 * (values / 255) ** np.float32(random.uniform(0.75, 1.33))
        if random.random() < 0.5:
            values = values + random.normal(0, random.uniform(0, 4), values.shape).astype(np.float32)
        values = np.clip(np.rint(values), 0, 255)
    spread = max(values.std(), 1e-3)
    return np.clip(np.rint(32 * (values - values.mean()) / spread), -127, 127)


def band(scenes, random, rows):
    """A band of rows of a random pair: left, right [1][y][x], truth and where it is to be learnt [y][x], disparities."""
    pair = scenes[random.integers(len(scenes))]
    top = random.integers(0, len(pair.left) - rows + 1)
    cut = slice(top, top + rows)
    left, right = (exposed(image, random)[cut] for image in (pair.left, pair.right))
    truth, visible = pair.truth[cut], pair.visible[cut]
    if random.random() < 0.5:
        left, right, truth, visible = (a[::-1].copy() for a in (left, right, truth, visible))
    return left[None], right[None], truth, visible, pair.disparities


def losses(left, right, truth, visible, disparities, sharpness, random, every=3):
    """The loss of one band, from its features [F][y][x]: the mean over some of its visible pixels; and how often they are wrong."""
    inner = slice(MARGIN, left.shape[1] - MARGIN)
    columns = np.arange(random.integers(every), left.shape[2], every)
    truth, visible = torch.from_numpy(truth[inner][:, columns]), torch.from_numpy(visible[inner][:, columns])
    dots = left[:, inner][:, :, columns].permute(1, 2, 0) @ right[:, inner].permute(1, 0, 2)  # [y][left x][right x]
    shift = torch.from_numpy(columns)[:, None] - torch.arange(left.shape[2])[None]
    dots = dots.masked_fill((shift < 0) | (shift >= disparities), -2.0)
    position = torch.from_numpy(columns)[None] - truth.nan_to_num(0)
    visible = visible & (position >= 0)
    low = position.floor().clamp(0, left.shape[2] - 2)
    share = (position - low)[..., None].clamp(0, 1)
    low = low.long()[..., None]
    scaled = torch.log_softmax(sharpness * dots, 2)
    loss = -((1 - share) * scaled.gather(2, low) + share * scaled.gather(2, low + 1))[..., 0]
    wrong = (dots.argmax(2) - position).abs() > 3
    return loss[visible].clamp(max=8).mean(), wrong[visible].float().mean().item()


@torch.no_grad()
def held_out(net, scenes):
    """Per cent of the visible pixels of pairs that are wrong by more than 3 px, by the products alone."""
    from winners import by_dots, wrong

    rates = []
    for pair in scenes:
        sides = [net(torch.from_numpy(exposed(i, None))[None, None])[0].numpy() for i in (pair.left, pair.right)]
        rates.append(wrong(by_dots(*sides, pair.disparities), pair))
    return float(np.mean(rates))


def train(options, net, scenes, checked):
    """The steps from the last checkpoint to the end."""
    sharpness = torch.nn.Parameter(torch.tensor(2.7))  # its logarithm
    optimiser = torch.optim.Adam([*net.parameters(), sharpness], lr=options.rate)
    checkpoint = options.out.parent / (options.out.name + ".checkpoint.pt")
    first = 0
    if checkpoint.exists():
        state = torch.load(checkpoint)
        first = state["step"]
        net.load_state_dict(state["net"])
        optimiser.load_state_dict(state["optimiser"])
        sharpness.data = state["sharpness"]
    began, total, errors = time.time(), 0.0, 0.0
    for step in range(first, options.steps):
        random = np.random.default_rng([options.seed, step])
        bands = [band(scenes, random, options.rows) for _ in range(options.batch)]
        for group in optimiser.param_groups:
            warm = min(1.0, (step + 1) / 30)
            group["lr"] = float(options.rate * warm * (0.5 + 0.5 * np.cos(np.pi * step / options.steps)))
        images = torch.from_numpy(np.stack([b[side] for side in (0, 1) for b in bands]))
        images = images.contiguous(memory_format=torch.channels_last)
        if step % 50 == 0 and step <= options.steps * 2 // 3:
            net.calibrate(images)
        features = net(images)
        loss = 0
        for i, (_, _, truth, visible, disparities) in enumerate(bands):
            if visible[MARGIN:-MARGIN].mean() > 0.05:
                one, wrong = losses(features[i], features[i + options.batch], truth, visible, disparities, sharpness.exp(), random)
                loss, errors = loss + one / options.batch, errors + wrong / options.batch
        if not torch.is_tensor(loss):
            continue
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimiser.step()
        total += loss.item()
        if (step + 1) % 10 == 0:
            print(f"step {step + 1}: loss {total / 10:.3f}, wrong {10 * errors:.1f} %, {time.time() - began:.0f} s", flush=True)
            total, errors = 0.0, 0.0
        if (step + 1) % 50 == 0 or step + 1 == options.steps:
            state = {"step": step + 1, "net": net.state_dict(), "optimiser": optimiser.state_dict(), "sharpness": sharpness.data}
            torch.save(state, checkpoint)
        if (step + 1) % 150 == 0:
            print(f"step {step + 1}: held out {held_out(net, checked):.2f} %, sharpness {sharpness.exp().item():.1f}", flush=True)


def main():
    options = arguments()
    torch.manual_seed(options.seed)
    torch.set_num_threads(options.threads)
    scenes = list(pairs.generated(options.scenes, options.count))
    scenes, checked = scenes[: -options.held_out], scenes[-options.held_out :]
    net = FeatureNet(ARCHITECTURES[options.architecture])
    source = "trained by training/train.py of gpu-stereo on generated scenes"
    license = "MIT OR Apache-2.0"
    if options.start:
        images = [pair.left for pair in scenes[:8]]
        net.start_from(quantise.balanced(quantise.folded(options.start), images))
        source += ", from CNES MC-CNN 1.4.1, mc_cnn_fast_dw.onnx"
        license = quantise.LICENSE
    train(options, net.to(memory_format=torch.channels_last), scenes, checked)
    network = net.whole()
    network.metadata = {"source": source, "license": license}
    write(network, options.out.with_suffix(".safetensors"))
    write_compact(network, options.out.with_suffix(".bin"))


if __name__ == "__main__":
    main()
