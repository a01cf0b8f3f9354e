"""gpu-stereo beside OpenCV; started by benches/versus_opencv, which installs what this needs.

What is compared, and why it is fair:

- Input. Both sides start from the same decoded 8-bit gray images. They are written as gray PNGs for gpu-stereo, which
  decodes them before its clock starts; so neither decoding nor the conversion of colours is in either figure.
- Ours is the whole frame (`frame_ms` of `--json`): with `--backend cpu` from the images to the map in memory; with
  `gpu` upload, every kernel, readback. With `--json` every stage is a pass of its own with timestamps there, so the
  figure is at worst a little above that of a run without.
- OpenCV's is `compute` on arrays in memory, into an array that is reused, as a program would do it for a video.
- Presets with all that they switch on: `balanced` and `strict` beside MODE_HH4 with its speckle filter of the same
  window (`strict` matches twice), `dense` (a second match, fillings, a weighted median) beside MODE_SGBM_3WAY with its
  right matcher and the WLS filter of ximgproc, which fills and smooths in its way.
- The others, work after the winner, on both sides: uniqueness 10 %, left-right check 1 px, one 3x3 median, no speckle
  filter.
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

POST = ("--preset classic --prefilter xsobel --prefilter-cap 31 --uniqueness 10 --lr-check 1 --speckle-window off "
        "--median 3").split()
# name, our options, OpenCV's matcher, time / OpenCV's to reach with --backend cpu
MODES = {
    "8 paths": (["--paths", "8", "--block", "5", *POST], "MODE_HH", 0.18),
    "4 paths": (["--paths", "4", "--block", "5", *POST], "MODE_HH4", 0.20),
    "3 paths": (["--paths", "3", "--block", "5", *POST], "MODE_SGBM_3WAY", 0.60),
    "bm 15": (["--method", "bm", "--block", "15", *POST], "StereoBM", 0.50),
    "balanced": (["--preset", "balanced"], "MODE_HH4, speckle 100", 0.30),
    "strict": (["--preset", "strict"], "MODE_HH4, speckle 200", 0.60),
    "dense": (["--preset", "dense"], "MODE_SGBM_3WAY, WLS", 0.80),
}
BACKENDS = ["cpu", "gpu"]
# The most that the time a pixel and disparity may grow from 741x500, D = 64 to a larger size and to D = 256.
GROWTH = 1.2


class Failed(Exception):
    """Told in one line."""


def arguments():
    parser = argparse.ArgumentParser(
        prog="benches/versus_opencv", description="Times gpu-stereo beside OpenCV; a Markdown table on stdout.",
        allow_abbrev=False,  # benches/versus_opencv looks for --binary, too
    )
    parser.add_argument("--binary", type=pathlib.Path, help="gpu-stereo; default: build it")
    parser.add_argument("--backend", choices=BACKENDS, action="append",
                        help="of gpu-stereo, may be given twice; default: cpu, and gpu where there is an adapter")
    parser.add_argument("--adapter", help="for --backend gpu; default: the one that gpu-stereo chooses")
    parser.add_argument("--only", choices=MODES, action="append", help="this row alone, may be given several times")
    parser.add_argument("--no-growth", action="store_true", help="leave the growth out")
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


def ours(given, pair, disparities, options, repeat, backend):
    command = [str(given.binary), *pair.paths, "--disp", str(disparities), *options, "--json", "--backend", backend]
    command += ["--repeat", str(repeat), "-o", str(WORK / "map.npy")]
    if given.adapter is not None and backend == "gpu":
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
        name, _, post = mode.partition(", ")
        speckle = int(post.removeprefix("speckle ")) if post.startswith("speckle ") else 0
        matcher = cv2.StereoSGBM_create(
            minDisparity=0, numDisparities=disparities, blockSize=5, P1=8 * 25, P2=32 * 25, disp12MaxDiff=1,
            preFilterCap=31, uniquenessRatio=10, speckleWindowSize=speckle, speckleRange=1 if speckle else 0,
            mode=getattr(cv2, "STEREO_SGBM_" + name),
        )
        if post == "WLS":
            right, wls = cv2.ximgproc.createRightMatcher(matcher), cv2.ximgproc.createDisparityWLSFilter(matcher)
            wls.setLambda(8000)
            wls.setSigmaColor(1.5)

            def smoothed():
                found = matcher.compute(pair.left, pair.right)
                wls.filter(found, pair.left, None, right.compute(pair.right, pair.left))

            return smoothed
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
        elif mode.startswith("MODE_HH,") or mode == "MODE_HH":
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
    reports = {backend: ours(given, pair, 16, MODES["4 paths"][0], 1, backend) for backend in given.backend}
    facts = {
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "load": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
        "system": platform.platform(),
        "opencv": importlib.metadata.version("opencv-contrib-python-headless"),
        "ours": {name: {k: found[k] for k in ("adapter", "backend", "driver")} for name, found in reports.items()},
        "rounds": given.rounds,
        "repeat": given.repeat,
    }
    print(f"CPU: {facts['cpu']}, {facts['cores']} cores  ")
    print(f"OpenCV: {facts['opencv']}, {cv2.getNumThreads()} threads  ")
    for name, found in facts["ours"].items():
        print(f"gpu-stereo --backend {name}: {found['adapter']} ({found['backend']}, {found['driver']})  ")
    print(f"Rounds: {given.rounds} of {given.repeat} frames a side")
    if facts["load"] and facts["load"][0] > 0.5:
        warn(f"the load was {facts['load'][0]:.1f} at the start: others use the cores, and figures are noisy")
    if given.quick:
        warn("--quick: one round; take no figure from this run")
    return facts


def compare(given, pair, disparities, name):
    options, mode, target = MODES[name]
    rounds = []
    for number in range(given.rounds):
        sides = {}
        order = [*given.backend, "opencv"]
        for side in order if number % 2 == 0 else order[::-1]:
            if side == "opencv":
                sides[side] = theirs(mode, pair, disparities, given.repeat)
            else:
                sides[side] = ours(given, pair, disparities, options, given.repeat, side)["frame_ms"]
        rounds.append(sides)
    median = {side: statistics.median(sides[side]["median"] for sides in rounds) for side in rounds[0]}
    least = {side: min(sides[side]["min"] for sides in rounds) for side in rounds[0]}
    of_rounds = {
        side: [sides[side]["median"] / sides["opencv"]["median"] for sides in rounds] for side in given.backend
    }
    ratio = {side: median[side] / median["opencv"] for side in given.backend}
    return {
        "pair": pair.name, "width": pair.width, "height": pair.height, "disparities": disparities,
        "ours": name, "opencv": mode, "median_ms": median, "min_ms": least, "ratio": ratio,
        "ratio_of_rounds": {side: [min(ratios), max(ratios)] for side, ratios in of_rounds.items()},
        "target": target, "reached": "cpu" in ratio and ratio["cpu"] <= target, "rounds": rounds,
    }


def growth(given, small, large, name):
    """[a case]: what a pixel and disparity takes, relative to the small pair at D = 64."""
    settings = [(small, 64), (large, 64), (small, 256)]
    times = [[] for _ in settings]
    for number in range(given.rounds):
        for i in range(len(settings))[:: 1 if number % 2 == 0 else -1]:
            pair, disparities = settings[i]
            frame = ours(given, pair, disparities, MODES[name][0], given.repeat, given.backend[0])["frame_ms"]
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
    def ms(side):
        return f"{case['median_ms'][side]:.1f} ({case['min_ms'][side]:.1f})"

    cells = [f"{case['pair']} {case['width']}x{case['height']}", case["disparities"], case["ours"], case["opencv"]]
    cells.append(ms("opencv"))
    for side in case["ratio"]:
        low, high = case["ratio_of_rounds"][side]
        cells += [ms(side), f"{case['ratio'][side]:.2f} ({low:.2f} to {high:.2f})"]
        if side == "cpu":
            cells += [f"{case['target']:.2f}", "yes" if case["reached"] else "no"]
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def heading(given):
    cells = ["pair", "D", "gpu-stereo", "OpenCV", "OpenCV, ms: median (min)"]
    for side in given.backend:
        cells += [f"{side}, ms", f"{side} / OpenCV (rounds)"]
        if side == "cpu":
            cells += ["to reach", "reached"]
    return f"\n| {' | '.join(cells)} |\n{'|---' * len(cells)}|"


def has_adapter(given):
    listed = subprocess.run([str(given.binary), "--list-adapters", "--json"], capture_output=True, text=True)
    return listed.returncode == 0 and json.loads(listed.stdout) != []


def main():
    given = arguments()
    sys.stdout.reconfigure(line_buffering=True)  # a row when it is known, also into a file
    WORK.mkdir(parents=True, exist_ok=True)
    if given.backend is None:
        given.backend = BACKENDS if has_adapter(given) else ["cpu"]
    names = [name for name in MODES if given.only is None or name in given.only]
    cases = list(pairs(given))
    first = cases[0][0]
    facts = machine(given, first)
    cores = check_cores(first, 0.5 if given.quick else 2, [MODES[name][1] for name in names])

    print(heading(given))
    found = []
    for name in names:
        for pair, ranges in cases:
            for disparities in ranges:
                found.append(compare(given, pair, disparities, name))
                print(row(found[-1]))
    reached = sum(case["reached"] for case in found)
    if "cpu" in given.backend:
        print(f"\n{reached} of {len(found)} ratios reached.")

    if not given.no_growth:
        print(f"\nGrowth with --backend {given.backend[0]}:\n\n| gpu-stereo | pair | D | ns a pixel and disparity "
              "| of that at 741x500, D = 64 | of a round | to reach | reached |\n|---|---|---|---|---|---|---|---|")
    grown = []
    for name in [] if given.no_growth else names:
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
