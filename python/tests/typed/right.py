"""A program that strict type checkers accept."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import gpu_stereo


def pairs() -> Iterator[tuple[NDArray[np.uint8], NDArray[np.uint8]]]:
    for _ in range(2):
        yield np.zeros((8, 40), np.uint8), np.zeros((8, 40), np.uint8)


def main() -> None:
    left, right = gpu_stereo.read_pair("left.png", "right.png")
    matcher = gpu_stereo.StereoMatcher(741, 500, "strict", 64, "cpu", cost="census", lr_check="off", wls_sigma=1.5, confidence=True)
    matched = matcher.compute(left, right)
    disparity: NDArray[np.float32] = matched.disparity
    raw: NDArray[np.int16] = matched.raw
    times: dict[str, float] = matched.timings
    frames: list[gpu_stereo.Matched] = list(matcher.stream(pairs()))
    camera = gpu_stereo.Camera(700, 0.12, cx=320, cy=240)
    found = gpu_stereo.match(left, right, "auto", cameras=camera, paths=8, bits="auto", mask=(None, np.ones((8, 40), np.bool_)))
    points: NDArray[np.float32] = found.points()
    scores: gpu_stereo.Scores = gpu_stereo.evaluate(matched, disparity)
    bad: float = scores.bad_2
    stages: list[str] = [stage.stage for stage in gpu_stereo.check(memoryview(b""), left, 16)]
    options: gpu_stereo.Options = {"method": "bm", "block": 9, "speckle_window": False}
    other = gpu_stereo.match(left, right, 64, **options)
    calibration = gpu_stereo.read_calibration("calib.yaml", rectify=True, calib_unit="mm")
    rectified = gpu_stereo.rectify(left, right, calibration)
    print(raw, times, frames, points, bad, stages, other, rectified[2].focal, gpu_stereo.adapters()[0].kind, gpu_stereo.__version__)
