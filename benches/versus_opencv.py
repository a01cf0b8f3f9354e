"""gpu-stereo beside OpenCV; started by benches/versus_opencv, which installs what this needs.

What is compared, and why it is fair:

- Input. Both sides start from the same decoded 8-bit gray images. They are written as gray PNGs for gpu-stereo, which
  decodes them before its clock starts; so neither decoding nor the conversion of colours is in either figure.
- Ours is the whole frame: upload, every kernel, readback (`frame_ms` of `--json`). With `--json` every stage is a pass
  of its own with timestamps, so the figure is at worst a little above that of a run without.
- OpenCV's is `compute` on arrays in memory, into an array that is reused, as a program would do it for a video.
- Work after the winner, on both sides: uniqueness 10 %, left-right check 1 px, one 3x3 median, no speckle filter.
  StereoSGBM.compute ends with medianBlur(disp, disp, 3) of its own (modules/stereo/src/stereosgbm.cpp), so it is in
  its figure already, and a second one would be work that we do not do. StereoBM.compute has none (stereobm.cpp): there
  cv2.medianBlur is called inside the timing.
- StereoBM rejects pixels of low texture; gpu-stereo has no such test, so it is off (threshold 0). With OpenCV's default
  of 10 the medians of its time differed by less than 3 % (both pairs, D = 64, 60 frames each, a loaded machine).
- Prefilter: x-Sobel clipped at 31. OpenCV's SGBM adds a cost on the gray image, which is its own choice of cost.
- P1 = 8 * 25, P2 = 32 * 25 are OpenCV's advice for a block of 5. Ours are the defaults: the unit of our cost is another
  one, and no time depends on their values.
- OpenCV does not compute the leftmost D columns (9 % of 741 at D = 64); gpu-stereo computes every pixel. Not corrected.

After the comparison the growth of our own cost: the time a pixel and disparity at 1482x1000, and at D = 256, relative to
that at 741x500, D = 64, from rounds in which the three take turns.

The sides alternate round by round, and the one that begins alternates too, so that a slow spell of the machine meets
both. A figure is the median over the rounds of the medians of a round.
"""

import argparse
import contextlib
import importlib.metadata
import json
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import time

import cv2

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORK = ROOT / "target" / "versus_opencv"

# name, our options, OpenCV's matcher, time / OpenCV's to reach (on lavapipe)
MODES = {
    "8 paths": (["--paths", "8", "--block", "5"], "MODE_HH", 0.70),
    "4 paths": (["--paths", "4", "--block", "5"], "MODE_HH4", 0.60),
    "3 paths": (["--paths", "3", "--block", "5"], "MODE_SGBM_3WAY", 1.3),
    "bm 15": (["--method", "bm", "--block", "15"], "StereoBM", 1.0),
}
# The most that the time a pixel and disparity may grow from 741x500, D = 64 to a larger size and to D = 256.
GROWTH = 1.3
POST = ("--preset classic --prefilter xsobel --prefilter-cap 31 --uniqueness 10 --lr-check 1 --speckle-window off "
        "--median 3").split()


class Failed(Exception):
    """Told in one line."""


def arguments():
    parser = argparse.ArgumentParser(
        prog="benches/versus_opencv", description="Times gpu-stereo beside OpenCV; a Markdown table on stdout.",
        allow_abbrev=False,  # benches/versus_opencv looks for --binary, too
    )
    parser.add_argument("--binary", type=pathlib.Path, help="gpu-stereo; default: build it")
    parser.add_argument("--adapter", help="for gpu-stereo; default: the one that it chooses")
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="default 5")
    parser.add_argument("--repeat", type=int, default=10, metavar="N", help="frames a side and round, default 10")
    parser.add_argument("--quick", action="store_true", help="1 round of 3 frames: too few to be told to others")
    parser.add_argument("--long", action="store_true", help="D = 128 at 1482x1000, too")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write everything measured")
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared" / "data", metavar="FOLDER",
                        help="where kitti2015/000001_10 is; default ../shared/data beside the checkout")
    given = parser.parse_args()
    if given.quick:
        given.rounds, given.repeat = 1, 3
    if given.rounds < 1 or given.repeat < 1:
        parser.error("--rounds and --repeat are at least 1")
    if given.binary is None:
        parser.error("start benches/versus_opencv, which builds gpu-stereo, or give --binary")
    given.binary = given.binary.resolve()
    if not given.binary.is_file():
        parser.error(f"--binary: there is no file {given.binary}")
    return given


