"""Figures of networks by the smallest pixel cost alone: per cent of the visible pixels whose disparity is off by more than 3 px.

    python training/evaluate.py WEIGHTS.safetensors ... [--onnx mc_cnn_fast_dw.onnx] [--only teddy --only kitti] [--scenes DIR]

Beside them `census-sobel`, and with --onnx the network of that file in floats. Pairs are those of ../shared/data (or --data), and
with --scenes generated ones.
"""

import argparse
from pathlib import Path

import numpy as np

import pairs
from features import features, read
from winners import by_census_sobel, by_dots, wrong


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("weights", type=Path, nargs="*")
    options.add_argument("--onnx", type=Path)
    options.add_argument("--only", action="append")
    options.add_argument("--data", type=Path, default=pairs.COLLECTION)
    options.add_argument("--scenes", type=Path)
    options = options.parse_args()
    networks = [read(path) for path in options.weights]
    names = ["census-sobel", *(path.stem for path in options.weights)]
    if options.onnx:
        from quantise import float_features, folded

        layers = folded(options.onnx)
        names.append("floats")
    print("| pair |", " | ".join(names), "|", flush=True)
    print("|---" * (len(names) + 1) + "|")
    rows = []
    for pair in pairs.generated(options.scenes) if options.scenes else pairs.collection(options.only, options.data):
        row = [wrong(by_census_sobel(pair.left, pair.right, pair.disparities), pair)]
        for network in networks:
            row.append(wrong(by_dots(*(features(network, i) for i in (pair.left, pair.right)), pair.disparities), pair))
        if options.onnx:
            row.append(wrong(by_dots(*(float_features(layers, i) for i in (pair.left, pair.right)), pair.disparities), pair))
        rows.append(row)
        print(f"| {pair.name} |", " | ".join(f"{v:.2f}" for v in row), "|", flush=True)
    print("| mean |", " | ".join(f"{v:.2f}" for v in np.mean(rows, 0)), "|")


if __name__ == "__main__":
    main()
