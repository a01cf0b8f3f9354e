"""Accuracy of the presets beside OpenCV's; started by benches/accuracy, which installs what this needs.

- Scenes: those of a collection with a MANIFEST.json that have a truth, KITTI's frames at 128 disparities and the others
  at the multiple of 16 that holds their largest; without a collection the two pairs of data/.
- Ours is the map that the command writes, in ms the median of `frame_ms` (upload, kernels, readback).
- OpenCV's is StereoSGBM in mode HH, with what its documentation advises for a block of 5, a speckle filter and its
  left-right check; in ms the median of `compute` on gray images in memory. It has no map in the leftmost columns, as many
  as there are disparities: they count as holes.
- Figures are those of `gpu-stereo eval`, in per cent; docs/EVALUATION.md defines them.
"""

import argparse
import json
import pathlib
import shlex
import statistics
import subprocess
import sys
import tempfile
import time

import accuracy_picture
import cv2
import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
PRESETS = ["classic", "fast", "balanced", "strict", "dense", "accurate"]
OPENCV = "OpenCV HH"
FIGURES = {"density": "density", "bad2": "bad-2 of valid", "d1_est": "D1-est", "d1_all": "D1-all"}
MEANS = {
    "KITTI": lambda scene: scene["set"].startswith("kitti"),
    "Teddy and Cones": lambda scene: scene["scene"] in ("teddy", "cones"),
    "Middlebury": lambda scene: scene["set"].startswith("middlebury") and not scene["set"].endswith("_full"),
}


class Failed(Exception):
    """Told in one line."""


def variant(text):
    name, colon, options = text.partition(":")
    if not colon or not name.strip():
        raise argparse.ArgumentTypeError('"NAME: OPTIONS" is needed, as in "eight: --preset balanced --paths 8"')
    return name.strip(), shlex.split(options)


def arguments():
    parser = argparse.ArgumentParser(
        prog="benches/accuracy", description="Accuracy of presets and variants beside OpenCV; Markdown on stdout.",
        allow_abbrev=False,  # benches/accuracy looks for --binary, too
    )
    parser.add_argument("--variant", type=variant, action="append", default=[], metavar='"NAME: OPTIONS"',
                        help="measure these options of the command, too; may be given several times")
    parser.add_argument("--presets", metavar="LIST", default=",".join(PRESETS),
                        help="presets to measure, with commas between them; default: all; none: no preset")
    parser.add_argument("--opencv", choices=("on", "off"), default="on", help="default on")
    parser.add_argument("--only", action="append", metavar="SCENE", help="scenes whose name contains this")
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="frames for the time, default 3")
    parser.add_argument("--means", action="store_true", help="print no table a scene")
    parser.add_argument("--independent", action="store_true", help="hold every figure to cli/tests/command/evaluation.py")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write everything measured")
    parser.add_argument("--picture", type=pathlib.Path, metavar="FILE", help="draw the time and D1-all of the means, as SVG")
    parser.add_argument("--data", type=pathlib.Path, metavar="FOLDER",
                        help="collection with a MANIFEST.json; default ../shared/data beside the checkout")
    parser.add_argument("--binary", type=pathlib.Path, help="gpu-stereo; default: build it")
    parser.add_argument("--adapter", help="for gpu-stereo; default: the one that it chooses")
    given = parser.parse_args()
    if given.repeat < 1:
        parser.error("--repeat is at least 1")
    if given.binary is None:
        parser.error("start benches/accuracy, which builds gpu-stereo, or give --binary")
    given.binary = given.binary.resolve()
    given.equal = 0
    sys.path.insert(0, str(ROOT / "cli" / "tests" / "command"))
    if not given.binary.is_file():
        parser.error(f"--binary: there is no file {given.binary}")
    return given


def own_scenes():
    for name, disparities in (("motorcycle", 64), ("corridor", 48)):
        folder = ROOT / "data" / name
        yield {"set": "data", "scene": name, "disparities": disparities, "scale": 1.0,
               **{key: folder / f"{file}" for key, file in
                  (("left", "left.png"), ("right", "right.png"), ("truth", "disp_left.pfm"))}}


def collected_scenes(folder):
    for entry in json.loads((folder / "MANIFEST.json").read_text()):
        if entry.get("gt") and entry.get("gt_scale") and entry.get("max_disp"):
            kitti = entry["set"].startswith("kitti")
            disparities = 128 if kitti else (int(entry["max_disp"]) + 16) // 16 * 16
            yield {"set": entry["set"], "scene": entry["scene"], "disparities": disparities,
                   "scale": float(entry["gt_scale"]), "left": folder / entry["left"],
                   "right": folder / entry["right"], "truth": folder / entry["gt"]}


def scenes(given):
    folder = given.data or ROOT.parent / "shared" / "data"
    if (folder / "MANIFEST.json").is_file():
        found = list(collected_scenes(folder))
    elif given.data:
        raise Failed(f"there is no MANIFEST.json in {folder}")
    else:
        print("No collection at ../shared/data and no --data FOLDER: only the pairs in data/ are measured.\n")
        found = list(own_scenes())
    if given.only:
        found = [s for s in found if any(part in f"{s['set']}/{s['scene']}" for part in given.only)]
    if not found:
        raise Failed("no scene is left")
    return found