def warn(text):
    print(f"\n**WARNING: {text}**")


def gray(path):
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise Failed(f"{path} cannot be read")
    return image


class Pair:
    def __init__(self, name, left, right):
        self.name, self.left, self.right = name, left, right
        self.height, self.width = left.shape
        self.paths = []
        for side, image in (("left", left), ("right", right)):
            path = WORK / f"{name}_{self.width}x{self.height}_{side}.png"
            if not cv2.imwrite(str(path), image):
                raise Failed(f"{path} cannot be written")
            self.paths.append(str(path))


def pairs(given):
    """[(pair, disparities)]"""
    folder = ROOT / "data" / "motorcycle"
    motorcycle = Pair("motorcycle", gray(folder / "left.png"), gray(folder / "right.png"))
    yield motorcycle, [64, 128]
    folder = given.data / "kitti2015" / "000001_10"
    if folder.is_dir():
        yield Pair("kitti", gray(folder / "left.png"), gray(folder / "right.png")), [64, 128]
    else:
        print("KITTI is left out: there is no kitti2015/000001_10 in ../shared/data (or in --data FOLDER).\n")
    size = (2 * motorcycle.width, 2 * motorcycle.height)
    left, right = (cv2.resize(i, size, interpolation=cv2.INTER_CUBIC) for i in (motorcycle.left, motorcycle.right))
    yield Pair("motorcycle", left, right), [64, 128] if given.long else [64]


def ours(given, pair, disparities, options, repeat):
    command = [str(given.binary), *pair.paths, "--disp", str(disparities), *options, *POST, "--json"]
    command += ["--repeat", str(repeat), "-o", str(WORK / "map.npy")]
    if given.adapter is not None:
        command += ["--adapter", given.adapter]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    if (report["width"], report["height"]) != (pair.width, pair.height):
        raise Failed(f"gpu-stereo read {report['width']}x{report['height']}, not {pair.width}x{pair.height}")
    return report


def opencv(mode, pair, disparities):
    """A function that computes the map."""
    if mode == "StereoBM":
        matcher = cv2.StereoBM_create(numDisparities=disparities, blockSize=15)
        matcher.setPreFilterType(cv2.STEREO_BM_PREFILTER_XSOBEL)
        matcher.setPreFilterCap(31)
        matcher.setTextureThreshold(0)
        matcher.setUniquenessRatio(10)
        matcher.setDisp12MaxDiff(1)
        matcher.setSpeckleWindowSize(0)
    else:
        matcher = cv2.StereoSGBM_create(
            minDisparity=0, numDisparities=disparities, blockSize=5, P1=8 * 25, P2=32 * 25, disp12MaxDiff=1,
            preFilterCap=31, uniquenessRatio=10, speckleWindowSize=0, speckleRange=0,
            mode=getattr(cv2, "STEREO_SGBM_" + mode),
        )
    kept = matcher.compute(pair.left, pair.right)
    filtered = kept.copy()

    def compute():
        matcher.compute(pair.left, pair.right, kept)
        if mode == "StereoBM":
            cv2.medianBlur(kept, 3, filtered)

    return compute


def theirs(mode, pair, disparities, repeat):
    compute = opencv(mode, pair, disparities)
    compute()  # warm-up, as gpu-stereo does one
    times = []
    for _ in range(repeat):
        before = time.perf_counter()
        compute()
        times.append((time.perf_counter() - before) * 1e3)
    return {"median": statistics.median(times), "min": min(times)}


def thread_times():
    """Seconds of CPU time by thread of this process; empty where the system does not tell."""
    times = {}
    for path in pathlib.Path("/proc/self/task").glob("*/schedstat"):
        with contextlib.suppress(OSError):  # a thread that has just ended
            times[path.parent.name] = int(path.read_text().split()[0]) / 1e9
    return times


