"""Pairs in the viewer Rerun: both images, disparities, depths, and the cloud of points, over time.

    pip install gpu-stereo rerun-sdk
    python examples/rerun_pairs.py left.png right.png --calib calib.txt --disp 64
    python examples/rerun_pairs.py lefts/ rights/ --calib calib.txt --disp 128 --save pairs.rrd

Two images, or two folders of images, whose names are sorted; `--fps` is the time between pairs. With a calibration there are depths and
points, in metres; without one there are disparities alone. `--save` writes a recording, which `rerun pairs.rrd` shows; without it
the viewer is opened.
"""

from __future__ import annotations

import argparse
import itertools
import pathlib
import sys
from collections.abc import Iterator

import numpy as np
import rerun as rr

import gpu_stereo


def files(left: pathlib.Path, right: pathlib.Path) -> list[tuple[pathlib.Path, pathlib.Path]]:
    """The files of the pairs, in order."""
    if left.is_dir() != right.is_dir():
        sys.exit(f"{left} and {right}: two images or two folders are needed, not one of each")
    if not left.is_dir():
        return [(left, right)]
    sides = [sorted(path for path in folder.iterdir() if path.is_file()) for folder in (left, right)]
    counts = [len(side) for side in sides]
    if counts[0] != counts[1] or not counts[0]:
        sys.exit(f"{left} has {counts[0]} files, {right} {counts[1]}: as many are needed on both sides")
    return list(zip(*sides, strict=True))


def pairs(
    given: list[tuple[pathlib.Path, pathlib.Path]], calibration: gpu_stereo.Calibration | None
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The images, rectified if the calibration is one of cameras that are not."""
    for left, right in given:
        images = gpu_stereo.read_pair(left, right)
        yield gpu_stereo.rectify(*images, calibration)[:2] if calibration and calibration.rectifies else images


def eight_bits(image: np.ndarray) -> np.ndarray:
    return image if image.dtype == np.uint8 else (image / 257).round().astype(np.uint8)


def log(left: np.ndarray, right: np.ndarray, matched: gpu_stereo.Matched, camera: gpu_stereo.Camera | None) -> None:
    """A pair and what was computed: what lies in space under world, beside it the disparities."""
    rr.log("world/left/image", rr.Image(eight_bits(left)))
    rr.log("world/right/image", rr.Image(eight_bits(right)))
    rr.log("disparity", rr.Tensor(matched.disparity, dim_names=("y", "x")))
    if camera is None:
        return
    height, width = matched.shape
    for side, at, cx in (("left", 0.0, camera.cx), ("right", camera.baseline, camera.cx + camera.doffs)):
        lens = rr.Pinhole(focal_length=camera.focal, principal_point=(cx, camera.cy), width=width, height=height)
        rr.log(f"world/{side}", rr.Transform3D(translation=(at, 0.0, 0.0)), lens)
    depth = matched.depth
    known = ~np.isnan(depth)
    rr.log("world/left/depth", rr.DepthImage(np.where(known, depth, 0).astype(np.float32), meter=1.0))
    colours = eight_bits(left)[known]
    rr.log("world/points", rr.Points3D(matched.points(), colors=colours if colours.ndim == 2 else np.repeat(colours[:, None], 3, axis=1)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("left", type=pathlib.Path)
    parser.add_argument("right", type=pathlib.Path)
    parser.add_argument("--disp", type=int, default=64, help="disparities to search (64)")
    parser.add_argument("--preset", default="balanced", help="classic, fast, balanced, strict, dense or accurate (balanced)")
    parser.add_argument("--calib", type=pathlib.Path, help="a calibration of rectified cameras: depths and points")
    parser.add_argument("--fps", type=float, default=10.0, help="pairs a second (10)")
    parser.add_argument("--save", type=pathlib.Path, help="writes a recording in place of opening the viewer")
    given = parser.parse_args()

    found = files(given.left, given.right)
    calibration = gpu_stereo.read_calibration(given.calib) if given.calib else None
    height, width = gpu_stereo.read_pair(*found[0])[0].shape[:2]
    camera = calibration.camera(width, height) if calibration else None
    rr.init("gpu-stereo", spawn=given.save is None)
    if given.save:
        rr.save(given.save)
    rr.log("world", rr.ViewCoordinates.RDF, static=True)  # x right, y down, z forward, as the points have it

    to_match, to_show = itertools.tee(pairs(found, calibration))  # those in flight are kept
    results = gpu_stereo.stream(to_match, disparities=given.disp, preset=given.preset, cameras=camera)
    for number, ((left, right), matched) in enumerate(zip(to_show, results, strict=True)):
        rr.set_time("pair", sequence=number)
        rr.set_time("time", duration=number / given.fps)
        log(left, right, matched, camera)
        print(f"{found[number][0].name}: {matched.mask.mean():.1%} have a disparity", file=sys.stderr)


if __name__ == "__main__":
    main()
