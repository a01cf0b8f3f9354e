"""Functions of given maps, beside OpenCV's: equal to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gpu_stereo import cv


def test_speckles_are_opencvs(cv2: Any) -> None:
    draws = np.random.default_rng(1)
    for round_ in range(200):
        size = draws.integers(1, 40, 2)
        dtype = (np.int16, np.uint8)[round_ % 2]
        given = (draws.integers(0, 6, size) * int(draws.integers(1, 4))).astype(dtype)
        if dtype is np.int16:
            given -= 5
        invalid = int(draws.integers(-16 if dtype is np.int16 else 0, 8))
        largest, difference = int(draws.integers(-1, 20)), float(draws.integers(0, 11)) / 2
        theirs, _ = cv2.filterSpeckles(given.copy(), invalid, largest, difference)
        ours = given.copy()
        returned, _ = cv.filterSpeckles(ours, invalid, largest, difference)
        assert returned is ours
        assert np.array_equal(theirs, ours), (size, dtype, invalid, largest, difference)


def test_a_slice_is_filtered_in_place() -> None:
    whole = np.full((4, 8), 16, np.int16)
    whole[1, 2] = 800
    cv.filterSpeckles(whole[:, ::2], -16, 1, 16)
    assert whole[1, 2] == -16
    assert (whole == 16).sum() == 31


def test_validation_is_opencvs(cv2: Any) -> None:
    draws = np.random.default_rng(2)
    dropped = 0
    for round_ in range(200):
        height, width = draws.integers(1, 60, 2)
        minimum, count = int(draws.integers(-20, 20)), int(draws.integers(1, 40))
        limit = int(draws.integers(-1, 4))
        given = draws.integers(16 * minimum - 16, 16 * (minimum + count), (height, width)).astype(np.int16)
        # What leads out of the row is memory that OpenCV should not read.
        partner = np.arange(width) - ((given.astype(int) + 8) >> 4)
        given[(partner < 0) | (partner >= width)] = 16 * minimum - 16
        costs = draws.integers(-50, 50, given.shape).astype((np.int16, np.int32)[round_ % 2])
        theirs, ours = given.copy(), given.copy()
        cv2.validateDisparity(theirs, costs, minimum, count, limit)
        assert cv.validateDisparity(ours, costs, minimum, count, limit) is ours
        assert np.array_equal(theirs, ours), (given.shape, minimum, count, limit)
        dropped += int((given != ours).sum())
    assert dropped > 1000


def test_points_are_opencvs(cv2: Any) -> None:
    draws = np.random.default_rng(3)
    for round_ in range(120):
        size = draws.integers(1, 60, 2)
        given = draws.integers(-20, 200, size).astype((np.int16, np.uint8, np.int32, np.float32)[round_ % 4])
        if given.dtype == np.float32:
            given /= 16
        usual = np.array([[1, 0, 0, -30], [0, 1, 0, -20], [0, 0, 0, 700], [0, 0, -1 / 0.12, 3.0]])
        q = draws.normal(size=(4, 4)) if round_ % 3 else usual
        missing, depth = bool(round_ // 4 % 2), (-1, cv2.CV_32F, cv2.CV_16S, cv2.CV_32S)[round_ // 8 % 4]
        theirs = cv2.reprojectImageTo3D(given, q, handleMissingValues=missing, ddepth=depth)
        ours = cv.reprojectImageTo3D(given, q, handleMissingValues=missing, ddepth=depth)
        assert ours.dtype == theirs.dtype
        # With a matrix of chance W may be 0, and what is infinite is no integer.
        finite = np.isfinite(cv2.reprojectImageTo3D(given, q)).all(axis=2)
        assert np.array_equal(theirs[finite], ours[finite]), (given.shape, given.dtype, missing, depth)


def test_the_valid_rectangle_is_opencvs(cv2: Any) -> None:
    draws = np.random.default_rng(4)
    for _ in range(500):
        rois = [tuple(int(number) for number in (*draws.integers(-5, 40, 2), *draws.integers(0, 120, 2))) for _ in range(2)]
        rest = [int(draws.integers(-20, 40)), int(draws.integers(1, 64)), int(draws.integers(-3, 30))]
        assert cv.getValidDisparityROI(*rois, *rest) == tuple(cv2.getValidDisparityROI(*rois, *rest)), (rois, rest)


def test_the_picture_of_a_map_is_opencvs(ximgproc: Any) -> None:
    given = np.random.default_rng(5).integers(-40, 16400, (50, 70)).astype(np.int16)
    for scale in (1.0, 0.3, 2.5):
        assert np.array_equal(ximgproc.getDisparityVis(given, scale=scale), cv.ximgproc.getDisparityVis(given, scale=scale))


def test_errors_of_a_map_are_opencvs(ximgproc: Any) -> None:
    draws = np.random.default_rng(6)
    # OpenCV's squares end at 32767: errors of 11 px and more count as 11 px.
    truth, given = (draws.integers(800, 980, (40, 50)).astype(np.int16) for _ in range(2))
    truth[draws.random(truth.shape) < 0.2] = 16320
    part = (3, 4, 30, 20)
    assert cv.ximgproc.computeMSE(truth, given, part) == pytest.approx(ximgproc.computeMSE(truth, given, part), rel=1e-12)
    theirs = ximgproc.computeBadPixelPercent(truth, given, part, 100)
    assert cv.ximgproc.computeBadPixelPercent(truth, given, part, 100) == pytest.approx(theirs, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: cv.filterSpeckles(np.zeros((2, 2), np.float32), 0, 1, 1), "int16 or uint8, but is float32"),
        (lambda: cv.filterSpeckles(np.zeros((0, 2), np.int16), 0, 1, 1), "not empty"),
        (lambda: cv.filterSpeckles(np.zeros((2, 2), np.uint8), -1, 1, 1), "0 to 255"),
        (lambda: cv.filterSpeckles([[1]], 0, 1, 1), "NumPy array"),
        (lambda: cv.validateDisparity(np.zeros((2, 2), np.int16), np.zeros((2, 3), np.int32), 0, 16), "alike"),
        (lambda: cv.validateDisparity(np.zeros((2, 2), np.int16), np.zeros((2, 2), np.int32), 0, 0), "positive"),
        (lambda: cv.reprojectImageTo3D(np.zeros((2, 2), np.int16), np.eye(3)), "4 x 4"),
        (lambda: cv.reprojectImageTo3D(np.zeros((2, 2), np.int16), np.eye(4), ddepth=6), "ddepth is 6"),
        (lambda: cv.ximgproc.computeMSE(np.zeros((2, 2), np.int16), np.zeros((2, 2), np.int16), (0, 0, 3, 1)), "not inside"),
    ],
)
def test_what_cannot_be_computed_is_refused(call: Any, says: str) -> None:
    with pytest.raises(cv.error, match=says):
        call()


def test_an_array_that_cannot_be_written_is_refused() -> None:
    given = np.zeros((2, 2), np.int16)
    given.flags.writeable = False
    with pytest.raises(cv.error, match="can't be written"):
        cv.filterSpeckles(given, -16, 1, 1)