def parallelism(mode, pair, seconds):
    """CPU time / wall time, which falls when others use the cores, and CPU time / that of the busiest thread, which
    does not: it is 1 for serial work and the number of threads for work that is divided evenly."""
    compute = opencv(mode, pair, 64)
    compute()
    threads, cpu, wall = thread_times(), time.process_time(), time.perf_counter()
    while time.perf_counter() - wall < seconds:
        compute()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    spent = [now - threads.get(thread, 0) for thread, now in thread_times().items()]
    busiest = max(spent, default=0)
    return {"cpu_by_wall": cpu / wall, "cpu_by_busiest_thread": sum(spent) / busiest if busiest > 0 else None}


def check_cores(pair, seconds, modes):
    """Did OpenCV use all cores? Says so loudly where it did not."""
    cores, threads = os.cpu_count(), cv2.getNumThreads()
    if threads != cores:
        warn(f"OpenCV uses {threads} threads on {cores} cores: the ratios flatter gpu-stereo")
    found = {mode: parallelism(mode, pair, seconds) for mode in modes}
    print("\n| OpenCV, 741x500, D = 64 | CPU time / wall time | CPU time / busiest thread's |\n|---|---|---|")
    for mode, use in found.items():
        divided = use["cpu_by_busiest_thread"]
        print(f"| {mode} | {use['cpu_by_wall']:.2f} | {'not told' if divided is None else f'{divided:.2f}'} |")
    starved = []
    for mode, use in found.items():
        if cores == 1 or use["cpu_by_wall"] > 1.2:
            continue
        divided = use["cpu_by_busiest_thread"]
        if divided is not None and divided > 1.2:
            starved.append(f"{mode} {use['cpu_by_wall']:.2f}")
        elif mode == "MODE_HH":
            # computeDisparitySGBM has no parallel_for_ (modules/stereo/src/stereosgbm.cpp); HH4, 3WAY and BM have one.
            warn("MODE_HH ran on one core: OpenCV has no parallel code for it, so its ratio compares all cores "
                 "with one")
        else:
            warn(f"{mode} ran on one core: OpenCV did not use all cores, and its ratio flatters gpu-stereo")
    if starved:
        warn(f"work divided over threads was not given the cores ({', '.join(starved)}): something else is running. "
             "Take no figure from this run; MODE_HH, on one core, suffers least, so its ratio comes out too high")
    return {"cores": cores, "opencv_threads": threads, "parallelism": found}


def cpu_model():
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", pathlib.Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        found = None
    return found.group(1) if found else platform.processor() or platform.machine()


def machine(given, pair):
    report = ours(given, pair, 16, MODES["4 paths"][0], 1)
    facts = {
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "load": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
        "system": platform.platform(),
        "opencv": importlib.metadata.version("opencv-contrib-python-headless"),
        "adapter": report["adapter"],
        "driver": report["driver"],
        "backend": report["backend"],
        "rounds": given.rounds,
        "repeat": given.repeat,
    }
    print(f"CPU: {facts['cpu']}, {facts['cores']} cores  ")
    print(f"OpenCV: {facts['opencv']}, {cv2.getNumThreads()} threads  ")
    print(f"gpu-stereo: {facts['adapter']} ({facts['backend']}, {facts['driver']})  ")
    print(f"Rounds: {given.rounds} of {given.repeat} frames a side")
    if facts["load"] and facts["load"][0] > 0.5:
        warn(f"the load was {facts['load'][0]:.1f} at the start: others use the cores, and figures are noisy")
    if "llvmpipe" not in facts["adapter"]:
        warn("the targets are meant for lavapipe, and this is another adapter")
    if given.quick:
        warn("--quick: one round; take no figure from this run")
    return facts


def compare(given, pair, disparities, name):
    options, mode, target = MODES[name]
    rounds = []
    for number in range(given.rounds):
        sides = {}
        for side in ("ours", "opencv") if number % 2 == 0 else ("opencv", "ours"):
            if side == "ours":
                sides[side] = ours(given, pair, disparities, options, given.repeat)["frame_ms"]
            else:
                sides[side] = theirs(mode, pair, disparities, given.repeat)
        rounds.append(sides)
    medians = {side: statistics.median(sides[side]["median"] for sides in rounds) for side in ("ours", "opencv")}
    least = {side: min(sides[side]["min"] for sides in rounds) for side in ("ours", "opencv")}
    ratios = [sides["ours"]["median"] / sides["opencv"]["median"] for sides in rounds]
    ratio = medians["ours"] / medians["opencv"]
    return {
        "pair": pair.name, "width": pair.width, "height": pair.height, "disparities": disparities,
        "ours": name, "opencv": mode,
        "ours_ms": {"median": medians["ours"], "min": least["ours"]},
        "opencv_ms": {"median": medians["opencv"], "min": least["opencv"]},
        "ratio": ratio, "ratio_of_minima": least["ours"] / least["opencv"],
        "ratio_of_rounds": [min(ratios), max(ratios)],
        "target": target, "reached": ratio <= target, "rounds": rounds,
    }