def output(command):
    command = [str(part) for part in command]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{shlex.join(command)}: exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def ours(given, scene, options):
    """The map in px, NaN where there is none, and ms a frame."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "map.npy"
        command = [given.binary, scene["left"], scene["right"], "--disp", scene["disparities"], *options, "--json",
                   "--repeat", given.repeat, "-o", path]
        if given.adapter is not None:
            command += ["--adapter", given.adapter]
        told = json.loads(output(command))
        return numpy.load(path), told["frame_ms"]["median"]


def opencv(given, scene):
    left, right = (cv2.imread(str(scene[side]), cv2.IMREAD_GRAYSCALE) for side in ("left", "right"))
    matcher = cv2.StereoSGBM_create(
        minDisparity=0, numDisparities=scene["disparities"], blockSize=5, P1=8 * 25, P2=32 * 25, disp12MaxDiff=1,
        preFilterCap=63, uniquenessRatio=10, speckleWindowSize=100, speckleRange=2, mode=cv2.STEREO_SGBM_MODE_HH,
    )
    times = []
    for _ in range(given.repeat + 1):  # the first is a warm-up
        before = time.perf_counter()
        found = matcher.compute(left, right)
        times.append((time.perf_counter() - before) * 1e3)
    found = found / 16.0
    return numpy.where(found >= 0, found, numpy.nan), statistics.median(times[1:])


def figures(given, scene, found):
    """Figures of a map in px, NaN where there is none, in per cent; held to cli/tests/command/evaluation.py with --independent."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "map.npy"
        numpy.save(path, found.astype(numpy.float32))
        case = [str(path), str(scene["truth"]), "--gt-scale", str(scene["scale"])]
        told = json.loads(output([given.binary, "eval", *case, "--json"]))["evaluation"]
        if given.independent:
            import evaluation

            expected = evaluation.case(case)
            for name, value in expected.items():
                if abs(told[name] - value) > 1e-6 * max(1, abs(value)):
                    raise Failed(f"{scene['scene']}: {name} is {told[name]}, but docs/EVALUATION.md says {value}")
            given.equal += len(expected)
    return {key: 100 * told[name] for key, name in
            (("density", "density"), ("bad2", "bad_2_of_valid"), ("d1_est", "d1_est"), ("d1_all", "d1_all"))}


def line(name, found):
    cells = [f"{found[key]:.2f}" for key in FIGURES]
    return f"| {name} | {' | '.join(cells)} | {found['ms']:.0f} |"


HEADER = f"| setting | {' | '.join(FIGURES.values())} | ms |\n|---|{'---|' * (len(FIGURES) + 1)}"


def main():
    given = arguments()
    sys.stdout.reconfigure(line_buffering=True)  # a row when it is known, also into a file
    chosen = [] if given.presets == "none" else given.presets.split(",")
    settings = {name: ["--preset", name] for name in chosen} | dict(given.variant)
    results = []
    for scene in scenes(given):
        title = f"{scene['set']}/{scene['scene']}, {scene['disparities']} disparities"
        print(f"{title}:\n\n{HEADER}" if not given.means else f"<!-- {title} -->")
        sides = [(name, lambda options=options: ours(given, scene, options)) for name, options in settings.items()]
        if given.opencv == "on":
            sides.append((OPENCV, lambda: opencv(given, scene)))
        for name, compute in sides:
            found, ms = compute()
            result = {"setting": name, "set": scene["set"], "scene": scene["scene"],
                      "disparities": scene["disparities"], **figures(given, scene, found), "ms": ms}
            results.append(result)
            if not given.means:
                print(line(name, result))
        print()
    names = list(dict.fromkeys(result["setting"] for result in results))
    means = []
    for mean, belongs in MEANS.items():
        of_mean = [result for result in results if belongs(result)]
        if len({result["scene"] for result in of_mean}) < 2:
            continue
        print(f"Mean of {mean}:\n\n{HEADER}")
        for name in names:
            of_name = [result for result in of_mean if result["setting"] == name]
            found = {key: statistics.mean(result[key] for result in of_name) for key in (*FIGURES, "ms")}
            means.append({"mean": mean, "setting": name, "scenes": len(of_name), **found})
            print(line(name, found))
        print()
    if given.independent:
        print(f"{given.equal} figures of {len(results)} maps are those of cli/tests/command/evaluation.py to 1e-6.")
    if given.json is not None:
        given.json.write_text(json.dumps({"scenes": results, "means": means}, indent=1) + "\n")
    if given.picture is not None:
        given.picture.write_text(accuracy_picture.picture(means, [OPENCV]))


if __name__ == "__main__":
    try:
        main()
    except Failed as error:
        print(f"accuracy: {error}", file=sys.stderr)
        sys.exit(2)
