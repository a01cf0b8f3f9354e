"""gpu_stereo.cv beside OpenCV: the tables of docs/OPENCV.md.

Needs gpu_stereo and opencv-contrib-python-headless in the environment, and the pairs of ../shared/data:

    python python/tools/compare_opencv.py             # prints the tables
    python python/tools/compare_opencv.py --write     # puts them into docs/OPENCV.md

The first table follows OpenCV's own test of its matchers (modules/stereo/test/test_stereomatching.cpp): the share of non-occluded
pixels with known truth, 10 px (for StereoBM half a block, if that is more) off the border, whose disparity is wrong by more than
1 px; pixels without a disparity are wrong. The numbers of StereoSGBM are those of that test: colour images, P1 and P2 10 and 40
times the pixels of a block, uniqueness 10, a clip of 63, speckles of 100 pixels that differ by 32 px, and disparities without their
fraction. StereoBM has its default numbers and gray images.
"""

from __future__ import annotations

import argparse
import pathlib
import sys
import warnings
from typing import Any

import cv2
import numpy as np

from gpu_stereo import cv

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data"
# Set, levels of the truth a pixel, disparities, and the block of StereoSGBM in OpenCV's test.
SCENES = {
    "cones": ("middlebury2003", 4, 64, 5),
    "teddy": ("middlebury2003", 4, 48, 3),
    "tsukuba": ("middlebury2001", 16, 16, 1),
    "venus": ("middlebury2001", 8, 32, 3),
}
MODES = {"SGBM": 0, "HH": 1, "3WAY": 2, "HH4": 3}
BM_BLOCKS = (9, 15)
# By how many points a share of wrong pixels may be above OpenCV's.
ALLOWED = 0.3


def read(path: pathlib.Path, how: int = cv2.IMREAD_COLOR) -> Any:
    image = cv2.imread(str(path), how)
    if image is None:
        raise SystemExit(f"compare_opencv.py: {path} cannot be read; the pairs of ../shared/data are needed")
    return image


def scene(name: str) -> tuple[Any, Any, Any, Any]:
    """Both images, the left truth in pixels, and which pixels are not occluded."""
    folder = DATA / SCENES[name][0] / name
    levels = SCENES[name][1]
    truth = read(folder / "disp_left.png", cv2.IMREAD_GRAYSCALE).astype(np.float32) / levels
    right_path = folder / "disp_right.png"
    right = read(right_path, cv2.IMREAD_GRAYSCALE).astype(np.float32) / levels if right_path.is_file() else None
    return read(folder / "left.png"), read(folder / "right.png"), truth, not_occluded(truth, right)


def not_occluded(truth: Any, right: Any) -> Any:
    """Where a known left pixel leads to a right pixel whose disparity is not larger by more than 1 px."""
    height, width = truth.shape
    y, x = np.mgrid[:height, :width]
    known = truth > 0
    partner = x - np.rint(truth).astype(int)
    leads = known & (partner >= 0)
    if right is None:
        right, right_known = np.zeros_like(truth), np.ones_like(known)
        np.maximum.at(right, (y[leads], partner[leads]), truth[leads])
    else:
        right_known = right > 0
    partner = np.maximum(partner, 0)
    return leads & right_known[y, partner] & (right[y, partner] <= truth + 1)


def wrong(disparities: Any, truth: Any, counts: Any, border: int) -> float:
    inside = np.zeros_like(counts)
    inside[border:-border, border:-border] = counts[border:-border, border:-border]
    return float(100 * (np.abs(disparities - truth) > 1)[inside].mean())


def gray(image: Any) -> Any:
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


def sgbm(module: Any, name: str, mode: int) -> Any:
    _, _, count, block = SCENES[name]
    area = block * block
    return module.StereoSGBM_create(0, count, block, 10 * area, 40 * area, 1, 63, 10, 100, 32, mode)