def growth(given, small, large, name):
    """[a case]: what a pixel and disparity takes, relative to the small pair at D = 64."""
    settings = [(small, 64), (large, 64), (small, 256)]
    times = [[] for _ in settings]
    for number in range(given.rounds):
        for i in range(len(settings))[:: 1 if number % 2 == 0 else -1]:
            pair, disparities = settings[i]
            frame = ours(given, pair, disparities, MODES[name][0], given.repeat)["frame_ms"]
            times[i].append(frame["median"] * 1e6 / (pair.width * pair.height * disparities))
    of_rounds = [[now / base for now, base in zip(one, times[0])] for one in times]
    found = []
    for (pair, disparities), one, ratios in zip(settings, times, of_rounds):
        factor = statistics.median(one) / statistics.median(times[0])
        found.append({
            "ours": name, "pair": pair.name, "width": pair.width, "height": pair.height, "disparities": disparities,
            "ns": statistics.median(one), "growth": factor, "growth_of_rounds": [min(ratios), max(ratios)],
            "target": GROWTH, "reached": factor <= GROWTH,
        })
    return found


def growth_row(case):
    low, high = case["growth_of_rounds"]
    return (
        f"| {case['ours']} | {case['pair']} {case['width']}x{case['height']} | {case['disparities']} "
        f"| {case['ns']:.2f} | {case['growth']:.2f} | {low:.2f} to {high:.2f} | {case['target']:.2f} "
        f"| {'yes' if case['reached'] else 'no'} |"
    )


def row(case):
    low, high = case["ratio_of_rounds"]
    return (
        f"| {case['pair']} {case['width']}x{case['height']} | {case['disparities']} "
        f"| {case['ours']} | {case['opencv']} "
        f"| {case['ours_ms']['median']:.1f} ({case['ours_ms']['min']:.1f}) "
        f"| {case['opencv_ms']['median']:.1f} ({case['opencv_ms']['min']:.1f}) "
        f"| {case['ratio']:.2f} | {low:.2f} to {high:.2f} | {case['target']:.2f} "
        f"| {'yes' if case['reached'] else 'no'} |"
    )


def main():
    given = arguments()
    sys.stdout.reconfigure(line_buffering=True)  # a row when it is known, also into a file
    WORK.mkdir(parents=True, exist_ok=True)
    cases = list(pairs(given))
    first = cases[0][0]
    facts = machine(given, first)
    cores = check_cores(first, 0.5 if given.quick else 2, [mode for _, mode, _ in MODES.values()])

    print("\n| pair | D | gpu-stereo | OpenCV | ours, ms: median (min) | OpenCV, ms: median (min) | ratio | of a round "
          "| to reach | reached |\n|---|---|---|---|---|---|---|---|---|---|")
    found = []
    for name in MODES:
        for pair, ranges in cases:
            for disparities in ranges:
                found.append(compare(given, pair, disparities, name))
                print(row(found[-1]))
    reached = sum(case["reached"] for case in found)
    print(f"\n{reached} of {len(found)} ratios reached.")

    print("\n| gpu-stereo | pair | D | ns a pixel and disparity | of that at 741x500, D = 64 | of a round | to reach "
          "| reached |\n|---|---|---|---|---|---|---|---|")
    grown = []
    for name in MODES:
        for case in growth(given, first, cases[-1][0], name):
            grown.append(case)
            print(growth_row(case))
    if given.json is not None:
        result = {"machine": facts, "opencv_cores": cores, "cases": found, "growth": grown}
        given.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    try:
        main()
    except Failed as error:
        print(f"versus_opencv: {error}", file=sys.stderr)
        sys.exit(2)
