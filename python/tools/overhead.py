"""What the module adds to a frame: the median time of StereoMatcher.compute beside the command's own frames, in turn.

    python python/tools/overhead.py [COMMAND] [--rounds N]     # COMMAND: the program, of the same profile as the module; target/debug/gpu-stereo

Run it on an idle machine."""

import argparse
import json
import statistics
import subprocess
import time
from pathlib import Path

import gpu_stereo

ROOT = Path(__file__).resolve().parents[2]
PAIR = [ROOT / "data/motorcycle/left.png", ROOT / "data/motorcycle/right.png"]
FRAMES = 40


def of_command(program: str) -> float:
    args = [program, *PAIR, "--disp", "64", "--backend", "cpu", "--repeat", str(FRAMES), "--json", "-o", ROOT / "target/overhead.npy"]
    done = subprocess.run([*map(str, args)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)["frame_ms"]["median"]


def of_module() -> float:
    left, right = gpu_stereo.read_pair(*PAIR)
    matcher = gpu_stereo.StereoMatcher(left.shape[1], left.shape[0], disparities=64, device="cpu")
    _ = matcher.compute(left, right).disparity
    times = []
    for _ in range(FRAMES):
        start = time.perf_counter()
        _ = matcher.compute(left, right).disparity
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", nargs="?", default=str(ROOT / "target/debug/gpu-stereo"))
    parser.add_argument("--rounds", type=int, default=5)
    given = parser.parse_args()
    rounds = [(of_command(given.command), of_module()) for _ in range(given.rounds)]
    for command, module in rounds:
        print(f"command {command:8.2f} ms   module {module:8.2f} ms   {100 * (module / command - 1):+.1f} %")
    command, module = (min(times) for times in zip(*rounds, strict=True))
    print(f"best    {command:8.2f} ms   module {module:8.2f} ms   {100 * (module / command - 1):+.1f} %")


if __name__ == "__main__":
    main()