def protocol() -> tuple[list[str], bool]:
    """OpenCV's own test: a table, and whether all rows are near enough."""
    lines = ["| matcher | scene | OpenCV | gpu_stereo.cv | difference |", "|---|---|---|---|---|"]
    near = True

    def row(matcher: str, name: str, theirs: float, ours: float) -> None:
        nonlocal near
        near &= ours - theirs <= ALLOWED
        lines.append(f"| {matcher} | {name} | {theirs:.2f} % | {ours:.2f} % | {ours - theirs:+.2f} |")

    scenes = {name: scene(name) for name in SCENES}
    for mode, number in MODES.items():
        for name, (left, right, truth, counts) in scenes.items():
            maps = [np.rint(sgbm(module, name, number).compute(left, right) / 16) for module in (cv2, cv)]
            row(f"StereoSGBM, {mode}", name, *(wrong(map, truth, counts, 10) for map in maps))
    for block in BM_BLOCKS:
        for name, (left, right, truth, counts) in scenes.items():
            count = SCENES[name][2]
            maps = [module.StereoBM_create(count, block).compute(gray(left), gray(right)) / 16 for module in (cv2, cv)]
            row(f"StereoBM, block {block}", name, *(wrong(map, truth, counts, max(10, block // 2)) for map in maps))
    return lines, near


def pairs() -> dict[str, tuple[Any, Any, int]]:
    """The pairs of the second table, with a number of disparities."""
    motorcycle = ROOT / "data" / "motorcycle"
    found = {"motorcycle": (read(motorcycle / "left.png"), read(motorcycle / "right.png"), 64)}
    for name in ("cones", "teddy"):
        folder = DATA / "middlebury2003" / name
        found[name] = (read(folder / "left.png"), read(folder / "right.png"), 64)
    for name in ("000001_10", "000003_10"):
        folder = DATA / "kitti2015" / name
        found[f"kitti {name}"] = (read(folder / "left.png"), read(folder / "right.png"), 96)
    return found


def agreement() -> list[str]:
    """How alike the maps are with usual numbers."""
    lines = [
        "| matcher | pair | equal | within 1/16 px | within 1 px | valid in one alone |",
        "|---|---|---|---|---|---|",
    ]

    def row(matcher: str, name: str, theirs: Any, ours: Any) -> None:
        invalid = -16
        both = (theirs != invalid) & (ours != invalid)
        apart = np.abs(theirs.astype(int) - ours)
        alone = (theirs != invalid) != (ours != invalid)
        shares = [100 * (theirs == ours).mean(), *(100 * (apart[both] <= limit).mean() for limit in (1, 16))]
        lines.append(f"| {matcher} | {name} | {' | '.join(f'{share:.2f} %' for share in shares)} | {100 * alone.mean():.2f} % |")

    for name, (left, right, count) in pairs().items():
        for block in (9, 21):
            theirs, ours = (module.StereoBM_create(count, block).compute(gray(left), gray(right)) for module in (cv2, cv))
            row(f"StereoBM, block {block}", name, theirs, ours)
        for label, number in MODES.items():
            theirs, ours = (
                module.StereoSGBM_create(0, count, 5, 600, 2400, 1, 63, 10, 100, 2, number).compute(gray(left), gray(right))
                for module in (cv2, cv)
            )
            row(f"StereoSGBM, {label}", name, theirs, ours)
    return lines


def put(text: str, name: str, lines: list[str]) -> str:
    """The page with a table between its two marks."""
    start, end = f"<!-- table {name} -->\n", f"<!-- end {name} -->\n"
    before, rest = text.split(start)
    return before + start + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python/tools/compare_opencv.py", description="Tables of gpu_stereo.cv beside OpenCV.")
    parser.add_argument("--write", action="store_true", help="into docs/OPENCV.md")
    given = parser.parse_args()
    # The numbers of OpenCV's test are small for us; the page says so.
    warnings.simplefilter("ignore", UserWarning)
    tested, near = protocol()
    tables = {"protocol": tested, "agreement": agreement()}
    if given.write:
        page = ROOT / "docs" / "OPENCV.md"
        text = page.read_text(encoding="utf-8")
        for name, lines in tables.items():
            text = put(text, name, lines)
        page.write_text(text, encoding="utf-8")
    else:
        print(f"OpenCV {cv2.__version__}\n")
        print("\n\n".join("\n".join(lines) for lines in tables.values()))
    if not near:
        print(f"compare_opencv.py: a row of the first table is more than {ALLOWED} points above OpenCV's", file=sys.stderr)
    return 0 if near else 1


if __name__ == "__main__":
    sys.exit(main())
