#!/usr/bin/env python3
"""Energies of the methods beside that of alpha-expansion, on the same Markov random field in integers.

    python3 benches/energy.py [--binary PROGRAM] [--field PROGRAM] [--only SCENE] [--prior WEIGHT,TRUNCATION]

- Field: that of --method bp with the command's usual settings, without edges; examples/random_field writes the data terms
  and the labels of each method. The energy of the labels is added up here once more and must be what `--json` of the command
  tells (on an adapter, where there is one); `bm 9x9` has data terms of its own, so its labels are also judged on the common field.
- Alpha-expansion: Boykov, Veksler and Zabih, "Fast Approximate Energy Minimization via Graph Cuts", IEEE TPAMI 23(11), 2001,
  by PyMaxflow's fastmin.aexpansion_grid, from the smallest data terms on, until no expansion helps.
- Scenes: Tsukuba, Venus, Teddy and Cones of ../shared/data, where it lies there, and data/corridor; as many disparities as the
  multiple of 16 that holds the largest true one.

It fails if a figure of the command differs, if belief propagation exceeds alpha-expansion by more than 2 %, or if it does not
stay below the other methods. Builds the two programs unless they are named, and makes a virtual environment in target/energy
with PyMaxflow and numpy; without them it prints NOT TESTED.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import venv

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "target" / "energy"
# Pinned: a figure of an unknown version says nothing.
PACKAGES = ["PyMaxflow==1.3.2", "numpy==2.4.6"]
SHARED = ROOT.parent / "shared" / "data"
SCENES = {
    "tsukuba": (SHARED / "middlebury2001" / "tsukuba", 16),
    "venus": (SHARED / "middlebury2001" / "venus", 32),
    "teddy": (SHARED / "middlebury2003" / "teddy", 64),
    "cones": (SHARED / "middlebury2003" / "cones", 64),
    "corridor": (ROOT / "data" / "corridor", 48),
}
SAME_COST = ["cost=census-sobel", "prefilter=none"]
METHODS = {
    "bp": ["method=bp"],
    "sgm": ["method=sgm"],
    "bm 1x1": ["method=bm", *SAME_COST, "block=1"],
    "bm 9x9": ["method=bm", *SAME_COST, "block=9"],
}
MOST = 1.02


def environment():
    """Starts this program again in its virtual environment; returns in it."""
    python = WORK / "venv" / "bin" / "python"
    if os.environ.get("ENERGY_IN_VENV"):
        return
    try:
        if not python.exists():
            venv.create(WORK / "venv", with_pip=True)
        done = subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], capture_output=True, text=True)
        problem = done.stderr.strip().splitlines()[-1:] if done.returncode else []
    except (OSError, subprocess.CalledProcessError) as error:
        problem = [str(error)]
    if problem:
        print("NOT TESTED: energies beside alpha-expansion:", problem[0])
        sys.exit(0)
    sys.exit(subprocess.run([python, *sys.argv], env={**os.environ, "ENERGY_IN_VENV": "1"}).returncode)


def built(*what):
    subprocess.run(["cargo", "build", "--release", "--locked", *what], cwd=ROOT, check=True)
    return pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"


def smoothness(numpy, labels, weight, truncation):
    """What neighbours pay, in a row and in a column."""
    steps = [numpy.abs(numpy.diff(labels.astype(numpy.int64), axis=axis)) for axis in (0, 1)]
    return int(sum(numpy.minimum(weight * step, truncation).sum() for step in steps))


def data(numpy, cost, labels):
    return int(numpy.take_along_axis(cost, labels[..., None].astype(numpy.int64), axis=2).sum(dtype=numpy.int64))


def field(numpy, program, pair, disparities, settings):
    """The data terms with these settings, and the labels that their method finds."""
    with tempfile.TemporaryDirectory() as folder:
        options = [part for setting in settings for part in ("--set", setting)]
        line = [program, *pair, folder, "--disp", str(disparities), *options]
        told = subprocess.run(line, check=True, stdout=subprocess.PIPE, text=True).stdout.split()
        width, height, count, *_ = map(int, told)
        cost = numpy.fromfile(f"{folder}/cost.raw", numpy.uint8).reshape(height, width, count)
        labels = numpy.fromfile(f"{folder}/labels.raw", "<u2").reshape(height, width)
    return cost, labels


def told(program, pair, disparities, settings):
    """Data and smoothness, as the command tells them."""
    options = [f"--{name}={value}" for name, value in (setting.split("=") for setting in settings)]
    with tempfile.TemporaryDirectory() as folder:
        line = [program, *pair, "--disp", str(disparities), "--json", "-o", f"{folder}/map.npy", *options]
        energy = json.loads(subprocess.run(line, check=True, stdout=subprocess.PIPE).stdout)["energy"]
    return energy["data"], energy["smoothness"]


def expansion(numpy, cost, weight, truncation):
    """The energy of alpha-expansion, and its time in seconds."""
    from maxflow import fastmin

    labels = numpy.arange(cost.shape[2])
    pairwise = numpy.minimum(weight * numpy.abs(labels[:, None] - labels), truncation).astype(numpy.float64)
    start = time.monotonic()
    best = fastmin.aexpansion_grid(cost.astype(numpy.float64), pairwise)
    return data(numpy, cost, best) + smoothness(numpy, best, weight, truncation), time.monotonic() - start


def scene(numpy, programs, folder, disparities, prior, faults):
    """The energies of a scene on the common field, the methods' and alpha-expansion's, and the time of the latter."""
    pair = [str(folder / f"{side}.png") for side in ("left", "right")]
    common, energies = None, {}
    given = [f"smoothness-weight={prior[0]}", f"smoothness-truncation={prior[1]}"]
    for name, settings in ((name, settings + given) for name, settings in METHODS.items()):
        cost, labels = field(numpy, programs["field"], pair, disparities, settings)
        common = cost if common is None else common
        own = data(numpy, cost, labels), smoothness(numpy, labels, *prior)
        theirs = told(programs["binary"], pair, disparities, settings)
        if own != theirs:
            faults.append(f"{folder.name}, {name}: {own} is added up here and {theirs} told by the command")
        energies[name] = data(numpy, common, labels) + own[1]
    best, seconds = expansion(numpy, common, *prior)
    if energies["bp"] > MOST * best:
        faults.append(f"{folder.name}: belief propagation has {energies['bp']}, alpha-expansion {best}")
    if energies["bp"] >= min(energy for name, energy in energies.items() if name != "bp"):
        faults.append(f"{folder.name}: another method has less energy than belief propagation, {energies}")
    return energies, best, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", help="the built command")
    parser.add_argument("--field", help="the built example random_field")
    parser.add_argument("--only", help="scenes whose name contains this")
    parser.add_argument("--prior", default="2,20", metavar="WEIGHT,TRUNCATION", help="of the smoothness; default 2,20, the command's")
    options = parser.parse_args()
    prior = [int(number) for number in options.prior.split(",")]
    environment()
    import numpy

    programs = {
        "binary": options.binary or str(built() / "gpu-stereo"),
        "field": options.field or str(built("--example", "random_field") / "examples" / "random_field"),
    }
    faults = []
    print("| scene | disparities |", " | ".join(METHODS), "| alpha-expansion | bp / expansion | expansion, s |")
    print("|---" * (len(METHODS) + 5) + "|")
    for name, (folder, disparities) in SCENES.items():
        if options.only and options.only not in name:
            continue
        if not folder.is_dir():
            print(f"NOT TESTED: {name}, {folder} is not there", file=sys.stderr)
            continue
        energies, best, seconds = scene(numpy, programs, folder, disparities, prior, faults)
        cells = [name, disparities, *energies.values(), best, f"{energies['bp'] / best:.4f}", f"{seconds:.0f}"]
        print("|", " | ".join(map(str, cells)), "|", flush=True)
    sys.exit("\n".join(faults) if faults else 0)


if __name__ == "__main__":
    main()
